//! What f64 says of the rays that f32 leaves open.

use glam::DVec3;

use super::batch::RayBatch;
use super::cloud::TreeAim;
use super::list::beam_of;
use crate::bounds::{self, Footprint};
use crate::bvh::{Bvh, Traversal, Visitor, above};
use crate::error::Result;
use crate::num::{Float, UNDECIDED, V3};
use crate::prepare::{Hierarchy, Prepared, ScaledInteger, power_of_two};
use crate::rays::{self, Frame, Pixels, Rays};
use crate::scene::Object;
use crate::shape::{Bounds, Objects, Ray, RayOrigin, bounds_from};
use crate::support::control::Control;
use crate::support::fpu_check;
use crate::support::parallel;

/// Finds what rays see in f64, or the objects that may be the nearest.
pub struct Find64<'a> {
    prepared: &'a Prepared,
    rays: Rays64<'a>,
}

/// The rays in f64.
enum Rays64<'a> {
    Pixels(Box<OfPixels<'a>>),
    /// The rays of a list have eyes of their own. The objects beside the tree, or all where there is none.
    List(&'a [rays::WorldRay], Vec<(u32, Object<'a>)>),
    /// The bounds don't hold for them.
    Unknown,
}

/// The pixels of a picture.
struct OfPixels<'a> {
    pixels: &'a Pixels,
    camera: Frame<f64>,
    eye: RayOrigin,
    /// The objects beside the tree, or all where they are few.
    objects: Objects<f64>,
    /// Where there is a tree.
    aim: Option<TreeAim<'a>>,
}

/// Up to so many objects are looked at one after the other also where there is a tree.
const FEW: usize = 64;

/// Rays that one thread decides at a time.
const RAYS_PER_PART: usize = 1 << 10;

/// Memory for the rays in f64.
#[derive(Default)]
pub struct Scratch64 {
    tile: RayBatch,
    candidates: Candidates,
    walk: Traversal,
}

/// The objects that a ray may see.
#[derive(Default)]
struct Candidates {
    /// By ids, with lower bounds of `t`.
    roots: Vec<(u32, f64)>,
    /// One of them is certainly hit no later.
    least_high: f64,
}

impl Candidates {
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

    /// What [`Find64::look`] says of a ray whose `t` is multiplied with `scale`.
    fn say(&mut self, scale: f64) -> Result<u32, &[(u32, f64)]> {
        let Candidates { roots, least_high } = self;
        roots.retain(|&(_, low)| low <= *least_high);
        // A `t` beyond f32's range is only left open.
        let in_range = scale.is_normal() && *least_high * scale < power_of_two(127);
        match roots[..] {
            [] => Ok(0),
            [(id, _)] if *least_high < f64::BEYOND && in_range => Ok(id),
            _ => {
                roots.sort_unstable_by_key(|&(id, _)| id);
                Err(roots)
            }
        }
    }
}

impl<'a> Find64<'a> {
    /// For the rays that a scene is prepared for.
    pub fn new(prepared: &'a Prepared, rays: &'a Rays) -> Find64<'a> {
        let rays = match rays {
            Rays::Pixels(pixels) if !pixels.is_in_range() || pixels.spread() > f64::FARTHEST => {
                Rays64::Unknown
            }
            Rays::Pixels(pixels) => {
                let eye = RayOrigin::of_pixels(pixels, Footprint::default(), f64::UNIT);
                let is_many = prepared.scene.n_objects() > FEW;
                let objects = prepared.listed(prepared.rest().filter(|_| is_many));
                let hierarchy = prepared.hierarchy.as_ref().filter(|_| is_many);
                Rays64::Pixels(Box::new(OfPixels {
                    pixels,
                    camera: Frame::of_pixels(pixels),
                    eye,
                    objects: Objects::new(objects, &eye),
                    aim: hierarchy.map(|hierarchy| TreeAim::new(&hierarchy.bvh, pixels)),
                }))
            }
            Rays::List(rays) => Rays64::List(rays, prepared.listed(prepared.outside())),
        };
        Find64 { prepared, rays }
    }

    /// Whether the bounds hold for these rays.
    pub fn are_known(&self) -> bool {
        !matches!(self.rays, Rays64::Unknown)
    }

    /// Finds the ids of some rays, [`UNDECIDED`] where f64 leaves them so: side by side where all objects are listed.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] when `control` was cancelled, and that of [`fpu_check::check`].
    pub fn decide(&self, rays: &[u32], control: &Control, ids: &mut [u32]) -> Result<()> {
        let parts = rays.chunks(RAYS_PER_PART).zip(ids.chunks_mut(RAYS_PER_PART));
        let of_part = |scratch: &mut Scratch64, (rays, ids): (&[u32], &mut [u32])| {
            fpu_check::check()?;
            if let Rays64::Pixels(all) = &self.rays
                && let OfPixels { pixels, camera, objects, aim: None, .. } = &**all
            {
                control.check()?;
                let tile = &mut scratch.tile;
                tile.take_samples(pixels, 1, rays);
                // Times the unit, `t` is in f32's range.
                let largest_t = power_of_two(127 - self.prepared.unit.exponent().max(0));
                tile.find_f64(camera, objects, largest_t);
                ids.copy_from_slice(&tile.ids);
                return Ok(());
            }
            for (&ray, id) in rays.iter().zip(ids) {
                // A ray may have millions of spheres to look at.
                control.check()?;
                *id = self.look(ray as usize, scratch).unwrap_or(UNDECIDED);
            }
            Ok(())
        };
        parallel::try_map_in(parts, of_part).map(drop)
    }

    /// The id of what a ray sees, 0 for the background; or those of the objects of which one may be it, ascending, with lower
    /// bounds of `t`.
    pub fn look<'s>(
        &self,
        index: usize,
        scratch: &'s mut Scratch64,
    ) -> Result<u32, &'s [(u32, f64)]> {
        let Scratch64 { candidates, walk, .. } = scratch;
        candidates.roots.clear();
        candidates.least_high = f64::BEYOND;
        let scale = match &self.rays {
            Rays64::Unknown => {
                let all = self.prepared.listed(None);
                candidates.roots.extend(all.into_iter().map(|(id, _)| (id, 0.0)));
                0.0
            }
            Rays64::Pixels(all) => {
                let OfPixels { pixels, camera, eye, objects, aim } = &**all;
                let (x, y) = pixels.xy(index);
                let (i, j) = pixels.offset2(x, y);
                let ray = camera.ray(i as f64, j as f64);
                objects.each(&ray, |id, bounds| candidates.add(id, bounds));
                if let Some(aim) = aim {
                    let (bvh, beam) = (aim.bvh, aim.beam([i as f32; 2], [j as f32; 2]));
                    let beside = self.prepared.rest().unwrap_or_default();
                    let mut seek = CandidateVisitor { bvh, beside, ray, eye: *eye, candidates };
                    walk.all(bvh, bvh.root(), beam, &mut seek);
                }
                self.prepared.unit.factor()
            }
            Rays64::List(rays, listed) => {
                let rays::WorldRay { origin, direction } = rays[index];
                if direction == DVec3::ZERO {
                    return Ok(0);
                }
                let scaled = ScaledInteger::new(direction);
                let input = bounds::LIST_F64;
                let eye = RayOrigin { input, unit: f64::UNIT, ..RayOrigin::of_list(origin, 0.0) };
                let ray = Ray::new(V3([0.0; 3]), V3(scaled.rounded().to_array()));
                for &(id, object) in listed {
                    candidates.add(id, bounds_from(&eye, object, &ray));
                }
                if let Some(Hierarchy { bvh, .. }) = &self.prepared.hierarchy {
                    let beam = beam_of(bvh, origin, scaled.rounded());
                    let mut seek = CandidateVisitor { bvh, beside: &[], ray, eye, candidates };
                    walk.all(bvh, bvh.root(), beam, &mut seek);
                }
                power_of_two(self.prepared.unit.exponent() - scaled.exponent())
            }
        };
        candidates.say(scale)
    }
}

/// Looks for the candidates of a ray in the tree.
struct CandidateVisitor<'a> {
    bvh: &'a Bvh,
    /// Ids of those that were looked at already, ascending.
    beside: &'a [u32],
    ray: Ray<f64>,
    eye: RayOrigin,
    candidates: &'a mut Candidates,
}

impl Visitor for CandidateVisitor<'_> {
    #[inline(always)]
    fn last(&self) -> f32 {
        above(self.candidates.least_high)
    }

    #[inline(always)]
    fn see(&mut self, place: u32) {
        let Bvh { spheres, ids, .. } = self.bvh;
        let (sphere, id) = (&spheres[place as usize], ids[place as usize]);
        if self.beside.binary_search(&id).is_err() {
            let bounds = bounds_from(&self.eye, Object::Sphere(sphere), &self.ray);
            self.candidates.add(id, bounds);
        }
    }
}
