//! What figures say, in each language.

use super::Figure;
use crate::explain::Lang;

/// What a figure shows.
pub fn caption(figure: Figure, lang: Lang) -> &'static str {
    let captions = match figure {
        Figure::Rays => [
            "Figure 2: rays of a camera at t = 0, from above: each sees the point of its smallest t > 0",
            "Abbildung 2: Strahlen einer Kamera bei t = 0, von oben: gesehen wird das kleinste t > 0",
        ],
        Figure::Plane => [
            "Figure 3: a plane in a coordinate system, with a point a and the normal n: (p − a)·n = 0",
            "Abbildung 3: eine Ebene im Koordinatensystem, mit Punkt a und Normale n: (p − a)·n = 0",
        ],
        Figure::Sphere => [
            "Figure 4: a sphere in a coordinate system, with centre c and radius r: |p − c| = r",
            "Abbildung 4: eine Kugel im Koordinatensystem, mit Mittelpunkt c, Radius r: |p − c| = r",
        ],
        Figure::Discriminant => [
            "Figure 5: the points of a ray on spheres, turned about it into one plane, and D = b² − 4ak",
            "Abbildung 5: Punkte des Strahls auf Kugeln, um ihn in eine Ebene gedreht; D = b² − 4ak",
        ],
    };
    captions[lang as usize]
}

/// The largest of 1, 2 and 5 times a power of ten that is not above a number.
pub fn round_step(most: f64) -> f64 {
    // Parsed, it is the nearest number.
    let power = format!("1e{}", most.log10().floor()).parse().unwrap_or(f64::INFINITY);
    let steps = [5.0, 2.0, 1.0].map(|step| step * power);
    steps.into_iter().find(|step| *step <= most).unwrap_or(power)
}

/// `i` steps, without what f64 adds to a decimal number.
pub fn multiple(step: f64, i: i32) -> f64 {
    let x = step * f64::from(i);
    format!("{x:.9e}").parse().unwrap_or(x)
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
