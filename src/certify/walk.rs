//! Rays of a list that f64 decides through the tree, some thousand at a time. What they leave open goes
//! to [`Stage::decide_f64`].

use glam::DVec3;
use pulp::Simd;

use super::{RayF64, Stage};
use crate::control::Control;
use crate::error::Result;
use crate::guard;
use crate::kernel::certified::{Nearest, Nearness, UNDECIDED, closest_approach};
use crate::prepare::Hierarchy;
use crate::scene::{Object, Sphere};
use crate::tree::{Open, TreeRay};
use crate::vec3::{Vec3, dot3};

/// Some rays, compiled for each instruction set that the processor may have.
pub struct Walks<'a> {
    pub stage: &'a Stage<'a>,
    pub hierarchy: &'a Hierarchy,
    pub rays: &'a [u32],
    pub control: &'a Control,
    /// [`UNDECIDED`] where f64 leaves them open.
    pub ids: &'a mut [u32],
}

impl pulp::WithSimd for Walks<'_> {
    type Output = Result<()>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Result<()> {
        let Walks { stage, hierarchy, rays, control, ids } = self;
        let mut open = Open::with_capacity(64);
        for (&ray, id) in rays.iter().zip(ids) {
            control.check()?;
            *id = stage.walk(simd, hierarchy, ray as usize, &mut open);
        }
        Ok(())
    }
}

impl Stage<'_> {
    /// The object of a ray of a list, or [`UNDECIDED`].
    #[inline(always)]
    fn walk<S: Simd>(&self, simd: S, hierarchy: &Hierarchy, index: usize, open: &mut Open) -> u32 {
        let Hierarchy { tree, rest, .. } = hierarchy;
        let ray = self.ray_f64(index);
        let origin = ray.reference - tree.reference;
        if ray.ray.direction == Vec3::ZERO || !origin.is_finite() {
            return UNDECIDED;
        }
        let mut nearest = Nearest::NONE;
        let planes = self.scene.spheres.len() as u32..self.scene.n_objects() as u32;
        for id in planes.map(|index| index + 1).chain(rest.iter().copied()) {
            if let Some(object) = self.scene.object(id) {
                nearest = nearest.nearer(self.nearness(&ray, id, object), id);
            }
        }
        let spheres = &self.scene.spheres[..];
        let t_bound = |low: f64| guard::widening_f64().wider / (ray.ray.a * low);
        let mut t_max = t_bound(nearest.low);
        let direction = DVec3::from_array(ray.ray.direction.0);
        tree.walk(simd, &TreeRay { origin, direction }, open, |place| {
            let index = tree.order[place];
            let (id, sphere) = (index + 1, &spheres[index as usize]);
            if !surely_misses(&ray, sphere) {
                let root = self.nearness(&ray, id, Object::Sphere(sphere));
                nearest = nearest.nearer(root, id);
                t_max = t_bound(nearest.low);
            }
            t_max
        });
        let root = Nearness { low: nearest.low, high: nearest.high };
        match nearest.decide() {
            0 => 0,
            id if id != UNDECIDED && self.to_f32(&ray, root).is_some() => id,
            _ => UNDECIDED,
        }
    }
}

/// Whether the line passes a sphere by more than any rounding of f64 could hide. It asks for
/// more than [`guard::Guard::outer2`] `= ((r + κη)² + 111η²)(1 + 5.1·2⁻⁵²)` with `κη ≤ 2⁻⁴⁹ℓ`: as
/// `2rx ≤ 2⁻³¹r² + 2³¹x²`, that is below `(1 + 2⁻³⁰)r² + 2⁻⁶⁶ℓ²`.
#[inline(always)]
fn surely_misses(ray: &RayF64, sphere: &Sphere) -> bool {
    const ROUND: f64 = 1.0 + 1.0 / (1u64 << 30) as f64;
    const FAR: f64 = 1.0 / (1u128 << 66) as f64;
    let l = ray.to_point(sphere.center);
    let (_, m) = closest_approach(ray.ray.direction, ray.ray.inv_a, l);
    let is_in_range = guard::sphere_in_range_f64(sphere.radius.abs(), 0.0);
    is_in_range && m > sphere.radius * sphere.radius * ROUND + dot3(l, l) * FAR
}
