//! One ray's numbers as the kernels have them, in f64, and exactly.

use std::sync::Arc;

use glam::DVec3;
use kugelblitz::Result;
use kugelblitz::exact::{
    Dyadic, ExactHit, ExactRay, ExactRays, QuadraticSurd, plane_numbers, signum_of_discriminant,
    visible_hit,
};
use kugelblitz::kernel::baseline::{BaselineRay, BaselineRays};
use kugelblitz::kernel::lecture::{plane_quotient, quadratic, quadratic_roots};
use kugelblitz::kernel::relative::{PlaneStable, SphereStable, approach, half_root, roots_stable};
use kugelblitz::lighting::{BaselinePoint, Lighting};
use kugelblitz::num::{self, Float, Real, V3};
use kugelblitz::prepare::{Prepared, exponent_of};
use kugelblitz::query::{Kernel, Rays, WorldRay};
use kugelblitz::scene::{Object, Plane, Scene, Sphere};

use super::camera;
use super::derivation::Derivation;
use super::derivation::LineDetail::{Addends, Numbers};
use super::numbers::{in_all, scaled};
use super::shading::lighting;
use super::step::{Step, Tape};
use super::words::ExplanationWords;
use super::{CameraExplanation, ExplainStyle, ObjectExplanation, Rank, Reason, label_in};
use crate::verify::{Near, is_clearly_missed};
use crate::wrong_usage;

/// All that is known of a ray.
pub struct RayNumbers<'a> {
    pub scene: &'a Scene,
    pub rays: &'a Rays,
    pub exact: ExactRay,
    pub origin: DVec3,
    pub direction: DVec3,
    /// The ray in f64, from the camera's position or from its own origin.
    pub near: Near,
    lecture: num::Ray<f32>,
    double: num::Ray<f64>,
    stable: BaselineRay<f32>,
    /// `direction = 2^exponent · stable.direction`.
    exponent: i32,
    pub words: &'static ExplanationWords,
    pub digits: usize,
    /// What the ray sees, exactly.
    pub hit: Option<ExactHit<'a>>,
    /// All that lights the scene; `None` where a pixel shows the colour of its object.
    pub lighting: Option<Lighting>,
    /// What the kernels `lecture`, `stable` and `double` make of the light, whatever they see.
    plain: [Option<BaselinePoint>; 3],
    /// What the numbers of `stable` are relative to.
    reference_of_stable: DVec3,
    /// What the points of `double` are relative to.
    pub reference: DVec3,
}

impl<'a> RayNumbers<'a> {
    /// The numbers of the one ray, without what it sees.
    pub fn new(scene: &'a Arc<Scene>, rays: &'a Rays, style: &ExplainStyle) -> Result<Self> {
        let (WorldRay { origin, direction }, exponent) = match rays {
            _ if rays.len() != 1 => return wrong_usage("one ray is explained at a time"),
            Rays::Pixels(p) => (p.ray(p.x, p.y), 0),
            Rays::List(rays) => (rays[0], exponent_of(rays[0].direction)),
        };
        let of_kernel = |kernel| Prepared::new(Arc::clone(scene), kernel, rays);
        let on_lecture = of_kernel(Kernel::Lecture)?;
        let on_stable = of_kernel(Kernel::Stable)?;
        let on_double = of_kernel(Kernel::Double)?;
        let lighting = lighting(scene, rays);
        let none = Lighting { lamps: Vec::new(), ambient: [0.0; 3], n_shares: 1 };
        let plain = [&on_lecture, &on_stable, &on_double]
            .map(|prepared| BaselinePoint::new(prepared, rays, lighting.as_ref().unwrap_or(&none)));
        let of_kernel =
            |prepared: &Prepared| BaselineRays::new(prepared.coordinates(), rays).one(0);
        let (lecture, stable) = (of_kernel(&on_lecture).ray, of_kernel(&on_stable));
        Ok(RayNumbers {
            scene,
            rays,
            exact: ExactRays::from(rays).ray(0),
            origin,
            direction,
            near: Near::new(rays, 0),
            lecture,
            double: num::Ray::new(V3::lit(origin), V3::lit(direction)),
            stable,
            exponent,
            words: style.lang.words(),
            digits: style.digits,
            hit: None,
            lighting,
            plain,
            reference_of_stable: on_stable.reference,
            reference: on_double.reference,
        })
    }

    /// What the kernels `lecture`, `stable` and `double` make of the light; none where one sees another object.
    pub fn plain(&self) -> [Option<&BaselinePoint>; 3] {
        let right = self.hit.as_ref().map(|hit| hit.id);
        self.plain.each_ref().map(|plain| plain.as_ref().filter(|plain| Some(plain.id) == right))
    }

    /// `sphere 3 (red giant)`
    pub fn label(&self, id: u32) -> String {
        label_in(self.words, self.scene, id)
    }

    /// The exact `t` at which the ray meets an object.
    pub fn root(&self, id: u32) -> Option<QuadraticSurd> {
        let object = self.scene.object(id)?;
        if is_clearly_missed(&self.near, &object) {
            return None;
        }
        visible_hit(&self.exact, id, object).map(|hit| hit.root)
    }

    /// Whether the ray's whole line meets an object.
    pub fn line_meets(&self, id: u32) -> Option<bool> {
        Some(match self.scene.object(id)? {
            object if is_clearly_missed(&self.near, &object) => false,
            Object::Sphere(sphere) => signum_of_discriminant(&self.exact, sphere)? >= 0,
            Object::Plane(plane) => plane_numbers(&self.exact, plane)?.denominator.signum() != 0,
        })
    }

    /// How far the half line passes from a surface that it misses, and whether its origin is as near as any
    /// point of it; only for order and for the eye.
    pub fn gap(&self, object: Object) -> (f64, bool) {
        let (gap, is_at_origin) = match object {
            Object::Sphere(sphere) => {
                let l = sphere.center - self.origin;
                let s = self.direction.dot(l) / self.direction.length_squared();
                let nearest = if s > 0.0 { l - self.direction * s } else { l };
                (nearest.length() - sphere.radius, s <= 0.0)
            }
            Object::Plane(plane) => {
                let distance = (plane.point - self.origin).dot(plane.normal);
                ((distance / plane.normal.length()).abs(), true)
            }
        };
        (gap.max(0.0), is_at_origin)
    }

    /// Begins a derivation from `o` and `d`, exactly.
    pub fn derivation<'t>(&self, tape: &'t Tape) -> (Derivation, [V3<Step<'t>>; 2]) {
        let derivation = Derivation::new(self.digits);
        let (s, f) = (self.exact.world_scale(), self.exact.direction_scale());
        let of = |name, v: &[Dyadic; 3], scale| {
            tape.vector(name, v.each_ref().map(|x| QuadraticSurd::ratio(x.clone(), scale)))
        };
        (derivation, [of("o", self.exact.origin(), s), of("d", self.exact.direction(), f)])
    }

    /// Derives `o` and `d`, and returns the camera as well if the ray belongs to a pixel.
    pub fn ray(&self) -> (Derivation, Option<CameraExplanation>) {
        let tape = Tape::default();
        let (mut derivation, [o, d], camera) = match self.rays {
            Rays::Pixels(pixels) => {
                let (derivation, ray, camera) =
                    camera::derive(&tape, pixels, self.scene, self.words, self.digits);
                (derivation, ray, Some(camera))
            }
            Rays::List(_) => {
                let (mut derivation, [o, d]) = self.derivation(&tape);
                derivation.given("o", &o.0);
                derivation.given("d", &d.0);
                (derivation, [o, d], None)
            }
        };
        let num::Ray { origin, direction, .. } = self.lecture;
        derivation.rows(["o.x", "o.y", "o.z"], o.0, |axis| {
            [Some(Some(origin.0[axis].into())), None, Some(Some(self.origin[axis]))]
        });
        derivation.rows(["d.x", "d.y", "d.z"], d.0, |axis| {
            let stable = scaled(self.stable.ray.direction.0[axis], self.exponent);
            in_all(direction.0[axis], stable, self.direction[axis])
        });
        (derivation, camera)
    }

    /// How the ray meets an object.
    pub fn object(&self, rank: &Rank) -> Option<ObjectExplanation> {
        let id = rank.id;
        let object = self.scene.object(id)?;
        let derivation = match object {
            Object::Sphere(sphere) => self.sphere(sphere),
            Object::Plane(plane) => self.plane(plane),
        };
        let (gap, is_at_origin) = self.gap(object);
        let mut explanation = ObjectExplanation {
            id,
            label: self.label(id),
            shape: object.shape(),
            formulas: derivation.formulas(),
            derivation,
            reason: Reason::Degenerate,
            why: Vec::new(),
            gap: rank.root.is_none().then_some(gap),
        };
        explanation.reason = explanation.reason(rank.root.as_deref(), self);
        explanation.why = explanation.why(self, is_at_origin);
        Some(explanation)
    }

    fn sphere(&self, sphere: &Sphere) -> Derivation {
        let tape = Tape::default();
        let (mut derivation, [o, d]) = self.derivation(&tape);
        let c = V3(derivation.of_scene(&tape, "c", sphere.center.to_array()));
        let [r] = derivation.of_scene(&tape, "r", [sphere.radius]);
        let exact = quadratic(o, d, c, r);
        derivation.line("", &(o - c).0, Numbers);
        derivation.line("a", &[exact.a], Numbers);
        derivation.line("b", &[exact.b], Addends);
        derivation.line("k", &[exact.k], Addends);
        derivation.line("D", &[exact.discriminant], Addends);
        derivation.state_sign(exact.discriminant.signum());
        let is_line = exact.a.signum() > 0;
        let is_met = exact.discriminant.signum() >= 0;
        let roots = (is_line && is_met).then(|| quadratic_roots(exact));
        if let Some(roots) = roots {
            derivation.roots(roots);
        }

        let (single, double) = (solved(&self.lecture, sphere), solved(&self.double, sphere));
        let of_stable = SphereStable::new(sphere, self.reference_of_stable);
        let l = of_stable.offset(&self.stable);
        let k = of_stable.k(&self.stable, l);
        let (ray, e) = (&self.stable.ray, self.exponent);
        let chord = approach(ray, l, of_stable.radius);
        let h = half_root(ray, chord.delta);
        let is_hit = h >= 0.0;
        let stable = is_hit.then(|| roots_stable(ray, chord.b, h, k).map(|t| self.t_of_stable(t)));

        let mut row = |symbol, lecture: Option<usize>, stable, exact: Option<Step>| {
            let [single, double] = [single, double].map(|numbers| lecture.map(|i| numbers[i]));
            derivation.row(symbol, [single, stable, double], exact.map(Step::value));
        };
        let (lit, discriminant) = (Step::lit, exact.discriminant);
        let delta = is_line.then(|| discriminant / (lit(4.0) * exact.a));
        let half = is_met.then(|| discriminant.sqrt() / lit(2.0));
        row("a", Some(0), Some(Some(scaled(ray.a, 2 * e))), Some(exact.a));
        row("b", Some(1), Some(Some(-2.0 * scaled(chord.b, e))), Some(exact.b));
        row("k", Some(2), Some(Some(k.into())), Some(exact.k));
        row("D", Some(3), None, Some(discriminant));
        row("r²−P·P", None, Some(Some(chord.delta.into())), delta);
        row("h", None, Some(is_hit.then(|| scaled(h, e))), half);
        row("t₁", Some(4), Some(stable.map(|t| t[0])), roots.map(|roots| roots[0]));
        row("t₂", Some(5), Some(stable.map(|t| t[1])), roots.map(|roots| roots[1]));
        derivation
    }

    /// A `t` of the kernel `stable`, as it reports it.
    fn t_of_stable(&self, t: f32) -> f64 {
        f64::from(scaled(t, -self.exponent) as f32)
    }

    fn plane(&self, plane: &Plane) -> Derivation {
        let tape = Tape::default();
        let (mut derivation, [o, d]) = self.derivation(&tape);
        let a = V3(derivation.of_scene(&tape, "a", plane.point.to_array()));
        let n = V3(derivation.of_scene(&tape, "n", plane.normal.to_array()));
        let exact = plane_quotient(o, d, a, n);
        derivation.line("", &(a - o).0, Numbers);
        derivation.line("", &exact[..1], Addends);
        derivation.line("", &exact[1..], Addends);
        let root = (exact[1].signum() != 0).then(|| exact[0] / exact[1]);
        if let Some(root) = root {
            derivation.line("t", &[root], Numbers);
        }

        let (single, double) = (divided(&self.lecture, plane), divided(&self.double, plane));
        let of_stable = PlaneStable::new(plane, self.reference_of_stable);
        let slope = self.stable.ray.direction.dot(V3(of_stable.normal));
        let stable = [of_stable.n_offset(&self.stable), slope];
        let (e, of_normal) = (self.exponent, exponent_of(plane.normal));
        derivation.rows(["(a−o)·n", "d·n"], exact, |i| {
            in_all(single[i], scaled(stable[i], of_normal + [0, e][i]), double[i])
        });
        let t_of_stable = self.t_of_stable(stable[0] / stable[1]);
        let t = in_all(single[0] / single[1], t_of_stable, double[0] / double[1]);
        // A quotient by 0 is an infinity or NaN: no root.
        let t = t.map(|t| t.map(|t| t.filter(|t| t.is_finite())));
        derivation.row("t", t, root.map(Step::value));
        derivation
    }

    /// `f(p)` of the object that a kernel sees, in its arithmetic: that of `lecture`, `stable` or `double`,
    /// in this order.
    pub fn residual(&self, kernel: usize, seen: &BaselinePoint) -> Option<f64> {
        let object = self.scene.object(seen.id)?;
        let (at, _) = object.extent();
        let lecture = V3(seen.at.map(|x| x as f32)) - V3::lit(at);
        let double = V3::<f64>::lit((self.origin - at) + self.direction * seen.t);
        let (ray, way) = (&self.stable, self.stable.ray.direction * seen.t as f32);
        let of_kernels = match object {
            Object::Sphere(sphere) => {
                let stable = SphereStable::new(sphere, self.reference_of_stable);
                [
                    off_sphere(lecture, sphere.radius as f32).into(),
                    off_sphere(way - stable.offset(ray), stable.radius).into(),
                    off_sphere(double, sphere.radius),
                ]
            }
            Object::Plane(plane) => {
                let stable = PlaneStable::new(plane, self.reference_of_stable);
                let along = way.dot(V3(stable.normal)) - stable.n_offset(ray);
                [
                    lecture.dot(V3::lit(plane.normal)).into(),
                    scaled(along, exponent_of(plane.normal)),
                    double.dot(V3::lit(plane.normal)),
                ]
            }
        };
        Some(of_kernels[kernel])
    }
}

/// `v·v − r²`, of a point from a sphere's centre.
pub fn off_sphere<R: Real>(v: V3<R>, r: R) -> R {
    v.dot(v) - r * r
}

/// `a`, `b`, `k` and `D` of the lecture's equation, and the roots where it has some, in an arithmetic.
fn solved<F: Float>(ray: &num::Ray<F>, sphere: &Sphere) -> [Option<f64>; 6] {
    let (center, radius) = (V3::lit(sphere.center), F::near(sphere.radius));
    let found = quadratic(ray.origin, ray.direction, center, radius);
    let is_met = found.discriminant.to_f64() >= 0.0;
    let [near, far] = quadratic_roots(found);
    let of = |number: F| Some(number.to_f64());
    let root = |root: F| of(root).filter(|_| is_met);
    [of(found.a), of(found.b), of(found.k), of(found.discriminant), root(near), root(far)]
}

/// `(a − o)·n` and `d·n` in an arithmetic.
fn divided<F: Float>(ray: &num::Ray<F>, plane: &Plane) -> [F; 2] {
    let [point, normal] = [plane.point, plane.normal].map(V3::lit);
    plane_quotient(ray.origin, ray.direction, point, normal)
}
