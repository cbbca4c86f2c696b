//! What a file looks like that is no scene.

/// Bytes that a binary file is known by.
const BINARY: [(&[u8], &str); 11] = [
    (b"\x93NUMPY", "an array of NumPy; name it with the ending .npy"),
    (b"PK\x03\x04", "an archive (ZIP, as .npz files are); save one array with numpy.save"),
    (b"\x1f\x8b", "compressed with gzip; unpack it first"),
    (b"BZh", "compressed with bzip2; unpack it first"),
    (b"\xfd7zXZ", "compressed with xz; unpack it first"),
    (b"\x28\xb5\x2f\xfd", "compressed with zstd; unpack it first"),
    (b"\x89HDF", "an HDF5 file; save the columns as .npy or .csv"),
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"\x76\x2f\x31\x01", "an OpenEXR picture"),
    (b"P6\n", "a PPM picture"),
];

/// Bytes that are looked at.
const N_LOOKED_AT: usize = 1 << 13;

/// What bytes look like that are surely no text in UTF-8.
pub(super) fn look_of_bytes(bytes: &[u8]) -> Option<&'static str> {
    if let Some((_, look)) = BINARY.iter().find(|(start, _)| bytes.starts_with(start)) {
        return Some(look);
    }
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Some("text in UTF-16; save it as UTF-8");
    }
    // A text with a few damaged bytes is told where they are.
    let seen = &bytes[..bytes.len().min(N_LOOKED_AT)];
    let n_zeros = seen.iter().filter(|&&byte| byte == 0).count();
    (n_zeros > seen.len() / 16).then_some("binary data")
}

/// What a text looks like that is not TOML.
pub(super) fn look_of_text(text: &str) -> Option<&'static str> {
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let (first, last) = (lines.next()?, lines.take(9).last()?);
    if first.starts_with("ITEM:") {
        return Some("a dump of LAMMPS");
    }
    if first.parse::<u64>().is_ok() && numbers(last) >= 3 {
        return Some("a file of atoms (.xyz)");
    }
    let is_toml = |line: &str| line.contains('=') || line.starts_with(['[', '#']);
    (!is_toml(first) && numbers(last) >= 3).then_some("a table of numbers (.csv)")
}

/// Numbers that a line consists of, but for a word among them.
fn numbers(line: &str) -> usize {
    let cells = line.split([',', ';', '\t', ' ']).map(str::trim).filter(|cell| !cell.is_empty());
    cells.filter(|cell| cell.parse::<f64>().is_ok()).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_known_by_their_beginning() {
        let look = |bytes: &[u8]| look_of_bytes(bytes).unwrap_or_default();
        assert!(look(b"\x93NUMPY\x01\x00").contains(".npy"));
        assert!(look(b"\x1f\x8b\x08").contains("gzip"));
        assert!(look(b"ab\0c").contains("binary"));
        assert!(look(b"\xff\xfea\0").contains("UTF-16"));
        assert_eq!(look("# caf\u{e9}\n[camera]\n".as_bytes()), "");
        assert_eq!(look(b"# caf\xe9\n"), "");
        assert_eq!(look(b"# one zero in a long \0 line of text is damage, not binary data\n"), "");
        assert_eq!(look(b""), "");
    }

    #[test]
    fn tables_are_told_from_toml() {
        for table in
            ["x,y,z\n1,2,3\n", "1 2 3\n4 5 6\n", "x;y;z;r\n1;2;3;4\n", "x\ty\tz\n1\t2\t-3e4\n"]
        {
            assert_eq!(look_of_text(table), Some("a table of numbers (.csv)"), "{table}");
        }
        assert_eq!(look_of_text("2\nwater\nO 0 0 0\nH 1 0 0\n"), Some("a file of atoms (.xyz)"));
        assert_eq!(look_of_text("ITEM: TIMESTEP\n0\n"), Some("a dump of LAMMPS"));
        for toml in ["", "\n", "a", "[camera]\nposition = [1, 2, 3", "# 1 2 3\na b\n1, 2, 3\n"] {
            assert_eq!(look_of_text(toml), None, "{toml}");
        }
    }
}
