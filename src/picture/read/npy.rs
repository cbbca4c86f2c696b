//! NPY: an array of numbers with one to three axes, or a structured one with one or two.

use std::io::{self, BufRead, Read};
use std::path::Path;

use exr::prelude::f16;
use npyz::{DType, Endianness, Order, TypeChar};

use super::{Channel, Image, Samples, require, wrong};
use crate::error::{Error, Result};
use crate::npy::read_header;

/// Most numbers of a pixel.
const MAX_CHANNELS: usize = 1024;

/// A number of each record.
struct Column {
    name: String,
    /// Where it begins in the record, bytes.
    offset: usize,
    n_bytes: usize,
    kind: TypeChar,
    is_big_endian: bool,
}

pub(super) fn read(mut reader: impl BufRead, path: &Path) -> Result<Image> {
    let (header, _) = read_header(&mut reader).map_err(|error| match error.kind() {
        io::ErrorKind::InvalidData | io::ErrorKind::UnexpectedEof => {
            wrong(path, format!("not a readable .npy file ({error})"))
        }
        _ => Error::io(path)(error),
    })?;
    let dtype = header.dtype();
    let is_record = matches!(dtype, DType::Record(_));
    let shape: Vec<usize> = header.shape().iter().map(|&n| n as usize).collect();
    let expected = "expected an array of shape (H, W), (N,) or (H, W, channels)";
    let (n_rows, n_columns, n_inner, is_list) = match (&shape[..], is_record) {
        (&[n], _) => (1, n, 1, true),
        (&[n_rows, n_columns], _) => (n_rows, n_columns, 1, false),
        (&[n_rows, n_columns, n_inner], false) => (n_rows, n_columns, n_inner, false),
        _ => return Err(wrong(path, format!("its shape has {} axes; {expected}", shape.len()))),
    };
    let mut columns = Vec::new();
    let n_record_bytes = add_columns(&dtype, String::new(), 0, &mut columns)
        .ok_or_else(|| wrong(path, format!("its dtype is {}; expected numbers", dtype.descr())))?;
    if n_inner == 0 || n_inner > MAX_CHANNELS || columns.is_empty() {
        return Err(wrong(path, format!("it has no numbers, or too many of a pixel; {expected}")));
    }
    if !is_record {
        let Some(column) = columns.pop() else { return Err(wrong(path, "it has no numbers")) };
        columns = (0..n_inner)
            .map(|i| Column {
                name: plain_name(i, n_inner),
                offset: 0,
                n_bytes: column.n_bytes,
                kind: column.kind,
                is_big_endian: column.is_big_endian,
            })
            .collect();
    }

    // Below 10¹⁸ each, by the header's check.
    let n_pixels = n_rows as u64 * n_columns as u64;
    let n_data_bytes = (n_pixels * n_inner as u64).saturating_mul(n_record_bytes as u64);
    require(path, n_data_bytes.saturating_mul(2))?;
    let mut data = Vec::new();
    let read = reader.take(n_data_bytes.saturating_add(1)).read_to_end(&mut data);
    read.map_err(Error::io(path))?;
    if data.len() as u64 != n_data_bytes {
        let (found, more) = match data.len() as u64 > n_data_bytes {
            true => ("more".to_string(), ""),
            false => (data.len().to_string(), "; is the file cut off?"),
        };
        return Err(wrong(
            path,
            format!("its header tells of {n_data_bytes} bytes, but {found} follow{more}"),
        ));
    }

    // Records from one to the next along each axis.
    let strides = match header.order() {
        Order::C => [n_columns * n_inner, n_inner, 1],
        Order::Fortran => [1, n_rows, n_rows * n_columns],
    };
    let is_plain = !is_record;
    let channels = columns.iter().enumerate().map(|(i, column)| {
        let inner = if is_plain { i * strides[2] } else { 0 };
        let places = (0..n_rows)
            .flat_map(|row| (0..n_columns).map(move |x| row * strides[0] + x * strides[1] + inner));
        let numbers = places.map(|place| {
            let start = place * n_record_bytes + column.offset;
            column.bytes(&data[start..start + column.n_bytes])
        });
        let samples = samples(column, numbers);
        Some(Channel { name: column.name.clone(), samples: samples? })
    });
    let channels = channels.collect::<Option<Vec<_>>>();
    let channels =
        channels.ok_or_else(|| wrong(path, format!("its dtype is {}", dtype.descr())))?;
    Ok(Image {
        format: "NPY",
        width: n_columns,
        height: n_rows,
        is_list,
        whole: [n_columns, n_rows],
        channels,
        ..Image::default()
    })
}

/// Channels of an array without fields: of three or four, they may be colours.
fn plain_name(i: usize, n: usize) -> String {
    match n {
        1 => "value".into(),
        3 | 4 => ["R", "G", "B", "A"][i].into(),
        _ => format!("value.{i}"),
    }
}

/// The names of this program's fields, as its OpenEXR files have them.
fn field_name(name: &str, i: Option<usize>) -> String {
    match (name, i) {
        ("t", None) => "Z".into(),
        ("a", None) => "A".into(),
        ("normal", Some(i @ 0..3)) => format!("N.{}", ["X", "Y", "Z"][i]),
        ("rgb", Some(i @ 0..3)) => ["R", "G", "B"][i].into(),
        (name, None) => name.into(),
        (name, Some(i)) => format!("{name}.{i}"),
    }
}

/// Adds the numbers of a type that lies at `offset`; gives its length. `None` where it is no number.
fn add_columns(
    dtype: &DType,
    name: String,
    offset: usize,
    columns: &mut Vec<Column>,
) -> Option<usize> {
    let mut n_bytes = 0;
    match dtype {
        DType::Plain(plain) => {
            let kind = plain.type_char();
            let is_number =
                matches!(kind, TypeChar::Bool | TypeChar::Int | TypeChar::Uint | TypeChar::Float);
            n_bytes = plain.num_bytes().filter(|&n| is_number && n <= 8)?;
            let is_big_endian = plain.endianness() == Endianness::Big;
            if columns.len() >= MAX_CHANNELS {
                return None;
            }
            columns.push(Column { name, offset, n_bytes, kind, is_big_endian });
        }
        DType::Array(n, inner) => {
            for i in 0..usize::try_from(*n).ok().filter(|&n| n <= MAX_CHANNELS)? {
                n_bytes +=
                    add_columns(inner, field_name(&name, Some(i)), offset + n_bytes, columns)?;
            }
        }
        DType::Record(fields) => {
            for field in fields {
                let name = match (&field.dtype, name.is_empty()) {
                    (DType::Plain(_), true) => field_name(&field.name, None),
                    (_, true) => field.name.clone(),
                    (_, false) => format!("{name}.{}", field.name),
                };
                n_bytes += add_columns(&field.dtype, name, offset + n_bytes, columns)?;
            }
        }
    }
    Some(n_bytes)
}

impl Column {
    /// The number's bytes, the low one first, and zeros.
    fn bytes(&self, bytes: &[u8]) -> [u8; 8] {
        let mut low_first = [0; 8];
        low_first[..bytes.len()].copy_from_slice(bytes);
        if self.is_big_endian {
            low_first[..bytes.len()].reverse();
        }
        low_first
    }
}

fn samples(column: &Column, numbers: impl Iterator<Item = [u8; 8]>) -> Option<Samples> {
    let numbers = numbers.map(u64::from_le_bytes);
    Some(match (column.kind, column.n_bytes) {
        (TypeChar::Bool, 1) | (TypeChar::Uint, 1) => {
            Samples::U8(numbers.map(|n| n as u8).collect())
        }
        (TypeChar::Uint, 2) => Samples::U16(numbers.map(|n| n as u16).collect()),
        (TypeChar::Uint, 4) => Samples::U32(numbers.map(|n| n as u32).collect()),
        (TypeChar::Uint, 8) => Samples::I64(numbers.map(|n| n as i64).collect()),
        (TypeChar::Int, n_bytes @ 1..=8) => {
            let unused = 64 - 8 * n_bytes as u32;
            Samples::I64(numbers.map(|n| (n as i64) << unused >> unused).collect())
        }
        (TypeChar::Float, 2) => {
            Samples::F16(numbers.map(|n| f16::from_bits(n as u16).to_f32()).collect())
        }
        (TypeChar::Float, 4) => Samples::F32(numbers.map(|n| f32::from_bits(n as u32)).collect()),
        (TypeChar::Float, 8) => Samples::F64(numbers.map(f64::from_bits).collect()),
        _ => return None,
    })
}
