//! NPY: an array of numbers with one to three axes, or a structured one with one or two.

use std::path::Path;

use exr::prelude::f16;

use super::{Channel, ChannelValues, Image, require};
use crate::error::Result;
use crate::npy::{Array, Kind, NpyCell, NpyHeader};

/// Most numbers of a pixel.
const MAX_CHANNELS: usize = 1024;

pub(super) fn read(bytes: &[u8], path: &Path) -> Result<Image> {
    let n_bytes = Some(bytes.len() as u64);
    let array = Array::new(bytes, n_bytes, path, "an array of numbers")?;
    let &NpyHeader { is_structured: is_record, is_fortran, .. } = &array.header;
    let shape: Vec<usize> = array.header.shape.iter().map(|&n| n as usize).collect();
    let expected = "expected an array of shape (H, W), (N,) or (H, W, channels)";
    let (n_rows, n_columns, n_inner, is_list) = match (&shape[..], is_record) {
        (&[n], _) => (1, n, 1, true),
        (&[n_rows, n_columns], _) => (n_rows, n_columns, 1, false),
        (&[n_rows, n_columns, n_inner], false) => (n_rows, n_columns, n_inner, false),
        _ => return Err(array.wrong(format!("its shape has {} axes; {expected}", shape.len()))),
    };
    if array.header.cells.iter().any(|cell| cell.kind.is_none()) {
        let dtype = array.header.dtype();
        return Err(array.wrong(format!("its dtype is {dtype}; expected numbers")));
    }
    let n_record_bytes = array.element_bytes()?;
    let cells = &array.header.cells;
    if n_inner == 0 || n_inner.max(cells.len()) > MAX_CHANNELS || cells.is_empty() {
        return Err(array.wrong(format!("it has no numbers, or too many of a pixel; {expected}")));
    }
    let row_bytes = n_columns as u128 * n_inner as u128 * n_record_bytes as u128;
    let n_data_bytes = array.data_bytes(n_rows as u64, row_bytes)?;
    require(path, n_data_bytes.saturating_mul(2))?;
    let data = &bytes[bytes.len() - n_data_bytes as usize..];

    // Records from one to the next along each axis.
    let strides = if is_fortran {
        [1, n_rows, n_rows * n_columns]
    } else {
        [n_columns * n_inner, n_inner, 1]
    };
    let channel = |(cell, inner): (&NpyCell, usize)| {
        let first = inner * strides[2];
        let places = (0..n_rows)
            .flat_map(|row| (0..n_columns).map(move |x| row * strides[0] + x * strides[1] + first));
        let bits = places.map(|place| cell.bits(&data[place * n_record_bytes..]));
        Channel { name: name(cell, inner, n_inner), samples: samples(cell, bits) }
    };
    // Either there is one cell, or one inner place.
    let inner_cells = cells.iter().flat_map(|cell| (0..n_inner).map(move |inner| (cell, inner)));
    Ok(Image {
        format: "NPY",
        width: n_columns,
        height: n_rows,
        is_list,
        whole: [n_columns, n_rows],
        channels: inner_cells.map(channel).collect(),
        ..Image::default()
    })
}

/// The name of a channel of an array. Without fields, three or four channels may be colours.
fn name(cell: &NpyCell, inner: usize, n_inner: usize) -> String {
    match cell.field.as_str() {
        "" if n_inner == 1 => "value".into(),
        "" if matches!(n_inner, 3 | 4) => ["R", "G", "B", "A"][inner].into(),
        "" => format!("value.{inner}"),
        field => channel_name(field, cell.element),
    }
}

/// Returns the name of the channel of a field, or of an element of a field with several elements. Fields that this
/// program writes have the names of the channels of its OpenEXR files.
pub fn channel_name(field: &str, element: Option<usize>) -> String {
    match (field, element) {
        ("t", None) => "Z".into(),
        ("a", None) => "A".into(),
        ("normal", Some(i @ 0..3)) => format!("N.{}", ["X", "Y", "Z"][i]),
        ("rgb", Some(i @ 0..3)) => ["R", "G", "B"][i].into(),
        (field, None) => field.into(),
        (field, Some(i)) => format!("{field}.{i}"),
    }
}

/// The numbers of a cell that has some, by their bits.
fn samples(cell: &NpyCell, bits: impl Iterator<Item = u64>) -> ChannelValues {
    match (cell.kind, cell.n_bytes) {
        (Some(Kind::Bool | Kind::Uint), 1) => ChannelValues::U8(bits.map(|n| n as u8).collect()),
        (Some(Kind::Uint), 2) => ChannelValues::U16(bits.map(|n| n as u16).collect()),
        (Some(Kind::Uint), 4) => ChannelValues::U32(bits.map(|n| n as u32).collect()),
        (Some(Kind::Float), 2) => {
            ChannelValues::F16(bits.map(|n| f16::from_bits(n as u16).to_f32()).collect())
        }
        (Some(Kind::Float), 4) => {
            ChannelValues::F32(bits.map(|n| f32::from_bits(n as u32)).collect())
        }
        (Some(Kind::Float), _) => ChannelValues::F64(bits.map(f64::from_bits).collect()),
        _ => ChannelValues::I64(bits.map(|n| n as i64).collect()),
    }
}
