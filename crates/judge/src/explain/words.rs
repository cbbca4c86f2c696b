//! All that explanations say, in each language, and the sentences that come of it.
//!
//! In a phrase `#` stands for the next name or number that is put in. What stands between `$` is a
//! formula: plain text leaves the `$` out, LaTeX writes it in math mode. A name never stands in a
//! formula, and a number that may be `1e-7` always does.

use std::fmt;

use kugelblitz::scene::Object;
use serde::{Serialize, Serializer};

use super::expression::Notation;

/// The language of an explanation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lang {
    /// English.
    #[default]
    English,
    /// German, the language of the lecture.
    German,
}

impl Lang {
    /// All languages.
    pub const ALL: [Lang; 2] = [Lang::English, Lang::German];

    /// `en`, `de`
    pub fn name(self) -> &'static str {
        ["en", "de"][self as usize]
    }

    pub(super) fn words(self) -> &'static ExplanationWords {
        &WORDS[self as usize]
    }
}

/// A sentence with its names and numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    phrase: &'static str,
    parts: Vec<String>,
}

impl Remark {
    pub(super) fn of<T: ToString>(
        phrase: &'static str,
        parts: impl IntoIterator<Item = T>,
    ) -> Remark {
        Remark { phrase, parts: parts.into_iter().map(|part| part.to_string()).collect() }
    }

    pub(super) fn name(name: &str) -> Remark {
        Remark::of("#", [name])
    }

    pub(super) fn written(&self, notation: Notation) -> String {
        let mut parts = self.parts.iter();
        let mut text = String::new();
        for (i, segment) in self.phrase.split('$').enumerate() {
            let is_formula = i % 2 == 1;
            let dollar = if is_formula && notation == Notation::Latex { "$" } else { "" };
            text += dollar;
            for (j, piece) in segment.split('#').enumerate() {
                if j > 0 {
                    let part = parts.next().map_or("", String::as_str);
                    text += &if is_formula { notation.number(part) } else { notation.name(part) };
                }
                text += &if is_formula { notation.formula(piece) } else { notation.name(piece) };
            }
            text += dollar;
        }
        text
    }
}

impl From<&'static str> for Remark {
    fn from(phrase: &'static str) -> Remark {
        Remark { phrase, parts: Vec::new() }
    }
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.written(Notation::Text))
    }
}

impl Serialize for Remark {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl ExplanationWords {
    /// The symbol of a row, which is a word in some.
    pub fn symbol(&self, symbol: &'static str) -> &'static str {
        match symbol {
            "red" => self.channels[0],
            "green" => self.channels[1],
            "blue" => self.channels[2],
            "suns" => self.suns,
            other => other,
        }
    }
}

macro_rules! words {
    (phrases { $($phrase:ident: $english:literal, $german:literal;)* }
     lists { $($list:ident[$n:literal]: $all_english:expr, $all_german:expr;)* }) => {
        /// The phrases of a language.
        pub(super) struct ExplanationWords {
            $(pub $phrase: &'static str,)*
            $(pub $list: [&'static str; $n],)*
        }

        /// The phrases of each [`Lang`].
        static WORDS: [ExplanationWords; 2] = [
            ExplanationWords { $($phrase: $english,)* $($list: $all_english,)* },
            ExplanationWords { $($phrase: $german,)* $($list: $all_german,)* },
        ];
    };
}

impl ExplanationWords {
    /// The word for an object's shape.
    pub(super) fn shape(&self, object: Object) -> &'static str {
        match object {
            Object::Sphere(_) => self.sphere,
            Object::Plane(_) => self.plane,
        }
    }
}

words! {
    phrases {
        // Objects and lights.
        sphere: "sphere", "Kugel";
        plane: "plane", "Ebene";
        background: "background", "Hintergrund";
        light: "light", "Licht";
        at_point: "at $(#, #, #)$", "bei $(#, #, #)$";
        at_eye: "at the eye", "am Auge";
        sun: "a sun along $(#, #, #)$", "eine Sonne entlang $(#, #, #)$";

        // The ray and the list of objects.
        pixel:
            "Pixel $(#, #)$ of $#×#$: the ray $p(t) = o + t·d$",
            "Pixel $(#, #)$ von $#×#$: der Strahl $p(t) = o + t·d$";
        ray: "The ray $p(t) = o + t·d$", "Der Strahl $p(t) = o + t·d$";
        depth_in_perspective:
            "$d$ is not normalised: it goes 1 along the view axis, so $t$ is the depth and $t·|d|$ the distance",
            "$d$ ist nicht normiert: es geht 1 entlang der Blickachse, also ist $t$ die Tiefe und $t·|d|$ der Abstand";
        depth_in_parallel:
            "$d$ is the unit vector along the view axis, so $t$ is both the depth and the distance",
            "$d$ ist der Einheitsvektor entlang der Blickachse, also ist $t$ sowohl Tiefe als auch Abstand";
        depth_of_ray:
            "$d$ is not normalised: $t$ counts multiples of $d$, and the distance is $t·|d|$",
            "$d$ ist nicht normiert: $t$ zählt Vielfache von $d$, und der Abstand ist $t·|d|$";
        ray_of_center:
            "the ray goes through the centre of the pixel, whose colour is the mean of $#×#$ samples",
            "der Strahl geht durch die Mitte des Pixels, dessen Farbe das Mittel von $#×#$ Strahlen ist";
        digits_missing:
            "$≈$ means that digits are missing: a scene's 0.4, for example, is the f64 0.40000000000000002…",
            "$≈$ heißt, dass Stellen fehlen: 0.4 in einer Szene etwa ist die f64-Zahl 0.40000000000000002…";
        left_out:
            "Left out: # more of # objects: # hit but not first, # behind, # missed",
            "Ausgelassen: # weitere von # Objekten: # getroffen, aber nicht zuerst, # dahinter, # verfehlt";
        all_shows: "--all shows up to # objects.", "--all zeigt bis zu # Objekte.";

        // Why an object is seen, or isn't.
        visible: "nearest positive $t$: visible", "kleinstes positives $t$: sichtbar";
        farther: "farther than #", "weiter weg als #";
        tie: "tie with #: the lower id wins", "gleiches $t$ wie #: die kleinere Nummer gewinnt";
        missed: "$D < 0$: the line misses the sphere", "$D < 0$: die Gerade verfehlt die Kugel";
        in_plane:
            "$t = 0$: the origin lies in the plane, which does not count",
            "$t = 0$: der Ursprung des Strahls liegt in der Ebene, das zählt nicht";
        plane_behind:
            "#: the line meets the plane at $t < 0$",
            "#: die Gerade trifft die Ebene bei $t < 0$";
        pierced_behind:
            "#: the line pierces the sphere, but both $t < 0$",
            "#: die Gerade durchstößt die Kugel, aber beide $t < 0$";
        touched_behind:
            "#: the line touches the sphere, but at $t < 0$",
            "#: die Gerade berührt die Kugel, aber bei $t < 0$";
        at_back:
            "the origin lies on the sphere: no $t > 0$ ($t = 0$ does not count)",
            "der Ursprung des Strahls liegt auf der Kugel: kein $t > 0$ ($t = 0$ zählt nicht)";
        parallel: "parallel: $d·n = 0$", "parallel: $d·n = 0$";
        parallel_in_plane:
            "parallel: $d·n = 0$ (the ray runs in the plane, which is no hit)",
            "parallel: $d·n = 0$ (der Strahl läuft in der Ebene, das ist kein Treffer)";
        too_far:
            "$t$ is larger than any f32: counts as background",
            "$t$ ist größer als jede f32-Zahl: zählt als Hintergrund";
        degenerate:
            "a number here can't be calculated with: no hit",
            "mit einer Zahl hier kann man nicht rechnen: kein Treffer";
        inside:
            "inside: near root behind, far root counts",
            "von innen: die nahe Lösung liegt hinten, die ferne zählt";
        at_front:
            "the origin lies on the sphere: near root 0, far root counts",
            "der Ursprung des Strahls liegt auf der Kugel: nahe Lösung 0, die ferne zählt";
        touches: "$D = 0$: the line touches the sphere", "$D = 0$: die Gerade berührt die Kugel";
        passes:
            "the ray passes it at a distance of $#$",
            "der Strahl geht im Abstand $#$ an ihr vorbei";
        passes_at_origin:
            "the point of the ray that is nearest to it is its origin, $#$ away",
            "der nächste Punkt des Strahls ist sein Ursprung, im Abstand $#$";
        stays_away: "the ray stays $#$ away from it", "der Strahl bleibt im Abstand $#$ von ihr";
        wrong_hit: "wrong in #, which sees a hit", "falsch in #: sieht einen Treffer";
        wrong_miss: "wrong in #, which sees no hit", "falsch in #: sieht keinen Treffer";

        // What is seen.
        sees_background: "The ray sees the background.", "Der Strahl sieht den Hintergrund.";
        sees: "The ray sees #: $t = #$", "Der Strahl sieht #: $t = #$";
        front:
            "its front; $n$ is the unit normal that faces the ray",
            "die Vorderseite; $n$ ist die Einheitsnormale zum Strahl hin";
        back:
            "its back; $n$ is the unit normal that faces the ray",
            "die Rückseite; $n$ ist die Einheitsnormale zum Strahl hin";
        decided:
            "The kernel certified decided this ray in #.",
            "Der Kernel certified hat diesen Strahl in # entschieden.";
        exact_arithmetic: "exact arithmetic", "exakter Arithmetik";
        wrong: "WRONG", "FALSCH";
        no_gpu:
            "No GPU took part: these are the CPU's results alone.",
            "Keine GPU war dabei: das sind nur die Ergebnisse der CPU.";

        // Light.
        counts_at_eye:
            "what the eye sees is lit from there: it counts",
            "was das Auge sieht, wird von dort beleuchtet: es zählt";
        counts: "nothing is in its way: it counts", "nichts ist im Weg: es zählt";
        counts_without_shadow:
            "nothing casts a shadow in it: it counts",
            "nichts wirft darin Schatten: es zählt";
        behind_surface: "behind the surface: $n·ω < 0$", "hinter der Fläche: $n·ω < 0$";
        light_at_point:
            "it is at the point itself: it gives nothing",
            "es liegt im Punkt selbst: es gibt nichts";
        grazing: "$n·ω = 0$: it gives nothing", "$n·ω = 0$: es gibt nichts";
        hidden: "in its way: #, $s = #$", "im Weg: #, $s = #$";
        dark: "it gives no light", "es gibt kein Licht";
        wrong_in_the_way: "wrong in #, which has # in its way", "falsch in #: hat # im Weg";
        wrong_self_shadowing:
            "wrong in #: self-shadowing (shadow acne)",
            "falsch in #: Selbstverschattung (shadow acne)";
        self_shadowing:
            "shadow acne: rounding puts the computed point below the surface (see $f(p)$), which occludes it",
            "durch Rundung liegt der berechnete Punkt hinter der Fläche (siehe $f(p)$), die ihn verdeckt";
        wrong_counting: "wrong in #, which has it count", "falsch in #: lässt es zählen";
        wrong_behind:
            "wrong in #, which has it behind the surface",
            "falsch in #: hat es hinter der Fläche";
        sky: "sky, # of # directions", "Himmel, # von # Richtungen";
        sky_counts:
            "# count, # are behind the surface, # have something in their way",
            "# zählen, # sind hinter der Fläche, # haben etwas im Weg";
        color_of_ray: "The colour of the ray", "Die Farbe des Strahls";
        color_of_pixel:
            "The colour of the pixel: the mean of $#×#$ samples",
            "Die Farbe des Pixels: das Mittel von $#×#$ Strahlen";
        byte:
            "# is byte #, which stands for $#$ to $#$: $#$ from its edge",
            "# ist Byte #, das für $#$ bis $#$ steht: $#$ von der Grenze";
        byte_below:
            "# is byte #, which stands for below $#$: $#$ from its edge",
            "# ist Byte #, das für weniger als $#$ steht: $#$ von der Grenze";
        byte_above:
            "# is byte #, which stands for $#$ and more: $#$ from its edge",
            "# ist Byte #, das für $#$ und mehr steht: $#$ von der Grenze";
        wrong_byte: "wrong in #, which shows # as byte #", "falsch in #: zeigt # als Byte #";
        no_light_on_background:
            "no light falls on the background",
            "auf den Hintergrund fällt kein Licht";
        channel_formula: "color × (ambient + Σ I·n·ω)", "Farbe × (Umgebung + Σ I·n·ω)";
        suns: "suns", "Sonnen";

        // Tables.
        none: "none", "keine";
        exact: "exact", "exakt";
        no_root: "no root", "keine Lösung";
        root_lost: "root lost", "verloren";
        should_be_0: "should be 0", "müsste 0 sein";
        overflow: "overflow", "Überlauf";
        sign: "sign!", "Vz.!";

        // What stands below and between, in lines of their own.
        notes: "\
Formulas: exact numbers, rounded to # digits (≈ where digits are missing), and to more where it
takes them to get from an expression to the result of its line with a calculator. (Where the
result is exactly 0, that gives 0 or, after ≈, a few units of the last digit.)
Tables: every f32 is the one that the kernel works with. A line of errors follows where a number
is not exact: in ulp, the distance of neighbouring f32 numbers (f64 column: of f64 numbers) at
the exact value.
", "\
Formeln: exakte Zahlen, auf # Stellen gerundet (≈, wo Stellen fehlen), und auf mehr, wo man sie
braucht, um mit dem Taschenrechner von einem Ausdruck zum Ergebnis seiner Zeile zu kommen. (Ist
das Ergebnis genau 0, so kommt dabei 0 heraus oder, nach ≈, einige Einheiten der letzten Stelle.)
Tabellen: jede f32-Zahl ist die, mit der der Kernel rechnet. Eine Zeile mit Fehlern folgt, wo
eine Zahl nicht exakt ist: in ulp, dem Abstand benachbarter f32-Zahlen (Spalte f64: f64-Zahlen)
beim exakten Wert. Vz.! heißt: das Vorzeichen ist falsch.
";
        stable_notes: "\
\x20 In the table, stable has L = c − o and P = L − (d·L/a)·d, the way to the centre from the point
  of the line that is nearest to it. So r² − P·P = D/(4·a) is positive where the line pierces the
  sphere; h = √(a·(r² − P·P)) = √D/2; b = −2·d·L, k = L·L − r²; the roots are q/a and k/q with q
  = d·L ± h.
", "\
\x20 In der Tabelle hat stable L = c − o und P = L − (d·L/a)·d, den Weg zum Mittelpunkt von dem
  Punkt der Geraden, der ihm am nächsten ist. So ist r² − P·P = D/(4·a) positiv, wo die Gerade
  die Kugel durchstößt; h = √(a·(r² − P·P)) = √D/2; b = −2·d·L, k = L·L − r²; die Lösungen sind
  q/a und k/q mit q = d·L ± h.
";
        light_notes: "\
Light: w is the way to the light, ω = w/|w|, s the part of it up to what is in the way, I the colour
times the intensity. stable has its points relative to the camera; f64 is the kernel double; none of
the three uses an epsilon.
", "\
Licht: w ist der Weg zum Licht, ω = w/|w|, s sein Teil bis zu dem, was im Weg ist, I die Farbe mal
der Stärke. stable hat seine Punkte relativ zur Kamera; f64 ist der Kernel double; keiner der drei
nimmt ein Epsilon.
";
    }

    lists {
        // Of a camera's ray and of any other.
        behind[2]: ["behind the camera", "behind the ray's origin"],
            ["hinter der Kamera", "hinter dem Ursprung des Strahls"];
        // Axes of the camera.
        axes[3]: ["forward", "right", "true_up"], ["vorn", "rechts", "oben"];
        // Kernel, device, what it shows, its error, its normal.
        shown[5]: ["kernel", "on", "shows", "error", "normal"],
            ["Kernel", "auf", "zeigt", "Fehler", "Normale"];
        channels[3]: ["red", "green", "blue"], ["rot", "grün", "blau"];
    }
}
