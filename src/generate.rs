//! Clouds of spheres made up from a seed, for tests and measurements: the same bytes on every
//! machine.
//!
//! All numbers come from integers by operations that IEEE 754 rounds alike everywhere, and by
//! functions of [`libm`], which are built from such operations.

use std::io::Write;
use std::path::Path;

use glam::DVec3;

use crate::error::{Error, Result, wrong_usage};
use crate::output::OutputFile;
use crate::scene::schema::{CloudKeys, SceneKeys};
use crate::scene::{
    Camera, Color, MAX_OBJECTS, Projection, Scene, Sphere, Spheres, seen_from, write_rows,
};
use crate::support::control::Control;
use crate::support::memory;
use crate::support::random::SplitMix;

/// How the spheres lie in space. Colours follow the place, so that pictures can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distribution {
    /// Evenly in the cube of side 1 about the origin; each radius is 0.3·N^(−1/3).
    Uniform,
    /// A cubic lattice of spheres of radius 1 about the origin. Coordinates are whole numbers, so
    /// neighbours touch exactly.
    Lattice,
    /// A heap of spheres of radius 1 that touch each other and the floor y = 0: square layers, each in
    /// the hollows of the one below, with gaps here and there.
    Packing,
}

impl Distribution {
    /// All of them.
    pub const ALL: [Distribution; 3] =
        [Distribution::Uniform, Distribution::Lattice, Distribution::Packing];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Distribution::Uniform => "uniform",
            Distribution::Lattice => "lattice",
            Distribution::Packing => "packing",
        }
    }
}

/// The numbers that a cloud is made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Recipe {
    /// How the spheres lie in space.
    pub distribution: Distribution,
    /// Number of spheres, from 1 to [`MAX_COUNT`].
    pub count: u64,
    /// Other seeds give other clouds; a lattice is always the same.
    pub seed: u64,
}

/// The most spheres that a scene can have.
pub const MAX_COUNT: u64 = MAX_OBJECTS as u64;

/// Writes the cloud as an `.npy` file: little-endian float64 of shape (N, 7) with x, y, z, radius, and red, green, blue as bytes
/// in sRGB, 0 to 255. `control` counts the bytes.
///
/// # Errors
/// [`Error::Usage`] for a count that can't be; [`Error::Io`] and [`Error::Interrupted`].
pub fn write_cloud(file: &mut OutputFile, recipe: &Recipe, control: &Control) -> Result<()> {
    recipe.check()?;
    let in_bytes = |(sphere, bytes): (Sphere, [u8; 3])| (sphere, bytes.map(f64::from));
    write_rows(file, recipe.count as usize, recipe.rows().map(in_bytes), control)
}

/// Writes a scene file with the cloud in the file `cloud` and a camera that sees all of it where
/// the picture is not higher than wide.
///
/// # Errors
/// [`Error::Io`]; [`Error::Usage`] for a count that can't be, and for a path that is not UTF-8 and
/// so has no place in a scene.
pub fn write_scene(file: &mut OutputFile, cloud: &Path, recipe: &Recipe) -> Result<()> {
    recipe.check()?;
    let path = file.path().to_path_buf();
    let cloud = CloudKeys::of_file(&seen_from(&path, cloud)?)?;
    let scene = SceneKeys {
        background: Color::parse("#20242c"),
        camera: Some((&recipe.camera()).into()),
        spheres: Some(vec![cloud]),
        ..SceneKeys::default()
    };
    let Recipe { distribution, count, seed } = recipe;
    let text = format!(
        "# kugelblitz generate --distribution {} --count {count} --seed {seed}\n{}",
        distribution.name(),
        scene.document()
    );
    file.write_all(text.as_bytes()).map_err(Error::io(path))
}

impl Recipe {
    fn check(&self) -> Result<()> {
        let count = self.count;
        match count {
            1..=MAX_COUNT => Ok(()),
            _ => wrong_usage(format!("a cloud of {count} spheres: give from 1 to {MAX_COUNT}")),
        }
    }

    /// The scene of the two files that [`write_cloud`] and [`write_scene`] write, without its way
    /// through them.
    ///
    /// # Errors
    /// [`Error::Usage`] for a count that can't be; [`Error::TooLarge`] for more than memory holds;
    /// [`Error::Interrupted`].
    pub fn scene(&self, control: &Control) -> Result<Scene> {
        self.check()?;
        // Twice, as lists that grow are moved.
        let needed = 2 * self.count * (size_of::<Sphere>() + size_of::<Color>()) as u64;
        memory::require(format!("a cloud of {} spheres", self.count), needed, "generate fewer")?;
        let mut spheres = Spheres::default();
        for (index, (sphere, color)) in (0..self.count).zip(self.rows()) {
            if index % (1 << 14) == 0 {
                control.check()?;
            }
            spheres.push(sphere, Color::from_srgb8(color));
        }
        Ok(Scene { camera: Some(self.camera()), spheres, ..Scene::default() })
    }

    /// Returns the spheres with their colours as bytes in sRGB, and possibly more than are needed.
    fn rows(&self) -> impl Iterator<Item = (Sphere, [u8; 3])> {
        self.rows_in_linear_colors().map(|(sphere, color)| (sphere, color.to_srgb8()))
    }

    fn rows_in_linear_colors(&self) -> Box<dyn Iterator<Item = (Sphere, Color)>> {
        match self.distribution {
            Distribution::Uniform => {
                let radius = self.uniform_radius();
                let mut random = SplitMix::new(self.seed);
                Box::new(std::iter::repeat_with(move || {
                    let center = in_cube(&mut random);
                    (Sphere { center, radius }, color_of_place(2.0 * center))
                }))
            }
            Distribution::Lattice => {
                let n_side = lattice_side(self.count);
                Box::new((0..).map(move |index| lattice_point(index, n_side)))
            }
            Distribution::Packing => Box::new(Heap::of(self)),
        }
    }

    fn uniform_radius(&self) -> f64 {
        UNIFORM_RADIUS / libm::cbrt(self.count as f64)
    }

    /// A distance from the origin that no sphere reaches beyond.
    fn reach(&self) -> f64 {
        let half_diagonal = 3f64.sqrt();
        match self.distribution {
            Distribution::Uniform => 0.5 * half_diagonal + self.uniform_radius(),
            Distribution::Lattice => (lattice_side(self.count) as f64 - 1.0) * half_diagonal + 1.0,
            // To a corner of the lowest layer; those above are nearer.
            Distribution::Packing => 2f64.sqrt() * (Heap::of(self).n_side as f64 - 1.0) + 2.0,
        }
    }

    /// A camera that has all of the cloud in its view.
    pub fn camera(&self) -> Camera {
        let from = DVec3::new(1.0, 1.0, 2.0) / 6f64.sqrt();
        let distance = self.reach() / libm::sin((FOV_DEGREES / 2.0).to_radians());
        let projection = Projection::Perspective { fov_degrees: FOV_DEGREES };
        Camera { projection, ..Camera::new(distance * from, DVec3::ZERO) }
    }
}

/// Vertical field of view of the scenes, degrees.
const FOV_DEGREES: f64 = 40.0;

/// Radius of a sphere, as a part of the mean distance between neighbours N^(−1/3).
const UNIFORM_RADIUS: f64 = 0.3;

/// A colour for a place in the cube from −1 to 1; nothing is too dark to be seen.
fn color_of_place(place: DVec3) -> Color {
    Color(place.to_array().map(|x| {
        let part = 0.5 + 0.5 * x;
        0.03 + 0.9 * part * part
    }))
}

/// Evenly in the cube of side 1 about the origin.
fn in_cube(random: &mut SplitMix) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| random.unit() - 0.5))
}

/// The smallest number with a cube of at least `count`.
fn lattice_side(count: u64) -> u64 {
    let rounded = libm::cbrt(count as f64) as u64;
    (rounded.saturating_sub(1)..).find(|n| n * n * n >= count).unwrap_or(rounded)
}

/// Neighbours are 2 apart, which is the sum of their radii, and the whole lattice lies about the
/// origin. Every other sphere is darker, so that neighbours can be told apart.
fn lattice_point(index: u64, n_side: u64) -> (Sphere, Color) {
    let steps = [index % n_side, index / n_side % n_side, index / (n_side * n_side)];
    let last = n_side as f64 - 1.0;
    let center = DVec3::from_array(steps.map(|step| 2.0 * step as f64 - last));
    let shade = if steps.iter().sum::<u64>() % 2 == 0 { 1.0 } else { 0.4 };
    let color = color_of_place(center / last.max(1.0)).0.map(|part| shade * part);
    (Sphere { center, radius: 1.0 }, Color(color))
}

/// See [`Distribution::Packing`]; from below, row by row.
struct Heap {
    /// Spheres along a side of the lowest layer.
    n_side: u64,
    layer: u64,
    /// The places of the layer below, and those of this layer so far: is a sphere there?
    below: Vec<bool>,
    own: Vec<bool>,
    random: SplitMix,
}

/// Part of the places that stay empty though a sphere could lie there.
const GAPS: f64 = 1.0 / 256.0;

impl Heap {
    fn new(n_side: u64, seed: u64) -> Heap {
        let random = SplitMix::new(seed);
        Heap { n_side, layer: 0, below: Vec::new(), own: Vec::new(), random }
    }

    /// One that has as many spheres as the recipe, and not many more.
    fn of(recipe: &Recipe) -> Heap {
        let mut n_side = (recipe.count as f64 / HEAP_LAYERS).sqrt().ceil() as u64;
        let n_spheres = |n_side| Heap::new(n_side, recipe.seed).take(recipe.count as usize).count();
        while (n_spheres(n_side) as u64) < recipe.count {
            n_side += n_side / 32 + 1;
        }
        Heap::new(n_side, recipe.seed)
    }

    /// True where all four places below this one have their sphere.
    fn is_held(&self, row: usize, column: usize, n: usize) -> bool {
        let at = row * (n + 1) + column;
        self.layer == 0 || [at, at + 1, at + n + 1, at + n + 2].iter().all(|&i| self.below[i])
    }
}

/// Most layers' worth of full ones in a heap, about: the gaps grow upwards.
const HEAP_LAYERS: f64 = 8.0;

impl Iterator for Heap {
    type Item = (Sphere, Color);

    fn next(&mut self) -> Option<(Sphere, Color)> {
        loop {
            let n = (self.n_side - self.layer) as usize;
            if n == 0 {
                return None;
            }
            if self.own.len() == n * n {
                self.below = std::mem::take(&mut self.own);
                self.layer += 1;
                continue;
            }
            let (row, column) = (self.own.len() / n, self.own.len() % n);
            let is_there = self.is_held(row, column, n) && self.random.unit() >= GAPS;
            self.own.push(is_there);
            if is_there {
                let place = |index: usize| 2.0 * index as f64 - (n as f64 - 1.0);
                let height = 1.0 + 2f64.sqrt() * self.layer as f64;
                let center = DVec3::new(place(column), height, place(row));
                // Between clay and sand.
                let mix = self.random.unit();
                let color = [0.5 + 0.35 * mix, 0.22 + 0.4 * mix, 0.12 + 0.3 * mix];
                return Some((Sphere { center, radius: 1.0 }, Color(color)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recipe(distribution: Distribution, count: u64) -> Recipe {
        Recipe { distribution, count, seed: 9 }
    }

    #[test]
    fn every_sphere_is_within_reach_and_some_nearly_at_its_end() {
        for distribution in Distribution::ALL {
            let recipe = recipe(distribution, 1000);
            let reach = recipe.reach();
            let farthest = recipe
                .rows()
                .take(recipe.count as usize)
                .map(|(sphere, _)| sphere.center.length() + sphere.radius)
                .fold(0.0, f64::max);
            let name = distribution.name();
            assert!(farthest <= reach, "{name}: {farthest} > {reach}");
            assert!(farthest > 0.5 * reach, "{name}: {farthest} << {reach}");
        }
    }

    #[test]
    fn a_lattice_has_room_for_all() {
        for count in [1, 2, 7, 8, 9, 26, 27, 28, 999_999, 1_000_000, 1_000_001, (1 << 32) - 3] {
            let side = lattice_side(count);
            assert!((side - 1).pow(3) < count && count <= side.pow(3), "{count}: {side}");
        }
    }

    /// x, radius and blue of the last sphere as they came out on x86-64 Linux. Another machine that
    /// rounds otherwise on the way would write another file.
    #[test]
    fn bytes_are_the_same_everywhere() {
        let known = [
            (Distribution::Uniform, [0x3fa704af50de0890, 0x3f9eb851eb851eb8, 0x3fd6b906b2755508]),
            (Distribution::Lattice, [0x4022000000000000, 0x3ff0000000000000, 0x3fd7ced916872b03]),
            (Distribution::Packing, [0xc000000000000000, 0x3ff0000000000000, 0x3fd6288c2f3a163b]),
        ];
        for (distribution, bits) in known {
            let mut rows = recipe(distribution, 1000).rows_in_linear_colors();
            let (sphere, color) = rows.nth(999).unwrap();
            let found = [sphere.center.x, sphere.radius, color.0[2]].map(f64::to_bits);
            assert_eq!(found, bits, "{}: {found:x?}", distribution.name());
        }
    }
}
