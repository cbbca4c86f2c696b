//! Numbers as colours. A colour is a word: sRGB bytes, red lowest, then alpha.

use crate::exact::{ExactPixels, signum_of_discriminant};
use crate::guard::{self, Guard};
use crate::kernel::RayOf;
use crate::kernel::arithmetic::Arithmetic;
use crate::kernel::lecture::quadratic;
use crate::kernel::relative::{RelativeSphere, approach};
use crate::prepare::{Objects, Prepared};
use crate::rays::{Bundle, CameraF32, Lens, Pixels, View};
use crate::scene::{Color, Object, Scene};
use crate::trace::{Hits, Level};
use crate::vec3::{Real, Vec3, dot3};
use crate::verify::{TError, Truth};

use super::show::Show;

/// Red, green and blue bytes.
pub type Rgb = [u8; 3];

/// A colour as a word.
pub fn word([r, g, b]: Rgb) -> u32 {
    u32::from_le_bytes([r, g, b, 255])
}

/// Rays that are not decided yet.
const NOT_YET: Rgb = [128, 128, 128];

const FRONT: Rgb = [0x4c, 0x9f, 0xd8];
const BACK: Rgb = [0xe0, 0x8a, 0x3c];
const NOTHING: Rgb = [0x1c, 0x1f, 0x24];

/// Colours by id, the background's first, and last that of rays that are not decided yet.
pub fn palette(show: Show, scene: &Scene, pixels: &Pixels) -> Vec<u32> {
    let n = scene.n_objects() as u32;
    let colors: Vec<Rgb> = match show {
        Show::Id => std::iter::once(NOTHING).chain((1..=n).map(id_color)).collect(),
        Show::Side => {
            let side = |id| if is_front(scene, pixels, id) { FRONT } else { BACK };
            std::iter::once(NOTHING).chain((1..=n).map(side)).collect()
        }
        _ => scene.colors().map(Color::to_srgb8).collect(),
    };
    colors.into_iter().chain([NOT_YET]).map(word).collect()
}

/// Hues a golden angle apart, so that neighbouring ids differ.
pub fn id_color(id: u32) -> Rgb {
    let hue = (f64::from(id) * 0.618_033_988_749_895).fract() * 6.0;
    let (value, chroma) = if id.is_multiple_of(2) { (0.95, 0.62) } else { (0.75, 0.55) };
    let channel = |shift: f64| {
        let distance = ((hue + shift) % 6.0 - 3.0).abs() - 1.0;
        ((value - chroma * (1.0 - distance.clamp(0.0, 1.0))) * 255.0).round() as u8
    };
    [channel(0.0), channel(4.0), channel(2.0)]
}

/// True where the eye is outside of the sphere, or on the side of the plane that its normal points
/// to. All of a picture's rays start at the eye, so what they see of an object is one side of it;
/// so it is where all run along one direction, but for spheres that the picture's plane cuts: of
/// these most of what is seen tells.
fn is_front(scene: &Scene, pixels: &Pixels, id: u32) -> bool {
    let View { position: eye, forward, lens, .. } = pixels.view;
    match (lens, scene.object(id)) {
        (Lens::Perspective, Some(Object::Sphere(sphere))) => {
            crate::exact::is_outside(eye, sphere.center, sphere.radius).unwrap_or(true)
        }
        (Lens::Perspective, Some(Object::Plane(plane))) => {
            (eye - plane.point).dot(plane.normal) >= 0.0
        }
        (Lens::Orthographic, Some(Object::Sphere(sphere))) => {
            (sphere.center - eye).dot(forward) > sphere.radius / 2.0
        }
        (Lens::Orthographic, Some(Object::Plane(plane))) => forward.dot(plane.normal) <= 0.0,
        (_, None) => true,
    }
}

/// A colour with its meaning.
pub type Swatch = (Rgb, &'static str);

const STAGES: [Swatch; 3] = [
    ([0x26, 0x3a, 0x4d], "f32, on the device"),
    ([0xf2, 0xb7, 0x01], "f64, on the CPU"),
    ([0xff, 0x4d, 0x6d], "exact arithmetic"),
];

const TWO: Rgb = [0xd6, 0x45, 0x2c];
const ONE: Rgb = [0xff, 0xf0, 0x7a];
const NONE: Rgb = [0x3b, 0x82, 0xc4];

/// Largest error in ulp, colour and meaning.
const ERRORS: [(f64, Swatch); 5] = [
    (0.5, ([0x1d, 0x4d, 0x3a], "t is the nearest f32")),
    (1.0, ([0x3a, 0x9d, 0x74], "t within 1 ulp")),
    (16.0, ([0xa7, 0xc9, 0x57], "t within 16 ulp")),
    (4096.0, ([0xf2, 0xb7, 0x01], "t within 4096 ulp")),
    (f64::INFINITY, ([0xf0, 0x7d, 0x1a], "t is off by more")),
];
const BACKGROUND_RIGHT: Swatch = (NOTHING, "background, rightly");
const OTHER: Swatch = ([0xe0, 0x2f, 0x6b], "wrong object");
const MISSED: Swatch = ([0xb0, 0x4c, 0xd8], "object missed");
const INVENTED: Swatch = ([0xff, 0x9e, 0xc4], "hit where nothing is");

/// The colours' meanings; empty where the names of the objects say them.
pub fn legend(show: Show) -> Vec<Swatch> {
    match show {
        Show::Color | Show::Id => Vec::new(),
        Show::Depth => vec![([0xf4, 0xf4, 0xf4], "near"), ([0x30, 0x30, 0x30], "far")],
        Show::Normal => {
            vec![([255, 128, 128], "+x"), ([128, 255, 128], "+y"), ([128, 128, 255], "+z")]
        }
        Show::Side => vec![(FRONT, "front"), (BACK, "back")],
        Show::Discriminant => {
            vec![(NONE, "D < 0: no solution"), (ONE, "D = 0: one"), (TWO, "D > 0: two")]
        }
        Show::Error => {
            let rest = [BACKGROUND_RIGHT, OTHER, MISSED, INVENTED];
            ERRORS.iter().map(|&(_, entry)| entry).chain(rest).collect()
        }
        Show::Stage => STAGES.to_vec(),
    }
}

/// The smallest and the largest `t` of a picture; `None` where nothing is hit.
pub fn range_of_t(hits: &Hits) -> Option<(f32, f32)> {
    let ts = hits.t.iter().copied().filter(|t| t.is_finite() && *t > 0.0);
    ts.fold(None, |range, t| match range {
        None => Some((t, t)),
        Some((low, high)) => Some((f32::min(low, t), f32::max(high, t))),
    })
}

/// Near is bright; the scale is logarithmic.
pub fn depth(hits: &Hits) -> Vec<u32> {
    let Some((low, high)) = range_of_t(hits) else { return vec![word(NOTHING); hits.t.len()] };
    let span = (f64::from(high) / f64::from(low)).ln().max(f64::MIN_POSITIVE);
    let shade = |&t: &f32| {
        if !t.is_finite() {
            return word(NOTHING);
        }
        let far = (f64::from(t) / f64::from(low)).ln() / span;
        let grey = (244.0 - 196.0 * far.clamp(0.0, 1.0)).round() as u8;
        word([grey; 3])
    };
    hits.t.iter().map(shade).collect()
}

/// −1 … 1 as 0 … 255.
pub fn normal(hits: &Hits) -> Vec<u32> {
    let shade = |(normal, &id): (&[f32; 3], &u32)| match id {
        0 => word(NOTHING),
        _ => word(normal.map(|x| ((f64::from(x) + 1.0) * 127.5).round() as u8)),
    };
    hits.normal.iter().zip(&hits.id).map(shade).collect()
}

/// By the stage that decided.
pub fn stage(hits: &Hits) -> Vec<u32> {
    let colors = STAGES.map(|(color, _)| word(color));
    let color = |&level: &u8| colors[usize::from(level).min(Level::Exact as usize)];
    hits.level.iter().map(color).collect()
}

/// The kernel's result of one ray against the exact one: entry `k` of `truth`.
pub fn error(hits: &Hits, truth: &Truth, k: usize) -> u32 {
    let index = truth.index[k];
    let (found, expected) = (hits.id[index], truth.id[k]);
    let (color, _) = match (found, expected) {
        (0, 0) => BACKGROUND_RIGHT,
        (0, _) => MISSED,
        (_, 0) => INVENTED,
        _ if found != expected => OTHER,
        _ => {
            let ulps = TError::new(hits.t[index], truth.t[k]).ulp;
            let class = ERRORS.iter().find(|(most, _)| ulps <= *most);
            class.map_or(ERRORS[ERRORS.len() - 1].1, |&(_, entry)| entry)
        }
    };
    word(color)
}

/// The discriminants of some rows of a picture, with the spheres that `hits` chooses.
pub struct Discriminants<'a> {
    prepared: &'a Prepared,
    pixels: &'a Pixels,
    exact: ExactPixels,
    camera: CameraF32,
    guards: Vec<Guard>,
}

impl<'a> Discriminants<'a> {
    /// For a scene prepared for the kernel whose arithmetic is looked at.
    pub fn new(prepared: &'a Prepared, pixels: &'a Pixels) -> Discriminants<'a> {
        let View { position, lens, .. } = pixels.view;
        let guard = |sphere: &crate::scene::Sphere| {
            let distance = guard::length_bound(sphere.center - position) + pixels.spread();
            Guard::new(sphere.radius, distance, guard::UNIT_F64, guard::input_of(lens))
        };
        Discriminants {
            prepared,
            pixels,
            exact: ExactPixels::new(pixels),
            camera: f32::camera(&prepared.coordinates(), pixels),
            guards: prepared.scene.spheres.iter().map(guard).collect(),
        }
    }

    /// The colour of the pixel with this index, where object `id` is seen.
    pub fn color(&self, index: usize, id: u32) -> u32 {
        let (x, y) = self.pixels.xy(index);
        let ray = self.pixels.ray_from_position(x, y);
        // (‖P‖² , 1 − ‖P‖²/r²): the latter is D/(4ar²), and 1 where the line meets the centre.
        let nearness = |i: usize| {
            let sphere = &self.prepared.scene.spheres[i];
            let l = Vec3::from(sphere.center - self.pixels.view.position) - ray.origin;
            let p = l - direction_times(&ray, l);
            let m = dot3(p, p);
            (m, 1.0 - m / (sphere.radius * sphere.radius))
        };
        let n_spheres = self.prepared.scene.spheres.len();
        let chosen = match (id as usize).checked_sub(1).filter(|&i| i < n_spheres) {
            Some(i) => Some(i),
            None => (0..n_spheres).max_by(|&a, &b| nearness(a).1.total_cmp(&nearness(b).1)),
        };
        let Some(i) = chosen else { return word(NOTHING) };
        let (m, value) = nearness(i);
        let (column, row) = self.pixels.offset2(x, y);
        let single = f32::pixel_ray(&self.camera, column, row);
        let sign = match &self.prepared.objects {
            Objects::Lecture(lists) => {
                let sphere = &lists.spheres[i];
                let RayOf { origin, direction, .. } = single;
                let equation = quadratic(origin, direction, Vec3(sphere.center), sphere.radius);
                sign(equation.discriminant)
            }
            Objects::Stable(lists) => self.sign_of_delta(&lists.spheres[i], &single),
            Objects::Double(lists) => self.sign_of_delta(&lists.spheres[i], &ray),
            Objects::Certified(_) => self.exact_sign(i, m, x, y),
        };
        shade(sign, value)
    }

    fn sign_of_delta<S: RelativeSphere>(&self, sphere: &S, ray: &RayOf<S::Float>) -> i32 {
        let l = match self.prepared.bundle() {
            Bundle::Point => sphere.sphere_offset::<true>(ray),
            Bundle::Parallel | Bundle::Free => sphere.sphere_offset::<false>(ray),
        };
        sign(approach(ray, l, sphere.radius()).delta)
    }

    /// The sign of D: in f64 where its bounds allow, else exactly.
    fn exact_sign(&self, i: usize, m: f64, x: u32, y: u32) -> i32 {
        let guard = &self.guards[i];
        if m < guard.inner2 {
            return 1;
        }
        if m > guard.outer2 {
            return -1;
        }
        let sphere = &self.prepared.scene.spheres[i];
        signum_of_discriminant(&self.exact.ray(x, y), sphere.center, sphere.radius).unwrap_or(-1)
    }
}

fn direction_times(ray: &RayOf<f64>, l: Vec3<f64>) -> Vec3<f64> {
    ray.direction * (dot3(ray.direction, l) * ray.inv_a)
}

fn sign<R: Real>(discriminant: R) -> i32 {
    if discriminant > R::ZERO {
        1
    } else if discriminant == R::ZERO {
        0
    } else {
        -1
    }
}

/// Brighter the nearer the line comes to the middle.
fn shade(sign: i32, value: f64) -> u32 {
    let (color, light) = match sign {
        0 => (ONE, 1.0),
        1 => (TWO, 0.45 + 0.55 * value.clamp(0.0, 1.0)),
        _ => (NONE, 0.25 + 0.75 / (1.0 + value.min(0.0).abs())),
    };
    word(color.map(|channel| (f64::from(channel) * light).round() as u8))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::Path;
    use std::sync::Arc;

    use super::*;
    use crate::control::Control;
    use crate::cpu::CpuTracer;
    use crate::rays::View;
    use crate::scene::parse_scene;
    use crate::trace::{Kernel, Rays, Wants};
    use crate::tracer::Tracer;

    const FIGURE5: &str = include_str!("../../scenes/figure5.toml");

    fn figure5() -> (Arc<Scene>, Pixels) {
        let scene = Arc::new(parse_scene(FIGURE5, Path::new("figure5.toml")).unwrap());
        let view = View::new(scene.camera.as_ref().unwrap());
        (scene, Pixels::whole(view, 1281, 721))
    }

    fn traced(kernel: Kernel, pixels: Pixels) -> (Prepared, Hits) {
        let scene = figure5().0;
        let rays = Rays::Pixels(pixels);
        let prepared = Prepared::new(scene, kernel, &rays).unwrap();
        let wants = Wants { surface: true, level: true };
        let mut hits = Hits::default();
        let mut tracer = CpuTracer::new(Arc::new(prepared.clone()), wants);
        tracer.trace(&rays, &Control::default(), &mut hits).unwrap();
        (prepared, hits)
    }

    #[test]
    fn figure_5_has_all_three_signs_and_d_0_in_its_centre_alone() {
        let whole = figure5().1;
        let pixels = Pixels { x: 600, y: 320, width: 81, height: 81, ..whole };
        for kernel in Kernel::ALL {
            let (prepared, hits) = traced(kernel, pixels);
            let discriminants = Discriminants::new(&prepared, &pixels);
            let colors: Vec<u32> =
                (0..pixels.len()).map(|i| discriminants.color(i, hits.id[i])).collect();
            assert_eq!(colors[40 * 81 + 40], word(ONE), "{kernel:?}");
            if kernel == Kernel::Certified {
                assert_eq!(colors.iter().filter(|&&color| color == word(ONE)).count(), 1);
            }
            let is_blue = |color: &u32| color >> 16 & 255 > color & 255;
            assert!(colors.iter().any(is_blue) && colors.iter().any(|color| !is_blue(color)));
        }
    }

    #[test]
    fn errors_are_told_apart() {
        let pixels = Pixels { x: 560, y: 300, width: 161, height: 121, ..figure5().1 };
        let (_, mut hits) = traced(Kernel::Certified, pixels);
        let all = (0..pixels.len()).collect();
        let truth = Truth::of_pixels(&figure5().0, &pixels, all, &Control::default()).unwrap();
        let on = |id| truth.id.iter().position(|&other| other == id).unwrap();
        let (hit, miss) = (on(2), on(0));
        let right = |hits: &Hits, k| error(hits, &truth, k);
        assert_eq!(right(&hits, hit), word(ERRORS[0].1.0));
        assert_eq!(right(&hits, miss), word(BACKGROUND_RIGHT.0));
        hits.t[hit] = f32::from_bits(hits.t[hit].to_bits() + 9);
        assert_eq!(right(&hits, hit), word(ERRORS[2].1.0));
        hits.id[hit] = 3;
        assert_eq!(right(&hits, hit), word(OTHER.0));
        hits.id[hit] = 0;
        assert_eq!(right(&hits, hit), word(MISSED.0));
        hits.id[miss] = 1;
        assert_eq!(right(&hits, miss), word(INVENTED.0));
    }

    #[test]
    fn palettes_have_a_colour_for_each_id_and_for_what_is_open() {
        let (scene, pixels) = figure5();
        for show in Show::ALL {
            let palette = palette(show, &scene, &pixels);
            assert_eq!(palette.len(), scene.n_objects() + 2);
            assert_eq!(palette.last(), Some(&word(NOT_YET)));
            assert!(palette.iter().all(|color| color >> 24 == 255));
        }
        let ids: BTreeSet<Rgb> = (1..200).map(id_color).collect();
        assert!(ids.len() > 190, "{} colours", ids.len());
    }

    #[test]
    fn sides_are_those_of_the_eye() {
        let (scene, pixels) = figure5();
        assert!((1..=3).all(|id| is_front(&scene, &pixels, id)));
        let mut inside = pixels;
        inside.view.position = scene.spheres[1].center;
        assert!(is_front(&scene, &inside, 1) && !is_front(&scene, &inside, 2));
    }

    #[test]
    fn depth_and_normal_follow_the_numbers() {
        let pixels = Pixels { x: 560, y: 300, width: 161, height: 121, ..figure5().1 };
        let (_, hits) = traced(Kernel::Stable, pixels);
        let (low, high) = range_of_t(&hits).unwrap();
        assert!(low > 0.0 && low < high && high.is_finite());
        let depth = depth(&hits);
        let at = |t: f32| depth[hits.t.iter().position(|&other| other == t).unwrap()];
        assert_eq!((at(low), at(high)), (word([244; 3]), word([48; 3])));
        let normals = normal(&hits);
        let k = hits.id.iter().position(|&id| id == 3).unwrap();
        let [_, _, z] = hits.normal[k];
        assert_eq!(normals[k] >> 16 & 255, ((f64::from(z) + 1.0) * 127.5).round() as u32);
        let empty = Hits { t: vec![f32::INFINITY; 2], ..Hits::default() };
        assert_eq!(super::depth(&empty), [word(NOTHING); 2]);
    }
}
