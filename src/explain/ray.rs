//! One ray's numbers as the kernels have them, in f64, and exactly.

use std::sync::Arc;

use glam::DVec3;

use super::formula::{PlaneSteps, SphereSteps, of_plane, of_sphere};
use super::numbers::{Columns, Quantity, Short, scaled};
use super::words::Words;
use super::{ObjectExplanation, Rank, Reason, Style, Terms, gap, label_in};
use crate::error::{Error, Result};
use crate::exact::{
    ExactHit, ExactRay, Real, Root, double, exact, integer, plane_numbers, product3, real, real3,
    sphere_numbers,
};
use crate::kernel::lecture;
use crate::kernel::plain::{PlainRay, PlainRays};
use crate::kernel::relative::{PlaneStable, SphereStable, approach, half_root, roots_stable};
use crate::num::{self, V3};
use crate::prepare::{Lists, Objects, Prepared, exponent_of};
use crate::scene::{Object, Plane, Scene, Sphere};
use crate::shade::PlainPoint;
use crate::trace::{Kernel, Ray, Rays};
use crate::verify::Near;

/// A ray's numbers as the kernels have them.
pub struct RayNumbers {
    pub exact: ExactRay,
    pub origin: DVec3,
    pub direction: DVec3,
    /// The same from the camera's position, or from the ray's origin.
    pub near: Near,
    lecture: num::Ray<f32>,
    stable: PlainRay<f32>,
    /// `direction = 2^exponent · stable.direction`.
    exponent: i32,
    /// True for a camera's ray.
    pub is_pixel: bool,
    pub words: &'static Words,
    pub digits: usize,
    lecture_objects: Lists<lecture::SphereLecture, lecture::PlaneLecture>,
    stable_objects: Lists<SphereStable, PlaneStable>,
}

impl RayNumbers {
    pub fn new(scene: &Arc<Scene>, rays: &Rays, style: &Style) -> Result<RayNumbers> {
        let one = || Error::Usage("one ray is explained at a time".into());
        if rays.len() != 1 {
            return Err(one());
        }
        let of_kernel = |kernel| Prepared::new(Arc::clone(scene), kernel, rays);
        let (on_lecture, on_stable) = (of_kernel(Kernel::Lecture)?, of_kernel(Kernel::Stable)?);
        let of_kernel = |prepared: &Prepared| PlainRays::new(prepared.coordinates(), rays).one(0);
        let (lecture, stable) = (of_kernel(&on_lecture).ray, of_kernel(&on_stable));
        let exponent = match rays {
            Rays::Pixels(_) => 0,
            Rays::List(rays) => on_stable.coordinates().ray(&rays[0]).2,
        };
        let (exact, Ray { origin, direction }, near) = match rays {
            Rays::Pixels(p) => {
                let ray =
                    Ray { origin: p.origin_offset(p.x, p.y), direction: p.direction(p.x, p.y) };
                let near = Near { reference: p.view.position, ray };
                (ExactRay::from_pixel(p, p.x, p.y), p.ray(p.x, p.y), near)
            }
            Rays::List(rays) => {
                let &ray = rays.first().ok_or_else(one)?;
                let of_origin = Ray { origin: DVec3::ZERO, ..ray };
                (ExactRay::new(&ray), ray, Near { reference: ray.origin, ray: of_origin })
            }
        };
        let (Objects::Lecture(lecture_objects), Objects::Stable(stable_objects)) =
            (on_lecture.objects, on_stable.objects)
        else {
            return Err(one());
        };
        Ok(RayNumbers {
            exact,
            origin,
            direction,
            near,
            lecture,
            stable,
            exponent,
            is_pixel: matches!(rays, Rays::Pixels(_)),
            words: style.lang.words(),
            digits: style.digits,
            lecture_objects,
            stable_objects,
        })
    }

    /// `sphere 3 (red giant)`
    pub fn label(&self, scene: &Scene, id: u32) -> String {
        label_in(self.words, scene, id)
    }

    /// `o` and `d`, exactly.
    pub fn origin_and_direction(&self) -> [[Root; 3]; 2] {
        let (s, f) = (self.exact.world_scale(), self.exact.direction_scale());
        let of = |v: &[Real; 3], scale| v.each_ref().map(|x| Root::ratio(x.clone(), scale));
        [of(self.exact.origin(), s), of(self.exact.direction(), f)]
    }

    pub fn ray(&self) -> Vec<Quantity> {
        let [exact_origin, exact_direction] = self.origin_and_direction();
        let origin = |i: usize| {
            let columns = Columns::all(self.lecture.origin.0[i], 0.0, self.origin[i]);
            Columns { stable: None, ..columns }
                .against(["o.x", "o.y", "o.z"][i], Some(&exact_origin[i]))
        };
        let direction = |i: usize| {
            let stable = scaled(self.stable.ray.direction.0[i], self.exponent);
            Columns::all(self.lecture.direction.0[i], stable, self.direction[i])
                .against(["d.x", "d.y", "d.z"][i], Some(&exact_direction[i]))
        };
        (0..3).map(origin).chain((0..3).map(direction)).collect()
    }

    pub fn object(
        &self,
        scene: &Scene,
        rank: &Rank,
        hit: Option<&ExactHit>,
    ) -> Option<ObjectExplanation> {
        let id = rank.id;
        let index = id as usize - 1;
        let object = scene.object(id)?;
        let (terms, lines, quantities) = match object {
            Object::Sphere(sphere) => {
                let steps = self.sphere_steps(sphere)?;
                let terms = self.sphere_terms(&steps);
                (terms, of_sphere(steps, self.digits), self.sphere(sphere, index)?)
            }
            Object::Plane(plane) => {
                let steps = self.plane_steps(plane)?;
                let terms = self.plane_terms(&steps);
                let index = index - self.lecture_objects.spheres.len();
                (terms, of_plane(steps, self.digits), self.plane(plane, index)?)
            }
        };
        let (gap, is_at_origin) = gap(self.origin, self.direction, object);
        let mut explanation = ObjectExplanation {
            id,
            label: self.label(scene, id),
            terms,
            quantities,
            reason: Reason::Degenerate,
            why: Vec::new(),
            gap: rank.root.is_none().then_some(gap),
            lines,
        };
        explanation.reason = explanation.reason(rank.root.as_deref(), hit);
        explanation.why = explanation.why(scene, rank.root.is_some(), hit, (self, is_at_origin));
        Some(explanation)
    }

    fn sphere(&self, sphere: &Sphere, index: usize) -> Option<Vec<Quantity>> {
        let exact = sphere_numbers(&self.exact, sphere.center, sphere.radius)?;
        let of_lecture = self.lecture_objects.spheres.get(index)?;
        let num::Ray { origin, direction, .. } = self.lecture;
        let single =
            lecture::quadratic(origin, direction, V3(of_lecture.center), of_lecture.radius);
        let double = lecture::quadratic::<f64>(
            V3::near(self.origin),
            V3::near(self.direction),
            V3::near(sphere.center),
            sphere.radius,
        );
        let single_roots = (single.discriminant >= 0.0).then(|| lecture::quadratic_roots(single));
        let double_roots = (double.discriminant >= 0.0).then(|| lecture::quadratic_roots(double));

        let of_stable = self.stable_objects.spheres.get(index)?;
        let l = of_stable.offset(&self.stable);
        let k = of_stable.k(&self.stable, l);
        let ray = &self.stable.ray;
        let chord = approach(ray, l, of_stable.radius);
        let h = half_root(ray, chord.delta);
        let stable_roots = (h >= 0.0).then(|| roots_stable(ray, chord.b, h, k));

        let e = self.exponent;
        let stable_only =
            |value: Option<f64>| Columns { lecture: None, stable: Some(value), double: None };
        let root = |i: usize| Columns {
            lecture: Some(single_roots.map(|roots| f64::from(roots[i]))),
            stable: Some(stable_roots.map(|roots| f64::from(scaled(roots[i], -e) as f32))),
            double: Some(double_roots.map(|roots| roots[i])),
        };
        let roots = exact.roots.as_ref();
        Some(vec![
            Columns::all(single.a, scaled(ray.a, 2 * e), double.a).against("a", Some(&exact.a)),
            Columns::all(single.b, -2.0 * scaled(chord.b, e), double.b)
                .against("b", Some(&exact.b)),
            Columns::all(single.k, f64::from(k), double.k).against("k", Some(&exact.k)),
            Columns { stable: None, ..Columns::all(single.discriminant, 0.0, double.discriminant) }
                .against("D", Some(&exact.discriminant)),
            stable_only(Some(f64::from(chord.delta))).against("r²−P·P", exact.delta.as_ref()),
            stable_only((h >= 0.0).then(|| scaled(h, e))).against("h", exact.half_root.as_ref()),
            root(0).against("t₁", roots.map(|roots| &roots[0])),
            root(1).against("t₂", roots.map(|roots| &roots[1])),
        ])
    }

    fn plane(&self, plane: &Plane, index: usize) -> Option<Vec<Quantity>> {
        let exact = plane_numbers(&self.exact, plane.point, plane.normal)?;
        let of_lecture = self.lecture_objects.planes.get(index)?;
        let num::Ray { origin, direction, .. } = self.lecture;
        let normal = V3(of_lecture.normal);
        let single = [(V3(of_lecture.point) - origin).dot(normal), direction.dot(normal)];
        let [normal, point, origin, direction] =
            [plane.normal, plane.point, self.origin, self.direction].map(V3::<f64>::near);
        let double = [(point - origin).dot(normal), direction.dot(normal)];
        let of_stable = self.stable_objects.planes.get(index)?;
        let slope = self.stable.ray.direction.dot(V3(of_stable.normal));
        let stable = [of_stable.n_offset(&self.stable), slope];
        let (e, of_normal) = (self.exponent, exponent_of(plane.normal));
        let row =
            |i: usize, exponent| Columns::all(single[i], scaled(stable[i], exponent), double[i]);
        // A quotient by 0 is an infinity or NaN: no root.
        let quotient = |t: f64| t.is_finite().then_some(t);
        let t = Columns {
            lecture: Some(quotient(f64::from(single[0] / single[1]))),
            stable: Some(quotient(f64::from(scaled(stable[0] / stable[1], -e) as f32))),
            double: Some(quotient(double[0] / double[1])),
        };
        Some(vec![
            row(0, of_normal).against("(a−o)·n", Some(&exact.numerator)),
            row(1, of_normal + e).against("d·n", Some(&exact.denominator)),
            t.against("t", exact.root.as_ref()),
        ])
    }

    /// `f(p)` of the object that a kernel sees, in its arithmetic: that of `lecture`, `stable` or `double`,
    /// in this order.
    pub fn residual(&self, scene: &Scene, kernel: usize, seen: &PlainPoint) -> Option<f64> {
        let index = seen.id.checked_sub(1)? as usize;
        let object = scene.object(seen.id)?;
        match kernel {
            0 => {
                let p = V3(seen.at.map(|x| x as f32));
                let objects = &self.lecture_objects;
                Some(f64::from(match object {
                    Object::Sphere(_) => {
                        let sphere = objects.spheres.get(index)?;
                        let v = p - V3(sphere.center);
                        v.dot(v) - sphere.radius * sphere.radius
                    }
                    Object::Plane(_) => {
                        let plane = objects.planes.get(index - objects.spheres.len())?;
                        (p - V3(plane.point)).dot(V3(plane.normal))
                    }
                }))
            }
            1 => {
                // p − o
                let (ray, objects) = (&self.stable, &self.stable_objects);
                let way = ray.ray.direction * seen.t as f32;
                match object {
                    Object::Sphere(_) => {
                        let sphere = objects.spheres.get(index)?;
                        let v = way - sphere.offset(ray);
                        Some(f64::from(v.dot(v) - sphere.radius * sphere.radius))
                    }
                    Object::Plane(of_scene) => {
                        let plane = objects.planes.get(index - objects.spheres.len())?;
                        let off = way.dot(V3(plane.normal)) - plane.n_offset(ray);
                        Some(scaled(off, exponent_of(of_scene.normal)))
                    }
                }
            }
            _ => {
                let way = self.direction * seen.t;
                Some(match object {
                    Object::Sphere(sphere) => {
                        let v = (self.origin - sphere.center) + way;
                        v.dot(v) - sphere.radius * sphere.radius
                    }
                    Object::Plane(plane) => ((self.origin - plane.point) + way).dot(plane.normal),
                })
            }
        }
    }

    fn sphere_steps(&self, sphere: &Sphere) -> Option<SphereSteps> {
        let numbers = sphere_numbers(&self.exact, sphere.center, sphere.radius)?;
        let [origin, direction] = self.origin_and_direction();
        let (d, a) = (self.exact.direction(), self.exact.norm_squared());
        let offset = self.exact.to_point(sphere.center)?.map(|x| -x);
        let (s, f) = (self.exact.world_scale().into(), self.exact.direction_scale().into());
        let (s, f) = (integer(s), integer(f));
        let of_d = |x: Real| Root::quotient(x, &f * &f * &s * &s, 1);
        let of_k = |x: Real| Root::quotient(x, &s * &s, 1);
        let r = self.exact.to_scale(real(sphere.radius)?);
        let (v_squared, r_squared) = (product3(&offset, &offset), &r * &r);
        let b = double(&product3(d, &offset));
        let minus_ak = a * &(&r_squared - &v_squared);
        Some(SphereSteps {
            given: (given3(sphere.center), Short::given(sphere.radius)),
            origin,
            direction,
            center: real3(sphere.center)?.map(Root::from),
            radius: Root::from(exact(sphere.radius)),
            products: std::array::from_fn(|i| Root::quotient(&d[i] * &offset[i], &f * &s, 1)),
            offset: offset.map(|x| Root::quotient(x, s.clone(), 1)),
            parts_of_k: [of_k(v_squared), of_k(-r_squared)],
            parts_of_d: [of_d(&b * &b), of_d(double(&double(&minus_ak)))],
            a: numbers.a,
            b: numbers.b,
            k: numbers.k,
            discriminant: numbers.discriminant,
            roots: numbers.roots,
        })
    }

    fn sphere_terms(&self, steps: &SphereSteps) -> Terms {
        let short = |root: &Root| Short::new(root, self.digits);
        let (s, f) = (self.exact.world_scale(), self.exact.direction_scale());
        let square = |x: &Real, scale: u32| {
            let scale = integer(scale.into());
            short(&Root::quotient(x * x, &scale * &scale, 1))
        };
        let radius = self.exact.to_scale(exact(steps.radius.to_f64()));
        Terms::Sphere {
            center: steps.center.each_ref().map(short),
            radius: short(&steps.radius),
            offset: steps.offset.each_ref().map(short),
            squares: self.exact.direction().each_ref().map(|x| square(x, f)),
            products: steps.products.each_ref().map(short),
            offset_squared: short(&steps.parts_of_k[0]),
            radius_squared: square(&radius, s),
        }
    }

    fn plane_steps(&self, plane: &Plane) -> Option<PlaneSteps> {
        let numbers = plane_numbers(&self.exact, plane.point, plane.normal)?;
        let [origin, direction] = self.origin_and_direction();
        let (point, normal) = (real3(plane.point)?, real3(plane.normal)?);
        let offset = self.exact.to_point(plane.point)?;
        let (s, f) = (self.exact.world_scale(), self.exact.direction_scale());
        let products =
            |v: &[Real; 3], scale| std::array::from_fn(|i| Root::ratio(&v[i] * &normal[i], scale));
        Some(PlaneSteps {
            given: [given3(plane.point), given3(plane.normal)],
            origin,
            direction,
            numerator_products: products(&offset, s),
            denominator_products: products(self.exact.direction(), f),
            point: point.map(Root::from),
            normal: normal.clone().map(Root::from),
            offset: offset.map(|x| Root::ratio(x, s)),
            numerator: numbers.numerator,
            denominator: numbers.denominator,
            root: numbers.root,
        })
    }

    fn plane_terms(&self, steps: &PlaneSteps) -> Terms {
        let short = |root: &Root| Short::new(root, self.digits);
        Terms::Plane {
            point: steps.point.each_ref().map(short),
            normal: steps.normal.each_ref().map(short),
            offset: steps.offset.each_ref().map(short),
            numerator: steps.numerator_products.each_ref().map(short),
            denominator: steps.denominator_products.each_ref().map(short),
        }
    }
}

fn given3(v: DVec3) -> [Short; 3] {
    v.to_array().map(Short::given)
}
