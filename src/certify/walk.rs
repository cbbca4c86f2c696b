//! Rays of a list that f64 decides through the tree, some thousand at a time. What they leave open goes
//! to [`Stage::decide_f64`].

use glam::DVec3;
use pulp::Simd;

use super::{RayF64, Stage};
use crate::control::Control;
use crate::error::Result;
use crate::guard;
use crate::kernel::certified::{Nearest, Nearness, closest_approach};
use crate::num::OPEN;
use crate::prepare::Hierarchy;
use crate::scene::{Object, Sphere};
use crate::tree::{Company, TreeRay};
use crate::vec3::{Vec3, dot3};

/// Some rays, compiled for each instruction set that the processor may have.
pub struct Walks<'a> {
    pub stage: &'a Stage<'a>,
    pub hierarchy: &'a Hierarchy,
    pub rays: &'a [u32],
    pub control: &'a Control,
    /// [`OPEN`] where f64 leaves them open.
    pub ids: &'a mut [u32],
}

impl pulp::WithSimd for Walks<'_> {
    type Output = Result<()>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Result<()> {
        let Walks { stage, hierarchy, rays, control, ids } = self;
        ids.fill(OPEN);
        let mut walkers = Walkers { stage, hierarchy, rays, control, ids, n_begun: 0 };
        hierarchy.tree.visit_all(&mut walkers);
        control.check()
    }
}

/// The rays of [`Walks`], of which some have begun.
struct Walkers<'a> {
    stage: &'a Stage<'a>,
    hierarchy: &'a Hierarchy,
    rays: &'a [u32],
    control: &'a Control,
    ids: &'a mut [u32],
    n_begun: usize,
}

/// A ray on its way.
struct OnItsWay {
    /// Its place among the rays.
    place: usize,
    ray: RayF64,
    nearest: Nearest<f64>,
}

impl OnItsWay {
    fn t_max(&self) -> f64 {
        guard::widening_f64().wider / (self.ray.ray.a * self.nearest.low)
    }
}

impl Company for Walkers<'_> {
    type Ray = OnItsWay;
    type Sphere = Sphere;

    #[inline(always)]
    fn next(&mut self) -> Option<(OnItsWay, TreeRay)> {
        let Hierarchy { tree, rest, .. } = self.hierarchy;
        let scene = self.stage.scene;
        while let Some(&index) = self.rays.get(self.n_begun) {
            if self.control.is_cancelled() {
                return None;
            }
            let place = self.n_begun;
            self.n_begun += 1;
            let ray = self.stage.ray_f64(index as usize);
            let origin = ray.reference - tree.reference;
            if ray.ray.direction == Vec3::ZERO || !origin.is_finite() {
                continue;
            }
            let mut nearest = Nearest::NONE;
            let planes = scene.spheres.len() as u32..scene.n_objects() as u32;
            for id in planes.map(|index| index + 1).chain(rest.iter().copied()) {
                if let Some(object) = scene.object(id) {
                    nearest = nearest.nearer(self.stage.nearness(&ray, id, object), id);
                }
            }
            let direction = DVec3::from_array(ray.ray.direction.0);
            return Some((OnItsWay { place, ray, nearest }, TreeRay { origin, direction }));
        }
        None
    }

    #[inline(always)]
    fn sphere(&self, place: usize) -> &Sphere {
        self.hierarchy.sphere_at(place, &self.stage.scene.spheres)
    }

    #[inline(always)]
    fn visit(&mut self, on_its_way: &mut OnItsWay, place: usize) -> f64 {
        let OnItsWay { ray, nearest, .. } = on_its_way;
        let sphere = self.sphere(place);
        if !surely_misses(ray, sphere) {
            let id = self.hierarchy.tree.order[place] + 1;
            let root = self.stage.nearness(ray, id, Object::Sphere(sphere));
            *nearest = nearest.nearer(root, id);
        }
        on_its_way.t_max()
    }

    #[inline(always)]
    fn finish(&mut self, on_its_way: &mut OnItsWay) {
        let OnItsWay { place, ray, nearest } = on_its_way;
        let root = Nearness { low: nearest.low, high: nearest.high };
        let id = nearest.decide();
        if id == 0 || id != OPEN && self.stage.to_f32(ray, root).is_some() {
            self.ids[*place] = id;
        }
    }
}

/// Whether the line passes a sphere by more than any rounding of f64 could hide. It asks for more than
/// [`guard::Guard::outer2`] `= ((r + x)² + 111η²)(1 + 5.1·2⁻⁵²)` with `x = κη ≤ 1.52·2⁻⁵²ℓ`: as
/// `2rx ≤ 2⁻³⁰r² + 2³⁰x²`, that is below `(1 + 1.01·2⁻³⁰)r² + 1.01·2³⁰x²`, where the last term is at most
/// `2.34·2⁻⁷⁴ℓ²`.
#[inline(always)]
fn surely_misses(ray: &RayF64, sphere: &Sphere) -> bool {
    let l = ray.to_point(sphere.center);
    let (_, m) = closest_approach(ray.ray.direction, ray.ray.inv_a, l);
    let is_in_range = guard::sphere_in_range_f64(sphere.radius.abs(), 0.0);
    is_in_range && m > sphere.radius * sphere.radius * ROUND + dot3(l, l) * FAR
}

/// Room of a squared radius.
const ROUND: f64 = 1.0 + 1.05 / (1u64 << 30) as f64;

/// Room of a squared distance.
const FAR: f64 = 1.0 / (1u128 << 72) as f64;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guard::{Guard, LIST_F64};
    use crate::num::Float;

    /// For radii of all sizes beside a distance: the part of what a sure miss asks for that is needed
    /// where one of its terms has only a share of its room.
    fn needed(round: f64, far: f64) -> f64 {
        let of_radius = |step: i32| {
            let (r, l) = (2f64.powf(f64::from(step) / 64.0), 1.0);
            let outer2 = Guard::new(r, l, f64::UNIT, LIST_F64).outer2;
            // Without what both have, as 1 hides the rest.
            (outer2 - r * r) / (r * r * (ROUND - 1.0) * round + l * l * FAR * far)
        };
        (-64 * 60..64 * 10).map(of_radius).fold(0.0, f64::max)
    }

    #[test]
    fn a_sure_miss_is_one_by_the_guard() {
        println!("{} {} {}", needed(1.0, 1.0), needed(0.5, 1.0), needed(1.0, 0.5));
        assert!(needed(1.0, 1.0) <= 1.0);
        assert!(needed(0.5, 1.0) > 1.0, "half of the room of the radius would do");
        assert!(needed(1.0, 0.5) > 1.0, "half of the room of the distance would do");
    }
}
