//! One ray's numbers as the kernels have them, in f64, and exactly.

use std::sync::Arc;

use glam::DVec3;
use kugelblitz::exact::{ExactHit, ExactRay, Root};
use kugelblitz::kernel::lecture::{self, quadratic, quadratic_roots};
use kugelblitz::kernel::plain::{PlainRay, PlainRays};
use kugelblitz::kernel::relative::{PlaneStable, SphereStable, approach, half_root, roots_stable};
use kugelblitz::num::{self, Float, Real, V3};
use kugelblitz::prepare::{Lists, ObjectRecords, Prepared, exponent_of};
use kugelblitz::scene::{Object, Plane, Scene, Sphere};
use kugelblitz::shade::PlainPoint;
use kugelblitz::trace::{Kernel, Rays, WorldRay};
use kugelblitz::{Error, Result};

use super::line::{Derivation, Line, LineDetail};
use super::numbers::{Columns, FormulaNumber, rows_of_vector, scaled};
use super::step::{Step, vector};
use super::words::Words;
use super::{ExplainStyle, ObjectExplanation, Rank, Reason, gap, label_in};
use crate::verify::{ExactRays, Near};

/// A ray's numbers as the kernels have them.
pub struct RayNumbers {
    pub exact: ExactRay,
    pub origin: DVec3,
    pub direction: DVec3,
    /// The ray in f64, from the camera's position or from its own origin.
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
    pub fn new(scene: &Arc<Scene>, rays: &Rays, style: &ExplainStyle) -> Result<RayNumbers> {
        let one = || Error::Usage("one ray is explained at a time".into());
        let (WorldRay { origin, direction }, listed) = match rays {
            _ if rays.len() != 1 => return Err(one()),
            Rays::Pixels(p) => (p.ray(p.x, p.y), None),
            Rays::List(rays) => (rays[0], Some(&rays[0])),
        };
        let of_kernel = |kernel| Prepared::new(Arc::clone(scene), kernel, rays);
        let (on_lecture, on_stable) = (of_kernel(Kernel::Lecture)?, of_kernel(Kernel::Stable)?);
        let of_kernel = |prepared: &Prepared| PlainRays::new(prepared.coordinates(), rays).one(0);
        let (lecture, stable) = (of_kernel(&on_lecture).ray, of_kernel(&on_stable));
        let of_list = |ray| on_stable.coordinates().ray(ray).2;
        let exponent = listed.map_or(0, of_list);
        let exactly = ExactRays::from(rays);
        let (ObjectRecords::Lecture(lecture_objects), ObjectRecords::Stable(stable_objects)) =
            (on_lecture.objects, on_stable.objects)
        else {
            return Err(one());
        };
        Ok(RayNumbers {
            exact: exactly.exact(0),
            origin,
            direction,
            near: exactly.near(0),
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
    pub fn told(&self) -> [V3<Step>; 2] {
        let (s, f) = (self.exact.world_scale(), self.exact.direction_scale());
        [("o", self.exact.origin(), s), ("d", self.exact.direction(), f)].map(|(name, v, scale)| {
            vector(name, v.each_ref().map(|x| Root::ratio(x.clone(), scale)))
        })
    }

    /// Where the ray begins and goes.
    pub fn ray(&self) -> (Vec<FormulaNumber>, Vec<Line>) {
        let mut told = Derivation::new(self.digits);
        let [o, d] = self.told();
        told.given("o", o, false);
        told.given("d", d, true);
        let num::Ray { origin, direction, .. } = self.lecture;
        let origins = rows_of_vector(["o.x", "o.y", "o.z"], o, |axis| {
            Columns(
                [Some(origin.0[axis].into()), None, Some(self.origin[axis])].map(|x| x.map(Some)),
            )
        });
        let directions = rows_of_vector(["d.x", "d.y", "d.z"], d, |axis| {
            let stable = scaled(self.stable.ray.direction.0[axis], self.exponent);
            Columns::all(direction.0[axis], stable, self.direction[axis])
        });
        ([origins, directions].concat(), told.lines)
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
        let (shape, (lines, quantities)) = match object {
            Object::Sphere(sphere) => ("sphere", self.sphere(sphere, index)?),
            Object::Plane(plane) => ("plane", self.plane(plane, index - scene.spheres.len())?),
        };
        let (gap, is_at_origin) = gap(self.origin, self.direction, object);
        let mut explanation = ObjectExplanation {
            id,
            label: self.label(scene, id),
            shape,
            lines,
            quantities,
            reason: Reason::Degenerate,
            why: Vec::new(),
            gap: rank.root.is_none().then_some(gap),
        };
        explanation.reason = explanation.reason(rank.root.as_deref(), hit);
        explanation.why = explanation.why(scene, rank.root.is_some(), hit, (self, is_at_origin));
        Some(explanation)
    }

    fn sphere(&self, sphere: &Sphere, index: usize) -> Option<(Vec<Line>, Vec<FormulaNumber>)> {
        let mut told = Derivation::new(self.digits);
        let [o, d] = self.told();
        let c = told.vector("c", sphere.center.to_array(), false);
        let r = told.number("r", sphere.radius);
        let exact = quadratic(o, d, c, r);
        told.line("", o - c, LineDetail::Numbers);
        told.line("a", exact.a, LineDetail::Numbers);
        told.line("b", exact.b, LineDetail::Addends);
        told.line("k", exact.k, LineDetail::Addends);
        told.line("D", exact.discriminant, LineDetail::Addends);
        told.say_sign(exact.discriminant.signum());
        let is_line = exact.a.signum() > 0;
        let is_met = exact.discriminant.signum() >= 0;
        let roots = (is_line && is_met).then(|| quadratic_roots(exact));
        if let Some(roots) = roots {
            told.roots(roots);
        }

        let of_lecture = self.lecture_objects.spheres.get(index)?;
        let num::Ray { origin, direction, .. } = self.lecture;
        let single = solved(origin, direction, V3(of_lecture.center), of_lecture.radius);
        let [origin, direction, center] =
            [self.origin, self.direction, sphere.center].map(V3::<f64>::near);
        let double = solved(origin, direction, center, sphere.radius);

        let of_stable = self.stable_objects.spheres.get(index)?;
        let l = of_stable.offset(&self.stable);
        let k = of_stable.k(&self.stable, l);
        let ray = &self.stable.ray;
        let chord = approach(ray, l, of_stable.radius);
        let h = half_root(ray, chord.delta);
        let stable_roots = (h >= 0.0).then(|| roots_stable(ray, chord.b, h, k));

        let e = self.exponent;
        let row = |i: usize, symbol, stable: Option<f64>, exact: Step| {
            let columns =
                Columns([Some(Some(single.0[i])), stable.map(Some), Some(Some(double.0[i]))]);
            columns.against(symbol, Some(&exact.value()))
        };
        let of_stable = |symbol, value: Option<f64>, exact: Option<Step>| {
            Columns([None, Some(value), None]).against(symbol, exact.map(Step::value).as_ref())
        };
        let root = |i: usize, symbol| {
            let stable = stable_roots.map(|roots| f64::from(scaled(roots[i], -e) as f32));
            let [lecture, double] = [single.1, double.1].map(|found| found.map(|roots| roots[i]));
            let exact = roots.map(|roots| roots[i].value());
            Columns([lecture, stable, double].map(Some)).against(symbol, exact.as_ref())
        };
        let lit = <Step as Real>::lit;
        let discriminant = exact.discriminant;
        let quantities = vec![
            row(0, "a", Some(scaled(ray.a, 2 * e)), exact.a),
            row(1, "b", Some(-2.0 * scaled(chord.b, e)), exact.b),
            row(2, "k", Some(f64::from(k)), exact.k),
            row(3, "D", None, discriminant),
            of_stable(
                "r²−P·P",
                Some(f64::from(chord.delta)),
                is_line.then(|| discriminant / (lit(4.0) * exact.a)),
            ),
            of_stable(
                "h",
                (h >= 0.0).then(|| scaled(h, e)),
                is_met.then(|| discriminant.sqrt() / lit(2.0)),
            ),
            root(0, "t₁"),
            root(1, "t₂"),
        ];
        Some((told.lines, quantities))
    }

    fn plane(&self, plane: &Plane, index: usize) -> Option<(Vec<Line>, Vec<FormulaNumber>)> {
        let mut told = Derivation::new(self.digits);
        let [o, d] = self.told();
        let a = told.vector("a", plane.point.to_array(), false);
        let n = told.vector("n", plane.normal.to_array(), true);
        let exact = lecture::plane_quotient(o, d, a, n);
        told.line("", a - o, LineDetail::Numbers);
        told.line("", exact[0], LineDetail::Addends);
        told.line("", exact[1], LineDetail::Addends);
        let root = (exact[1].signum() != 0).then(|| exact[0] / exact[1]);
        if let Some(root) = root {
            told.line("t", root, LineDetail::Numbers);
        }

        let of_lecture = self.lecture_objects.planes.get(index)?;
        let num::Ray { origin, direction, .. } = self.lecture;
        let (point, normal) = (V3(of_lecture.point), V3(of_lecture.normal));
        let single = lecture::plane_quotient(origin, direction, point, normal);
        let [origin, direction, point, normal] =
            [self.origin, self.direction, plane.point, plane.normal].map(V3::<f64>::near);
        let double = lecture::plane_quotient(origin, direction, point, normal);
        let of_stable = self.stable_objects.planes.get(index)?;
        let slope = self.stable.ray.direction.dot(V3(of_stable.normal));
        let stable = [of_stable.n_offset(&self.stable), slope];
        let (e, of_normal) = (self.exponent, exponent_of(plane.normal));
        let row = |i: usize, exponent, symbol| {
            Columns::all(single[i], scaled(stable[i], exponent), double[i])
                .against(symbol, Some(&exact[i].value()))
        };
        // A quotient by 0 is an infinity or NaN: no root.
        let quotient = |t: f64| t.is_finite().then_some(t);
        let t = [
            f64::from(single[0] / single[1]),
            f64::from(scaled(stable[0] / stable[1], -e) as f32),
            double[0] / double[1],
        ];
        let t = Columns(t.map(|t| Some(quotient(t))));
        let quantities = vec![
            row(0, of_normal, "(a−o)·n"),
            row(1, of_normal + e, "d·n"),
            t.against("t", root.map(Step::value).as_ref()),
        ];
        Some((told.lines, quantities))
    }

    /// `f(p)` of the object that a kernel sees, in its arithmetic: that of `lecture`, `stable` or `double`,
    /// in this order.
    pub fn residual(&self, scene: &Scene, kernel: usize, seen: &PlainPoint) -> Option<f64> {
        let index = seen.id.checked_sub(1)? as usize;
        let (p, way) = (V3(seen.at.map(|x| x as f32)), self.direction * seen.t);
        let (ray, way_of_stable) = (&self.stable, self.stable.ray.direction * seen.t as f32);
        let of_kernels = match scene.object(seen.id)? {
            Object::Sphere(sphere) => {
                let lecture = self.lecture_objects.spheres.get(index)?;
                let stable = self.stable_objects.spheres.get(index)?;
                let way = V3::near((self.origin - sphere.center) + way);
                [
                    off_sphere(p - V3(lecture.center), lecture.radius).into(),
                    off_sphere(way_of_stable - stable.offset(ray), stable.radius).into(),
                    off_sphere(way, sphere.radius),
                ]
            }
            Object::Plane(plane) => {
                let index = index - scene.spheres.len();
                let lecture = self.lecture_objects.planes.get(index)?;
                let stable = self.stable_objects.planes.get(index)?;
                let along = way_of_stable.dot(V3(stable.normal)) - stable.n_offset(ray);
                let way = V3::<f64>::near((self.origin - plane.point) + way);
                [
                    (p - V3(lecture.point)).dot(V3(lecture.normal)).into(),
                    scaled(along, exponent_of(plane.normal)),
                    way.dot(V3::near(plane.normal)),
                ]
            }
        };
        of_kernels.get(kernel).copied()
    }
}

/// `v·v − r²`, of a point from a sphere's centre.
pub fn off_sphere<R: Real>(v: V3<R>, r: R) -> R {
    v.dot(v) - r * r
}

/// `a`, `b`, `k` and `D` of the lecture's equation, and the roots, in an arithmetic.
fn solved<F: Float>(o: V3<F>, d: V3<F>, c: V3<F>, r: F) -> ([f64; 4], Option<[f64; 2]>) {
    let found = quadratic(o, d, c, r);
    let numbers = [found.a, found.b, found.k, found.discriminant].map(F::to_f64);
    (numbers, (numbers[3] >= 0.0).then(|| quadratic_roots(found).map(F::to_f64)))
}
