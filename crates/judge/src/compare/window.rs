//! The place of a foreign picture in the whole one.

use kugelblitz::picture::Image;
use kugelblitz::rays::Pixels;
use kugelblitz::{Error, Result};

use crate::wrong_usage;

/// The size of the whole picture that `image` is to be a part of, by a size and a crop that are given or not; `None` for
/// the scene's own.
///
/// # Errors
/// [`Error::Usage`] for a list, and where the image has another size.
pub fn whole_size(
    image: &Image,
    size: Option<[u32; 2]>,
    crop: Option<[u32; 4]>,
) -> Result<Option<[u32; 2]>> {
    let Image { width, height, whole, first, is_list, .. } = *image;
    let of_file = whole.map(|n| u32::try_from(n).unwrap_or(u32::MAX));
    let wrong = match (crop, size) {
        _ if is_list => {
            format!("a list of {width} results; give the rays that they are of (--rays)")
        }
        (Some([.., w, h]), _) if [w as usize, h as usize] != [width, height] => {
            format!("{width}×{height} pixels, but crop has {w}×{h}")
        }
        (Some(_), _) => {
            let is_whole = whole == [width, height] && first == [0, 0];
            return Ok(size.or((!is_whole).then_some(of_file)));
        }
        (None, Some([w, h])) if [w, h] != of_file => {
            let [width, height] = of_file;
            format!(
                "{width}×{height} pixels, but size has {w}×{h}; say with crop which part of it they are"
            )
        }
        _ => return Ok(Some(of_file)),
    };
    wrong_usage(wrong)
}

/// The pixels that a picture shows, of a camera's picture of that size: a part where the file says so.
///
/// # Errors
/// [`Error::Usage`] where the picture doesn't lie within the whole one.
pub fn pixels_of(image: &Image, whole: Pixels) -> Result<Pixels> {
    let Image { width, height, first: [x, y], .. } = image;
    let part = || {
        let part = [*x, *y, *width as i64, *height as i64].map(|n| u32::try_from(n).ok());
        let [x, y, width, height] = part;
        whole.part([x?, y?, width?, height?])
    };
    part().ok_or_else(|| {
        let Pixels { image_width, image_height, .. } = whole;
        Error::Usage(format!(
            "{width}×{height} pixels at {x},{y} don't lie in a picture of {image_width}×{image_height}; say which \
             part they are with size and crop"
        ).into())
    })
}
