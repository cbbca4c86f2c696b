//! Cameras that frame everything: as near as the picture's edges let them.
//!
//! A sphere is in a perspective picture where it lies within the four planes through the eye `p` and
//! the picture's edges. With such a plane's unit normal `n`, which points into the picture, that is
//! `n·(c − p) ≥ r`, linear in `p`: of all spheres, only the least `n·c − r` counts. So the nearest eye
//! follows from five numbers, whatever the number of spheres, and silhouettes touch the edges. For an
//! orthographic camera the planes are parallel to the view axis, and the same numbers give the picture's
//! width and height.

use glam::DVec3;

use super::{Camera, Projection, Sphere};
use crate::error::{Error, Hint, Message, Result, Setting, wrong_usage};
use crate::rays::View;
use crate::support::control::Control;
use crate::support::parallel;

/// Where a camera is placed, but for how far away.
#[derive(Clone, Debug, PartialEq)]
pub struct Framing {
    /// From what is seen towards the camera, in world axes, of any length but zero.
    pub from: DVec3,
    /// The direction that appears upward; not parallel to `from`.
    pub up: DVec3,
    /// The kind of picture.
    pub projection: Projection,
    /// True where an orthographic picture is as high as needed, whatever the projection says.
    pub fits_height: bool,
    /// Columns and rows of the picture: only their ratio counts.
    pub size: [u32; 2],
    /// Part of the picture's shorter side that is left free at each edge, from 0 to
    /// [`Framing::MAX_MARGIN`].
    pub margin: f64,
    /// The point in the middle of the picture; chosen by what is seen where there is none.
    pub look_at: Option<DVec3>,
    /// Number of directions around `up`, evenly spread from `from` on, that all are to see everything:
    /// 1 for a single picture.
    pub n_turns: u32,
}

/// Part of the scene's size that a camera's numbers are rounded to; less than a pixel.
const ROUNDING: f64 = 5e-5;

impl Framing {
    /// The margin where none is asked for.
    pub const MARGIN: f64 = 0.04;

    /// The largest margin: a tenth of the picture is left.
    pub const MAX_MARGIN: f64 = 0.45;

    /// A camera that has all `spheres` in its picture, as near as can be. Its numbers are short where
    /// those of `from` are.
    ///
    /// # Errors
    /// [`Error::Usage`] without spheres, and where their coordinates are too large to be framed;
    /// [`Error::Interrupted`] when `control` was cancelled.
    pub fn camera(&self, spheres: &[Sphere], control: &Control) -> Result<Camera> {
        let (middle, size) = bounds(spheres)?;
        let step = FramingStep::of(ROUNDING * size);
        let n_turns = self.n_turns.clamp(1, MOST_TURNS);
        let look_at = match self.look_at {
            Some(look_at) => look_at,
            None if n_turns > 1 => step.near(middle),
            None => step.near(middle + self.centred(spheres, middle, control)?),
        };
        let fit = |turn: u32| {
            control.check()?;
            let view = self.view(turned(self.from, self.up, turn, n_turns));
            let limits = Limits::new(self, view, self.usable(view.h), spheres, middle);
            Ok(limits.fit(self, look_at - middle, size))
        };
        let larger = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a.max(c), b.max(d)];
        let fits = parallel::try_map(0..n_turns, fit)?;
        let [distance, height] = fits.into_iter().fold([0.0; 2], larger);
        let factor = step.above(distance / self.from.length());
        let camera = Camera {
            position: step.near_if_it_is(look_at + factor * self.from, size),
            look_at,
            up: self.up,
            projection: match self.projection {
                Projection::Orthographic { .. } if self.fits_height => {
                    Projection::Orthographic { height: step.above(height) }
                }
                projection => projection,
            },
        };
        let is_usable = camera.position.is_finite() && camera.position != camera.look_at;
        if is_usable { Ok(camera) } else { Err(too_large()) }
    }

    /// Half the picture's width and height that can be used, as tangents or as parts of its height.
    fn usable(&self, h: f64) -> [f64; 2] {
        let [width, height] = self.size.map(|side| f64::from(side.max(1)));
        let margin = self.margin.clamp(0.0, Framing::MAX_MARGIN) * width.min(height);
        [h * (width - 2.0 * margin) / height, h * (height - 2.0 * margin) / height]
    }

    fn view(&self, from: DVec3) -> View {
        let Framing { up, projection, .. } = *self;
        View::new(&Camera { position: from, look_at: DVec3::ZERO, up, projection })
    }

    /// The way from the middle of the scene to the axis of a picture that has equal parts of it free at
    /// opposite edges.
    ///
    /// Two opposite edges decide how far away the eye is, and are touched. Between the other two there is
    /// room to spare: as much at both where a picture that is narrower in this direction would be filled.
    fn centred(&self, spheres: &[Sphere], middle: DVec3, control: &Control) -> Result<DVec3> {
        let view = self.view(self.from);
        let usable = self.usable(view.h);
        let limits = |usable| Limits::new(self, view, usable, spheres, middle);
        let whole = limits(usable);
        let Projection::Perspective { .. } = self.projection else { return Ok(whole.aside()) };
        let [across, along] = whole.eyes();
        let (spare, eye) = if across < along { (1, across) } else { (0, along) };
        let (mut too_narrow, mut enough, mut narrowed) = (0.0, 1.0, whole);
        for _ in 0..CENTRING_STEPS {
            control.check()?;
            let part = 0.5 * (too_narrow + enough);
            let mut usable = usable;
            usable[spare] *= part;
            let limits = limits(usable);
            if limits.eyes()[spare] < eye {
                too_narrow = part;
            } else {
                (enough, narrowed) = (part, limits);
            }
        }
        Ok(narrowed.aside())
    }
}

/// Directions that are looked from. Between two of them, half a degree apart, what is in the picture moves by
/// less than a pixel in a thousand.
const MOST_TURNS: u32 = 720;

/// Halvings until the picture is in the middle to a part in two thousand.
const CENTRING_STEPS: u32 = 10;

/// `from` turned about `up`: the given part of a full turn, to the right as seen from above.
pub(crate) fn turned(from: DVec3, up: DVec3, turn: u32, n_turns: u32) -> DVec3 {
    if turn == 0 {
        return from;
    }
    let angle = std::f64::consts::TAU * f64::from(turn) / f64::from(n_turns);
    // The system's functions may differ in their last bit from one machine to the next.
    let (sin, cos) = libm::sincos(angle);
    let axis = up / up.length();
    from * cos + axis.cross(from) * sin + axis * (axis.dot(from) * (1.0 - cos))
}

/// Two opposite edges of the picture: the angle between the view axis and the planes through them.
#[derive(Clone, Copy, Debug)]
struct Edge {
    cos: f64,
    sin: f64,
}

/// Spheres that one thread looks at, at a time.
const SPHERES_AT_ONCE: usize = 1 << 14;

fn least_of<const N: usize>(a: [f64; N], b: [f64; N]) -> [f64; N] {
    std::array::from_fn(|i| a[i].min(b[i]))
}

/// How far within left, right, lower, upper edge and picture plane the spheres reach, with the planes
/// put through the middle of the scene.
struct Limits {
    view: View,
    edges: [Edge; 2],
    least: [f64; 5],
}

impl Limits {
    /// The limits of a picture of which so much can be used.
    fn new(
        framing: &Framing,
        view: View,
        usable: [f64; 2],
        spheres: &[Sphere],
        middle: DVec3,
    ) -> Limits {
        let edges = usable.map(|tan| match framing.projection {
            Projection::Perspective { .. } => {
                let cos = 1.0 / (1.0 + tan * tan).sqrt();
                Edge { cos, sin: tan * cos }
            }
            Projection::Orthographic { .. } => Edge { cos: 1.0, sin: 0.0 },
        });
        let [across, along] = edges;
        let of_some = |spheres: &[Sphere]| {
            let mut least = [f64::INFINITY; 5];
            for sphere in spheres {
                let from_middle = sphere.center - middle;
                let x = from_middle.dot(view.right);
                let y = from_middle.dot(view.true_up);
                let z = from_middle.dot(view.forward);
                let inside = [
                    across.cos * x + across.sin * z,
                    -across.cos * x + across.sin * z,
                    along.cos * y + along.sin * z,
                    -along.cos * y + along.sin * z,
                    z,
                ];
                least = least_of(least, inside.map(|inside| inside - sphere.radius));
            }
            least
        };
        let parts = parallel::map(spheres.chunks(SPHERES_AT_ONCE), of_some);
        let least = parts.into_iter().fold([f64::INFINITY; 5], least_of);
        Limits { view, edges, least }
    }

    /// The nearest places of an eye on the axis that two opposite edges allow, along the view axis.
    fn eyes(&self) -> [f64; 2] {
        let [left, right, lower, upper, _] = self.least;
        let [across, along] = self.edges.map(|edge| edge.sin);
        [(left + right) / (2.0 * across), (lower + upper) / (2.0 * along)]
    }

    /// The way from the middle of the scene to the axis that has as much room on all sides.
    fn aside(&self) -> DVec3 {
        let [left, right, lower, upper, _] = self.least;
        let [across, along] = self.edges.map(|edge| edge.cos);
        let (x, y) = ((left - right) / (2.0 * across), (lower - upper) / (2.0 * along));
        x * self.view.right + y * self.view.true_up
    }

    /// The least distance from the point that is looked at, and height of an orthographic picture, that are enough.
    /// `axis` is the way from the middle of the scene to that point.
    fn fit(&self, framing: &Framing, axis: DVec3, size: f64) -> [f64; 2] {
        let [left, right, lower, upper, front] = self.least;
        let View { right: to_right, true_up, forward, .. } = self.view;
        let (x, y, z) = (axis.dot(to_right), axis.dot(true_up), axis.dot(forward));
        let [across, along] = self.edges;
        // Beyond what the edges ask for: a camera looks from somewhere.
        let least_distance = ROUNDING * size;
        match framing.projection {
            Projection::Perspective { .. } => {
                let eye = [
                    (left - across.cos * x) / across.sin,
                    (right + across.cos * x) / across.sin,
                    (lower - along.cos * y) / along.sin,
                    (upper + along.cos * y) / along.sin,
                ];
                let eye = eye.into_iter().fold(f64::INFINITY, f64::min);
                [(z - eye).max(least_distance), 0.0]
            }
            Projection::Orthographic { .. } => {
                let [half_width, half_height] = framing.usable(0.5);
                let needed = |here: f64, low: f64, high: f64| (here - low).max(-high - here);
                let height = (needed(x, left, right) / half_width)
                    .max(needed(y, lower, upper) / half_height);
                // Rays start in the picture's plane, which is before everything.
                [(z - front + 0.5 * size).max(least_distance), height]
            }
        }
    }
}

/// The middle of the box around all spheres, and its diagonal.
///
/// # Errors
/// As [`Framing::camera`].
pub(crate) fn bounds(spheres: &[Sphere]) -> Result<(DVec3, f64)> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for Sphere { center, radius } in spheres {
        low = low.min(*center - *radius);
        high = high.max(*center + *radius);
    }
    if spheres.is_empty() {
        return wrong_usage(Message::new(
            "there are no spheres that a camera could frame",
            place_it(),
        ));
    }
    let (middle, size) = (0.5 * low + 0.5 * high, (high - low).length());
    // Products of two lengths are formed, and distances are many times the size.
    let largest = size.max(middle.abs().max_element());
    if largest < 1e140 && size > 1e-140 && size > 1e-12 * largest {
        Ok((middle, size))
    } else {
        Err(too_large())
    }
}

fn too_large() -> Error {
    let text = "the spheres are too large, too small or too far from the origin to be framed automatically";
    Error::Usage(Message::new(text, place_it()))
}

fn place_it() -> Hint {
    Hint::new(
        "place the camera with {} and {}",
        [Setting::named("position"), Setting::named("look_at")],
    )
}

/// A power of ten that coordinates are rounded to.
#[derive(Clone, Copy)]
struct FramingStep {
    exponent: i32,
}

impl FramingStep {
    /// The largest that is not above `most`.
    fn of(most: f64) -> FramingStep {
        FramingStep { exponent: libm::log10(most).floor() as i32 }
    }

    /// The nearest f64 to a decimal number of this step; 0 has no sign.
    fn written(self, number: f64) -> f64 {
        let Ok(digits) = usize::try_from(-self.exponent) else {
            let step = self.size();
            return (number / step).round() * step + 0.0;
        };
        let text = format!("{number:.digits$}");
        // What was just written can be read.
        text.parse::<f64>().unwrap_or(number) + 0.0
    }

    fn size(self) -> f64 {
        libm::exp10(f64::from(self.exponent))
    }

    fn near(self, point: DVec3) -> DVec3 {
        DVec3::from_array(point.to_array().map(|number| self.written(number)))
    }

    /// The rounded point where it is the same but for the errors of arithmetic.
    fn near_if_it_is(self, point: DVec3, size: f64) -> DVec3 {
        let rounded = self.near(point);
        if (rounded - point).abs().max_element() <= 1e-9 * size { rounded } else { point }
    }

    /// Not less than `number`.
    fn above(self, number: f64) -> f64 {
        let written = self.written(number);
        if written >= number { written } else { self.written(number + self.size()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::Lens;
    use crate::support::random::SplitMix;

    fn cloud(seed: u64, scale: f64, center: DVec3) -> Vec<Sphere> {
        let mut random = SplitMix::new(seed);
        let mut number = move || random.unit() - 0.5;
        let stretch = DVec3::new(3.0, 0.5, 1.0);
        let sphere = |_| Sphere {
            center: center + scale * stretch * DVec3::new(number(), number(), number()),
            radius: scale * 0.2 * (number() + 0.6),
        };
        (0..60).map(sphere).collect()
    }

    fn framing(from: DVec3, projection: Projection, size: [u32; 2]) -> Framing {
        let up = if from.x == 0.0 && from.z == 0.0 { DVec3::NEG_Z } else { DVec3::Y };
        let (fits_height, margin, look_at, n_turns) = (true, 0.0, None, 1);
        Framing { from, up, projection, fits_height, size, margin, look_at, n_turns }
    }

    /// How much room the spheres leave at left, right, lower and upper edge, as parts of the picture's
    /// height at the sphere's distance, by the angles between the axis of a sphere's cone of sight and
    /// the edge: another way than the planes' normals. Negative where one sticks out.
    fn room(camera: &Camera, size: [u32; 2], spheres: &[Sphere]) -> [f64; 4] {
        let view = View::new(camera);
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        let mut room = [f64::INFINITY; 4];
        for sphere in spheres {
            let l = sphere.center - camera.position;
            let z = l.dot(view.forward);
            assert!(z - sphere.radius > 0.0, "a sphere lies before the picture");
            for (k, (axis, half)) in
                [(view.right, view.h * aspect), (view.true_up, view.h)].into_iter().enumerate()
            {
                let x = l.dot(axis);
                let (low, high) = match view.lens {
                    Lens::Orthographic => (x - sphere.radius, x + sphere.radius),
                    Lens::Perspective => {
                        // The silhouette's ends in the plane through the view axis.
                        let (angle, half) = (x.atan2(z), (sphere.radius / x.hypot(z)).asin());
                        ((angle - half).tan(), (angle + half).tan())
                    }
                };
                room[2 * k] = room[2 * k].min((low + half) / (2.0 * view.h));
                room[2 * k + 1] = room[2 * k + 1].min((half - high) / (2.0 * view.h));
            }
        }
        room
    }

    const FROM: [DVec3; 6] = [
        DVec3::X,
        DVec3::NEG_Y,
        DVec3::NEG_Z,
        DVec3::ONE,
        DVec3::new(1.0, 1.0, 2.0),
        DVec3::new(0.123, -0.7, 0.31),
    ];

    #[test]
    fn everything_is_in_the_picture_and_touches_opposite_edges() {
        let lenses = [
            Projection::Perspective { fov_degrees: 30.0 },
            Projection::Perspective { fov_degrees: 110.0 },
            Projection::Orthographic { height: 1.0 },
        ];
        for (scale, center) in [
            (1.0, DVec3::ZERO),
            (1e-6, DVec3::X),
            (3e5, DVec3::new(6e6, 1.0, -8e6)),
            (0.7, DVec3::ONE),
        ] {
            let spheres = cloud(7, scale, center);
            for (from, lens) in FROM.iter().flat_map(|from| lenses.map(|lens| (*from, lens))) {
                for size in [[1280, 720], [300, 900]] {
                    let camera =
                        framing(from, lens, size).camera(&spheres, &Control::default()).unwrap();
                    let room = room(&camera, size, &spheres);
                    let case = format!("{scale} {center} {from} {lens:?} {size:?}: {room:?}");
                    let least = room.into_iter().fold(f64::INFINITY, f64::min);
                    assert!(least > -1e-7, "{case}");
                    // Across or along, both edges are nearly touched, and the others have equal room.
                    let [across, along] = [room[0].max(room[1]), room[2].max(room[3])];
                    assert!(across.min(along) < 0.006, "{case}");
                    assert!(
                        (room[0] - room[1]).abs().max((room[2] - room[3]).abs()) < 0.01,
                        "{case}"
                    );
                }
            }
        }
    }

    /// The comparison sees a camera that is a little too near.
    #[test]
    fn a_nearer_camera_cuts_something_off() {
        let spheres = cloud(8, 1.0, DVec3::ZERO);
        let framing =
            framing(DVec3::ONE, Projection::Perspective { fov_degrees: 40.0 }, [640, 480]);
        let mut camera = framing.camera(&spheres, &Control::default()).unwrap();
        camera.position = camera.look_at + 0.99 * (camera.position - camera.look_at);
        let room = room(&camera, framing.size, &spheres);
        assert!(room.iter().any(|&room| room < 0.0), "{room:?}");
    }

    #[test]
    fn a_margin_is_left_at_each_edge() {
        let spheres = cloud(9, 1.0, DVec3::ZERO);
        for lens in [
            Projection::Perspective { fov_degrees: 40.0 },
            Projection::Orthographic { height: 1.0 },
        ] {
            let framing = Framing { margin: 0.1, ..framing(DVec3::Z, lens, [1000, 500]) };
            let room = room(
                &framing.camera(&spheres, &Control::default()).unwrap(),
                framing.size,
                &spheres,
            );
            let least = room.into_iter().fold(f64::INFINITY, f64::min);
            assert!((least - 0.1).abs() < 0.003, "{room:?}");
        }
    }

    #[test]
    fn all_turns_see_everything() {
        let spheres = cloud(10, 1.0, DVec3::ONE);
        for lens in [
            Projection::Perspective { fov_degrees: 40.0 },
            Projection::Orthographic { height: 1.0 },
        ] {
            let n_turns = 12;
            let framing =
                Framing { n_turns, ..framing(DVec3::new(1.0, 1.0, 2.0), lens, [640, 480]) };
            let first = framing.camera(&spheres, &Control::default()).unwrap();
            let mut least = f64::INFINITY;
            for turn in 0..n_turns {
                let from = turned(first.position - first.look_at, DVec3::Y, turn, n_turns);
                let camera = Camera { position: first.look_at + from, ..first.clone() };
                least = room(&camera, framing.size, &spheres).into_iter().fold(least, f64::min);
            }
            assert!(least > -1e-9 && least < 0.01, "{lens:?} {least}");
        }
    }

    #[test]
    fn numbers_are_short() {
        let spheres = cloud(11, 1.0, DVec3::new(0.1234567, 5.4321, -1.0 / 3.0));
        let lens = Projection::Orthographic { height: 1.0 };
        let camera = framing(DVec3::new(1.0, 1.0, 2.0), lens, [640, 480])
            .camera(&spheres, &Control::default())
            .unwrap();
        let Projection::Orthographic { height } = camera.projection else { panic!("{camera:?}") };
        for number in [camera.position, camera.look_at].map(|v| v.to_array()).as_flattened() {
            assert!(format!("{number:?}").len() <= 8, "{camera:?}");
        }
        assert!(format!("{height:?}").len() <= 7, "{camera:?}");
        assert_eq!(turned(DVec3::X, DVec3::Y, 1, 4).dot(DVec3::NEG_Z), 1.0);
    }

    #[test]
    fn what_has_no_middle_is_refused() {
        let lens = Projection::Orthographic { height: 1.0 };
        let framing = framing(DVec3::ONE, lens, [640, 480]);
        let at = |center, radius| vec![Sphere { center, radius }];
        for spheres in [
            vec![],
            at(DVec3::ZERO, 1e300),
            at(DVec3::splat(1e200), 1.0),
            at(DVec3::ZERO, 1e-200),
            at(DVec3::X, 1e-15),
        ] {
            assert_eq!(
                framing.camera(&spheres, &Control::default()).unwrap_err().exit_code(),
                2,
                "{spheres:?}"
            );
        }
        assert!(framing.camera(&at(DVec3::ZERO, 1.0), &Control::default()).is_ok());
    }
}
