//! Files of other formats: each is named, with the command that converts it.

use std::fs;

use kugelblitz::scene::SceneOverrides;
use kugelblitz_tests::folder::Folder;

use super::{Keys, alternatives, folder, read, refusal};

const PLY: &str = "python3 -c \"import numpy, plyfile; numpy.save('OUT.npy', plyfile.PlyData.read('IN')['vertex'].data)\"";
const PCD: &str = "python3 -c \"import numpy, pypcd4; numpy.save('OUT.npy', pypcd4.PointCloud.from_path('IN').pc_data)\"";
const VTK: &str =
    "python3 -c \"import numpy, pyvista; numpy.save('OUT.npy', pyvista.read('IN').points)\"";
const ASE: &str = "ase convert -n 0 IN OUT.xyz";
const LAMMPS_DATA: &str = "ase convert -i lammps-data IN OUT.xyz";
const LAS: &str = "python3 -c \"import laspy, numpy; numpy.save('OUT.npy', laspy.read('IN').xyz)\"";
const HDF5: &str =
    "python3 -c \"import h5py, numpy; numpy.save('OUT.npy', h5py.File('IN')['NAME'][:])\"";

/// Name of each file, its kind, and the command in its hint; `IN` is the file, `OUT` the file without its ending.
pub const FOREIGN: [(&str, &str, &str); 36] = [
    ("ascii.ply", "a PLY file", PLY),
    ("binary.ply", "a PLY file", PLY),
    ("binary_be.ply", "a PLY file", PLY),
    ("ascii.pcd", "a PCD file", PCD),
    ("binary.pcd", "a PCD file", PCD),
    ("binary_compressed.pcd", "a PCD file", PCD),
    ("pcl_old.pcd", "a PCD file", PCD),
    ("poly.vtk", "a VTK file", VTK),
    ("binary.vtk", "a VTK file", VTK),
    ("points.vtp", "a VTK file", VTK),
    ("points.vtu", "a VTK file", VTK),
    ("water.pdb", "a PDB file", ASE),
    ("water.gro", "a GRO file", ASE),
    ("nacl.cif", "a CIF file", ASE),
    ("POSCAR", "a POSCAR file of VASP", "ase convert -i vasp -o extxyz IN atoms.xyz"),
    ("lammps.data", "a LAMMPS data file", LAMMPS_DATA),
    (
        "sphere.data",
        "a LAMMPS data file",
        "(echo x y z r; awk '/^[A-Z]/{a=/^Atoms/} a&&NF>6{print $5,$6,$7,$3/2}' IN) > OUT.csv",
    ),
    ("lammps_atom.bin", "a binary LAMMPS dump", "binary2txt IN"),
    ("lammps_custom.bin", "a binary LAMMPS dump", "binary2txt IN"),
    (
        "lammps.restart",
        "a LAMMPS restart file",
        "lmp -restart2dump IN all custom OUT.dump id type x y z radius",
    ),
    ("lammps.yaml", "a LAMMPS dump in YAML", "dump custom"),
    ("points.las", "a LAS point cloud", LAS),
    ("points.laz", "a LAS point cloud", LAS),
    (
        "points.npz",
        "an .npz archive of NumPy arrays",
        "python3 -c \"import numpy; a = numpy.load('IN'); numpy.save('OUT.npy', a[a.files[0]])\"",
    ),
    ("points.h5", "an HDF5 file", HDF5),
    (
        "points.parquet",
        "a Parquet file",
        "python3 -c \"import pandas; pandas.read_parquet('IN').to_csv('OUT.csv', index=False)\"",
    ),
    (
        "points.xlsx",
        "an Excel workbook",
        "python3 -c \"import pandas; pandas.read_excel('IN').to_csv('OUT.csv', index=False)\"",
    ),
    (
        "matlab_5.mat",
        "a MATLAB file",
        "python3 -c \"import numpy, scipy.io; m = scipy.io.loadmat('IN'); numpy.save('OUT.npy', next(m[k] for k in m if \
         k[0] != '_'))\"",
    ),
    (
        "points.feather",
        "a Feather file",
        "python3 -c \"import pandas; pandas.read_feather('IN').to_csv('OUT.csv', index=False)\"",
    ),
    ("table.csv.bz2", "a file compressed with bzip2", "bunzip2 -k IN"),
    ("table.csv.xz", "a file compressed with xz", "xz -dk IN"),
    ("table.csv.zst", "a file compressed with zstd", "zstd -d IN"),
    // Without advice of their own.
    ("points.gsd", "binary data", ""),
    ("points.pkl", "binary data", ""),
    ("matlab_4.mat", "binary data", ""),
    ("truncated.csv.gz", "", ""),
];

/// Returns the message and the hint of a file that is copied to another name, without the path of the folder.
fn refused_as(file: &str, name: &str) -> [String; 2] {
    let copy = Folder::default();
    copy.write(name, fs::read(folder().join(file)).expect("a file"));
    let error = refusal(read(&copy.path(name), &Keys::default()).expect_err(file));
    assert!(alternatives(&error.hint).is_empty(), "{file}: {}", error.hint);
    let before = format!("{}/", copy.path("").display()).replace("//", "/");
    [&error.message, &error.hint.to_string()].map(|text| text.replace(&before, ""))
}

#[test]
fn foreign_files_are_named_with_the_command_that_converts_them() {
    let mut failures = Vec::new();
    for (file, what, command) in FOREIGN {
        // The content decides under each name, also one that has the placeholders in it.
        for name in [file, "DATA", "IN.OUT.toml", "OUTPUT.xyz", "my data.IN"] {
            let [message, hint] = refused_as(file, name);
            let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
            // A shell needs quotes around spaces; Python's texts have theirs.
            let is_quoted = command.contains("('IN'") || !name.contains(' ');
            let [name_there, stem] =
                [name, stem].map(|text| if is_quoted { text.into() } else { format!("'{text}'") });
            let filled = command.split("IN").map(|part| part.replace("OUT", &stem));
            let filled = filled.collect::<Vec<_>>().join(&name_there);
            if !what.is_empty() && message != format!("expected a scene or data, found {what}") {
                failures.push(format!("{file} as {name}: {message}"));
            }
            if hint.is_empty() || !hint.contains(&filled) {
                failures.push(format!("{file} as {name}: expected {filled}, found {hint}"));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Cuts gzip files at each byte: each is refused as damaged, not read as a shorter table.
#[test]
fn truncated_gzip_is_refused() {
    let cut = Folder::default();
    for file in ["members.csv.gz", "table.csv.gz", "lammps_box.dump.gz", "truncated.csv.gz"] {
        let bytes = fs::read(folder().join(file)).expect("a file");
        // The first member of two is a whole file.
        let whole = (3..bytes.len()).find(|&at| bytes[at..].starts_with(b"\x1f\x8b\x08"));
        for end in 2..bytes.len() {
            cut.write("a.gz", &bytes[..end]);
            let read = read(&cut.path("a.gz"), &Keys::default());
            if Some(end) == whole {
                assert_eq!(read.expect("one member").scene.spheres.len(), 1);
                continue;
            }
            let error = refusal(read.expect_err("a damaged file"));
            assert!(error.message.starts_with("cannot read it: "), "{file} to {end}: {error}");
            assert!(!error.hint.is_empty(), "{file} to {end}");
        }
    }
}

/// Text that may begin like a format of another program, but is data or a scene.
#[test]
fn data_are_not_taken_for_foreign_files() {
    let folder = Folder::default();
    for (name, text) in [
        ("a.csv", "ply,x,y,z\n1,0,0,0\n2,1,0,0\n"),
        ("a.csv", "Atoms,x,y,z\n1,0,0,0\n2,1,0,0\n"),
        ("a.csv", "x,y,z,data_r\n0,0,0,1\n2,0,0,1\n"),
        ("a.xyz", "2\n3\nH 0 0 0\nH 2 0 0\n"),
        ("a.xyz", "2\n1.0\nH 0 0 0\nH 2 0 0\n"),
        ("a.csv", "PK;x;y;z\n1;0;0;0\n2;1;0;0\n"),
        ("a.csv", "name,x,y,z\nATOM,0,0,0\nHETATM,2,0,0\n"),
    ] {
        folder.write(name, text);
        let read = read(&folder.path(name), &Keys::default());
        assert_eq!(read.expect(text).scene.spheres.len(), 2, "{text}");
    }
    folder
        .write("a.toml", "# data_x\n[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\ncolor = \"red\"\n");
    let overrides = SceneOverrides { needs_camera: true, ..SceneOverrides::default() };
    let control = kugelblitz::Control::default();
    let composed = kugelblitz::scene::compose_scene(&folder.path("a.toml"), &overrides, &control);
    assert_eq!(composed.expect("a scene").scene.spheres.len(), 1);
}
