//! Recognizes the content of a file by its first bytes.

use std::ffi::OsStr;
use std::path::Path;

use super::clouds::n_numbers;
use crate::error::Hint;
use crate::plain::Shown;

/// A format of data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataFormat {
    /// An array of NumPy.
    Npy,
    /// A table of text: `.csv` and others.
    Table,
    /// Atoms in XYZ or extended XYZ.
    Xyz,
    /// A dump of LAMMPS.
    Lammps,
}

impl DataFormat {
    /// Returns the format of a file by the ending of its name; `.gz` is left out.
    pub fn of_name(path: &Path) -> Option<DataFormat> {
        match ending(path)?.as_str() {
            "npy" => Some(DataFormat::Npy),
            "csv" | "tsv" | "txt" | "dat" => Some(DataFormat::Table),
            "xyz" | "extxyz" => Some(DataFormat::Xyz),
            "dump" | "lammpstrj" | "lammpsdump" => Some(DataFormat::Lammps),
            _ => None,
        }
    }
}

/// Returns the ending of a file's name in lower case, without `.gz`.
fn ending(path: &Path) -> Option<String> {
    let ending = path.extension().and_then(OsStr::to_str)?.to_ascii_lowercase();
    if ending == "gz" { self::ending(Path::new(path.file_stem()?)) } else { Some(ending) }
}

/// Content of a file.
#[derive(Debug, PartialEq)]
pub(super) enum Content {
    /// A scene.
    Scene,
    /// Data.
    Data(DataFormat),
    /// Something that is not read.
    Foreign(Foreign),
}

/// A file of another kind.
#[derive(Debug, PartialEq)]
pub(super) struct Foreign {
    /// The kind, with an article.
    pub what: &'static str,
    /// Command that converts it, with `IN` for the file's name and `OUT` for the name without its ending.
    advice: &'static str,
}

impl Foreign {
    /// Returns the command or the step that converts the file at `path`.
    pub fn hint(&self, path: &Path) -> Hint {
        let (name, stem) = (path.shown(), path.with_extension("").shown());
        let (mut hint, mut rest) = (String::new(), self.advice);
        let first = |text: &str| {
            let found = [("IN", &name), ("OUT", &stem)];
            let places = found.map(|(mark, value)| Some((text.find(mark)?, mark, value)));
            places.into_iter().flatten().min_by_key(|(at, ..)| *at)
        };
        while let Some((at, mark, value)) = first(rest) {
            hint += &rest[..at];
            // Python's strings are quoted already.
            hint += &if hint.ends_with('\'') { value.clone() } else { shell_word(value) };
            rest = &rest[at + mark.len()..];
        }
        (hint + rest).into()
    }
}

/// Returns a word that a shell reads as this text.
fn shell_word(text: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "/._-+,:@%".contains(c);
    if text.chars().all(is_plain) {
        text.into()
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}

const fn foreign(what: &'static str, advice: &'static str) -> Foreign {
    Foreign { what, advice }
}

/// First bytes of binary files that are not read.
const BINARY: [(&[u8], Foreign); 19] = [
    (b"PK\x03\x04", foreign("a ZIP archive", ZIP)),
    (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", foreign("an Excel workbook", XLS)),
    (b"BZh", foreign("a file compressed with bzip2", "decompress it first: `bunzip2 -k IN`")),
    (b"\xfd7zXZ", foreign("a file compressed with xz", "decompress it first: `xz -dk IN`")),
    (
        b"\x28\xb5\x2f\xfd",
        foreign("a file compressed with zstd", "decompress it first: `zstd -d IN`"),
    ),
    (b"\x89HDF", foreign("an HDF5 file", HDF5)),
    (b"MATLAB 7.3", foreign("a MATLAB file in HDF5", HDF5)),
    (b"MATLAB 5.0", foreign("a MATLAB file", MATLAB)),
    (b"PAR1", foreign("a Parquet file", PARQUET)),
    (b"ARROW1", foreign("a Feather file", FEATHER)),
    (b"LASF", foreign("a LAS point cloud", LAS)),
    (b"\xf8\xff\xff\xff\xff\xff\xff\xffDUMP", foreign("a binary LAMMPS dump", LAMMPS_BINARY)),
    (b"\xf6\xff\xff\xff\xff\xff\xff\xffDUMP", foreign("a binary LAMMPS dump", LAMMPS_BINARY)),
    (b"LammpS RestartT", foreign("a LAMMPS restart file", LAMMPS_RESTART)),
    (b"\x89PNG", foreign("a PNG picture", PICTURE)),
    (b"\xff\xd8\xff", foreign("a JPEG picture", PICTURE)),
    (b"\x76\x2f\x31\x01", foreign("an OpenEXR picture", PICTURE)),
    (b"P6\n", foreign("a PPM picture", PICTURE)),
    (b"%PDF", foreign("a PDF document", PICTURE)),
];

const PICTURE: &str = "give a scene (TOML) or data (.npy, .csv, .xyz, LAMMPS dump)";
const NPZ: &str = "save its first array: `python3 -c \"import numpy; a = numpy.load('IN'); numpy.save('OUT.npy', a[a.files[0]])\"`";
const ZIP: &str = "unpack it first: `unzip IN`";
const XLSX: &str = "save the sheet as CSV, or run `python3 -c \"import pandas; pandas.read_excel('IN').to_csv('OUT.csv', index=False)\"` \
                    (needs pandas and openpyxl)";
const XLS: &str = "save the sheet as CSV in the spreadsheet program";
const HDF5: &str = "list its datasets with `python3 -c \"import h5py; h5py.File('IN').visit(print)\"` (needs h5py), then save one as NAME: \
                    `python3 -c \"import h5py, numpy; numpy.save('OUT.npy', h5py.File('IN')['NAME'][:])\"`";
const FEATHER: &str = "run `python3 -c \"import pandas; pandas.read_feather('IN').to_csv('OUT.csv', index=False)\"` (needs pandas and \
                       pyarrow)";
const PARQUET: &str = "run `python3 -c \"import pandas; pandas.read_parquet('IN').to_csv('OUT.csv', index=False)\"` (needs pandas and \
                       pyarrow)";
const LAS: &str = "run `python3 -c \"import laspy, numpy; numpy.save('OUT.npy', laspy.read('IN').xyz)\"` (needs laspy[lazrs])";
const MATLAB: &str = "save its first variable: `python3 -c \"import numpy, scipy.io; m = scipy.io.loadmat('IN'); numpy.save('OUT.npy', \
                      next(m[k] for k in m if k[0] != '_'))\"` (needs scipy)";
const PLY: &str = "run `python3 -c \"import numpy, plyfile; numpy.save('OUT.npy', plyfile.PlyData.read('IN')['vertex'].data)\"` (needs \
                   plyfile)";
const PCD: &str = "run `python3 -c \"import numpy, pypcd4; numpy.save('OUT.npy', pypcd4.PointCloud.from_path('IN').pc_data)\"` (needs \
                   pypcd4)";
const VTK: &str = "run `python3 -c \"import numpy, pyvista; numpy.save('OUT.npy', pyvista.read('IN').points)\"` (needs pyvista)";
const ATOMS: &str = "run `ase convert -n 0 IN OUT.xyz` (needs ase)";
const LAMMPS_DATA: &str =
    "run `ase convert -i lammps-data IN OUT.xyz` (needs ase), or dump the atoms in LAMMPS";
const LAMMPS_SPHERES: &str =
    "run `(echo x y z r; awk '/^[A-Z]/{a=/^Atoms/} a&&NF>6{print $5,$6,$7,$3/2}' IN) > OUT.csv`";
const VASP: &str = "run `ase convert -i vasp -o extxyz IN atoms.xyz` (needs ase)";
const LAMMPS_YAML: &str = "write it with LAMMPS' `dump custom` instead of `dump yaml`";
const LAMMPS_BINARY: &str = "run LAMMPS' `binary2txt IN`, which writes `IN.txt`";
const LAMMPS_RESTART: &str = "run `lmp -restart2dump IN all custom OUT.dump id type x y z radius`";

/// Recognizes the content of a file by its first bytes, and by its name if these can be several things.
pub(super) fn recognize(head: &[u8], path: &Path) -> Content {
    if head.starts_with(b"\x93NUMPY") {
        return Content::Data(DataFormat::Npy);
    }
    let text = String::from_utf8_lossy(head);
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let first = lines.next().unwrap_or_default();
    let second = lines.next().unwrap_or_default();
    // Binary data may follow the text of a header.
    let foreign = binary_start(head)
        .or_else(|| foreign_header(first, second))
        .or_else(|| binary_data(head))
        .or_else(|| foreign_text(&text, first, second));
    if let Some(foreign) = foreign {
        return Content::Foreign(foreign);
    }
    if first.starts_with("ITEM:") {
        return Content::Data(DataFormat::Lammps);
    }
    let by_name = DataFormat::of_name(path);
    // A count of atoms; a comment; atoms. Two rows of as many numbers are a table below the number of its rows.
    let line = |at| text.lines().nth(at).unwrap_or_default();
    let n_cells =
        |at| line(at).split([',', ';', '\t', ' ']).filter(|cell| !cell.is_empty()).count();
    let are_rows = n_numbers(line(1)) == n_cells(2) && n_numbers(line(2)) == n_cells(2);
    let has_comment = !are_rows || by_name == Some(DataFormat::Xyz);
    if is_count(first) && n_numbers(line(2)) >= 3 && has_comment {
        return Content::Data(DataFormat::Xyz);
    }
    if let Some(format @ (DataFormat::Xyz | DataFormat::Lammps)) = by_name
        && is_count(first)
    {
        return Content::Data(format);
    }
    match by_name {
        _ if is_table(&text) => Content::Data(DataFormat::Table),
        Some(format) => Content::Data(format),
        None => Content::Scene,
    }
}

/// Recognizes binary files by their first bytes.
fn binary_start(head: &[u8]) -> Option<Foreign> {
    let found = BINARY.iter().find(|(start, _)| head.starts_with(start));
    let (_, Foreign { what, advice }) = found?;
    let has = |part: &[u8]| head.windows(part.len()).any(|window| window == part);
    Some(match *advice {
        ZIP if has(b"xl/") || has(b"docProps/") => foreign("an Excel workbook", XLSX),
        ZIP if has(b".npy") => foreign("an .npz archive of NumPy arrays", NPZ),
        _ => foreign(what, advice),
    })
}

/// Recognizes binary data by their zero bytes.
fn binary_data(head: &[u8]) -> Option<Foreign> {
    // A text may have a few damaged bytes.
    let seen = &head[..head.len().min(1 << 13)];
    let n_zeros = seen.iter().filter(|&&byte| byte == 0).count();
    (n_zeros > seen.len() / 16).then_some(foreign("binary data", PICTURE))
}

/// Recognizes files of other programs by their first lines.
fn foreign_header(first: &str, second: &str) -> Option<Foreign> {
    let starts = |words: &[&str]| words.iter().any(|word| first.starts_with(word));
    if first == "ply" {
        Some(foreign("a PLY file", PLY))
    } else if starts(&["# .PCD", "VERSION .7", "VERSION 0.7"]) {
        Some(foreign("a PCD file", PCD))
    } else if starts(&["# vtk DataFile", "<VTKFile"]) || second.starts_with("<VTKFile") {
        Some(foreign("a VTK file", VTK))
    } else if first == "---" && second.starts_with("creator: LAMMPS") {
        Some(foreign("a LAMMPS dump in YAML", LAMMPS_YAML))
    } else {
        None
    }
}

/// Recognizes texts of other programs.
fn foreign_text(text: &str, first: &str, second: &str) -> Option<Foreign> {
    let has_line = |word: &str| text.lines().any(|line| line.starts_with(word));
    let line = |at: usize| text.lines().nth(at).unwrap_or_default();
    // Numbers in these columns.
    let has_numbers = |line: &str, columns: [(usize, usize); 3]| {
        let is_number = |(start, end)| {
            line.get(start..end).is_some_and(|part: &str| part.trim().parse::<f64>().is_ok())
        };
        columns.into_iter().all(is_number)
    };
    let is_atom = |line: &str| {
        ["ATOM  ", "HETATM"].iter().any(|record| line.starts_with(record))
            && has_numbers(line, [(30, 38), (38, 46), (46, 54)])
    };
    let is_gro = || {
        !is_count(first) && is_count(second) && has_numbers(line(2), [(20, 28), (28, 36), (36, 44)])
    };
    // A scale, three edges of the cell, elements and counts, and the kind of the coordinates.
    let is_poscar = || {
        let is_vector = |at| line(at).split_whitespace().count() == 3 && n_numbers(line(at)) == 3;
        let is_kind = |at| line(at).trim().starts_with(['C', 'D', 'K', 'S', 'c', 'd', 'k', 's']);
        line(1).trim().parse::<f64>().is_ok() && (2..5).all(is_vector) && (6..9).any(is_kind)
    };
    if text.lines().any(is_atom) && !text.contains("ITEM:") {
        Some(foreign("a PDB file", ATOMS))
    } else if has_line("data_") && has_line("loop_") {
        Some(foreign("a CIF file", ATOMS))
    } else if is_gro() {
        Some(foreign("a GRO file", ATOMS))
    } else if is_poscar() {
        Some(foreign("a POSCAR file of VASP", VASP))
    } else if has_line("Atoms") && text.contains(" atoms") && text.contains("xlo xhi") {
        let has_spheres =
            text.lines().any(|line| line.starts_with("Atoms") && line.contains("# sphere"));
        Some(foreign("a LAMMPS data file", if has_spheres { LAMMPS_SPHERES } else { LAMMPS_DATA }))
    } else {
        None
    }
}

fn is_count(line: &str) -> bool {
    line.parse::<u64>().is_ok()
}

/// Whether a text looks like a table and not like TOML.
fn is_table(text: &str) -> bool {
    let is_comment = |line: &&str| line.starts_with('#') || line.starts_with("//");
    let mut lines =
        text.lines().map(str::trim).filter(|line| !line.is_empty() && !is_comment(line)).peekable();
    let Some(&first) = lines.peek() else { return false };
    if first.to_ascii_lowercase().starts_with("sep=") {
        return true;
    }
    let is_toml = first.contains('=') || first.starts_with('[');
    !is_toml && lines.take(10).any(|line| n_numbers(line) >= 3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::schema::NamedValue;

    #[test]
    fn data_are_recognized_by_content_under_any_name() {
        let names =
            |format| DataFormat::NAMES.iter().find(|(_, other)| *other == format).unwrap().0;
        let data = |content: &[u8], name: &str| match recognize(content, Path::new(name)) {
            Content::Data(format) => names(format),
            Content::Scene => "scene",
            Content::Foreign(Foreign { what, .. }) => what,
        };
        for name in ["a", "a.toml", "a.csv", "a.npy", "a.dump.1000", "a.xyz"] {
            assert_eq!(data(b"\x93NUMPY\x01\x00", name), "npy");
            assert_eq!(data(b"ITEM: TIMESTEP\n0\n", name), "lammps");
            assert_eq!(data(b"2\nwater\nO 0 0 0\nH 1 0 0\n", name), "xyz");
            assert_eq!(data(b"x,y,z\n1,2,3\n", name), "csv");
            assert_eq!(data(b"ply\nformat ascii 1.0\n", name), "a PLY file");
        }
        for table in
            ["1 2 3\n4 5 6\n", "x;y;z;r\n1;2;3;4\n", "x\ty\tz\n1\t2\t-3e4\n", "# x y z\n1 2 3\n"]
        {
            assert_eq!(data(table.as_bytes(), "a.melt"), "csv", "{table}");
        }
        for toml in
            ["", "\n", "a", "[camera]\nposition = [1, 2, 3", "# 1 2 3\n[[sphere]]\n1, 2, 3\n"]
        {
            assert_eq!(data(toml.as_bytes(), "a"), "scene", "{toml}");
        }
        assert_eq!(data(b"0.0 0.0 0.0\n1.0 0.0 0.0\n", "lidar.xyz"), "csv");
        assert_eq!(data(b"", "a.csv"), "csv");
        assert_eq!(data(b"ab\0c", "a"), "binary data");
        assert_eq!(
            data(b"# one zero in a long \0 line of text is damage, not binary data\n", "a"),
            "scene"
        );
        assert_eq!(data(b"PK\x03\x04 docProps/app.xml", "a"), "an Excel workbook");
        assert_eq!(data(b"ply\nformat binary_little_endian 1.0\n\0\0\0\0\0\0", "a"), "a PLY file");
    }
}
