//! Lights.

use glam::DVec3;

use super::Color;

/// Where a light's rays come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// A point, world units.
    Point(DVec3),
    /// A sun: the direction that its light travels, of any length but zero.
    Sun(DVec3),
    /// The camera: a point at a perspective camera's position, a sun along an orthographic camera's
    /// view axis.
    Eye,
}

/// A light. There is no falloff with distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where its rays come from.
    pub source: Source,
    /// Linear colour.
    pub color: Color,
    /// Times the colour: the light that a surface across its rays gets. Not negative.
    pub intensity: f64,
    /// Whether objects are in its way.
    pub shadows: bool,
}

/// Soft white light from everywhere: suns of equal intensity, evenly spread over all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// The light that an open plane gets. Not negative.
    pub intensity: f64,
    /// Number of suns, at least 1.
    pub directions: u32,
}

impl Sky {
    /// Suns of a sky whose scene file does not say how many.
    pub const DIRECTIONS: u32 = 64;

    /// Most suns.
    pub const MAX_DIRECTIONS: u32 = 65536;

    /// The directions that the light of each sun travels, nearly unit vectors: `−(x, y, z)` with
    /// `y = 1 − (2i + 1)/n`, and `(x, z) = √(1 − y²)·(cos iγ, sin iγ)` with the golden angle
    /// `γ = π(3 − √5)`, a spherical Fibonacci lattice (Keinert et al. 2015, section 2). Cosine and
    /// sine are found by turning `(1, 0)` by `γ`, i times, so that all operations are `+ − × ÷ √` of f64,
    /// the same on every machine.
    pub fn suns(&self) -> Vec<DVec3> {
        // cos γ and sin γ to 2⁻⁵². The guide states these very numbers, on which all digests of skies depend.
        const COS: f64 = -0.737_368_878_078_319_9;
        const SIN: f64 = 0.675_490_294_261_523_8;
        let n = f64::from(self.directions);
        let (mut cos, mut sin) = (1.0, 0.0);
        (0..self.directions)
            .map(|i| {
                let y = 1.0 - (2.0 * f64::from(i) + 1.0) / n;
                let around = (1.0 - y * y).sqrt();
                let sun = -DVec3::new(around * cos, y, around * sin);
                (cos, sin) = (cos * COS - sin * SIN, cos * SIN + sin * COS);
                sun
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sky_is_even() {
        for directions in [1, 2, 7, 64, 1000, Sky::MAX_DIRECTIONS] {
            let suns = Sky { intensity: 1.0, directions }.suns();
            assert_eq!(suns.len(), directions as usize);
            for sun in &suns {
                assert!((sun.length() - 1.0).abs() < 1e-9, "{sun}");
            }
            if directions >= 64 {
                // An open plane gets the mean of n·ω over the half sphere, ½ of ½, times 4.
                for normal in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE.normalize()] {
                    let sum: f64 = suns.iter().map(|sun| (-*sun).dot(normal).max(0.0)).sum();
                    let light = sum * 4.0 / f64::from(directions);
                    assert!((light - 1.0).abs() < 0.03, "{directions} {normal}: {light}");
                }
            }
        }
    }
}
