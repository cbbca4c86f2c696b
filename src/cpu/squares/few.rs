//! Few objects: squares of pixels, large ones first.

use crate::guard::{self, Reach};
use crate::kernel::Lists;
use crate::kernel::certified::{
    Frame, Places, PlaneCertified, SeenObjects, SphereCertified, UNDECIDED, Widening,
};
use crate::prepare::{Objects, Prepared};
use crate::rays::{CameraF32, Pixels};
use crate::scene::Scene;
use crate::trace::Mixed;

/// Columns and rows of the largest squares, px.
pub(super) const LARGEST: u32 = 16;

/// The objects as squares of some size see them.
pub(super) struct Size {
    /// Columns and rows, px.
    pub side: u32,
    lists: Lists<SphereCertified, PlaneCertified>,
    widening: Widening<f32>,
}

impl Size {
    /// `None` where the squares are too large for the bounds.
    pub fn new(pixels: &Pixels, scene: &Scene, side: u32, reach: Reach) -> Option<Size> {
        let frame = Frame::of_squares(pixels, scene, reach)?;
        let lists = frame.objects(scene, scene.spheres.iter());
        Some(Size { side, lists, widening: frame.widening() })
    }
}

/// Pixels that are looked at in squares.
pub(super) struct Few<'a> {
    /// Of the picture of the samples.
    pub prepared: &'a Prepared,
    pub pixels: &'a Pixels,
    /// Samples across and down a pixel.
    pub n: u32,
    /// From large squares to single pixels.
    pub sizes: Vec<Size>,
}

/// Room for the squares of some rows.
#[derive(Default)]
pub(super) struct Room {
    open: Vec<[u32; 2]>,
    next: Vec<[u32; 2]>,
    places: Places,
    ids: Vec<u32>,
}

impl<'a> Few<'a> {
    /// `None` where pixels are too large for the bounds.
    pub fn new(prepared: &'a Prepared, pixels: &'a Pixels, n: u32) -> Option<Few<'a>> {
        let size =
            |side| Size::new(pixels, &prepared.scene, side, Reach::of_samples(pixels, side, n));
        let sides = [LARGEST, LARGEST / 4, LARGEST / 16].into_iter();
        let sizes: Vec<Size> = sides.filter_map(size).collect();
        let has_pixels = sizes.last().is_some_and(|size| size.side == 1);
        has_pixels.then_some(Few { prepared, pixels, n, sizes })
    }

    /// Finds the pixels of some rows that show one object alone, and what f32 sees of the samples of the others.
    pub fn look(&self, first_row: u32, whole: &mut [u32], room: &mut Room) -> Mixed {
        self.find_whole(first_row, whole, room);
        self.sample(first_row, whole, room)
    }

    /// Finds the pixels of some rows that show one object alone, and leaves the others [`UNDECIDED`].
    pub fn find_whole(&self, first_row: u32, whole: &mut [u32], room: &mut Room) {
        let Pixels { width, image_width, image_height, .. } = *self.pixels;
        let n_rows = whole.len() as u32 / width;
        let camera = CameraF32::new(self.pixels);
        let Room { open, next, places, ids } = room;
        open.clear();
        let largest = self.sizes[0].side;
        for y in (0..n_rows).step_by(largest as usize) {
            open.extend((0..width).step_by(largest as usize).map(|x| [x, y]));
        }
        for (size, smaller) in self.sizes.iter().zip(self.sizes[1..].iter().map(Some).chain([None]))
        {
            let side = size.side;
            // What the rows cut off is no square of the picture.
            let is_inside = |[x, y]: [u32; 2]| x + side <= width && y + side <= n_rows;
            places.clear();
            next.clear();
            let mut split = |[x, y]: [u32; 2]| {
                let step = smaller.map_or(side, |size| size.side) as usize;
                for y in (y..(y + side).min(n_rows)).step_by(step) {
                    next.extend((x..(x + side).min(width)).step_by(step).map(|x| [x, y]));
                }
            };
            open.retain(|&square| {
                if !is_inside(square) {
                    split(square);
                }
                is_inside(square)
            });
            for [x, y] in &*open {
                let (x, y) = (self.pixels.x + x, self.pixels.y + first_row + y);
                // Of its middle, as `Pixels::offset2` has it of a pixel's.
                let i = i64::from(2 * x + side) - i64::from(image_width);
                let j = i64::from(image_height) - i64::from(2 * y + side);
                places.push((i, j));
            }
            let (lists, widening) = (&size.lists, size.widening);
            SeenObjects { lists, widening, camera: &camera, near: true }.decide(places, ids);
            for (&[x, y], &id) in open.iter().zip(&*ids) {
                if id == UNDECIDED && smaller.is_some() {
                    split([x, y]);
                    continue;
                }
                for row in y..y + side {
                    let first = (row * width + x) as usize;
                    whole[first..first + side as usize].fill(id);
                }
            }
            std::mem::swap(open, next);
        }
    }

    /// What f32 sees of the samples of those pixels of some rows that are left.
    fn sample(&self, first_row: u32, whole: &[u32], room: &mut Room) -> Mixed {
        let Objects::Certified(lists) = &self.prepared.objects else { return Mixed::default() };
        let samples = self.pixels.samples(self.n);
        let camera = CameraF32::new(&samples);
        let Room { places, ids, .. } = room;
        places.clear();
        let first = (first_row * self.pixels.width) as usize;
        let mixed: Vec<u32> = (0..whole.len())
            .filter(|&at| whole[at] == UNDECIDED)
            .map(|at| (first + at) as u32)
            .collect();
        for &pixel in &mixed {
            let (x, y) = self.pixels.xy(pixel as usize);
            for y in y * self.n..(y + 1) * self.n {
                for x in x * self.n..(x + 1) * self.n {
                    places.push(samples.offset2(x, y));
                }
            }
        }
        let (widening, near) = (guard::widening_f32(), self.prepared.near);
        SeenObjects { lists, widening, camera: &camera, near }.decide(places, ids);
        (mixed, std::mem::take(ids))
    }
}
