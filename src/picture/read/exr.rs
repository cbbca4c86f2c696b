//! OpenEXR: all channels of all layers that have the size of the first.

use std::io::Cursor;
use std::path::Path;

use exr::error::Error as ExrError;
use exr::image::FlatSamples;
use exr::meta::MetaData;
use exr::meta::attribute::AttributeValue;
use exr::prelude::{ReadChannels, ReadLayers, Text, read as read_exr};

use super::{Channel, ChannelValues, Image, require, wrong};
use crate::error::Result;

pub(super) fn read(bytes: &[u8], path: &Path) -> Result<Image> {
    let unreadable = |error: ExrError| wrong(path, format!("not a readable OpenEXR file: {error}"));
    let meta = MetaData::read_from_buffered(bytes, false).map_err(unreadable)?;
    let layers = meta.headers.iter();
    let n_bytes = layers.map(|header| {
        let n_pixels = header.layer_size.0 as u64 * header.layer_size.1 as u64;
        n_pixels.saturating_mul(8 * header.channels.list.len() as u64)
    });
    require(path, n_bytes.fold(0, u64::saturating_add))?;
    if meta.headers.iter().any(|header| header.deep) {
        return Err(wrong(
            path,
            "it holds deep data: several samples of a pixel; flatten it first",
        ));
    }
    let image = read_exr()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(unreadable)?;
    let Some(first) = image.layer_data.first() else {
        return Err(wrong(path, "it has no layer"));
    };
    let (size, position) = (first.size, first.attributes.layer_position);
    let window = image.attributes.display_window;
    let mut found = Image {
        format: "OpenEXR",
        width: size.0,
        height: size.1,
        whole: [window.size.0, window.size.1],
        first: [
            i64::from(position.0) - i64::from(window.position.0),
            i64::from(position.1) - i64::from(window.position.1),
        ],
        ..Image::default()
    };
    for layer in image.layer_data {
        if (layer.size, layer.attributes.layer_position) != (size, position) {
            continue;
        }
        let layer_name = layer.attributes.layer_name.as_ref().map(Text::to_string);
        let layer_name = layer_name.filter(|name| !name.is_empty());
        if found.texts.is_empty() {
            let attributes = &layer.attributes;
            for (name, text) in [
                ("software", &attributes.software_name),
                ("owner", &attributes.owner),
                ("comments", &attributes.comments),
                ("capDate", &attributes.capture_date),
            ] {
                found.texts.extend(text.as_ref().map(|text| (name.into(), text.to_string())));
            }
            let others = attributes.other.iter().chain(&image.attributes.other);
            let others = others.filter_map(|(name, value)| Some((name.to_string(), words(value)?)));
            let mut others: Vec<_> = others.collect();
            others.sort();
            found.texts.extend(others);
        }
        for channel in layer.channel_data.list {
            let name = channel.name.to_string();
            if channel.sampling.0 != 1 || channel.sampling.1 != 1 {
                return Err(wrong(
                    path,
                    format!("its channel {name} has fewer samples than pixels; write it with all"),
                ));
            }
            let name = match &layer_name {
                Some(layer) if !name.starts_with(layer.as_str()) => format!("{layer}.{name}"),
                _ => name,
            };
            let samples = match channel.sample_data {
                FlatSamples::F16(all) => {
                    ChannelValues::F16(all.into_iter().map(|x| x.to_f32()).collect())
                }
                FlatSamples::F32(all) => ChannelValues::F32(all),
                FlatSamples::U32(all) => ChannelValues::U32(all),
            };
            found.channels.push(Channel { name, samples });
        }
    }
    Ok(found)
}

/// An attribute that is a text or a few numbers.
fn words(value: &AttributeValue) -> Option<String> {
    Some(match value {
        AttributeValue::Text(text) => text.to_string(),
        AttributeValue::F32(number) => number.to_string(),
        AttributeValue::F64(number) => number.to_string(),
        AttributeValue::I32(number) => number.to_string(),
        AttributeValue::FloatVec2(v) => format!("{} {}", v.0, v.1),
        AttributeValue::FloatVec3((x, y, z)) => format!("{x} {y} {z}"),
        AttributeValue::Matrix3x3(numbers) => format!("{numbers:?}"),
        AttributeValue::Matrix4x4(numbers) => format!("{numbers:?}"),
        _ => return None,
    })
}
