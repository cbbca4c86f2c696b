//! One hash of a picture's exact content, in place of a reference picture and its tolerances.
//!
//! With the kernel `certified`, ids, `t`, normals and colours are those that exact arithmetic gives, rounded, so that
//! the hash is the same on every device, with every driver and number of threads.
//!
//! # Version 2
//! SHA-256 of these bytes, each number little-endian:
//! 1. the text `kugelblitz digest 2` and a line feed;
//! 2. seven `u32`: width and height of the whole picture; left column, top row, width and height of the
//!    part that was traced; samples across a pixel;
//! 3. for each pixel of the part, row by row from the top: the id (`u32`), `t` (`f32`, +∞ on the background),
//!    the normal (three `f32`, zeros on the background, and 0 for −0), and red, green and blue (`u8`, sRGB).
//!
//! It is written as `kb2:` and 64 hexadecimal digits. Version 1 was the same with normals within 2⁻²³ of the exact
//! ones.
//!
//! # A scene's hash
//! [`scene_hash`] is of what a scene holds, whatever its file is called and however it is written. With the
//! camera, the size and the samples it defines every byte of a picture. Version 1 is SHA-256 of these
//! bytes, each number little-endian:
//! 1. the text `kugelblitz scene 1` and a line feed;
//! 2. the numbers of spheres and planes, lights and suns of the sky, and 1 where there is ambient light, which
//!    may be black and then still is a light (five `u64`);
//! 3. the background (three `f64`, as all colours: linear), the ambient light (the same, 0 without), the sky's
//!    intensity (`f64`, 0 without);
//! 4. of each light: `0` (a point), `1` (a sun) or `2` (the eye) and whether there are shadows (two `u8`), its
//!    point or direction (three `f64`, 0 for the eye), colour and intensity (four `f64`);
//! 5. of each 65536 spheres a SHA-256 of them: centre and radius (four `f64`) of each, then the colour of each;
//! 6. of each plane point, normal and colour (nine `f64`).
//!
//! It is written as `kbs1:` and 64 hexadecimal digits.

use std::fmt::Write;

use sha2::{Digest as _, Sha256};

use crate::error::{Result, wrong_usage};
use crate::lighting::{Colors, Framebuffer};
use crate::picture::Sink;
use crate::query::Hits;
use crate::rays::Pixels;
use crate::scene::{Color, Light, Samples, Scene, Source};
use crate::support::parallel;

/// The text before the digits: it tells the version.
pub const PREFIX: &str = "kb2:";

const HEAD: &[u8] = b"kugelblitz digest 2\n";

/// Bytes of a pixel.
const PIXEL_BYTES: usize = 4 + 4 + 12 + 3;

/// A digest that is being made.
#[derive(Clone, Debug)]
pub struct Digest(Sha256);

impl Digest {
    /// The digest of a picture that has no rows yet.
    pub fn new(pixels: &Pixels, samples: Samples) -> Digest {
        let &Pixels { image_width, image_height, x, y, width, height, .. } = pixels;
        let mut hash = Sha256::new_with_prefix(HEAD);
        for number in [image_width, image_height, x, y, width, height, samples.across()] {
            hash.update(number.to_le_bytes());
        }
        Digest(hash)
    }

    /// Adds the next pixels, in order. `hits` must have surfaces.
    pub fn rows(&mut self, hits: &Hits, srgb8: &[[u8; 3]]) {
        let mut bytes = Vec::with_capacity(srgb8.len() * PIXEL_BYTES);
        let surfaces = hits.t.iter().zip(&hits.normal);
        for ((id, (t, normal)), color) in hits.id.iter().zip(surfaces).zip(srgb8) {
            bytes.extend(id.to_le_bytes());
            bytes.extend(t.to_le_bytes());
            normal.iter().for_each(|component| bytes.extend((component + 0.0).to_le_bytes()));
            bytes.extend(color);
        }
        self.0.update(&bytes);
    }

    /// The digest in words.
    pub fn finish(self) -> String {
        in_words(PREFIX, self.0)
    }
}

impl Sink for Digest {
    /// Colours in sRGB with 8 bits a channel.
    fn band(&mut self, rows: &Framebuffer, _: u32) -> Result<()> {
        let Colors::Srgb8(srgb8) = &rows.colors else {
            return wrong_usage("a digest is of colours in sRGB with 8 bits");
        };
        self.rows(&rows.hits, srgb8);
        Ok(())
    }
}

fn in_words(prefix: &str, hash: Sha256) -> String {
    let mut text = prefix.to_string();
    for byte in hash.finalize() {
        // A String takes all that is written to it.
        let _ = write!(text, "{byte:02x}");
    }
    text
}

/// The text before the digits of a scene's hash.
pub const SCENE_PREFIX: &str = "kbs1:";

const SCENE_HEAD: &[u8] = b"kugelblitz scene 1\n";

/// Spheres that are hashed together.
const SPHERES_AT_ONCE: usize = 1 << 16;

/// The hash of what a scene holds, but for its camera, its size and samples, and names.
pub fn scene_hash(scene: &Scene) -> String {
    fn add<const N: usize>(hash: &mut Sha256, rows: impl IntoIterator<Item = [f64; N]>) {
        // At once: many small ones are several times slower.
        let rows: Vec<_> = rows.into_iter().map(|row| row.map(f64::to_le_bytes)).collect();
        hash.update(rows.as_flattened().as_flattened());
    }
    let mut hash = Sha256::new_with_prefix(SCENE_HEAD);
    let n_suns = scene.sky.map_or(0, |sky| sky.directions as usize);
    let has_ambient = usize::from(scene.ambient.is_some());
    for n in [scene.spheres.len(), scene.planes.len(), scene.lights.len(), n_suns, has_ambient] {
        hash.update((n as u64).to_le_bytes());
    }
    add(&mut hash, [scene.background.0]);
    add(&mut hash, [scene.ambient.map_or([0.0; 3], |Color(color)| color)]);
    add(&mut hash, [[scene.sky.map_or(0.0, |sky| sky.intensity)]]);
    for Light { source, color, intensity, shadows } in &scene.lights {
        let (kind, place) = match source {
            Source::Point(point) => (0, point.to_array()),
            Source::Sun(direction) => (1, direction.to_array()),
            Source::Eye => (2, [0.0; 3]),
        };
        hash.update([kind, u8::from(*shadows)]);
        add(&mut hash, [place, color.0]);
        add(&mut hash, [[*intensity]]);
    }
    let rows = scene.spheres.rows().chunks(SPHERES_AT_ONCE).enumerate();
    let parts = parallel::map(rows, |(part, rows)| {
        let mut hash = Sha256::new();
        add(&mut hash, rows.iter().copied());
        let first = part * SPHERES_AT_ONCE;
        let colors = (first..first + rows.len()).filter_map(|index| scene.spheres.color(index));
        add(&mut hash, colors.map(|Color(color)| color));
        hash.finalize()
    });
    parts.iter().for_each(|part| hash.update(part));
    for plane in &scene.planes {
        add(&mut hash, [plane.point.to_array(), plane.normal.to_array(), plane.color.0]);
    }
    in_words(SCENE_PREFIX, hash)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::rays::View;
    use crate::scene::Camera;

    fn pixels() -> Pixels {
        Pixels::whole(View::new(&Camera::new(DVec3::Z, DVec3::ZERO)), 2, 1)
    }

    fn hits() -> Hits {
        Hits {
            id: vec![7, 0],
            t: vec![1.5, f32::INFINITY],
            normal: vec![[0.0, -1.0, 0.5], [0.0; 3]],
            ..Hits::default()
        }
    }

    const COLORS: [[u8; 3]; 2] = [[1, 2, 3], [0, 0, 0]];

    fn digest(pixels: &Pixels, n_samples: u32, hits: &Hits, colors: &[[u8; 3]]) -> String {
        let mut digest = Digest::new(pixels, Samples::nearest(n_samples));
        digest.rows(hits, colors);
        digest.finish()
    }

    #[test]
    fn the_bytes_are_those_of_version_2() {
        let mut bytes = b"kugelblitz digest 2\n".to_vec();
        [2u32, 1, 0, 0, 2, 1, 1].iter().for_each(|n| bytes.extend(n.to_le_bytes()));
        bytes.extend([7, 0, 0, 0, 0, 0, 0xc0, 0x3f]);
        bytes.extend([0, 0, 0, 0, 0, 0, 0x80, 0xbf, 0, 0, 0, 0x3f, 1, 2, 3]);
        bytes.extend([0, 0, 0, 0, 0, 0, 0x80, 0x7f]);
        bytes.extend([0; 15]);
        let expected: String =
            Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(digest(&pixels(), 1, &hits(), &COLORS), format!("{PREFIX}{expected}"));
    }

    #[test]
    fn a_scene_has_another_hash_when_anything_of_it_differs() {
        let text = include_str!("../scenes/lit/figure1.toml");
        let of = |text: &str| {
            scene_hash(&crate::scene::parse_scene(text, "figure1.toml".as_ref()).unwrap())
        };
        let honest = of(text);
        assert_eq!(honest.len(), SCENE_PREFIX.len() + 64);
        // What is written otherwise, or is said elsewhere.
        let same = format!("# another file\n{}", text.replace("fov      = 42.0", "fov = 41"));
        assert!(same.contains("fov = 41"));
        assert_eq!(of(&same), honest);
        let mut differing = 0;
        for line in text.lines().skip_while(|line| !line.starts_with("[[")) {
            let Some(at) = line.rfind(|c: char| ('1'..='8').contains(&c)) else { continue };
            if line.starts_with('#') || line.starts_with("name") || line.starts_with("shadows") {
                continue;
            }
            let mut spoiled = line.to_owned();
            let next = char::from(line.as_bytes()[at] + 1);
            spoiled.replace_range(at..=at, &next.to_string());
            let spoiled = text.replacen(line, &spoiled, 1);
            assert_ne!(of(&spoiled), honest, "{line}");
            differing += 1;
        }
        assert!(differing > 5, "{differing}");
        // Without light, objects have their own colours; in none, they are black.
        let [unlit, dark] = [None, Some(Color::BLACK)]
            .map(|ambient| scene_hash(&Scene { ambient, ..Scene::default() }));
        assert_ne!(unlit, dark);
    }

    #[test]
    fn rows_can_come_in_any_number_of_bands() {
        let mut digest_in_two = Digest::new(&pixels(), Samples::ONE);
        let (all, one) = (hits(), |i: usize| Hits {
            id: vec![hits().id[i]],
            t: vec![hits().t[i]],
            normal: vec![hits().normal[i]],
            ..Hits::default()
        });
        digest_in_two.rows(&one(0), &COLORS[..1]);
        digest_in_two.rows(&one(1), &COLORS[1..]);
        assert_eq!(digest_in_two.finish(), digest(&pixels(), 1, &all, &COLORS));
    }

    /// Whatever differs is seen, but for the sign of 0 and the level that decided.
    #[test]
    fn each_difference_is_another_digest() {
        let honest = digest(&pixels(), 1, &hits(), &COLORS);
        type Sabotage = (&'static str, fn(&mut Hits));
        let sabotages: [Sabotage; 4] = [
            ("id", |hits| hits.id[1] = 1),
            ("t", |hits| hits.t[0] = hits.t[0].next_up()),
            ("normal", |hits| hits.normal[0][2] = hits.normal[0][2].next_up()),
            ("background", |hits| hits.t[1] = 0.0),
        ];
        for (what, spoil) in sabotages {
            let mut spoiled = hits();
            spoil(&mut spoiled);
            assert_ne!(digest(&pixels(), 1, &spoiled, &COLORS), honest, "{what}");
        }
        assert_ne!(digest(&pixels(), 1, &hits(), &[[1, 2, 4], [0; 3]]), honest, "a byte");
        assert_ne!(digest(&pixels(), 2, &hits(), &COLORS), honest, "samples");
        let part = Pixels { image_width: 3, ..pixels() };
        assert_ne!(digest(&part, 1, &hits(), &COLORS), honest, "a part of another picture");
        let mut same = hits();
        same.normal[0][0] = -0.0;
        same.level = vec![1, 2];
        assert_eq!(digest(&pixels(), 1, &same, &COLORS), honest);
    }
}
