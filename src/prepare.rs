//! Scene → [`Prepared`]: the plain numbers that every backend traces, the same for all of them.

mod certified_light;
mod device_bvh;
mod first_stage;
mod hierarchy;
mod lamp;
mod unit;

use std::collections::HashSet;
use std::ops::RangeInclusive;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use glam::DVec3;

use crate::bounds::{self, Footprint};
use crate::error::{Error, Result};
use crate::kernel::coordinates::Coordinates;
use crate::kernel::{FloatType, Kernel, Space};
use crate::num::Float as _;
use crate::num::fields::words;
use crate::num::typical::{largest_of_most, nth, sample};
use crate::query::Outputs;
use crate::rays::{Lens, Origins, Pixels, Rays, WorldRay, look_at_all};
use crate::scene::{Object, Scene};
use crate::shape::{
    PlaneRecord, RayOrigin, Record as _, ShapeRecord as _, SphereLeaf, SphereRecord,
};
use crate::support::control::Control;
use crate::support::fpu_check;
use crate::support::memory;

pub use crate::kernel::certified::{FEW_SPHERES, LISTED_SPHERES};
pub use crate::kernel::coordinates::split;
pub use crate::kernel::{Lists, ObjectRecords};
pub use crate::num::{ScaledInteger, exponent_of, power_of_two};
pub use certified_light::{CertifiedLamp, CertifiedLighting};
pub use device_bvh::DeviceBvh;
pub use hierarchy::Hierarchy;
pub use lamp::{Lighting, MOST_IN_F32, PreparedLight};
pub use unit::LengthUnit;

use first_stage::is_left_open;

/// The parts and numbers of a shader that a scene asks for: what it does not, is in no shader and in no
/// binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ShaderKey {
    /// The kernel.
    pub kernel: Kernel,
    /// That of the camera whose rays they are; `None` for those of a list.
    pub lens: Option<Lens>,
    /// Whether spheres are found by the kernel `certified` through the boxes of a tree, except for those outside of it.
    pub tree: bool,
    /// Number of spheres that are tested one after the other.
    pub n_spheres: usize,
    /// Whether one of these is so close and so large that its size hides its distance.
    pub close: bool,
    /// Number of planes.
    pub n_planes: usize,
    /// True where `t` and normals are wanted.
    pub surface: bool,
    /// Where it lights what it sees.
    pub light: Option<LightKey>,
    /// Whether lamps and samples are written one after the other while they are few: devices in software run that sooner, but
    /// cards compile it for seconds.
    pub unrolls: bool,
}

/// How a shader lights what it sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LightKey {
    /// As a kernel without a proof does.
    Baseline {
        /// Number of lamps.
        n_lamps: usize,
    },
    /// As `certified` does.
    Certified {
        /// Samples across and down a pixel.
        n_samples: u32,
        /// Number of lamps.
        n_lamps: usize,
        /// Numbers of occluders: spheres, planes, and large spheres ([`crate::shape::GroundOccluder`]).
        n_met: [usize; 3],
        /// Whether a lamp is close to a surface.
        has_contacts: bool,
    },
}

/// A scene ready to be traced by one kernel along one bundle of rays.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// The scene that this was made from.
    pub scene: Arc<Scene>,
    /// The unit of length of the scene and its rays; `t` is in world units.
    pub unit: LengthUnit,
    /// The kernel.
    pub kernel: Kernel,
    /// The point of the scene that coordinates are relative to: the camera's position; for lists the
    /// middle of the origins, or the world's origin for a kernel in f64.
    pub reference: DVec3,
    /// The objects.
    pub objects: ObjectRecords,
    /// True where the bounds of the certified kernel's f32 stage hold for these rays.
    pub in_range: bool,
    /// For the certified kernel and many spheres. `objects` then has only those that are not in the tree.
    pub hierarchy: Option<Hierarchy>,
    /// The rays as the objects' numbers in f32 ask for them.
    pub eye: RayOrigin,
    /// All of the picture whose pixels the numbers hold for; `None` where they do for rays of lists that start no farther from
    /// the reference point than the eye's.
    pub(crate) picture: Option<Pixels>,
    starts_in_f64: bool,
    /// Ids of the objects behind the spheres that a ray may see, found when they are first asked for: of those in one place the
    /// first. No other is in the way of anything that the first is not in.
    others: OnceLock<Vec<u32>>,
}

impl Prepared {
    /// Prepares `scene` for `rays`. It then traces these rays and parts of them; see
    /// [`Prepared::check`].
    ///
    /// # Errors
    /// [`Error::Usage`] for a ray with a number that is not finite;
    /// [`Error::TooLarge`] where the kernel's numbers or the hierarchy over many spheres would not fit
    /// the memory; [`Error::Host`] where this processor's arithmetic is not what the certified kernel's
    /// proof asks for.
    pub fn new(scene: Arc<Scene>, kernel: Kernel, rays: &Rays) -> Result<Prepared> {
        Prepared::renewed(None, scene, kernel, rays, &Control::default())
    }

    /// Prepares `scene` for `rays` as [`Prepared::new`] does; `control` can stop it between its steps. What depends on the scene
    /// alone is taken from `old` where that is of the same scene: the tree over many spheres.
    ///
    /// # Errors
    /// Those of [`Prepared::new`]; [`Error::Interrupted`] as well.
    pub fn renewed(
        old: Option<&Prepared>,
        scene: Arc<Scene>,
        kernel: Kernel,
        rays: &Rays,
        control: &Control,
    ) -> Result<Prepared> {
        control.check()?;
        let (picture, eye) = eye_of(rays, kernel)?;
        let reference = eye.reference;
        let n_spheres = scene.spheres.len();
        let (mut in_range, mut hierarchy) = (true, None);
        if kernel == Kernel::Certified {
            fpu_check::check_all()?;
            in_range =
                picture.is_none_or(|picture| picture.is_in_range()) && eye.spread <= f32::FARTHEST;
            let most_listed = if picture.is_some() { FEW_SPHERES } else { LISTED_SPHERES };
            if in_range && n_spheres > most_listed {
                let old = old.filter(|old| Arc::ptr_eq(&old.scene, &scene));
                let old = old.and_then(|old| old.hierarchy.as_ref());
                hierarchy = Some(Hierarchy::new(&eye, &scene, old, control)?);
            }
        } else {
            memory::require(
                format!("preparing {n_spheres} spheres for the kernel `{}`", kernel.name()),
                record_bytes(kernel, &scene),
                "free some, or split the scene",
            )?;
        }
        let mut prepared = Prepared {
            objects: kernel.objects(&scene, reference),
            scene,
            unit: LengthUnit::WORLD,
            kernel,
            reference,
            in_range,
            hierarchy,
            eye,
            picture,
            starts_in_f64: false,
            others: OnceLock::new(),
        };
        if kernel == Kernel::Certified {
            prepared.objects = prepared.records();
            prepared.starts_in_f64 =
                !in_range || prepared.hierarchy.is_none() && is_left_open(&prepared, rays);
        }
        Ok(prepared)
    }

    /// Returns the same with a scene and rays whose unit of length is this one, for the kernel `certified`.
    pub fn in_unit(self, unit: LengthUnit) -> Prepared {
        Prepared { unit, ..self }
    }

    /// Ids of the spheres that each ray looks at where the others are in a tree, ascending.
    pub(crate) fn rest(&self) -> Option<&[u32]> {
        Some(&self.hierarchy.as_ref()?.leaves.rest)
    }

    /// Ids of the spheres that are in no tree where there is one, ascending.
    pub(crate) fn outside(&self) -> Option<&[u32]> {
        Some(&self.hierarchy.as_ref()?.bvh.outside)
    }

    /// The objects that a ray may see and their ids: the spheres with these ids, or all where none are given, and all others. Of
    /// those in one place only the first is among all, and none that no ray hits.
    pub(crate) fn listed(&self, spheres: Option<&[u32]>) -> Vec<(u32, Object<'_>)> {
        let scene = &*self.scene;
        let firsts = |ids: RangeInclusive<u32>| {
            let (mut seen, place) = (HashSet::new(), |&id: &u32| scene.object(id)?.place());
            ids.filter(|id| place(id).is_some_and(|place| seen.insert(place))).collect()
        };
        let [n_spheres, n_objects] = [scene.spheres.len(), scene.n_objects()].map(|n| n as u32);
        let spheres = spheres.map_or_else(|| firsts(1..=n_spheres), <[u32]>::to_vec);
        let others = self.others.get_or_init(|| firsts(n_spheres + 1..=n_objects));
        let ids = spheres.into_iter().chain(others.iter().copied());
        ids.filter_map(|id| Some((id, scene.object(id)?))).collect()
    }

    /// The records of the objects that a device tests one after the other: of many spheres those of
    /// [`Leaves::rest`](crate::bvh::Leaves::rest), and behind them some that stand for none. None where f32 has no say.
    fn records(&self) -> ObjectRecords {
        let n_spheres = match &self.hierarchy {
            Some(hierarchy) => hierarchy.n_places_of_rest(),
            None if self.in_range => self.scene.spheres.len(),
            None => 0,
        };
        // A sphere's words begin with those of its leaf; the others are 0.
        let mut spheres = vec![words(&SphereLeaf::<f32>::nowhere()); n_spheres];
        let mut planes = vec![words(&PlaneRecord::NEVER.round::<f32>()); self.scene.planes.len()];
        let mut any_close = false;
        let listed = if self.in_range { self.listed(self.rest()) } else { Vec::new() };
        for (place, (id, object)) in listed.into_iter().enumerate() {
            let index = id as usize - 1;
            match object {
                Object::Sphere(sphere) => {
                    let seen = SphereRecord::new::<f32>(sphere, &self.eye);
                    any_close |= seen.is_close();
                    let place = if self.hierarchy.is_some() { place } else { index };
                    spheres[place] = words(&seen.round::<f32>());
                }
                Object::Plane(plane) => {
                    let seen = PlaneRecord::new::<f32>(plane, &self.eye);
                    planes[index - self.scene.spheres.len()] = words(&seen.round::<f32>());
                }
            }
        }
        ObjectRecords::Certified { lists: Lists { spheres, planes }, any_close }
    }

    /// Checks that this was made for `rays`: pixels of the same picture and within it, or rays of a list.
    ///
    /// # Errors
    /// [`Error::Usage`] where it was not, and for a ray with a number that is not finite;
    /// [`Error::TooLarge`] for more rays than 32 bits count.
    pub fn check(&self, rays: &Rays) -> Result<()> {
        let suits = match rays {
            Rays::Pixels(pixels) => {
                self.picture == Some(pixels.picture()) && pixels.is_in_picture()
            }
            Rays::List(list) => {
                check_numbers(list)?;
                self.picture.is_none()
            }
        };
        if !suits {
            let message = "the scene was prepared for other rays; prepare it for these";
            return Err(Error::Usage(message.into()));
        }
        if u32::try_from(rays.len()).is_err() {
            return Err(Error::TooLarge(
                format!(
                    "{} rays at once; at most {} can be counted: trace them in parts",
                    rays.len(),
                    u32::MAX
                )
                .into(),
            ));
        }
        Ok(())
    }

    /// True where preparing anew for `rays` would give the same numbers. Other lists have a better reference point of their own.
    pub fn is_for(&self, rays: &Rays) -> bool {
        eye_of(rays, self.kernel).is_ok_and(|of_rays| of_rays == (self.picture, self.eye))
    }

    /// The coordinates of the kernel's numbers.
    pub fn coordinates(&self) -> Coordinates {
        let origin = match self.kernel.about().space {
            Space::World => DVec3::ZERO,
            Space::Reference => self.reference,
        };
        Coordinates { kernel: self.kernel, origin, spread: self.origins().spread }
    }

    /// The region of origins that f32 decides rays of a list from.
    pub fn origins(&self) -> Origins {
        Origins { reference: self.reference, spread: self.eye.spread }
    }

    /// True where f64 decides all rays of the kernel `certified`, on every device: where the bounds of f32
    /// don't hold for them, or where f32 leaves more than half of some that were tried open. Few objects
    /// alone are tried: through a hierarchy f64 takes many times as long as f32.
    pub fn starts_in_f64(&self) -> bool {
        self.starts_in_f64
    }

    /// Spheres that a device tests one after the other.
    pub fn n_listed_spheres(&self) -> usize {
        match &self.objects {
            ObjectRecords::Certified { lists, .. } => lists.spheres.len(),
            _ => self.scene.spheres.len(),
        }
    }

    /// Objects that a device tests one after the other.
    pub fn n_listed(&self) -> usize {
        self.n_listed_spheres() + self.scene.planes.len()
    }

    /// Bytes of what the CPU looks at: the objects' records, and the hierarchy.
    pub fn bytes(&self) -> u64 {
        let (spheres, planes) = self.objects.bytes();
        let hierarchy = self.hierarchy.as_ref().map_or(0, Hierarchy::bytes);
        (spheres.len() + planes.len()) as u64 + hierarchy
    }

    /// Time that building the hierarchy took; zero where there is none.
    pub fn build_time(&self) -> Duration {
        self.hierarchy.as_ref().map_or(Duration::ZERO, |hierarchy| hierarchy.build_time)
    }

    /// The shader for this scene.
    pub fn shader_key(&self, wants: Outputs) -> ShaderKey {
        let is_certified = self.kernel == Kernel::Certified;
        ShaderKey {
            kernel: self.kernel,
            lens: self.picture.map(|picture| picture.view.lens),
            tree: self.hierarchy.is_some(),
            n_spheres: self.n_listed_spheres(),
            close: matches!(self.objects, ObjectRecords::Certified { any_close: true, .. }),
            n_planes: self.scene.planes.len(),
            // The certified kernel's f32 only proposes objects; t and normals come from f64.
            surface: wants.surface && !is_certified,
            light: None,
            unrolls: false,
        }
    }

    /// The shader for the light on what a picture's pixels see.
    pub fn light_key(&self, light: LightKey) -> ShaderKey {
        ShaderKey { light: Some(light), ..self.shader_key(Outputs::default()) }
    }
}

/// All of the picture that rays are of, if they are of one, and the rays as the objects' numbers in f32 ask for them.
fn eye_of(rays: &Rays, kernel: Kernel) -> Result<(Option<Pixels>, RayOrigin)> {
    match rays {
        Rays::Pixels(pixels) => {
            let eye = RayOrigin::of_pixels(pixels, Footprint::default(), f32::UNIT);
            Ok((Some(pixels.picture()), eye))
        }
        Rays::List(list) => {
            check_numbers(list)?;
            let Origins { reference, spread } = match (kernel, kernel.about().float) {
                // In f64, c − o straight from the scene's numbers is rounded only once.
                (_, FloatType::F64) => origins_about(list, |_| true, Some(DVec3::ZERO)),
                (Kernel::Certified, FloatType::F32) => {
                    let ordinary = ordinary_origins(list);
                    origins_about(list, |origin| !ordinary.is_far(origin), None)
                }
                (_, FloatType::F32) => origins_about(list, |_| true, None),
            };
            Ok((None, RayOrigin::of_list(reference, spread)))
        }
    }
}

/// Bytes of the numbers of a scene's objects, one after the other, for a kernel.
pub fn record_bytes(kernel: Kernel, scene: &Scene) -> u64 {
    let [sphere, plane] = kernel.about().record_bytes;
    (scene.spheres.len() * sphere + scene.planes.len() * plane) as u64
}

/// Checks that the numbers of all rays are finite.
///
/// # Errors
/// [`Error::Usage`] names the first ray with another number.
fn check_numbers(rays: &[WorldRay]) -> Result<()> {
    let is_finite = |ray: &WorldRay| ray.origin.is_finite() && ray.direction.is_finite();
    if look_at_all(rays, true, is_finite, |a, b| a && b) {
        return Ok(());
    }
    let index = rays.iter().position(|ray| !is_finite(ray)).unwrap_or_default();
    Err(Error::Usage(
        format!("ray {index} (counted from 0) has a number that is not finite; leave it out")
            .into(),
    ))
}

/// Returns the middle of the box around some origins, or a given reference point, and the distance of the farthest of these origins.
fn origins_about(
    rays: &[WorldRay],
    is_in: impl Fn(DVec3) -> bool + Sync + Send,
    reference: Option<DVec3>,
) -> Origins {
    let reference = reference.unwrap_or_else(|| {
        let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let range =
            |ray: &WorldRay| if is_in(ray.origin) { (ray.origin, ray.origin) } else { nothing };
        let join = |a: (DVec3, DVec3), b: (DVec3, DVec3)| (a.0.min(b.0), a.1.max(b.1));
        let (low, high) = look_at_all(rays, nothing, range, join);
        // Any point will do for an empty list.
        if low.x <= high.x { low / 2.0 + high / 2.0 } else { DVec3::ZERO }
    });
    let distance = |ray: &WorldRay| match is_in(ray.origin) {
        true => bounds::length_bound(ray.origin - reference),
        false => 0.0,
    };
    Origins { reference, spread: look_at_all(rays, 0.0, distance, f64::max) }
}

/// Returns a point amid the origins, and a distance within which all are, except for the few that are far from most others. f32 leaves
/// their rays undecided, because its errors for all rays grow with the distance of the farthest origin.
fn ordinary_origins(rays: &[WorldRay]) -> Origins {
    /// Factor of the distance of all others. Not a bound: it weighs the errors of all rays against some rays in f64.
    const ROOM: f64 = 8.0;
    let some = sample(rays).map(|ray| ray.origin);
    let median = |axis: usize| {
        let all: Vec<f64> = some.clone().map(|at| at[axis]).collect();
        nth(all.len() / 2, all)
    };
    let reference = DVec3::from_array(std::array::from_fn(median));
    let distances = some.map(|at| bounds::length_bound(at - reference)).collect();
    Origins { reference, spread: ROOM * largest_of_most(distances) }
}
