//! What f64 says of the rays that f32 leaves open.

use glam::DVec3;

use super::cloud::TreeAim;
use super::list::beam_of;
use super::tile::Tile;
use crate::bvh::{Bvh, Enter, Node, Visitor, WIDTH, Walk, above};
use crate::guard::{self, Reach};
use crate::num::{Float, V3};
use crate::prepare::{Prepared, Scaled, power_of_two};
use crate::rays::{self, Frame, Pixels, Rays};
use crate::scene::Object;
use crate::seen::{Bounds, Eye, Objects, Ray, bounds_from};

/// Finds what rays see in f64, or the objects that may be the nearest.
pub struct Find64<'a> {
    prepared: &'a Prepared,
    rays: Rays64<'a>,
    tree: Option<&'a Bvh>,
    /// For lists, whose rays have eyes of their own: the objects beside the tree, or all where there is none.
    listed: Vec<(u32, Object<'a>)>,
}

/// The rays in f64.
enum Rays64<'a> {
    Pixels(Box<OfPixels<'a>>),
    List(&'a [rays::WorldRay]),
    /// The bounds don't hold for them.
    Unknown,
}

/// The pixels of a picture.
struct OfPixels<'a> {
    pixels: &'a Pixels,
    camera: Frame<f64>,
    eye: Eye,
    /// The objects beside the tree, or all where they are few.
    objects: Objects<f64>,
    /// Where there is a tree.
    aim: Option<TreeAim>,
}

/// Up to so many objects are looked at one after the other also where there is a tree.
const FEW: usize = 64;

/// The objects that a ray may see.
#[derive(Default)]
pub struct Candidates {
    /// By ids, with lower bounds of `t`.
    roots: Vec<(u32, f64)>,
    /// One of them is certainly hit no later.
    least_high: f64,
    walk: Walk,
}

/// What f64 says of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Said<'a> {
    /// The object, 0 for the background.
    Sees(u32),
    /// One of these, ascending, or none.
    Open(&'a [(u32, f64)]),
}

impl Candidates {
    fn clear(&mut self) {
        self.roots.clear();
        self.least_high = f64::BEYOND;
    }

    #[inline(always)]
    fn add(&mut self, id: u32, bounds: Option<Bounds<f64>>) {
        if let Some(Bounds { low, high }) = bounds
            && low < f64::BEYOND
            && low <= self.least_high
        {
            self.least_high = self.least_high.min(high);
            self.roots.push((id, low));
        }
    }

    /// `scale` is what `t` is multiplied with.
    fn say(&mut self, scale: f64) -> Said<'_> {
        let Candidates { roots, least_high, .. } = self;
        roots.retain(|&(_, low)| low <= *least_high);
        // A `t` beyond f32's range is only left open.
        let in_range = scale.is_normal() && *least_high * scale < power_of_two(127);
        match roots[..] {
            [] => Said::Sees(0),
            [(id, _)] if *least_high < f64::BEYOND && in_range => Said::Sees(id),
            _ => {
                roots.sort_unstable_by_key(|&(id, _)| id);
                Said::Open(roots)
            }
        }
    }
}

impl<'a> Find64<'a> {
    /// For the rays that a scene is prepared for.
    pub fn new(prepared: &'a Prepared, rays: &'a Rays) -> Find64<'a> {
        let scene = &*prepared.scene;
        let tree = prepared.hierarchy.as_ref().map(|hierarchy| &*hierarchy.bvh);
        let mut listed = Vec::new();
        let rays = match rays {
            Rays::Pixels(pixels) if !pixels.is_in_range() || pixels.spread() > f64::FARTHEST => {
                Rays64::Unknown
            }
            Rays::Pixels(pixels) => {
                let eye = Eye::of_pixels(pixels, Reach::default(), f64::UNIT);
                let tree = tree.filter(|_| scene.n_objects() > FEW);
                let objects = match (tree, &prepared.hierarchy) {
                    (Some(_), Some(hierarchy)) => {
                        Objects::new(prepared.beside(&hierarchy.rest), &eye)
                    }
                    _ => Objects::new(prepared.seen_objects(), &eye),
                };
                let aim = tree.map(|bvh| TreeAim::new(bvh, pixels));
                let camera = Frame::of_pixels(pixels);
                Rays64::Pixels(Box::new(OfPixels { pixels, camera, eye, objects, aim }))
            }
            Rays::List(rays) => {
                listed = prepared.listed();
                Rays64::List(rays)
            }
        };
        Find64 { prepared, rays, tree, listed }
    }

    /// Whether the bounds hold for these rays.
    pub fn are_known(&self) -> bool {
        !matches!(self.rays, Rays64::Unknown)
    }

    /// Whether [`Find64::decide`] finds rays side by side.
    pub fn is_listed(&self) -> bool {
        matches!(&self.rays, Rays64::Pixels(rays) if rays.aim.is_none())
    }

    /// The ids of some rays, [`crate::num::OPEN`] where f64 leaves them so; where all objects are listed.
    pub fn decide(&self, rays: &[u32], tile: &mut Tile, ids: &mut [u32]) {
        let Rays64::Pixels(all) = &self.rays else { return };
        let OfPixels { pixels, camera, objects, .. } = &**all;
        tile.clear();
        for &ray in rays {
            let (x, y) = pixels.xy(ray as usize);
            tile.push(pixels.offset2(x, y));
        }
        tile.find_f64(camera, objects);
        ids.copy_from_slice(&tile.ids);
    }

    /// What a ray sees, or may see.
    pub fn look<'c>(&self, index: usize, candidates: &'c mut Candidates) -> Said<'c> {
        candidates.clear();
        let scale = match &self.rays {
            Rays64::Unknown => {
                candidates.roots.extend(self.prepared.seen_objects().map(|(id, _)| (id, 0.0)));
                0.0
            }
            Rays64::Pixels(all) => {
                let OfPixels { pixels, camera, eye, objects, aim } = &**all;
                let (x, y) = pixels.xy(index);
                let (i, j) = pixels.offset2(x, y);
                let ray = camera.ray(i as f64, j as f64);
                objects.each(&ray, |id, bounds| candidates.add(id, bounds));
                if let (Some(bvh), Some(aim)) = (self.tree, aim) {
                    let beam = aim.beam([i as f32; 2], [j as f32; 2]);
                    self.walk(
                        bvh,
                        beam,
                        Seek { bvh, beside: self.close(), ray, eye: *eye, candidates },
                    );
                }
                1.0
            }
            Rays64::List(rays) => {
                let rays::WorldRay { origin, direction } = rays[index];
                if direction == DVec3::ZERO {
                    return Said::Sees(0);
                }
                let scaled = Scaled::new(direction);
                let input = guard::LIST_F64;
                let eye = Eye { input, unit: f64::UNIT, ..Eye::of_list(origin, 0.0) };
                let ray = Ray::new(V3([0.0; 3]), V3(scaled.rounded().to_array()));
                for &(id, object) in &self.listed {
                    candidates.add(id, bounds_from(&eye, object, &ray));
                }
                if let Some(bvh) = self.tree {
                    let beam = beam_of(bvh, origin, scaled.rounded());
                    self.walk(bvh, beam, Seek { bvh, beside: &[], ray, eye, candidates });
                }
                power_of_two(-scaled.exponent())
            }
        };
        candidates.say(scale)
    }

    /// Ids of the spheres that are looked at beside the tree although it holds them, ascending.
    fn close(&self) -> &[u32] {
        self.prepared.hierarchy.as_ref().map_or(&[], |hierarchy| &hierarchy.leaves.close)
    }

    fn walk(&self, bvh: &Bvh, beam: crate::bvh::Beam, seek: Seek) {
        let mut walk = std::mem::take(&mut seek.candidates.walk);
        let mut seek = seek;
        walk.begin_at_root(bvh, beam);
        while walk.step(bvh, &mut seek) {}
        seek.candidates.walk = walk;
    }
}

/// Looks for the candidates of a ray in the tree.
struct Seek<'a> {
    bvh: &'a Bvh,
    /// Ids of those that were looked at already, ascending.
    beside: &'a [u32],
    ray: Ray<f64>,
    eye: Eye,
    candidates: &'a mut Candidates,
}

impl Visitor for Seek<'_> {
    #[inline(always)]
    fn last(&self) -> f32 {
        above(self.candidates.least_high)
    }

    #[inline(always)]
    fn visit(&mut self, node: &Node, mut leaves: u32, enter: &Enter) {
        while leaves != 0 {
            let lane = leaves.trailing_zeros();
            leaves &= leaves - 1;
            if enter.0[lane as usize % WIDTH] <= self.last() {
                let place = node.place(lane) as usize;
                if self.beside.binary_search(&self.bvh.ids[place]).is_ok() {
                    continue;
                }
                let sphere = Object::Sphere(&self.bvh.spheres[place]);
                let bounds = bounds_from(&self.eye, sphere, &self.ray);
                self.candidates.add(self.bvh.ids[place], bounds);
            }
        }
    }
}
