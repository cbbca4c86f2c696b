//! Comparing two pictures of any formats.

use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

use super::Share;
use crate::error::{Error, Result};
use crate::num::ulp_distance;
use crate::picture::{Image, Samples};
use crate::scene::Color;
use crate::words::percent;

/// How far the numbers of a pixel may differ, and how many pixels may differ more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Of whole numbers that are colours: of the format that has fewer of them.
    pub levels: f64,
    /// Of floats, in steps of the type that has fewer digits.
    pub ulp: u64,
    /// Of floats, where they are more steps apart.
    pub difference: f64,
    /// Pixels that may differ more.
    pub pixels: Share,
}

impl Default for Tolerance {
    fn default() -> Tolerance {
        Tolerance { levels: 0.0, ulp: 0, difference: 0.0, pixels: Share::Count(0) }
    }
}

impl fmt::Display for Tolerance {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Tolerance { levels, ulp, difference, pixels } = self;
        write!(f, "levels={levels},ulp={ulp},difference={difference},pixels={pixels}")
    }
}

impl FromStr for Tolerance {
    type Err = Error;

    /// Reads `levels=2,ulp=4,difference=1e-6,pixels=0.1%`, each of them or not.
    fn from_str(text: &str) -> Result<Tolerance> {
        const KEYS: [&str; 4] = ["levels", "ulp", "difference", "pixels"];
        let mut tolerance = Tolerance::default();
        for part in text.split(',') {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            let (key, value) = (key.trim(), value.trim());
            let no_size =
                || Error::Usage(format!("“{value}” is no size for {key}; give 0 or more"));
            let size = || value.parse().ok().filter(|size: &f64| *size >= 0.0).ok_or_else(no_size);
            match key {
                "levels" => tolerance.levels = size()?,
                "ulp" => tolerance.ulp = value.parse().map_err(|_| no_size())?,
                "difference" => tolerance.difference = size()?,
                "pixels" => tolerance.pixels = value.parse()?,
                other => {
                    let near = KEYS.into_iter().find(|key| strsim::osa_distance(other, key) <= 2);
                    let near = near.map_or(String::new(), |near| format!("; did you mean {near}?"));
                    return Err(Error::Usage(format!(
                        "nothing that can be allowed is called “{other}”; give levels, ulp, difference and \
                         pixels, as in levels=2,pixels=0.1%{near}"
                    )));
                }
            }
        }
        Ok(tolerance)
    }
}

/// How two pictures differ.
#[derive(Clone, Debug, Default)]
pub struct PictureDifference {
    /// Pixels compared; 0 where the sizes differ.
    pub pixels: u64,
    /// Pixels with any difference.
    pub differing: u64,
    /// Pixels that differ by more than is allowed.
    pub beyond: u64,
    /// The first pixel with any difference.
    pub first: Option<usize>,
    /// The channels that both have.
    pub channels: Vec<ChannelDifference>,
    /// The channels that only one of them has.
    pub only_in: [Vec<String>; 2],
    /// The names of texts that both have and that say something else.
    pub texts: Vec<String>,
    /// What is more than allowed, one sentence each.
    pub broken: Vec<String>,
    /// The largest difference of each pixel, by what is allowed of it and 0 to 1 of its channel.
    of_pixels: Vec<(bool, f32)>,
}

/// How two channels of one name differ.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct ChannelDifference {
    /// The name.
    pub name: String,
    /// The types in both files.
    pub types: [&'static str; 2],
    /// The type in which they are compared.
    pub compared_as: &'static str,
    /// Pixels with any difference.
    pub differing: u64,
    /// The largest difference.
    pub largest: f64,
    /// The most steps from one float to the other.
    pub largest_ulp: Option<u64>,
    /// The pixel with the largest difference.
    pub at: Option<usize>,
    /// Its two numbers.
    pub values: Option<[f64; 2]>,
}

/// Compares the channels that both pictures have.
///
/// Numbers of different types are compared as the one that has fewer of them; linear floats and whole
/// numbers of sRGB as sRGB. What is equal bit by bit is equal, NaN too, and so are ±0.
///
/// # Errors
/// [`Error::Usage`] where the pictures have no channel in common.
pub fn compare_pictures(a: &Image, b: &Image, tolerance: &Tolerance) -> Result<PictureDifference> {
    let only = |a: &Image, b: &Image| {
        let names = a.channels.iter().filter(|channel| b.channel(&channel.name).is_none());
        names.map(|channel| channel.name.clone()).collect::<Vec<_>>()
    };
    let texts = a.texts.iter().filter(|(name, text)| b.text(name).is_some_and(|of_b| of_b != text));
    let mut found = PictureDifference {
        only_in: [only(a, b), only(b, a)],
        texts: texts.map(|(name, _)| name.clone()).collect(),
        ..PictureDifference::default()
    };
    if (a.width, a.height, a.is_list) != (b.width, b.height, b.is_list) {
        found.broken.push(format!("the sizes differ: {} and {}", size(a), size(b)));
        return Ok(found);
    }
    if (a.whole, a.first) != (b.whole, b.first) {
        let place = |image: &Image| {
            let ([w, h], [x, y]) = (image.whole, image.first);
            format!("at {x},{y} of {w}×{h}")
        };
        found.broken.push(format!("they are other parts: {} and {}", place(a), place(b)));
    }
    found.of_pixels = vec![(false, 0.0); a.len()];
    found.pixels = a.len() as u64;
    for channel in &a.channels {
        if let Some(other) = b.channel(&channel.name) {
            let pair = [&channel.samples, other];
            found.channels.push(of_channel(&channel.name, pair, tolerance, &mut found.of_pixels));
        }
    }
    if found.channels.is_empty() {
        let names = |image: &Image| {
            let names: Vec<&str> = image.channels.iter().map(|c| c.name.as_str()).collect();
            names.join(", ")
        };
        return Err(Error::Usage(format!(
            "the pictures have no channel in common: one has {}, the other {}",
            names(a),
            names(b)
        )));
    }
    let differs = |&(is_beyond, size): &(bool, f32)| is_beyond || size > 0.0;
    found.differing = found.of_pixels.iter().filter(|pixel| differs(pixel)).count() as u64;
    found.first = found.of_pixels.iter().position(differs);
    found.beyond = found.of_pixels.iter().filter(|(is_beyond, _)| *is_beyond).count() as u64;
    let (beyond, pixels, share) = (found.beyond, found.pixels, tolerance.pixels);
    if share.is_exceeded(beyond, pixels) {
        found.broken.push(format!("{beyond} of {pixels} pixels differ by more than is allowed"));
    }
    Ok(found)
}

impl PictureDifference {
    /// The differences in lines for people. `names` are the pictures', which `images` are.
    pub fn in_words(&self, names: [&str; 2], images: [&Image; 2]) -> String {
        let mut text = String::new();
        for (name, Image { format, width, height, .. }) in names.iter().zip(images) {
            text += &format!("{name}: {format}, {width}×{height}\n");
        }
        if self.pixels > 0 {
            let PictureDifference { pixels, differing, beyond, .. } = self;
            text += &match differing {
                0 => format!("all {pixels} pixels are equal\n"),
                _ => format!(
                    "{differing} of {pixels} pixels differ ({}), {beyond} by more than is allowed\n",
                    percent(*differing, *pixels)
                ),
            };
            text += "\nchannel   as      pixels that differ      largest       at   most ulp\n";
        }
        for channel in &self.channels {
            let ChannelDifference { name, compared_as, differing, largest, at, .. } = channel;
            let at = at.map_or("–".into(), |at| {
                let [x, y] = images[0].pixel(at);
                format!("{x},{y}")
            });
            let ulp = match channel.largest_ulp {
                None => "–".to_string(),
                Some(u64::MAX) => "∞".to_string(),
                Some(ulp) => ulp.to_string(),
            };
            let largest = match largest {
                0.0 => "0".to_string(),
                x if x.fract() == 0.0 && x.abs() < 1e9 => format!("{x}"),
                x => format!("{x:.3e}"),
            };
            text += &format!(
                "{name:<9} {compared_as:<5}{differing:>21}{largest:>13}{at:>9}{ulp:>11}\n"
            );
        }
        for (name, only) in names.iter().zip(&self.only_in) {
            if !only.is_empty() {
                text += &format!("only in {name}: {}\n", only.join(" "));
            }
        }
        if !self.texts.is_empty() {
            text += &format!("they say different things of themselves: {}\n", self.texts.join(" "));
        }
        text
    }

    /// The pixels that differ by more than is allowed, in their order.
    pub fn pixels_beyond(&self) -> impl Iterator<Item = usize> {
        (0..).zip(&self.of_pixels).filter(|(_, (is_beyond, _))| *is_beyond).map(|(i, _)| i)
    }
}

/// `1280×720`, or `a list of 12`.
fn size(image: &Image) -> String {
    match image.is_list {
        true => format!("a list of {}", image.width),
        false => format!("{}×{}", image.width, image.height),
    }
}

fn of_channel(
    name: &str,
    [a, b]: [&Samples; 2],
    tolerance: &Tolerance,
    of_pixels: &mut [(bool, f32)],
) -> ChannelDifference {
    let (as_a, as_b) = in_common(name, a, b);
    let mut found = ChannelDifference {
        name: name.into(),
        types: [a.kind(), b.kind()],
        compared_as: as_a.kind(),
        differing: 0,
        largest: 0.0,
        largest_ulp: None,
        at: None,
        values: None,
    };
    let full = as_a.full().filter(|_| !matches!(*as_a, Samples::U32(_)));
    let n = as_a.len().min(as_b.len());
    for (i, of_pixel) in of_pixels.iter_mut().enumerate().take(n) {
        let (ulp, is_equal) = steps(&as_a, &as_b, i);
        if let Some(ulp) = ulp {
            found.largest_ulp = Some(found.largest_ulp.unwrap_or(0).max(ulp));
        }
        if is_equal {
            continue;
        }
        let [x, y] = [as_a.number(i), as_b.number(i)];
        let difference = match (x - y).abs() {
            difference if difference.is_nan() => f64::INFINITY,
            difference => difference,
        };
        found.differing += 1;
        if found.at.is_none() || difference > found.largest {
            (found.largest, found.at, found.values) = (difference, Some(i), Some([x, y]));
        }
        let (is_beyond, size) = match (full, ulp) {
            (Some(full), _) => (difference > tolerance.levels, difference / full),
            (None, Some(ulp)) => (
                ulp > tolerance.ulp && difference > tolerance.difference,
                difference / x.abs().max(y.abs()).max(1.0),
            ),
            // Ids are equal or not.
            (None, None) => (true, 1.0),
        };
        let size = (size as f32).clamp(f32::MIN_POSITIVE, 1.0);
        *of_pixel = (of_pixel.0 || is_beyond, of_pixel.1.max(size));
    }
    found
}

/// The steps between two floats, and whether the numbers are equal.
fn steps(a: &Samples, b: &Samples, i: usize) -> (Option<u64>, bool) {
    match (a, b) {
        (Samples::F32(a), Samples::F32(b)) => {
            let ulp = ulp_distance(a[i], b[i]);
            (Some(ulp), ulp == 0)
        }
        (Samples::F64(a), Samples::F64(b)) => {
            let ulp = ulp_distance_f64(a[i], b[i]);
            (Some(ulp), ulp == 0)
        }
        _ => (None, a.whole(i) == b.whole(i)),
    }
}

/// As [`ulp_distance`], of f64.
fn ulp_distance_f64(a: f64, b: f64) -> u64 {
    if a.is_nan() || b.is_nan() {
        return u64::from(a.to_bits() != b.to_bits()) * u64::MAX;
    }
    let ordered = |x: f64| {
        let magnitude = i128::from(x.to_bits() & (u64::MAX >> 1));
        if x.is_sign_negative() { -magnitude } else { magnitude }
    };
    u64::try_from(ordered(a).abs_diff(ordered(b))).unwrap_or(u64::MAX)
}

/// Both channels in one type.
fn in_common<'a>(
    name: &str,
    a: &'a Samples,
    b: &'a Samples,
) -> (Cow<'a, Samples>, Cow<'a, Samples>) {
    use Samples::{F16, F32, F64, U8, U16};
    let is_color = matches!(name, "R" | "G" | "B" | "Y");
    let is_alpha = name == "A";
    let own = |samples: Samples| Cow::Owned(samples);
    let as_f32 = |samples: &'a Samples| match samples {
        F32(_) => Cow::Borrowed(samples),
        other => own(F32((0..other.len()).map(|i| other.number(i) as f32).collect())),
    };
    let as_f64 = |samples: &'a Samples| match samples {
        F64(_) => Cow::Borrowed(samples),
        other => own(F64((0..other.len()).map(|i| other.number(i)).collect())),
    };
    let as_bytes = |samples: &'a Samples| match samples {
        U16(all) => own(U8(all.iter().map(|&n| ((u32::from(n) + 128) / 257) as u8).collect())),
        other => Cow::Borrowed(other),
    };
    // Floats as the whole numbers that a picture would show for them.
    let as_shown = |samples: &'a Samples, is_wide: bool| {
        let number = |i| match (is_color, is_wide) {
            (true, true) => f64::from(Color([shown(samples, i); 3]).to_srgb16()[0]),
            (true, false) => f64::from(Color([shown(samples, i); 3]).to_srgb8()[0]),
            (false, true) => (shown(samples, i) * 65535.0).round(),
            (false, false) => (shown(samples, i) * 255.0).round(),
        };
        let numbers = (0..samples.len()).map(number);
        own(match is_wide {
            true => U16(numbers.map(|n| n as u16).collect()),
            false => U8(numbers.map(|n| n as u8).collect()),
        })
    };
    match (a, b) {
        (F16(_), F16(_)) => (as_f32(a), as_f32(b)),
        _ if a.kind() == b.kind() => (Cow::Borrowed(a), Cow::Borrowed(b)),
        (U8(_) | U16(_), U8(_) | U16(_)) => (as_bytes(a), as_bytes(b)),
        (U8(_) | U16(_), F16(_) | F32(_) | F64(_)) if is_color || is_alpha => {
            (Cow::Borrowed(a), as_shown(b, matches!(a, U16(_))))
        }
        (F16(_) | F32(_) | F64(_), U8(_) | U16(_)) if is_color || is_alpha => {
            (as_shown(a, matches!(b, U16(_))), Cow::Borrowed(b))
        }
        (F16(_) | F32(_), F16(_) | F32(_) | F64(_)) | (F64(_), F16(_) | F32(_)) => {
            (as_f32(a), as_f32(b))
        }
        _ => (as_f64(a), as_f64(b)),
    }
}

/// A linear number from 0 to 1; what is no number is 0.
fn shown(samples: &Samples, i: usize) -> f64 {
    samples.number(i).clamp(0.0, 1.0).max(0.0)
}

/// A picture of the differences: what is equal is the first picture's brightness, darkened; what differs no
/// more than is allowed is blue; what differs more goes from red to yellow.
pub fn difference_picture(a: &Image, found: &PictureDifference) -> Vec<[u8; 3]> {
    const WITHIN: [u8; 3] = [0x2f, 0x6f, 0xb0];
    const BEYOND: [[u8; 3]; 2] = [[0xc2, 0x2b, 0x00], [0xff, 0xe0, 0x4a]];
    let colors = ["R", "G", "B"].map(|name| a.channel(name).or(a.channel("Y")));
    let gray = |i: usize| {
        let [Some(r), Some(g), Some(b)] = colors else { return 0x18 };
        let mean = [r, g, b].map(|channel| match channel.full() {
            Some(full) => channel.number(i) / full,
            None => crate::scene::srgb_from_linear(shown(channel, i)),
        });
        (mean.iter().sum::<f64>() / 3.0 * 72.0) as u8
    };
    let color = |(i, &(is_beyond, size)): (usize, &(bool, f32))| match (is_beyond, size > 0.0) {
        (true, _) => std::array::from_fn(|c| {
            let [low, high] = BEYOND.map(|color| f32::from(color[c]));
            // The smallest are seen as well.
            let share = (1.0 + size.log10() / 3.0).clamp(0.0, 1.0);
            (low + (high - low) * share) as u8
        }),
        (false, true) => WITHIN,
        (false, false) => [gray(i); 3],
    };
    found.of_pixels.iter().enumerate().map(color).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Channel;

    fn image(channels: &[(&str, Samples)]) -> Image {
        let channels = channels.iter();
        let channels = channels.map(|(n, s)| Channel { name: n.to_string(), samples: s.clone() });
        Image {
            width: 2,
            height: 1,
            whole: [2, 1],
            channels: channels.collect(),
            ..Image::default()
        }
    }

    fn differing(a: Samples, b: Samples, name: &str, tolerance: &str) -> (u64, u64) {
        let tolerance = tolerance.parse().unwrap_or_default();
        let (a, b) = (image(&[(name, a)]), image(&[(name, b)]));
        let found = compare_pictures(&a, &b, &tolerance).unwrap();
        assert_eq!(found.broken.is_empty(), found.beyond == 0);
        (found.differing, found.beyond)
    }

    #[test]
    fn each_kind_of_number_is_compared() {
        use Samples::{F32, F64, I64, U8, U16, U32};
        let up = 1f32.next_up();
        assert_eq!(differing(U8(vec![1, 2]), U8(vec![1, 2]), "R", ""), (0, 0));
        assert_eq!(differing(U8(vec![1, 2]), U8(vec![1, 3]), "R", ""), (1, 1));
        assert_eq!(differing(U8(vec![1, 2]), U8(vec![1, 3]), "R", "levels=1"), (1, 0));
        assert_eq!(differing(U8(vec![1, 2]), U16(vec![257, 514]), "R", ""), (0, 0));
        assert_eq!(differing(U8(vec![1, 2]), U16(vec![257, 900]), "R", ""), (1, 1));
        assert_eq!(differing(U32(vec![1, 2]), U32(vec![1, 3]), "id", "levels=9"), (1, 1));
        assert_eq!(differing(U32(vec![1, 2]), I64(vec![1, 3]), "id", ""), (1, 1));
        assert_eq!(differing(F32(vec![1.0, 2.0]), F32(vec![up, 2.0]), "Z", ""), (1, 1));
        assert_eq!(differing(F32(vec![1.0, 2.0]), F32(vec![up, 2.0]), "Z", "ulp=1"), (1, 0));
        let near = "difference=1e-6";
        assert_eq!(differing(F32(vec![1.0, 2.0]), F32(vec![up, 2.1]), "Z", near), (2, 1));
        assert_eq!(differing(F32(vec![0.0, f32::NAN]), F32(vec![-0.0, f32::NAN]), "Z", ""), (0, 0));
        assert_eq!(differing(F32(vec![0.0, f32::NAN]), F32(vec![0.0, 1.0]), "Z", near), (1, 1));
        assert_eq!(differing(F32(vec![1.0, 2.0]), F64(vec![1.0 + 1e-12, 2.0]), "Z", ""), (0, 0));
        let next = 2f64.next_up();
        assert_eq!(differing(F64(vec![1.0, 2.0]), F64(vec![1.0, next]), "Z", ""), (1, 1));
        // 0.5 in linear light is 188.
        assert_eq!(differing(F32(vec![0.5, 0.0]), U8(vec![188, 0]), "R", ""), (0, 0));
        assert_eq!(differing(F32(vec![0.5, 0.0]), U8(vec![187, 0]), "R", ""), (1, 1));
        assert_eq!(differing(F32(vec![0.5, 0.0]), U8(vec![128, 0]), "A", ""), (0, 0));
    }

    #[test]
    fn what_cannot_be_compared_is_told() {
        let one = image(&[("R", Samples::U8(vec![1, 2]))]);
        let other = image(&[("Z", Samples::F32(vec![1.0, 2.0]))]);
        let refused = compare_pictures(&one, &other, &Tolerance::default()).unwrap_err();
        assert!(refused.to_string().contains("no channel in common"), "{refused}");
        let wide = Image { width: 1, height: 2, ..one.clone() };
        let found = compare_pictures(&one, &wide, &Tolerance::default()).unwrap();
        assert!(found.broken[0].contains("the sizes differ: 2×1 and 1×2"), "{:?}", found.broken);
        let moved = Image { first: [1, 0], whole: [3, 1], ..one.clone() };
        let found = compare_pictures(&one, &moved, &Tolerance::default()).unwrap();
        assert!(found.broken[0].contains("other parts"), "{:?}", found.broken);
    }
}
