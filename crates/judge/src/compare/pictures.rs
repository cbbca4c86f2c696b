//! Comparing two pictures of any formats.

use std::path::Path;

use kugelblitz::Result;
use kugelblitz::num::ulp_distance;
use kugelblitz::picture::{Channel, ChannelValues, Image};
use kugelblitz::plain::Shown;
use kugelblitz::scene::Color;
use kugelblitz::words::percent;
use serde::Serialize;

use super::search::explains;
use super::{Allowed, AllowedKey, Transform, TransformMatch};

use crate::wrong_usage;

/// Differences between two pictures.
#[derive(Clone, Debug, Default, Serialize)]
pub struct PictureDifference {
    /// First picture.
    pub a: PictureSide,
    /// Second picture.
    pub b: PictureSide,
    /// Allowed differences, as for `--allow`.
    pub allowed: String,
    /// Pixels compared; 0 if the sizes differ.
    pub pixels: u64,
    /// Pixels with any difference.
    pub differing: u64,
    /// Pixels that differ by more than the allowed differences.
    pub beyond: u64,
    /// Column and row of the first pixel that differs; `null` if none does.
    pub first: Option<[usize; 2]>,
    /// Channels that both pictures have.
    pub channels: Vec<ChannelDifference>,
    /// Names of the texts in both files that differ.
    pub metadata_differs: Vec<String>,
    /// Differences beyond the allowed ones, one sentence each; empty if the comparison succeeds.
    pub broken: Vec<String>,
    /// Transforms of the first picture that explain the differences; `null` if none do.
    pub explained_by: Option<TransformMatch>,
    /// The largest difference of each pixel: whether it is beyond what is allowed of it, and 0 to 1 of its channel.
    #[serde(skip)]
    pub(super) of_pixels: Vec<(bool, f32)>,
}

/// One of two pictures.
#[derive(Clone, Debug, Default, Serialize)]
pub struct PictureSide {
    /// Path of the file.
    pub file: String,
    /// Format of the file.
    pub format: &'static str,
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// Channels that the other picture lacks.
    pub only: Vec<String>,
}

/// Differences between two channels with the same name.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ChannelDifference {
    /// Name of the channel.
    pub name: String,
    /// Types in both files.
    pub types: [&'static str; 2],
    /// Type in which the channels are compared.
    pub compared_as: &'static str,
    /// Pixels with any difference.
    pub differing: u64,
    /// Largest difference; `null` in JSON if it is infinite.
    pub largest: f64,
    /// Largest difference in steps between two floats; `null` for other types.
    pub largest_ulp: Option<u64>,
    /// Index of the pixel with the largest difference; `null` if none differs. Unstable in JSON.
    pub at: Option<usize>,
    /// Two numbers of the pixel with the largest difference; `null` if none differs.
    pub values: Option<[f64; 2]>,
    /// Column and row of the pixel with the largest difference; `null` if none differs.
    pub pixel: Option<[usize; 2]>,
}

/// Compares the channels that both pictures have. `files` are their names.
///
/// Numbers of different types are compared as the one that has fewer of them; linear floats and whole
/// numbers of sRGB as sRGB. What is equal bit by bit is equal, NaN too, and so are ±0.
///
/// # Errors
/// [`Error::Usage`](kugelblitz::Error::Usage) where the pictures have no channel in common.
pub fn compare_pictures(
    files: [&str; 2],
    [a, b]: [&Image; 2],
    allowed: &Allowed,
) -> Result<PictureDifference> {
    let side = |file: &str, image: &Image, other: &Image| {
        let names = image.channels.iter().map(|channel| &channel.name);
        PictureSide {
            file: file.into(),
            format: image.format,
            size: [image.width, image.height],
            only: names.filter(|name| other.channel(name).is_none()).cloned().collect(),
        }
    };
    let texts = a.texts.iter().filter(|(name, text)| b.text(name).is_some_and(|of_b| of_b != text));
    let mut found = PictureDifference {
        a: side(files[0], a, b),
        b: side(files[1], b, a),
        allowed: allowed.of_pictures(),
        metadata_differs: texts.map(|(name, _)| name.clone()).collect(),
        ..PictureDifference::default()
    };
    let size = |&Image { width, height, is_list, .. }: &Image| {
        if is_list { format!("a list of {width}") } else { format!("{width}×{height}") }
    };
    let sizes = [size(a), size(b)];
    if sizes[0] != sizes[1] {
        found.broken.push(format!("the sizes differ: {}", sizes.join(" and ")));
        return Ok(found);
    }
    if (a.whole, a.first) != (b.whole, b.first) {
        let place =
            |Image { whole: [w, h], first: [x, y], .. }: &Image| format!("at {x},{y} of {w}×{h}");
        found.broken.push(format!("they are other parts: {} and {}", place(a), place(b)));
    }
    found.of_pixels = vec![(false, 0.0); a.len()];
    found.pixels = a.len() as u64;
    for channel in &a.channels {
        if let Some(other) = b.channel(&channel.name) {
            found.channels.push(of_channel(a, channel, other, allowed, &mut found.of_pixels));
        }
    }
    if found.channels.is_empty() {
        let [a, b] = [found.a, found.b].map(|side| side.only.join(", "));
        return wrong_usage(format!(
            "the pictures have no channel in common: one has {a}, the other {b}"
        ));
    }
    let differing = (0..).zip(&found.of_pixels).filter(|(_, (_, size))| *size > 0.0);
    found.first = differing.clone().next().map(|(first, _)| a.pixel(first));
    found.differing = differing.count() as u64;
    found.beyond = found.pixels_beyond().count() as u64;
    let (beyond, pixels) = (found.beyond, found.pixels);
    if !allowed.limit(AllowedKey::Pixels).allows_part(beyond, pixels) {
        found.broken.push(format!("{beyond} of {pixels} pixels differ by more than is allowed"));
    }
    Ok(found)
}

/// Finds the transforms of the first picture that explain the differences.
///
/// # Errors
/// Returns the errors of [`compare_pictures`].
pub fn explain_pictures(
    [a, b]: [&Image; 2],
    allowed: &Allowed,
    found: &PictureDifference,
) -> Result<Option<TransformMatch>> {
    use Transform::{FlipColumns, FlipRows};
    let n = found.pixels;
    let mut best: Option<(u64, &[Transform])> = None;
    if a.is_list || found.beyond == 0 {
        return Ok(None);
    }
    for transforms in [&[FlipRows][..], &[FlipColumns], &[FlipRows, FlipColumns]] {
        let mut flipped = a.clone();
        transforms.iter().for_each(|transform| transform.apply_to_image(&mut flipped));
        let PictureDifference { beyond, .. } = compare_pictures(["", ""], [&flipped, b], allowed)?;
        if explains(n - beyond, n - found.beyond, n) && best.is_none_or(|(least, _)| beyond < least)
        {
            best = Some((beyond, transforms));
        }
    }
    Ok(best.map(|(beyond, transforms)| {
        TransformMatch::new(transforms, n - beyond, n - found.beyond, n)
    }))
}

impl PictureDifference {
    /// The differences in lines for people.
    pub fn in_words(&self) -> String {
        let mut text = String::new();
        let sides = [&self.a, &self.b].map(|side| (Path::new(&side.file).shown(), side));
        for (name, PictureSide { format, size: [width, height], .. }) in &sides {
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
            let ChannelDifference { name, compared_as, differing, .. } = channel;
            let at = channel.pixel.map_or("–".into(), |[x, y]| format!("{x},{y}"));
            let ulp = match channel.largest_ulp {
                None => "–".to_string(),
                Some(u64::MAX) => "∞".to_string(),
                Some(ulp) => ulp.to_string(),
            };
            let largest = match channel.largest {
                x if x.fract() == 0.0 && x.abs() < 1e9 => format!("{x}"),
                x => format!("{x:.3e}"),
            };
            text += &format!(
                "{name:<9} {compared_as:<5}{differing:>21}{largest:>13}{at:>9}{ulp:>11}\n"
            );
        }
        for (name, PictureSide { only, .. }) in
            sides.iter().filter(|(_, side)| !side.only.is_empty())
        {
            text += &format!("only in {name}: {}\n", only.join(" "));
        }
        if let Some(explained) = &self.explained_by {
            text += &format!("{explained}: --transform {}\n", explained.transforms);
        }
        if !self.metadata_differs.is_empty() {
            let texts = self.metadata_differs.join(" ");
            text += &format!("they say different things of themselves: {texts}\n");
        }
        text
    }

    /// The pixels that differ by more than is allowed, in their order.
    pub fn pixels_beyond(&self) -> impl Iterator<Item = usize> {
        (0..).zip(&self.of_pixels).filter(|(_, (is_beyond, _))| *is_beyond).map(|(i, _)| i)
    }
}

fn of_channel(
    image: &Image,
    Channel { name, samples: a }: &Channel,
    b: &ChannelValues,
    allowed: &Allowed,
    of_pixels: &mut [(bool, f32)],
) -> ChannelDifference {
    let common = Common::of(name, a, b);
    let mut found = ChannelDifference {
        name: name.clone(),
        types: [a.kind(), b.kind()],
        compared_as: common.name(a),
        ..ChannelDifference::default()
    };
    let [levels, most_ulp, most] =
        [AllowedKey::Levels, AllowedKey::Ulp, AllowedKey::Difference].map(|key| allowed.limit(key));
    let is_color = is_color(name);
    for (i, of_pixel) in of_pixels.iter_mut().enumerate().take(a.len().min(b.len())) {
        let [x, y] = [a, b].map(|samples| common.number(samples, i, is_color));
        let ulp = common.steps(x, y);
        found.largest_ulp = found.largest_ulp.max(ulp);
        let is_equal = match common {
            Own => a.whole(i) == b.whole(i),
            _ => ulp.map_or(x == y, |ulp| ulp == 0),
        };
        if is_equal {
            continue;
        }
        let difference = (x - y).abs();
        let difference = if difference.is_nan() { f64::INFINITY } else { difference };
        found.differing += 1;
        if found.at.is_none() || difference > found.largest {
            (found.largest, found.at, found.values) = (difference, Some(i), Some([x, y]));
            found.pixel = Some(image.pixel(i));
        }
        let (is_beyond, size) = match (common, ulp) {
            (_, Some(ulp)) => (
                !most_ulp.allows(ulp as f64) && !most.allows(difference),
                difference / x.abs().max(y.abs()).max(1.0),
            ),
            (Levels(full), None) => (!levels.allows(difference), difference / full),
            // Ids are equal or not.
            _ => (true, 1.0),
        };
        let size = (size as f32).clamp(f32::MIN_POSITIVE, 1.0);
        *of_pixel = (of_pixel.0 || is_beyond, of_pixel.1.max(size));
    }
    found
}

/// The type in which the numbers of two channels are compared: a smaller one has fewer of them.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Common {
    /// Whole numbers up to this one.
    Levels(f64),
    F32,
    F64,
    /// Whole numbers that are no levels, in the type that both have.
    Own,
}

use Common::{F32, F64, Levels, Own};

/// Levels of 8 bits.
const BYTES: f64 = 255.0;

/// Whether a channel is linear light where it has floats, and sRGB where it has whole numbers.
fn is_color(name: &str) -> bool {
    matches!(name, "R" | "G" | "B" | "Y")
}

impl Common {
    fn of(name: &str, a: &ChannelValues, b: &ChannelValues) -> Common {
        let own = |channel: &ChannelValues| match channel {
            ChannelValues::U8(_) => Levels(BYTES),
            ChannelValues::U16(_) => Levels(u16::MAX.into()),
            ChannelValues::F16(_) | ChannelValues::F32(_) => F32,
            ChannelValues::F64(_) => F64,
            ChannelValues::U32(_) | ChannelValues::I64(_) => Own,
        };
        let is_shown = is_color(name) || name == "A";
        match (own(a), own(b)) {
            (Own, Own) if a.kind() == b.kind() => Own,
            (Own, _) | (_, Own) => F64,
            (Levels(_), F32 | F64) | (F32 | F64, Levels(_)) if !is_shown => F64,
            (one, other) if one < other => one,
            (_, other) => other,
        }
    }

    /// The type's name, where `of` is one of the channels.
    fn name(self, of: &ChannelValues) -> &'static str {
        match self {
            Own => of.kind(),
            Levels(BYTES) => "u8",
            Levels(_) => "u16",
            F32 => "f32",
            F64 => "f64",
        }
    }

    /// The number of the `i`-th pixel in this type. Floats are the levels that a picture would show for them.
    fn number(self, samples: &ChannelValues, i: usize, is_color: bool) -> f64 {
        match (self, samples.full()) {
            (Own | F64, _) => samples.number(i),
            (F32, _) => samples.number(i) as f32 as f64,
            (Levels(full), Some(own)) => (samples.number(i) * full / own).round(),
            (Levels(full), None) if !is_color => (shown(samples, i) * full).round(),
            (Levels(BYTES), None) => Color([shown(samples, i); 3]).to_srgb8()[0].into(),
            (Levels(_), None) => Color([shown(samples, i); 3]).to_srgb16()[0].into(),
        }
    }

    /// The steps between two floats of this type.
    fn steps(self, x: f64, y: f64) -> Option<u64> {
        match self {
            F32 => Some(ulp_distance(x as f32, y as f32)),
            F64 => Some(ulp_distance_f64(x, y)),
            Own | Levels(_) => None,
        }
    }
}

/// The steps between two f64, as [`ulp_distance`] counts those between two f32.
fn ulp_distance_f64(a: f64, b: f64) -> u64 {
    if a.is_nan() || b.is_nan() {
        return u64::from(a.to_bits() != b.to_bits()) * u64::MAX;
    }
    let ordered = |x: f64| {
        let magnitude = x.abs().to_bits().cast_signed();
        if x.is_sign_negative() { -magnitude } else { magnitude }
    };
    ordered(a).abs_diff(ordered(b))
}

/// A linear number from 0 to 1; what is no number is 0.
pub(super) fn shown(samples: &ChannelValues, i: usize) -> f64 {
    samples.number(i).clamp(0.0, 1.0).max(0.0)
}
