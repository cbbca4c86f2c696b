//! What figures say, in each language.

use super::Figure;
use crate::explain::Lang;

/// The words of a language.
pub struct Words {
    /// `en`, for readers and speakers of the picture.
    pub lang: &'static str,
    plane: &'static str,
    sphere: &'static str,
}

impl Words {
    /// What a figure shows.
    pub fn caption(&self, figure: Figure) -> &'static str {
        match figure {
            Figure::Plane => self.plane,
            Figure::Sphere => self.sphere,
        }
    }
}

static ENGLISH: Words = Words {
    lang: "en",
    plane: "Figure 3: a plane in a coordinate system, with a point a and the normal n: (p − a)·n = 0",
    sphere: "Figure 4: a sphere in a coordinate system, with centre c and radius r: |p − c| = r",
};

static GERMAN: Words = Words {
    lang: "de",
    plane: "Abbildung 3: eine Ebene im Koordinatensystem, mit Punkt a und Normale n: (p − a)·n = 0",
    sphere: "Abbildung 4: eine Kugel im Koordinatensystem, mit Mittelpunkt c, Radius r: |p − c| = r",
};

/// The words of a language.
pub fn of(lang: Lang) -> &'static Words {
    match lang {
        Lang::English => &ENGLISH,
        Lang::German => &GERMAN,
    }
}

/// A number of the scene with a true minus sign.
pub fn number(x: f64) -> String {
    // No negative zero.
    let text = if x.abs() >= 1e-4 && x.abs() < 1e6 || x == 0.0 {
        (x + 0.0).to_string()
    } else {
        format!("{x:e}")
    };
    text.replace('-', "−")
}

/// `(1, −0.5, 0)`
pub fn vector(v: glam::DVec3) -> String {
    format!("({})", v.to_array().map(number).join(", "))
}
