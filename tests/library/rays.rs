//! Lists of rays from NumPy's files: in every order and type, and what is wrong said by its row.

use std::path::Path;

use kugelblitz::control::Control;
use kugelblitz::picture::read_rays;
use kugelblitz::{Error, Result};

/// An array of these numbers, in the order of the file.
fn npy_bytes(dtype: &str, shape: &str, is_fortran: bool, values: &[f64]) -> Vec<u8> {
    let order = if is_fortran { "True" } else { "False" };
    let header = format!("{{'descr': '{dtype}', 'fortran_order': {order}, 'shape': {shape}, }}");
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    bytes.extend(format!("{header:<117}\n").bytes());
    for &value in values {
        match dtype {
            "<f8" => bytes.extend(value.to_le_bytes()),
            ">f8" => bytes.extend(value.to_be_bytes()),
            "<f4" => bytes.extend((value as f32).to_le_bytes()),
            ">f4" => bytes.extend((value as f32).to_be_bytes()),
            "<i4" => bytes.extend((value as i32).to_le_bytes()),
            other => panic!("{other}"),
        }
    }
    bytes
}

/// The same array with the header of a later version.
fn of_version(version: u8, bytes: &[u8]) -> Vec<u8> {
    [&b"\x93NUMPY"[..], &[version, 0], &bytes[8..10], &[0, 0], &bytes[10..]].concat()
}

fn read_bytes(bytes: &[u8]) -> Result<Vec<kugelblitz::trace::Ray>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rays.npy");
    std::fs::write(&path, bytes).unwrap();
    read_rays(&path, &Control::default())
}

#[test]
fn rays_are_read_in_every_order_and_type() {
    let rows = [[1.0, 2.0, 3.0, 0.5, 0.25, -8.0], [-1.5, 0.0, 7.0, 0.0, 0.0, 1.0]];
    let c: Vec<f64> = rows.iter().flatten().copied().collect();
    let fortran: Vec<f64> = (0..6).flat_map(|column| rows.map(|row| row[column])).collect();
    let little = npy_bytes("<f8", "(2, 6)", false, &c);
    let files = [
        of_version(2, &little),
        of_version(3, &little),
        little,
        npy_bytes(">f8", "(2, 6)", false, &c),
        npy_bytes("<f8", "(2, 6)", true, &fortran),
        npy_bytes("<f4", "(2, 6)", false, &c),
        npy_bytes(">f4", "(2, 6)", true, &fortran),
    ];
    for bytes in files {
        let rays = read_bytes(&bytes).unwrap();
        let found: Vec<[f64; 6]> = rays
            .iter()
            .map(|r| {
                [r.origin.x, r.origin.y, r.origin.z, r.direction.x, r.direction.y, r.direction.z]
            })
            .collect();
        assert_eq!(found, rows);
    }
    let none = npy_bytes("<f8", "(0, 6)", false, &[]);
    assert!(read_bytes(&none).unwrap().is_empty());
}

#[test]
fn wrong_rays_are_named() {
    let ray = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let with = |column: usize, value: f64| {
        let mut values = [ray, ray].concat();
        values[6 + column] = value;
        npy_bytes("<f8", "(2, 6)", false, &values)
    };
    let good = npy_bytes("<f8", "(1, 6)", false, &ray);
    let longer = [&good[..], &[0]].concat();
    for (bytes, expected) in [
        (with(0, f64::NAN), "row 1 (counted from 0) has a number that is not finite"),
        (with(5, f64::INFINITY), "row 1 (counted from 0) has a number that is not finite"),
        (with(5, 0.0), "row 1 (counted from 0) has the direction (0, 0, 0)"),
        (npy_bytes("<f8", "(2, 3)", false, &ray), "its shape is (2, 3); expected"),
        (npy_bytes("<f8", "(6,)", false, &ray), "it has 1 dimensions; expected"),
        (npy_bytes("<i4", "(1, 6)", false, &[1.0; 6]), "its dtype is '<i4'; expected"),
        (good[..good.len() - 1].to_vec(), "47 bytes follow"),
        (longer, "49 bytes follow"),
        (b"x,y,z\n1,2,3\n".to_vec(), "not a readable .npy file"),
        (Vec::new(), "not a readable .npy file"),
        (of_version(4, &good), "unsupported version: (4, 0)"),
    ] {
        let error = read_bytes(&bytes).err().unwrap();
        assert!(matches!(error, Error::Input { .. }), "{error:?}");
        let message = error.to_string();
        assert!(message.contains(expected), "{message}");
    }
    let missing = read_rays(Path::new("no/such/rays.npy"), &Control::default());
    assert!(matches!(missing, Err(Error::Io { .. })));
}

#[test]
fn headers_that_promise_too_much_are_refused() {
    let with_text = |text: String| {
        let mut bytes = b"\x93NUMPY\x02\x00".to_vec();
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(text.bytes());
        bytes
    };
    let header = |shape: &str| {
        with_text(format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}"))
    };
    for bytes in [
        header("(18446744073709551615, 6)"),
        header("(0xffffffffffffffff, 6)"),
        header("(3000000000000000000, 6)"),
        header("(99999999999999, 6)"),
        header("(4294967296, 4294967296)"),
        header("(4294967296, 4294967296, 0)"),
        header("(-1, 6)"),
        header("(6, '\\N{DIGIT SIX}')"),
        header(&"(".repeat(5_000)),
        with_text("[".repeat(100_000)),
        with_text(String::new()),
        b"\x93NUMPY\x02\x00\xff\xff\xff\xff".to_vec(),
        b"\x93NUMPY\x09\x00\x00\x00\x00\x00".to_vec(),
    ] {
        let error = read_bytes(&bytes).err().unwrap();
        assert!(matches!(error, Error::Input { .. }), "{error:?}");
    }
}
