//! How many samples a pixel has.

use crate::error::{Result, wrong_usage};

/// The samples of a pixel: as many down as across, from 1 to [`Samples::MOST`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Samples(u32);

impl Samples {
    /// Most samples across a pixel.
    pub const MOST: u32 = 16;

    /// One sample: the pixel's centre ray.
    pub const ONE: Samples = Samples(1);

    /// So many across and down a pixel.
    ///
    /// # Errors
    /// [`Error::Usage`](crate::Error::Usage) for none, or for more than [`Samples::MOST`].
    pub fn new(across: u32) -> Result<Samples> {
        if (1..=Samples::MOST).contains(&across) {
            Ok(Samples(across))
        } else {
            let most = Samples::MOST;
            wrong_usage(format!("{across} samples across a pixel: give 1 to {most}"))
        }
    }

    /// So many across and down a pixel, or the nearest number that can be.
    pub const fn nearest(across: u32) -> Samples {
        match across {
            0 => Samples(1),
            1..Samples::MOST => Samples(across),
            _ => Samples(Samples::MOST),
        }
    }

    /// Across, and down.
    pub const fn across(self) -> u32 {
        self.0
    }

    /// All of a pixel.
    pub const fn of_pixel(self) -> u32 {
        self.0 * self.0
    }
}

impl Default for Samples {
    fn default() -> Samples {
        Samples::ONE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_no_pixel_has_are_refused() {
        for across in [0, 17, 1 << 16, u32::MAX] {
            let refused = Samples::new(across).unwrap_err();
            assert_eq!(refused.exit_code(), 2);
            assert!(refused.to_string().contains("give 1 to 16"), "{refused}");
            assert_ne!(Samples::nearest(across).across(), across);
        }
        for across in 1..=16 {
            let samples = Samples::new(across).unwrap();
            assert_eq!((samples.across(), samples.of_pixel()), (across, across * across));
            assert_eq!(samples, Samples::nearest(across));
        }
    }
}
