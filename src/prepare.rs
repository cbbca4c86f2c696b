//! Scene → [`Prepared`]: the plain numbers that every backend traces, the same for all of them.

mod hierarchy;

use std::sync::Arc;
use std::time::Duration;

use bytemuck::Zeroable;
use glam::DVec3;

use crate::camera::{Bundle, Lens, View};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::exact::{ExactRay, Root, plane_numbers, sphere_numbers};
use crate::guard::{self, Guard, InputError};
use crate::host;
use crate::kernel::certified::{PlaneCertified, SphereCertified, SphereFar};
use crate::kernel::double::{PlaneDouble, SphereDouble};
use crate::kernel::lecture::{PlaneLecture, SphereLecture};
use crate::kernel::stable::{PlaneStable, SphereStable};
use crate::memory;
use crate::scene::{Plane, Scene, Sphere};
use crate::trace::{Kernel, Ray, Rays, Wants};
use crate::tree::Tree;

pub use hierarchy::{Hierarchy, Seen};

/// What a scene asks of a backend. What is not needed is in no shader and in no binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Needs {
    /// The kernel.
    pub kernel: Kernel,
    /// How the rays lie to each other.
    pub bundle: Bundle,
    /// Number of spheres that are tested one after the other.
    pub n_spheres: usize,
    /// Number of planes.
    pub n_planes: usize,
    /// Whether `t` and normals are wanted.
    pub surface: bool,
    /// Whether a ray of the certified kernel may start in, on or close to a sphere; parallel rays
    /// have one filter for that and for all else.
    pub near: bool,
    /// Whether the spheres of a picture are found through a hierarchy.
    pub hierarchy: bool,
}

impl Needs {
    /// Whether spheres are tested that are far from all rays' one origin.
    pub fn has_far_filter(&self) -> bool {
        self.bundle == Bundle::Point && (self.hierarchy || self.n_spheres > 0 && !self.near)
    }
}

/// The objects in the form of one kernel, in id order.
#[derive(Clone, Debug)]
pub enum Objects {
    /// For [`Kernel::Lecture`].
    Lecture(Lists<SphereLecture, PlaneLecture>),
    /// For [`Kernel::Stable`].
    Stable(Lists<SphereStable, PlaneStable>),
    /// For [`Kernel::Double`].
    Double(Lists<SphereDouble, PlaneDouble>),
    /// For [`Kernel::Certified`].
    Certified(Lists<SphereCertified, PlaneCertified>),
}

/// Spheres and planes, each in id order.
#[derive(Clone, Debug)]
pub struct Lists<S, P> {
    /// Spheres.
    pub spheres: Vec<S>,
    /// Planes.
    pub planes: Vec<P>,
}

impl<S: bytemuck::NoUninit, P: bytemuck::NoUninit> Lists<S, P> {
    fn new(
        scene: &Scene,
        sphere: impl Fn(&Sphere) -> S,
        plane: impl Fn(&Plane) -> P,
    ) -> Lists<S, P> {
        Lists {
            spheres: scene.spheres.iter().map(sphere).collect(),
            planes: scene.planes.iter().map(plane).collect(),
        }
    }

    fn bytes(&self) -> (&[u8], &[u8]) {
        (bytemuck::cast_slice(&self.spheres), bytemuck::cast_slice(&self.planes))
    }
}

impl Objects {
    /// The device's bytes of the spheres and of the planes.
    pub fn bytes(&self) -> (&[u8], &[u8]) {
        match self {
            Objects::Lecture(lists) => lists.bytes(),
            Objects::Stable(lists) => lists.bytes(),
            Objects::Double(lists) => lists.bytes(),
            Objects::Certified(lists) => lists.bytes(),
        }
    }
}

/// A picture of more spheres than this has a hierarchy. It pays from about here on.
pub const FEW_SPHERES: usize = 16;

/// A list of rays into more spheres than this has a hierarchy. Up to here a device tests them one
/// after the other, unrolled, and its compiler takes longer with the square of their number.
pub const LISTED_SPHERES: usize = 128;

/// A scene ready to be traced by one kernel along one bundle of rays.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// The scene that this was made from.
    pub scene: Arc<Scene>,
    /// The kernel.
    pub kernel: Kernel,
    /// What coordinates are relative to, world units: the camera's position; for lists the middle of the origins,
    /// or for [`Kernel::Double`] the world's origin.
    pub reference: DVec3,
    /// The objects.
    pub objects: Objects,
    /// [`Needs::near`]
    pub near: bool,
    /// Whether the bounds of the certified kernel's f32 stage hold for these rays.
    pub in_range: bool,
    /// For the certified kernel and many spheres. `objects` then has only those of
    /// [`Hierarchy::rest`].
    pub hierarchy: Option<Hierarchy>,
    made_for: MadeFor,
}

/// The rays that the numbers of a [`Prepared`] hold for.
#[derive(Clone, Copy, Debug)]
enum MadeFor {
    /// Any pixels of this picture.
    Picture(View, u32, u32),
    /// Rays with origins up to this far from the reference point.
    Origins(f64),
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
        Prepared::new_with(scene, kernel, rays, &Control::default())
    }

    /// As [`Prepared::new`]; `control` can stop it between two steps. The longest one is the joining of
    /// a hierarchy's boxes, about half a second for a million spheres.
    ///
    /// # Errors
    /// [`Error::Interrupted`] as well.
    pub fn new_with(
        scene: Arc<Scene>,
        kernel: Kernel,
        rays: &Rays,
        control: &Control,
    ) -> Result<Prepared> {
        Prepared::with_tree(scene, kernel, rays, None, control)
    }

    /// The same scene prepared for other rays. What depends on the scene alone stays: the tree over
    /// many spheres.
    ///
    /// # Errors
    /// Those of [`Prepared::new_with`].
    pub fn for_rays(&self, rays: &Rays, control: &Control) -> Result<Prepared> {
        let tree = self.hierarchy.as_ref().map(|hierarchy| Arc::clone(&hierarchy.tree));
        Prepared::with_tree(Arc::clone(&self.scene), self.kernel, rays, tree, control)
    }

    fn with_tree(
        scene: Arc<Scene>,
        kernel: Kernel,
        rays: &Rays,
        tree: Option<Arc<Tree>>,
        control: &Control,
    ) -> Result<Prepared> {
        control.check()?;
        refuse_not_finite(rays)?;
        let reference = match rays {
            Rays::Pixels(pixels) => pixels.view.position,
            Rays::List(rays) => reference_of_list(rays, kernel),
        };
        let made_for = match rays {
            Rays::Pixels(p) => MadeFor::Picture(p.view, p.image_width, p.image_height),
            Rays::List(rays) => MadeFor::Origins(spread(rays, reference)),
        };
        if kernel != Kernel::Certified {
            let n_spheres = scene.spheres.len();
            memory::require(
                format!("preparing {n_spheres} spheres for the kernel `{}`", kernel.name()),
                record_bytes(kernel, n_spheres, scene.planes.len()),
                "free some, or split the scene",
            )?;
        }
        let (mut near, mut in_range, mut hierarchy) = (false, true, None);
        let objects = match kernel {
            Kernel::Lecture => {
                Objects::Lecture(Lists::new(&scene, SphereLecture::new, PlaneLecture::new))
            }
            Kernel::Stable => Objects::Stable(Lists::new(
                &scene,
                |sphere| SphereStable::new(sphere, reference),
                |plane| PlaneStable::new(plane, reference),
            )),
            Kernel::Double => Objects::Double(Lists::new(
                &scene,
                |sphere| SphereDouble::new(sphere, reference),
                |plane| PlaneDouble::new(plane, reference),
            )),
            Kernel::Certified => {
                host::check_all()?;
                let frame = Frame::new(rays, reference, &scene);
                (near, in_range) = (frame.near, frame.in_range);
                let planes = scene.planes.iter().map(|plane| frame.plane(plane)).collect();
                let spheres = if scene.spheres.len() <= most_listed(rays) {
                    scene.spheres.iter().map(|sphere| frame.sphere(sphere)).collect()
                } else if in_range {
                    let found = Hierarchy::new(&frame, rays, &scene, tree, control)?;
                    let sphere = |&id: &u32| frame.sphere(&scene.spheres[id as usize - 1]);
                    let rest = found.rest.iter().map(sphere).collect();
                    hierarchy = Some(found);
                    rest
                } else {
                    // The f32 stage has no say about these rays.
                    Vec::new()
                };
                Objects::Certified(Lists { spheres, planes })
            }
        };
        Ok(Prepared { scene, kernel, reference, objects, near, in_range, hierarchy, made_for })
    }

    /// Whether this was made for `rays`: pixels of the same picture and within it, or rays with origins no
    /// farther from the reference point than those it was made for.
    ///
    /// # Errors
    /// [`Error::Usage`] where it was not, and for a ray with a number that is not finite;
    /// [`Error::TooLarge`] for more rays than 32 bits count.
    pub fn check(&self, rays: &Rays) -> Result<()> {
        refuse_not_finite(rays)?;
        let suits = match (self.made_for, rays) {
            (MadeFor::Picture(view, width, height), Rays::Pixels(pixels)) => {
                (view, width, height) == (pixels.view, pixels.image_width, pixels.image_height)
                    && pixels.is_in_picture()
            }
            (MadeFor::Origins(farthest), Rays::List(rays)) => {
                spread(rays, self.reference) <= farthest
            }
            _ => false,
        };
        if !suits {
            let message = "the scene was prepared for other rays; prepare it for these";
            return Err(Error::Usage(message.into()));
        }
        if u32::try_from(rays.len()).is_err() {
            return Err(Error::TooLarge(format!(
                "{} rays at once; at most {} can be counted: trace them in parts",
                rays.len(),
                u32::MAX
            )));
        }
        Ok(())
    }

    /// True where preparing anew for `rays` would give the same numbers. Lists that only fit, see
    /// [`Prepared::check`], may have a better reference point of their own.
    pub fn is_for(&self, rays: &Rays) -> bool {
        let is_same = match (self.made_for, rays) {
            (MadeFor::Origins(farthest), Rays::List(rays)) => {
                reference_of_list(rays, self.kernel) == self.reference
                    && spread(rays, self.reference) == farthest
            }
            _ => true,
        };
        is_same && self.check(rays).is_ok()
    }

    /// How the rays lie to each other.
    pub fn bundle(&self) -> Bundle {
        match self.made_for {
            MadeFor::Picture(view, ..) => view.lens.bundle(),
            MadeFor::Origins(_) => Bundle::Free,
        }
    }

    /// The camera's position in the kernel's coordinates.
    pub fn camera_origin(&self) -> DVec3 {
        match self.kernel {
            Kernel::Lecture => self.reference,
            Kernel::Stable | Kernel::Double | Kernel::Certified => DVec3::ZERO,
        }
    }

    /// Whether the f32 stage has no way to these rays' many spheres, which f64 then finds.
    pub fn is_left_to_f64(&self) -> bool {
        self.hierarchy.as_ref().is_some_and(|hierarchy| hierarchy.seen.is_none())
    }

    /// Spheres that a device tests one after the other.
    pub fn n_listed_spheres(&self) -> usize {
        match &self.objects {
            Objects::Certified(lists) => lists.spheres.len(),
            _ => self.scene.spheres.len(),
        }
    }

    /// Time that building the hierarchy took; zero where there is none.
    pub fn build_time(&self) -> Duration {
        self.hierarchy.as_ref().map_or(Duration::ZERO, |hierarchy| hierarchy.build_time)
    }

    /// What a backend must be able to do for this scene.
    pub fn needs(&self, wants: Wants) -> Needs {
        Needs {
            kernel: self.kernel,
            bundle: self.bundle(),
            n_spheres: self.n_listed_spheres(),
            n_planes: self.scene.planes.len(),
            // The certified kernel's f32 only proposes objects; t and normals come from f64.
            surface: wants.surface && self.kernel != Kernel::Certified,
            near: self.near,
            hierarchy: self.hierarchy.as_ref().is_some_and(|hierarchy| hierarchy.seen.is_some()),
        }
    }
}

/// Bytes of the numbers of this many objects, one after the other, for a kernel.
pub fn record_bytes(kernel: Kernel, n_spheres: usize, n_planes: usize) -> u64 {
    let (sphere, plane) = match kernel {
        Kernel::Lecture => (size_of::<SphereLecture>(), size_of::<PlaneLecture>()),
        Kernel::Stable => (size_of::<SphereStable>(), size_of::<PlaneStable>()),
        Kernel::Double => (size_of::<SphereDouble>(), size_of::<PlaneDouble>()),
        Kernel::Certified => (size_of::<SphereCertified>(), size_of::<PlaneCertified>()),
    };
    (n_spheres * sphere + n_planes * plane) as u64
}

fn most_listed(rays: &Rays) -> usize {
    match rays {
        Rays::Pixels(_) => FEW_SPHERES,
        Rays::List(_) => LISTED_SPHERES,
    }
}

/// Largest distance of an origin from the reference point.
fn spread(rays: &[Ray], reference: DVec3) -> f64 {
    rays.iter().map(|ray| guard::length_bound(ray.origin - reference)).fold(0.0, f64::max)
}

fn reference_of_list(rays: &[Ray], kernel: Kernel) -> DVec3 {
    match kernel {
        // In f64, c − o straight from the scene's numbers is rounded only once.
        Kernel::Double => DVec3::ZERO,
        _ => middle_of_origins(rays),
    }
}

/// A ray with a number that is not finite means nothing, and would spoil the numbers of all others.
fn refuse_not_finite(rays: &Rays) -> Result<()> {
    let Rays::List(rays) = rays else { return Ok(()) };
    let is_finite = |ray: &Ray| ray.origin.is_finite() && ray.direction.is_finite();
    match rays.iter().position(|ray| !is_finite(ray)) {
        None => Ok(()),
        Some(index) => Err(Error::Usage(format!(
            "ray {index} (counted from 0) has a number that is not finite; leave it out"
        ))),
    }
}

/// Anywhere, where there are none.
fn middle_of_origins(rays: &[Ray]) -> DVec3 {
    let Some(first) = rays.first() else { return DVec3::ZERO };
    let (low, high) = rays.iter().fold((first.origin, first.origin), |(low, high), ray| {
        (low.min(ray.origin), high.max(ray.origin))
    });
    low / 2.0 + high / 2.0
}

/// `v` as f32 high part and f32 low part: together 48 bits.
pub fn split(v: DVec3) -> ([f32; 3], [f32; 3]) {
    let high = v.as_vec3();
    let low = (v - high.as_dvec3()).as_vec3();
    (high.to_array(), low.to_array())
}

/// The binary exponent of the largest component of `v`, `−1074` for the smallest subnormal; 0 for the
/// zero vector.
pub fn exponent_of(v: DVec3) -> i32 {
    let largest = v.abs().max_element();
    if largest == 0.0 || !largest.is_finite() {
        return 0;
    }
    match (largest.to_bits() >> 52) as i32 {
        0 => largest.to_bits().ilog2() as i32 - 1074,
        biased => biased - 1023,
    }
}

/// `v · 2^exponent`, exact unless the result leaves f64's normal range.
pub fn scale_by_power_of_two(v: DVec3, exponent: i32) -> DVec3 {
    let half = exponent / 2;
    v * 2f64.powi(half) * 2f64.powi(exponent - half)
}

impl SphereLecture {
    fn new(sphere: &Sphere) -> SphereLecture {
        SphereLecture { center: sphere.center.as_vec3().to_array(), radius: sphere.radius as f32 }
    }
}

impl PlaneLecture {
    fn new(plane: &Plane) -> PlaneLecture {
        PlaneLecture {
            point: plane.point.as_vec3().to_array(),
            pad0: 0.0,
            normal: plane.normal.as_vec3().to_array(),
            pad1: 0.0,
        }
    }
}

impl SphereStable {
    fn new(sphere: &Sphere, reference: DVec3) -> SphereStable {
        let l = sphere.center - reference;
        let (center, center_low) = split(l);
        let k = l.length_squared() - sphere.radius * sphere.radius;
        SphereStable { center, radius: sphere.radius as f32, center_low, k: k as f32 }
    }
}

impl PlaneStable {
    fn new(plane: &Plane, reference: DVec3) -> PlaneStable {
        let l = plane.point - reference;
        let normal = scale_by_power_of_two(plane.normal, -exponent_of(plane.normal));
        let (offset, offset_low) = split(l);
        PlaneStable {
            offset,
            n_offset: l.dot(normal) as f32,
            offset_low,
            pad0: 0.0,
            normal: normal.as_vec3().to_array(),
            pad1: 0.0,
        }
    }
}

impl SphereDouble {
    fn new(sphere: &Sphere, reference: DVec3) -> SphereDouble {
        let l = sphere.center - reference;
        SphereDouble {
            center: l.to_array(),
            radius: sphere.radius,
            k: l.length_squared() - sphere.radius * sphere.radius,
            padding: [0.0; 3],
        }
    }
}

impl PlaneDouble {
    fn new(plane: &Plane, reference: DVec3) -> PlaneDouble {
        let l = plane.point - reference;
        let normal = scale_by_power_of_two(plane.normal, -exponent_of(plane.normal));
        PlaneDouble {
            offset: l.to_array(),
            n_offset: l.dot(normal),
            normal: normal.to_array(),
            padding: 0.0,
        }
    }
}

/// What the certified kernel's numbers refer to.
struct Frame {
    bundle: Bundle,
    reference: DVec3,
    /// Largest distance of an origin from the reference point.
    spread: f64,
    input: InputError,
    /// Whether the bounds hold for these rays at all.
    in_range: bool,
    /// Whether a ray may start in, on or close to a sphere.
    near: bool,
}

/// Largest relative error of `k` and of `(a − o)·n` that their f32 may hide.
const OFFSET_TOLERANCE: f64 = 1.0 / (1u64 << 24) as f64;

/// Smallest magnitude of `k` that leaves f32 room above its subnormals.
const SMALLEST_K: f64 = 1.0 / (1u128 << 100) as f64;

/// Smallest magnitude of `(a − o)·n`: its inverse leaves f32 room for `|n|` and the longest `d`.
const SMALLEST_OFFSET: f64 = 1.0 / guard::LARGEST_NEARNESS;

/// Largest magnitude of them: that of `k` at the largest distance.
const LARGEST_OFFSET: f64 = guard::LARGEST_F32 * guard::LARGEST_F32;

impl Frame {
    fn new(rays: &Rays, reference: DVec3, scene: &Scene) -> Frame {
        let bundle = rays.bundle();
        match rays {
            Rays::Pixels(pixels) => {
                let spread = pixels.spread();
                let frame = Frame {
                    bundle,
                    reference,
                    spread,
                    input: guard::input_of(pixels.view.lens),
                    in_range: pixels.is_in_range() && spread <= guard::LARGEST_F32,
                    near: false,
                };
                if pixels.view.lens == Lens::Orthographic {
                    return frame;
                }
                let longest = pixels.longest_direction();
                let near = scene.spheres.len() > FEW_SPHERES
                    || scene.spheres.iter().any(|sphere| !frame.is_far(sphere, longest));
                Frame { near, ..frame }
            }
            Rays::List(rays) => {
                let spread = spread(rays, reference);
                Frame {
                    bundle,
                    reference,
                    spread,
                    input: guard::LIST,
                    in_range: spread <= guard::LARGEST_F32,
                    near: true,
                }
            }
        }
    }

    /// Whether the lean filter suits a sphere; one that is out of range needs the full one, where
    /// its slack can say so.
    fn is_far(&self, sphere: &Sphere, longest: f64) -> bool {
        let r = sphere.radius.abs();
        let l = sphere.center - self.reference;
        let distance = guard::length_bound(l);
        let k = self.sphere_k(sphere, l);
        r == 0.0
            || guard::sphere_in_range_f32(r, distance)
                && k_in_range(k, r + distance)
                && guard::is_far(&Guard::new(r, distance, guard::UNIT_F32, self.input), k, longest)
    }

    /// A sphere as the leaf of a picture's tree; `None` where it doesn't suit one. Parallel rays ask
    /// that f64 knows `k` of the camera's position well: exact arithmetic should find it once, not once
    /// a ray.
    #[inline(always)]
    fn leaf(&self, sphere: &Sphere, id: u32, longest: f64) -> Option<SphereFar> {
        let r = sphere.radius.abs();
        let l = sphere.center - self.reference;
        let distance = guard::length_bound(l) + self.spread;
        if r == 0.0 || !guard::sphere_in_range_f32(r, distance) {
            return None;
        }
        let guard = Guard::new(r, distance, guard::UNIT_F32, self.input);
        let q = match self.bundle {
            Bundle::Parallel => {
                guard::k_f64(l, r)?;
                None
            }
            _ => {
                let k = self.sphere_k(sphere, l);
                if !(k_in_range(k, r + distance) && guard::is_far(&guard, k, longest)) {
                    return None;
                }
                Some(guard::far_inverse_f32(k))
            }
        };
        let [inner2, outer2, slack, _] = guard.round_to_f32();
        let (center, q_or_slack) = (l.as_vec3().to_array(), q.unwrap_or(slack));
        Some(SphereFar { center, inner2, outer2, q_or_slack, id, padding: 0 })
    }

    /// Any ray, for exact statements about the reference point.
    fn exact_ray(&self) -> ExactRay {
        ExactRay::new(&Ray { origin: self.reference, direction: DVec3::X })
    }

    fn sphere(&self, sphere: &Sphere) -> SphereCertified {
        let r = sphere.radius.abs();
        if r == 0.0 {
            // Seen from outside, where no line comes within −1.
            return SphereCertified {
                inner2: -1.0,
                outer2: -1.0,
                slack: 1.0,
                q_low: 1.0,
                q_high_or_r2: match self.bundle {
                    Bundle::Point | Bundle::Parallel => 1.0,
                    Bundle::Free => -1.0,
                },
                ..SphereCertified::zeroed()
            };
        }
        let l = sphere.center - self.reference;
        let distance = guard::length_bound(l) + self.spread;
        let (k_or_r2, k_in_range) = match self.bundle {
            Bundle::Point => {
                let k = self.sphere_k(sphere, l);
                (k, k_in_range(k, r + distance))
            }
            Bundle::Parallel | Bundle::Free => (r * r, true),
        };
        if !(guard::sphere_in_range_f32(r, distance) && k_in_range) {
            // As seen from outside, this may be nearer than everything; see guard's "Range".
            return SphereCertified {
                inner2: -1.0,
                // Above every `m` of parallel rays, which start beside it.
                outer2: if self.bundle == Bundle::Parallel { guard::UNKNOWN } else { 0.0 },
                slack: guard::LARGEST_F32 as f32,
                q_low: 1.0,
                q_high_or_r2: guard::LARGEST_F32 as f32,
                k_error: guard::UNKNOWN,
                ..SphereCertified::zeroed()
            };
        }
        let (center, center_low) = self.split(l);
        let [inner2, outer2, slack, k_error] =
            Guard::new(r, distance, guard::UNIT_F32, self.input).round_to_f32();
        let (q_low, q_high_or_r2) = match self.bundle {
            Bundle::Point if self.near => guard::inverse_f32(k_or_r2),
            Bundle::Point => (0.0, guard::far_inverse_f32(k_or_r2)),
            Bundle::Parallel => (0.0, 0.0),
            Bundle::Free => (0.0, k_or_r2 as f32),
        };
        SphereCertified { center, inner2, center_low, outer2, slack, q_low, q_high_or_r2, k_error }
    }

    /// High and low part. Parallel rays, whose origins are rounded more than once, take the high
    /// part alone.
    fn split(&self, l: DVec3) -> ([f32; 3], [f32; 3]) {
        match self.bundle {
            Bundle::Parallel => (l.as_vec3().to_array(), [0.0; 3]),
            Bundle::Point | Bundle::Free => split(l),
        }
    }

    /// `l·l − r²` with exact sign or NaN; in f64 where its error is small enough, else exactly.
    #[inline(always)]
    fn sphere_k(&self, sphere: &Sphere, l: DVec3) -> f64 {
        let (l2, r2) = (l.length_squared(), sphere.radius * sphere.radius);
        let k = l2 - r2;
        // l: one rounding, doubled by squaring; three in the dot product, one each in r², k.
        let error = 4.0 * guard::UNIT_F64 * (l2 + r2);
        if error <= OFFSET_TOLERANCE * k.abs() {
            return k;
        }
        sphere_numbers(&self.exact_ray(), sphere.center, sphere.radius)
            .map_or(f64::NAN, |numbers| with_exact_sign(&numbers.k))
    }

    fn plane(&self, plane: &Plane) -> PlaneCertified {
        if plane.normal == DVec3::ZERO {
            return PlaneCertified { n_offset_error: -1.0, ..PlaneCertified::zeroed() };
        }
        let exponent = exponent_of(plane.normal);
        let normal = scale_by_power_of_two(plane.normal, -exponent);
        let n_length = guard::length_bound(normal);
        let l = plane.point - self.reference;
        let distance = guard::length_bound(l) + self.spread;
        let n_offset = match self.bundle {
            Bundle::Point => self.plane_offset(plane, l, normal, exponent),
            Bundle::Parallel | Bundle::Free => 0.0,
        };
        if !(guard::plane_in_range_f32(distance) && offset_in_range(n_offset)) {
            // As seen along the normal, this may be nearer than everything.
            return PlaneCertified {
                q_low: 1.0,
                q_high: guard::LARGEST_F32 as f32,
                direction_error: guard::LARGEST_F32 as f32,
                n_offset_error: guard::UNKNOWN,
                ..PlaneCertified::zeroed()
            };
        }
        let (offset, offset_low) = self.split(l);
        let [n_offset_error, direction_error] = [
            guard::plane_offset_error(
                n_length,
                distance,
                guard::UNIT_F32,
                self.input,
                guard::TINY_F32,
            ),
            guard::plane_direction_error(n_length, guard::UNIT_F32, self.input),
        ]
        .map(guard::round_up);
        let (q_low, q_high) = guard::inverse_f32(n_offset.abs());
        let away = if n_offset < 0.0 { -normal } else { normal };
        PlaneCertified {
            offset,
            q_low,
            offset_low,
            q_high,
            normal: away.as_vec3().to_array(),
            direction_error,
            n_offset_error,
            padding: [0.0; 3],
        }
    }

    /// `(a − o)·n` with exact sign or NaN; in f64 where its error is small enough, else exactly.
    fn plane_offset(&self, plane: &Plane, l: DVec3, normal: DVec3, exponent: i32) -> f64 {
        let n_offset = l.dot(normal);
        // One rounding in l, three in the dot product; and what underflows.
        let error = 4.0 * guard::UNIT_F64 * guard::length_bound(l) * guard::length_bound(normal)
            + f64::MIN_POSITIVE;
        if error <= OFFSET_TOLERANCE * n_offset.abs() {
            return n_offset;
        }
        // Scaled up, the normal is exact, and rounding the product to f64 costs no digits of it.
        let (normal, exponent) = if exponent < 0 { (normal, 0) } else { (plane.normal, exponent) };
        plane_numbers(&self.exact_ray(), plane.point, normal).map_or(f64::NAN, |numbers| {
            let numerator = with_exact_sign(&numbers.numerator);
            let scaled = numerator * 2f64.powi(-exponent);
            if scaled == 0.0 && numerator != 0.0 { f64::NAN } else { scaled }
        })
    }
}

/// The number in f64; NaN where it is not 0 but f64 says so.
fn with_exact_sign(exact: &Root) -> f64 {
    match exact.to_f64() {
        0.0 if exact.signum() != 0 => f64::NAN,
        rounded => rounded,
    }
}

fn offset_in_range(offset: f64) -> bool {
    offset == 0.0 || (SMALLEST_OFFSET..=LARGEST_OFFSET).contains(&offset.abs())
}

/// Whether neither `k` nor a nearness `u/k`, with `u` up to `2·reach`, leaves f32's range.
#[inline(always)]
fn k_in_range(k: f64, reach: f64) -> bool {
    k == 0.0
        || (SMALLEST_K..=LARGEST_OFFSET).contains(&k.abs())
            && reach <= k.abs() * guard::LARGEST_NEARNESS
}

/// A ray of a list as the device sees it.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct RayRecord {
    /// Origin: world units for `lecture`, else the high part relative to the reference point.
    pub origin: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad0: f32,
    /// Low part of the origin.
    pub origin_low: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad1: f32,
    /// Direction; scaled by a power of two to a largest component in `1..2`, but not for `lecture`.
    pub direction: [f32; 3],
    /// Fills WGSL's 16-byte alignment of `vec3f`.
    pub pad2: f32,
}

/// A ray of a list as the device sees it, for [`Kernel::Double`].
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct RayRecordDouble {
    /// Origin relative to the reference point.
    pub origin: [f64; 3],
    /// Fills WGSL's 32-byte alignment of `vec3<f64>`.
    pub pad0: f64,
    /// Direction, as it is.
    pub direction: [f64; 3],
    /// Fills WGSL's 32-byte alignment of `vec3<f64>`.
    pub pad1: f64,
}

impl Prepared {
    /// A ray of a list in this scene's frame, in f64.
    pub fn ray_record_double(&self, ray: &Ray) -> RayRecordDouble {
        RayRecordDouble {
            origin: (ray.origin - self.reference).to_array(),
            pad0: 0.0,
            direction: ray.direction.to_array(),
            pad1: 0.0,
        }
    }

    /// A ray of a list in this scene's frame, rounded to f32, and the exponent `e` with
    /// `direction = 2^e · record.direction`, so that `t = 2^−e · t_record`.
    pub fn ray_record(&self, ray: &Ray) -> (RayRecord, i32) {
        let (origin, low, direction, exponent) = match self.kernel {
            Kernel::Lecture => (ray.origin.as_vec3().to_array(), [0.0; 3], ray.direction, 0),
            Kernel::Stable | Kernel::Double | Kernel::Certified => {
                let (high, low) = split(ray.origin - self.reference);
                let exponent = exponent_of(ray.direction);
                let direction = match self.kernel {
                    // No ray, and undecided; but 1/d² stays finite.
                    Kernel::Certified if ray.direction == DVec3::ZERO => DVec3::X,
                    _ => scale_by_power_of_two(ray.direction, -exponent),
                };
                (high, low, direction, exponent)
            }
        };
        let record = RayRecord {
            origin,
            pad0: 0.0,
            origin_low: low,
            pad1: 0.0,
            direction: direction.as_vec3().to_array(),
            pad2: 0.0,
        };
        (record, exponent)
    }
}
