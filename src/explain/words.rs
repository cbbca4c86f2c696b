//! All that explanations say, in each language, and the sentences that come of it.
//!
//! In a phrase `#` stands for the next name or number that is put in. What stands between `$` is a
//! formula: plain text leaves the `$` out, LaTeX writes it in math mode. A name never stands in a
//! formula, and a number that may be `1e-7` always does.

use std::fmt;

use serde::{Serialize, Serializer};

use super::line::Notation;

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
        match self {
            Lang::English => "en",
            Lang::German => "de",
        }
    }

    pub(super) fn words(self) -> &'static Words {
        match self {
            Lang::English => &ENGLISH,
            Lang::German => &GERMAN,
        }
    }
}

/// A sentence with its names and numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    phrase: &'static str,
    parts: Vec<String>,
}

impl Remark {
    pub(super) fn new<S: Into<String>>(
        phrase: &'static str,
        parts: impl IntoIterator<Item = S>,
    ) -> Remark {
        Remark { phrase, parts: parts.into_iter().map(Into::into).collect() }
    }

    pub(super) fn plain(phrase: &'static str) -> Remark {
        Remark { phrase, parts: Vec::new() }
    }

    pub(super) fn written(&self, notation: Notation) -> String {
        let mut parts = self.parts.iter();
        let mut text = String::new();
        for (i, segment) in self.phrase.split('$').enumerate() {
            let is_formula = i % 2 == 1;
            if is_formula && notation == Notation::Latex {
                text.push('$');
            }
            for (j, piece) in segment.split('#').enumerate() {
                if j > 0 {
                    let part = parts.next().map_or("", String::as_str);
                    text += &match is_formula {
                        true => notation.number(part),
                        false => notation.name(part),
                    };
                }
                text += &match is_formula {
                    true => notation.formula(piece),
                    false => notation.name(piece),
                };
            }
            if is_formula && notation == Notation::Latex {
                text.push('$');
            }
        }
        text
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

/// The phrases of a language.
pub(super) struct Words {
    // Objects and lights.
    pub sphere: &'static str,
    pub plane: &'static str,
    pub background: &'static str,
    pub light: &'static str,
    pub at_point: &'static str,
    pub at_eye: &'static str,
    pub sun: &'static str,

    // The ray and the list of objects.
    pub pixel: &'static str,
    pub ray: &'static str,
    pub left_out: &'static str,
    pub all_shows: &'static str,

    // Why an object is seen, or isn't.
    pub visible: &'static str,
    pub farther: &'static str,
    pub tie: &'static str,
    pub missed: &'static str,
    pub in_plane: &'static str,
    /// Of a camera's ray and of any other.
    pub plane_behind: [&'static str; 2],
    pub pierced_behind: [&'static str; 2],
    pub touched_behind: [&'static str; 2],
    pub at_back: &'static str,
    pub parallel: &'static str,
    pub parallel_in_plane: &'static str,
    pub too_far: &'static str,
    pub degenerate: &'static str,
    pub inside: &'static str,
    pub at_front: &'static str,
    pub touches: &'static str,
    pub passes: &'static str,
    pub passes_at_origin: &'static str,
    pub stays_away: &'static str,
    pub wrong_hit: &'static str,
    pub wrong_miss: &'static str,

    // What is seen.
    pub sees_background: &'static str,
    pub sees: &'static str,
    pub front: &'static str,
    pub back: &'static str,
    pub decided: &'static str,
    pub exact_arithmetic: &'static str,
    /// Kernel, device, what it shows, its error, its normal.
    pub shown: [&'static str; 5],
    pub wrong: &'static str,
    pub no_gpu: &'static str,

    // Light.
    pub counts_at_eye: &'static str,
    pub counts: &'static str,
    pub counts_without_shadow: &'static str,
    pub behind_surface: &'static str,
    pub light_at_point: &'static str,
    pub grazing: &'static str,
    pub hidden: &'static str,
    pub dark: &'static str,
    pub wrong_in_the_way: &'static str,
    pub wrong_counting: &'static str,
    pub wrong_behind: &'static str,
    pub sky: &'static str,
    pub sky_counts: &'static str,
    pub color_of_ray: &'static str,
    pub color_of_pixel: &'static str,
    pub byte: &'static str,
    pub byte_below: &'static str,
    pub byte_above: &'static str,
    pub bytes: &'static str,
    pub wrong_byte: &'static str,
    pub no_light_on_background: &'static str,
    /// Red, green, blue.
    pub channels: [&'static str; 3],
    /// How each of them comes about.
    pub channel_forms: [&'static str; 3],
    pub suns: &'static str,

    // Tables.
    pub exact_column: &'static str,
    pub none: &'static str,
    pub exact: &'static str,
    pub no_root: &'static str,
    pub root_lost: &'static str,
    pub should_be_0: &'static str,
    pub overflow: &'static str,
    pub sign: &'static str,

    // What stands below and between, in lines of their own.
    pub notes: &'static str,
    pub stable_notes: &'static str,
    pub light_notes: &'static str,
}

impl Words {
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

static ENGLISH: Words = Words {
    sphere: "sphere",
    plane: "plane",
    background: "background",
    light: "light",
    at_point: "at $(#, #, #)$",
    at_eye: "at the eye",
    sun: "a sun along $(#, #, #)$",

    pixel: "Pixel $(#, #)$ of $#×#$: the ray $p(t) = o + t·d$",
    ray: "The ray $p(t) = o + t·d$",
    left_out: "Left out: # more of # objects: # hit but not first, # behind, # missed",
    all_shows: "--all shows up to # objects.",

    visible: "nearest positive $t$: visible",
    farther: "farther than #",
    tie: "tie with #: the lower id wins",
    missed: "$D < 0$: the line misses the sphere",
    in_plane: "$t = 0$: the origin lies in the plane, which does not count",
    plane_behind: [
        "behind the camera: the line meets the plane at $t < 0$",
        "behind the ray's origin: the line meets the plane at $t < 0$",
    ],
    pierced_behind: [
        "behind the camera: the line pierces the sphere, but both $t < 0$",
        "behind the ray's origin: the line pierces the sphere, but both $t < 0$",
    ],
    touched_behind: [
        "behind the camera: the line touches the sphere, but at $t < 0$",
        "behind the ray's origin: the line touches the sphere, but at $t < 0$",
    ],
    at_back: "the origin lies on the sphere: no $t > 0$ ($t = 0$ does not count)",
    parallel: "parallel: $d·n = 0$",
    parallel_in_plane: "parallel: $d·n = 0$ (the ray runs in the plane, which is no hit)",
    too_far: "$t$ is larger than any f32: counts as background",
    degenerate: "a number here can't be calculated with: no hit",
    inside: "inside: near root behind, far root counts",
    at_front: "the origin lies on the sphere: near root 0, far root counts",
    touches: "$D = 0$: the line touches the sphere",
    passes: "the ray passes it at a distance of $#$",
    passes_at_origin: "the point of the ray that is nearest to it is its origin, $#$ away",
    stays_away: "the ray stays $#$ away from it",
    wrong_hit: "wrong in #, which sees a hit",
    wrong_miss: "wrong in #, which sees no hit",

    sees_background: "The ray sees the background.",
    sees: "The ray sees #: $t = #$",
    front: "its front; $n$ is the unit normal that faces the ray",
    back: "its back; $n$ is the unit normal that faces the ray",
    decided: "The kernel certified decided this ray in #.",
    exact_arithmetic: "exact arithmetic",
    shown: ["kernel", "on", "shows", "error", "normal"],
    wrong: "WRONG",
    no_gpu: "No GPU took part: these are the CPU's results alone.",

    counts_at_eye: "what the eye sees is lit from there: it counts",
    counts: "nothing is in its way: it counts",
    counts_without_shadow: "nothing casts a shadow in it: it counts",
    behind_surface: "behind the surface: $n·ω < 0$",
    light_at_point: "it is at the point itself: it gives nothing",
    grazing: "$n·ω = 0$: it gives nothing",
    hidden: "in its way: #, $s = #$",
    dark: "it gives no light",
    wrong_in_the_way: "wrong in #, which has # in its way",
    wrong_counting: "wrong in #, which has it count",
    wrong_behind: "wrong in #, which has it behind the surface",
    sky: "sky, # of # directions",
    sky_counts: "# count, # are behind the surface, # have something in their way",
    color_of_ray: "The colour of the ray",
    color_of_pixel: "The colour of the pixel: the mean of $#×#$ samples",
    byte: "# is byte #, which stands for $#$ to $#$: $#$ from its edge",
    byte_below: "# is byte #, which stands for below $#$: $#$ from its edge",
    byte_above: "# is byte #, which stands for $#$ and more: $#$ from its edge",
    bytes: "bytes #, #, #",
    wrong_byte: "wrong in #, which shows # as byte #",
    no_light_on_background: "no light falls on the background",
    channels: ["red", "green", "blue"],
    channel_forms: [
        "red = color × (ambient + Σ I·n·ω) ~ #·(# + #) ~ #",
        "green = color × (ambient + Σ I·n·ω) ~ #·(# + #) ~ #",
        "blue = color × (ambient + Σ I·n·ω) ~ #·(# + #) ~ #",
    ],
    suns: "suns",

    exact_column: "exact",
    none: "none",
    exact: "exact",
    no_root: "no root",
    root_lost: "root lost",
    should_be_0: "should be 0",
    overflow: "overflow",
    sign: "sign!",

    notes: "\
Formulas: exact numbers, rounded to # digits (≈ where digits are missing), and to more where it
takes them to get from an expression to the result of its line with a calculator. (Where the
result is exactly 0, that gives 0 or, after ≈, a few units of the last digit.)
Tables: every f32 is the one that the kernel works with. A line of errors follows where a number
is not exact: in ulp, the distance of neighbouring f32 numbers (f64 column: of f64 numbers) at
the exact value.
",
    stable_notes: "\
\x20 In the table, stable has L = c − o and P = L − (d·L/a)·d, the way to the centre from the point
  of the line that is nearest to it. So r² − P·P = D/(4·a) is positive where the line pierces the
  sphere; h = √(a·(r² − P·P)) = √D/2; b = −2·d·L, k = L·L − r²; the roots are q/a and k/q with q
  = d·L ± h.
",
    light_notes: "\
Light: w is the way to the light, ω = w/|w|, s the part of it up to what is in the way, I the colour
times the intensity. stable has its points relative to the camera; f64 is the kernel double; none of
the three uses an epsilon.
",
};

static GERMAN: Words = Words {
    sphere: "Kugel",
    plane: "Ebene",
    background: "Hintergrund",
    light: "Licht",
    at_point: "bei $(#, #, #)$",
    at_eye: "am Auge",
    sun: "eine Sonne entlang $(#, #, #)$",

    pixel: "Pixel $(#, #)$ von $#×#$: der Strahl $p(t) = o + t·d$",
    ray: "Der Strahl $p(t) = o + t·d$",
    left_out: "Ausgelassen: # weitere von # Objekten: # getroffen, aber nicht zuerst, # dahinter, # verfehlt",
    all_shows: "--all zeigt bis zu # Objekte.",

    visible: "kleinstes positives $t$: sichtbar",
    farther: "weiter weg als #",
    tie: "gleiches $t$ wie #: die kleinere Nummer gewinnt",
    missed: "$D < 0$: die Gerade verfehlt die Kugel",
    in_plane: "$t = 0$: der Ursprung des Strahls liegt in der Ebene, das zählt nicht",
    plane_behind: [
        "hinter der Kamera: die Gerade trifft die Ebene bei $t < 0$",
        "hinter dem Ursprung des Strahls: die Gerade trifft die Ebene bei $t < 0$",
    ],
    pierced_behind: [
        "hinter der Kamera: die Gerade durchstößt die Kugel, aber beide $t < 0$",
        "hinter dem Ursprung des Strahls: die Gerade durchstößt die Kugel, aber beide $t < 0$",
    ],
    touched_behind: [
        "hinter der Kamera: die Gerade berührt die Kugel, aber bei $t < 0$",
        "hinter dem Ursprung des Strahls: die Gerade berührt die Kugel, aber bei $t < 0$",
    ],
    at_back: "der Ursprung des Strahls liegt auf der Kugel: kein $t > 0$ ($t = 0$ zählt nicht)",
    parallel: "parallel: $d·n = 0$",
    parallel_in_plane: "parallel: $d·n = 0$ (der Strahl läuft in der Ebene, das ist kein Treffer)",
    too_far: "$t$ ist größer als jede f32-Zahl: zählt als Hintergrund",
    degenerate: "mit einer Zahl hier kann man nicht rechnen: kein Treffer",
    inside: "von innen: die nahe Lösung liegt hinten, die ferne zählt",
    at_front: "der Ursprung des Strahls liegt auf der Kugel: nahe Lösung 0, die ferne zählt",
    touches: "$D = 0$: die Gerade berührt die Kugel",
    passes: "der Strahl geht im Abstand $#$ an ihr vorbei",
    passes_at_origin: "der nächste Punkt des Strahls ist sein Ursprung, im Abstand $#$",
    stays_away: "der Strahl bleibt im Abstand $#$ von ihr",
    wrong_hit: "falsch in #: sieht einen Treffer",
    wrong_miss: "falsch in #: sieht keinen Treffer",

    sees_background: "Der Strahl sieht den Hintergrund.",
    sees: "Der Strahl sieht #: $t = #$",
    front: "die Vorderseite; $n$ ist die Einheitsnormale zum Strahl hin",
    back: "die Rückseite; $n$ ist die Einheitsnormale zum Strahl hin",
    decided: "Der Kernel certified hat diesen Strahl in # entschieden.",
    exact_arithmetic: "exakter Arithmetik",
    shown: ["Kernel", "auf", "zeigt", "Fehler", "Normale"],
    wrong: "FALSCH",
    no_gpu: "Keine GPU war dabei: das sind nur die Ergebnisse der CPU.",

    counts_at_eye: "was das Auge sieht, wird von dort beleuchtet: es zählt",
    counts: "nichts ist im Weg: es zählt",
    counts_without_shadow: "nichts wirft darin Schatten: es zählt",
    behind_surface: "hinter der Fläche: $n·ω < 0$",
    light_at_point: "es liegt im Punkt selbst: es gibt nichts",
    grazing: "$n·ω = 0$: es gibt nichts",
    hidden: "im Weg: #, $s = #$",
    dark: "es gibt kein Licht",
    wrong_in_the_way: "falsch in #: hat # im Weg",
    wrong_counting: "falsch in #: lässt es zählen",
    wrong_behind: "falsch in #: hat es hinter der Fläche",
    sky: "Himmel, # von # Richtungen",
    sky_counts: "# zählen, # sind hinter der Fläche, # haben etwas im Weg",
    color_of_ray: "Die Farbe des Strahls",
    color_of_pixel: "Die Farbe des Pixels: das Mittel von $#×#$ Strahlen",
    byte: "# ist Byte #, das für $#$ bis $#$ steht: $#$ von der Grenze",
    byte_below: "# ist Byte #, das für weniger als $#$ steht: $#$ von der Grenze",
    byte_above: "# ist Byte #, das für $#$ und mehr steht: $#$ von der Grenze",
    bytes: "Bytes #, #, #",
    wrong_byte: "falsch in #: zeigt # als Byte #",
    no_light_on_background: "auf den Hintergrund fällt kein Licht",
    channels: ["rot", "grün", "blau"],
    channel_forms: [
        "rot = Farbe × (Umgebung + Σ I·n·ω) ~ #·(# + #) ~ #",
        "grün = Farbe × (Umgebung + Σ I·n·ω) ~ #·(# + #) ~ #",
        "blau = Farbe × (Umgebung + Σ I·n·ω) ~ #·(# + #) ~ #",
    ],
    suns: "Sonnen",

    exact_column: "exakt",
    none: "keine",
    exact: "exakt",
    no_root: "keine Lösung",
    root_lost: "verloren",
    should_be_0: "müsste 0 sein",
    overflow: "Überlauf",
    sign: "Vz.!",

    notes: "\
Formeln: exakte Zahlen, auf # Stellen gerundet (≈, wo Stellen fehlen), und auf mehr, wo man sie
braucht, um mit dem Taschenrechner von einem Ausdruck zum Ergebnis seiner Zeile zu kommen. (Ist
das Ergebnis genau 0, so kommt dabei 0 heraus oder, nach ≈, einige Einheiten der letzten Stelle.)
Tabellen: jede f32-Zahl ist die, mit der der Kernel rechnet. Eine Zeile mit Fehlern folgt, wo
eine Zahl nicht exakt ist: in ulp, dem Abstand benachbarter f32-Zahlen (Spalte f64: f64-Zahlen)
beim exakten Wert. Vz.! heißt: das Vorzeichen ist falsch.
",
    stable_notes: "\
\x20 In der Tabelle hat stable L = c − o und P = L − (d·L/a)·d, den Weg zum Mittelpunkt von dem
  Punkt der Geraden, der ihm am nächsten ist. So ist r² − P·P = D/(4·a) positiv, wo die Gerade
  die Kugel durchstößt; h = √(a·(r² − P·P)) = √D/2; b = −2·d·L, k = L·L − r²; die Lösungen sind
  q/a und k/q mit q = d·L ± h.
",
    light_notes: "\
Licht: w ist der Weg zum Licht, ω = w/|w|, s sein Teil bis zu dem, was im Weg ist, I die Farbe mal
der Stärke. stable hat seine Punkte relativ zur Kamera; f64 ist der Kernel double; keiner der drei
nimmt ein Epsilon.
",
};
