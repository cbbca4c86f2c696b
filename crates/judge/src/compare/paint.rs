//! Pictures of errors and of differences.

use kugelblitz::picture::Image;
use kugelblitz::scene::srgb_from_linear;

use super::pictures::shown;
use super::{NormalError, PictureDifference, RayError};

/// A hit where there is nothing. This colour and the next two are far from each other and from those of
/// other errors with each colour blindness.
const FALSE_HIT: [u8; 3] = [0xc2, 0x2b, 0x00];
/// No object where there is one.
const FALSE_MISS: [u8; 3] = [0xff, 0x93, 0x30];
/// Another object.
const WRONG_OBJECT: [u8; 3] = [0xff, 0xe0, 0x4a];

/// The right background, and the right background at a silhouette.
const BACKGROUND: [[u8; 3]; 2] = [[0x0c, 0x0e, 0x12], [0x1a, 0x1d, 0x23]];

/// The right object without any error worth showing, and a large error of `t` or of a normal.
const RAMP: [[u8; 3]; 2] = [[0x1e, 0x24, 0x2c], [0x7f, 0xc4, 0xff]];

/// The first of [`RAMP`], and the same at a silhouette.
const RIGHT: [[u8; 3]; 2] = [RAMP[0], [0x31, 0x3a, 0x45]];

/// A difference that is allowed.
const WITHIN: [u8; 3] = [0x2f, 0x6f, 0xb0];

/// Errors of `t` from the first to the second, f32 steps, go from the colour of what is right to that of
/// a large error.
const ULP_RANGE: [f64; 2] = [0.5, 1e6];

/// Errors of angles from the first to the second, degrees, go from the colour of what is right to that of a
/// large error.
const DEGREES_RANGE: [f64; 2] = [1e-5, 10.0];

/// Differences beyond what is allowed, from the first to the second, shares of a channel, go from [`FALSE_HIT`] to
/// [`WRONG_OBJECT`]; the smallest are seen as well.
const DIFFERENCE_RANGE: [f64; 2] = [1e-3, 1.0];

/// The errors of pixels as colours: wrong ids in red, orange and yellow; where the object is right, the larger the
/// error of `t` or of the normal, the brighter is a blue; what is right is nearly black, and a bit brighter at
/// silhouettes.
pub fn error_picture(
    errors: &[RayError],
    is_at_silhouette: impl Fn(usize) -> bool,
) -> Vec<[u8; 3]> {
    let color = |(i, error): (usize, &RayError)| {
        let place = usize::from(is_at_silhouette(i));
        match error {
            RayError::FalseHit => FALSE_HIT,
            RayError::FalseMiss => FALSE_MISS,
            RayError::WrongObject => WRONG_OBJECT,
            RayError::Right { id: 0, .. } => BACKGROUND[place],
            RayError::Right { t, normal, .. } => {
                let of_t = t.map_or(0.0, |t| share(t.ulp, ULP_RANGE));
                let in_degrees = |n: NormalError| n.degrees.max(n.component.to_degrees());
                let of_normal = normal.map_or(0.0, |n| share(in_degrees(n), DEGREES_RANGE));
                between(RIGHT[place], RAMP[1], of_t.max(of_normal))
            }
        }
    };
    errors.iter().enumerate().map(color).collect()
}

impl PictureDifference {
    /// The differences as colours: what is equal is the brightness of the first picture, `a`, darkened; what differs no
    /// more than is allowed is blue; what differs more goes from red to yellow.
    pub fn picture(&self, a: &Image) -> Vec<[u8; 3]> {
        let colors = ["R", "G", "B"].map(|name| a.channel(name).or(a.channel("Y")));
        let gray = |i: usize| {
            let [Some(r), Some(g), Some(b)] = colors else { return 0x18 };
            let mean = [r, g, b].map(|channel| match channel.full() {
                Some(full) => channel.number(i) / full,
                None => srgb_from_linear(shown(channel, i)),
            });
            (mean.iter().sum::<f64>() / 3.0 * 72.0) as u8
        };
        let color = |(i, &(is_beyond, size)): (usize, &(bool, f32))| match (is_beyond, size > 0.0) {
            (true, _) => between(FALSE_HIT, WRONG_OBJECT, share(size.into(), DIFFERENCE_RANGE)),
            (false, true) => WITHIN,
            (false, false) => [gray(i); 3],
        };
        self.of_pixels.iter().enumerate().map(color).collect()
    }
}

/// Where `x` lies in a range, by its logarithm: 0 to 1.
fn share(x: f64, [low, high]: [f64; 2]) -> f64 {
    ((x.log10() - low.log10()) / (high.log10() - low.log10())).clamp(0.0, 1.0)
}

/// The colour at a share of the way from one to another.
pub(crate) fn between(from: [u8; 3], to: [u8; 3], share: f64) -> [u8; 3] {
    std::array::from_fn(|c| {
        let (from, to) = (f64::from(from[c]), f64::from(to[c]));
        (from + (to - from) * share).round() as u8
    })
}
