//! How a picture is looked at, and its colours as the device takes them.

use crate::rays::{Lens, Pixels};
use crate::scene::{Samples, Scene};
use crate::show::{self, Rgb, Show};

/// How a picture is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    /// The quantity.
    pub show: Show,
    /// Colours are those that the scene's light gives.
    pub is_lit: bool,
    /// Samples across and down a pixel.
    pub n_samples: Samples,
    /// The camera's.
    pub lens: Lens,
}

impl Look {
    /// True where single pixels must be painted, which happens when the camera rests.
    pub fn is_painted(self) -> bool {
        match self.show {
            Show::Color => self.is_lit || self.n_samples > Samples::ONE,
            show => !show.is_of_objects(self.lens),
        }
    }
}

/// Rays that are not decided yet.
const NOT_YET: Rgb = [128, 128, 128];

/// A colour as a word: sRGB bytes, red lowest, then alpha.
pub fn word([r, g, b]: Rgb) -> u32 {
    u32::from_le_bytes([r, g, b, 255])
}

/// Colours by id, the background's first, and last that of rays that are not decided yet.
pub fn palette(show: Show, scene: &Scene, pixels: &Pixels) -> Vec<u32> {
    let colors = show::palette(show, scene, pixels);
    colors.into_iter().chain([NOT_YET]).map(word).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::View;
    use crate::scene::parse_scene;

    #[test]
    fn palettes_have_a_colour_for_each_id_and_for_what_is_open() {
        let text = include_str!("../../scenes/figure5.toml");
        let scene = parse_scene(text, "figure5.toml".as_ref()).unwrap();
        let pixels = Pixels::whole(View::new(scene.camera.as_ref().unwrap()), 64, 36);
        for show in Show::ALL {
            let palette = palette(show, &scene, &pixels);
            assert_eq!(palette.len(), scene.n_objects() + 2);
            assert_eq!(palette.last(), Some(&word(NOT_YET)));
            assert!(palette.iter().all(|color| color >> 24 == 255));
        }
    }
}
