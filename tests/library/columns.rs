//! Which column of a file is what: headers as people write them, colours of either scale, colour by a
//! column, structured arrays, extended XYZ, LAMMPS dumps, and the legend.

use glam::DVec3;
use kugelblitz::scene::{Color, ColorMap, Coloring, Scene, Spheres};
use kugelblitz_judge::figure::{legend_svg, svg_of_colorings};
use kugelblitz_tests::folder::Folder;

const WHITE: &str = "color = \"#ffffff\"";

fn rows(scene: &Scene) -> Vec<[f64; 4]> {
    scene.spheres.rows().to_vec()
}

fn bytes(scene: &Scene) -> Vec<[u8; 3]> {
    scene.spheres.colors().map(Color::to_srgb8).collect()
}

const TWO: [[f64; 4]; 2] = [[1.0, 2.0, 3.0, 0.5], [-1.5, 0.25, 4e-3, 2.0]];

#[test]
fn headers_are_understood_as_people_write_them() {
    let folder = Folder::default();
    let two = |header: &str, separator: &str| {
        let row = |row: &[f64; 4]| row.map(|number| number.to_string()).join(separator) + "\n";
        format!("{header}\n{}{}", row(&TWO[0]), row(&TWO[1]))
    };
    for (name, header, separator) in [
        ("a.csv", "x,y,z,r", ","),
        ("a.csv", "X,Y,Z,R", ","),
        ("a.csv", "x [m], y [m], z [m], Radius [mm]", ","),
        ("a.csv", "x(m),y(m),z(m),radius(m)", ","),
        ("a.csv", "x / m;y / m;z / m;radius / m", ";"),
        ("a.csv", "\u{feff}x;y;z;r", ";"),
        ("a.csv", "Points:0,Points:1,Points:2,radius", ","),
        ("a.csv", "pos_x,pos_y,pos_z,radii", ","),
        ("a.tsv", "x\ty\tz\tradius", "\t"),
        ("a.txt", "# x y z r", " "),
        ("a.dat", "# of a simulation\n#   x y z  radius", "    "),
        ("a.dat", "x [m] y [m] z [m] r [m]", " "),
        ("A.CSV", "\n\n  x,  y,  z,  r", "  ,  "),
    ] {
        let scene = folder.good(name, two(header, separator), WHITE);
        assert_eq!(rows(&scene), TWO, "{header}");
        assert!(scene.notes.is_empty(), "{header}: {:?}", scene.notes);
    }
    let diameters = "x,y,z,diameter\n1,2,3,1\n-1.5,0.25,4e-3,4\n";
    assert_eq!(rows(&folder.good("a.csv", diameters, WHITE)), TWO);

    // As a spreadsheet writes them where a comma is the decimal point.
    let scene = folder.good("a.csv", "x;y;z;r\n1,0;2;3;0,5\n-1,5;0,25;4e-3;2\n", WHITE);
    assert_eq!(rows(&scene), TWO);
    assert!(scene.notes[0].contains("a.csv: commas"), "{:?}", scene.notes);
}

#[test]
fn columns_of_other_names_are_named() {
    let folder = Folder::default();
    let text = "id,px,py,pz,size,R,mass\n7,1,2,3,9,0.5,8\n7,-1.5,0.25,4e-3,9,2,8\n";
    let keys =
        format!("{WHITE}\ncolumns = {{ x = \"px\", y = \"PY\", z = \"pz\", radius = \"R\" }}");
    assert_eq!(rows(&folder.good("a.csv", text, &keys)), TWO);
    let keys = keys.replace("radius = \"R\"", "diameter = \"size\"");
    assert_eq!(folder.good("a.csv", text, &keys).spheres[1].radius, 4.5);
    // As a table of its own, and with the radius of all.
    let keys = "radius = 3\ncolor = \"#ffffff\"\n[spheres.columns]\nx = \"px\"\ny = \"py\"\nz = \"pz\"\n\
                radius = false";
    assert_eq!(folder.good("a.csv", text, keys).spheres[1].radius, 3.0);
    // A colour of other names, and none.
    let text = "x,y,z,radius,a,b,c\n1,2,3,4,0.5,0,1\n";
    let keys = "columns = { red = \"c\", green = \"b\", blue = \"a\" }";
    let scene = folder.good("a.csv", text, keys);
    assert_eq!(scene.spheres.color(0), Some(Color([1.0, 0.0, 0.5])));
    let text = "x,y,z,radius,red,green,blue\n1,2,3,4,0.5,0,1\n";
    let scene = folder.good("a.csv", text, &format!("{WHITE}\ncolumns = {{ red = false }}"));
    assert_eq!(scene.spheres.color(0), Some(Color([1.0; 3])));
    // `r` beside `g` and `b` is red, unless it is named.
    let text = "x,y,z,r,g,b\n1,2,3,0.25,0.5,1\n";
    let scene = folder.good("a.csv", text, "radius = 7");
    assert_eq!(scene.spheres.color(0), Some(Color([0.25, 0.5, 1.0])));
    let keys = format!("{WHITE}\ncolumns = {{ radius = \"r\" }}");
    assert_eq!(folder.good("a.csv", text, &keys).spheres[0].radius, 0.25);
    // Elements, in a file of any kind.
    let text = "x,y,z,atom\n1,2,3,O\n1,2,3, h \n";
    let scene = folder.good("a.csv", text, "columns = { element = \"atom\" }");
    assert_eq!([scene.spheres[0].radius, scene.spheres[1].radius], [1.5, 1.2]);
    assert_eq!(bytes(&scene)[1], [255; 3]);
}

#[test]
fn colours_from_0_to_255_are_understood_and_said() {
    let folder = Folder::default();
    let header = "x,y,z,r,red,green,blue\n";
    let two = |one: &str, other: &str| format!("{header}1,2,3,1,{one}\n1,2,3,1,{other}\n");
    let scene = folder.good("a.csv", two("0,1,0", "214,39,255"), "");
    assert_eq!(bytes(&scene), [[0, 1, 0], [214, 39, 255]]);
    assert_eq!(scene.spheres.color(1), Some(Color::from_srgb8([214, 39, 255])));
    assert!(scene.notes[0].contains("sRGB"), "{:?}", scene.notes);
    // Whole numbers of linear colours stay what they were.
    let scene = folder.good("a.csv", two("0,1,0", "1,1,1"), "");
    assert_eq!(scene.spheres.color(0), Some(Color([0.0, 1.0, 0.0])));
    assert!(scene.notes.is_empty());
    // All equal, behind spheres of the same linear colour.
    let scene = folder.good("a.csv", two("2,2,2", "2,2,2"), "");
    assert_eq!(bytes(&scene), [[2; 3]; 2]);
}

/// Speeds, whose middle is 1.5, and the bytes of a map for them.
const SPEEDS: &str = "x,y,z,r,speed [m/s]\n0,0,0,1,1\n0,0,0,1,2\n0,0,0,1,1.5\n0,0,0,1,\n0,0,0,1,nan\n\
                      0,0,0,1,N/A\n";
const MAGENTA: [u8; 3] = [255, 0, 255];

#[test]
fn a_column_gives_colours() {
    let folder = Folder::default();
    let viridis = ColorMap::default().srgb8();
    let scene = folder.good("a.csv", SPEEDS, "color_by = \"speed\"");
    let expected = [viridis[0], viridis[255], viridis[128], MAGENTA, MAGENTA, MAGENTA];
    assert_eq!(bytes(&scene), expected);
    let coloring = scene.clouds[0].coloring.as_ref().unwrap();
    assert_eq!((coloring.range, coloring.n_missing), ([1.0, 2.0], 3));
    // A range, a map turned around, another colour for what is missing, the name as it stands.
    let keys = "color_by = \"speed [m/s]\"\ncolormap = \"grey_r\"\nrange = [1.25, 1.75]\n\
                missing_color = \"#ff0000\"";
    let scene = folder.good("a.csv", SPEEDS, keys);
    let red = [255, 0, 0];
    assert_eq!(bytes(&scene), [[255; 3], [0; 3], [127; 3], red, red, red]);
    // The file's own colours are left out, and where all numbers are equal they have the middle.
    let text = "x,y,z,r,red,green,blue,q\n0,0,0,1,900,0,0,5\n0,0,0,1,0.5,7,0,5\n";
    let scene = folder.good("a.csv", text, "color_by = \"q\"");
    assert_eq!(bytes(&scene), [viridis[128]; 2]);
    // By where spheres are and how large, also where the file calls that otherwise.
    let text = "px,py,pz,R\n0,0,5,1\n0,0,7,3\n";
    let columns = "columns = { x = \"px\", y = \"py\", z = \"pz\", radius = \"R\" }";
    for name in ["z", "pz", "radius", "r"] {
        let scene = folder.good("a.csv", text, &format!("{columns}\ncolor_by = \"{name}\""));
        assert_eq!(bytes(&scene), [viridis[0], viridis[255]], "{name}");
    }
    // The length of a vector, and one of its parts.
    let text = "x,y,z,r,v:0,v:1,v:2\n0,0,0,1,3,4,0\n0,0,0,1,0,0,-13\n0,0,0,1,0,0,1\n";
    let range = |name: &str| {
        let scene = folder.good("a.csv", text, &format!("color_by = \"{name}\""));
        scene.clouds[0].coloring.as_ref().unwrap().range
    };
    assert_eq!([range("v"), range("v:0"), range("V:2")], [[1.0, 13.0], [0.0, 3.0], [-13.0, 1.0]]);
    // Infinite numbers are beyond any range.
    let text = "x,y,z,r,q\n0,0,0,1,-inf\n0,0,0,1,1\n0,0,0,1,2\n0,0,0,1,inf\n";
    let scene = folder.good("a.csv", text, "color_by = \"q\"");
    assert_eq!(bytes(&scene), [viridis[0], viridis[0], viridis[255], viridis[255]]);
    // No spheres, no numbers.
    assert_eq!(folder.good("a.csv", "x,y,z,r,q\n", "color_by = \"q\"").n_objects(), 0);
    let none = "x,y,z,r,q\n0,0,0,1,\n";
    let scene = folder.good("a.csv", none, "color_by = \"q\"\nrange = [0, 1]");
    assert_eq!(bytes(&scene), [MAGENTA]);
}

/// Numbers of one cloud are not taken for colours of another.
#[test]
fn clouds_are_coloured_each_by_itself() {
    let folder = Folder::default();
    let black = "x,y,z,r,q\n0,0,0,1,0\n0,0,0,1,0\n";
    folder.write("b.csv", black);
    folder.write("c.csv", "x,y,z,r,red,green,blue\n0,0,0,1,0,0,0\n0,0,0,1,9,9,9\n");
    let more = "color = \"#000000\"\n[[spheres]]\nfile = \"b.csv\"\ncolor_by = \"q\"\n\
                [[spheres]]\nfile = \"c.csv\"\n[[spheres]]\nfile = \"b.csv\"\ncolor_by = \"q\"\n\
                colormap = \"grey\"\nrange = [-1, 0]";
    let scene = folder.good("a.csv", black, more);
    let middle = ColorMap::default().srgb8()[128];
    let expected = [[0; 3], [0; 3], middle, middle, [0; 3], [9; 3], [255; 3], [255; 3]];
    assert_eq!(bytes(&scene), expected);
    assert_eq!(scene.notes.len(), 3, "{:?}", scene.notes);
    let have: Vec<bool> = scene.clouds.iter().map(|cloud| cloud.coloring.is_some()).collect();
    assert_eq!(have, [false, true, false, true]);
}

/// A `.npy` file of version 1.
pub fn npy(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}");
    let n_text = (header.len() + 11).next_multiple_of(64) - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((n_text as u16).to_le_bytes());
    bytes.extend(format!("{header:<width$}\n", width = n_text - 1).bytes());
    bytes.extend(data);
    bytes
}

#[test]
fn structured_arrays_are_read_by_their_fields() {
    let folder = Folder::default();
    // A vector, padding, both byte orders, bytes, integers, text, a field of fields.
    let descr = "[('pos', '<f8', (3,)), ('', '|V4'), ('r', '>f4'), ('rgb', '|u1', (3,)), \
                 ('tag-1', '|S3'), ('n', '>i2'), ('is', '|b1'), ('in', [('a', '<u8'), ('b', '<f4', (2, 2))])]";
    let mut data = Vec::new();
    for (i, [x, y, z, r]) in TWO.into_iter().enumerate() {
        [x, y, z].iter().for_each(|number: &f64| data.extend(number.to_le_bytes()));
        data.extend([9; 4]);
        data.extend((r as f32).to_be_bytes());
        data.extend([10 * i as u8, 1, 0]);
        data.extend(b"abc");
        data.extend((7 - 9 * i as i16).to_be_bytes());
        data.push(i as u8);
        data.extend((1u64 << (53 + i)).to_le_bytes());
        (0..4).for_each(|k: u8| data.extend((f32::from(k) + i as f32).to_le_bytes()));
    }
    let bytes_of = npy(descr, "(2,)", &data);
    let scene = folder.good("a.npy", &bytes_of, "");
    assert_eq!(rows(&scene), TWO);
    assert_eq!(bytes(&scene), [[0, 1, 0], [10, 1, 0]]);
    // Bytes are not linear, even where none is above 1.
    let dark =
        npy("[('x', '<f4'), ('y', '<f4'), ('z', '<f4'), ('color', '|u1', (3,))]", "(1,)", &[1; 15]);
    assert_eq!(bytes(&folder.good("a.npy", dark, "radius = 1")), [[1; 3]]);
    for (name, range) in [
        ("n", [-2.0, 7.0]),
        ("is", [0.0, 1.0]),
        ("in.a", [2f64.powi(53), 2f64.powi(54)]),
        ("in.b:3", [3.0, 4.0]),
        ("pos:2", [4e-3, 3.0]),
        ("z", [4e-3, 3.0]),
        ("rgb:0", [0.0, 10.0]),
        ("8", [-2.0, 7.0]),
    ] {
        let scene = folder.good("a.npy", &bytes_of, &format!("color_by = \"{name}\""));
        assert_eq!(scene.clouds[0].coloring.as_ref().unwrap().range, range, "{name}");
    }
    for (bytes, keys, says) in [
        (&bytes_of[..], "color_by = \"tag-1\"", "\"tag-1\""),
        (&bytes_of, "color_by = \"in.c\"", "\"in.c\""),
        (&bytes_of[..bytes_of.len() - 1], "", "2 rows"),
        (&npy(descr, "(2, 1)", &data), "", "2 dimensions"),
        (&npy("[('x', '<f4'), ('y', '|O')]", "(0,)", &[]), "", "fixed length"),
        (&npy("[('x', '<f4')]", "(0,)", &[]), "", "the structured array has no column `y`"),
    ] {
        let (error, _) = folder.bad("a.npy", bytes, keys);
        assert!(error.message.contains(says), "{error}");
    }
}

#[test]
fn tables_of_floats_have_columns_by_place() {
    let folder = Folder::default();
    let values = [TWO[0].to_vec(), vec![8.0], TWO[1].to_vec(), vec![9.0]].concat();
    let data: Vec<u8> = values.iter().flat_map(|number| number.to_le_bytes()).collect();
    let five = npy("'<f8'", "(2, 5)", &data);
    let viridis = ColorMap::default().srgb8();
    let scene = folder.good("a.npy", &five, "columns = { radius = 3 }\ncolor_by = 4");
    assert_eq!((rows(&scene), bytes(&scene)), (TWO.to_vec(), vec![viridis[0], viridis[255]]));
    let keys = "radius = 7\ncolumns = { x = 2, z = \"0\" }\ncolor = \"#ffffff\"";
    let scene = folder.good("a.npy", &five, keys);
    assert_eq!(scene.spheres[0].center, DVec3::new(3.0, 2.0, 1.0));
    let four = npy("'<f8'", "(2, 4)", &[&data[..32], &data[40..72]].concat());
    for name in ["r", "radius", "3"] {
        let scene = folder.good("a.npy", &four, &format!("color_by = \"{name}\""));
        assert_eq!(bytes(&scene), [viridis[0], viridis[255]], "{name}");
    }
}

#[test]
fn extended_xyz_keeps_what_its_properties_say() {
    let folder = Folder::default();
    let head =
        "Lattice=\"9 0 0 0 9 0 0 0 9\" Properties=species:S:1:pos:R:3:radius:R:1:color:R:3:f:R:3";
    let text = format!(
        "2\n{head} energy=-1\nO 1 2 3 0.5 0.25 0.5 1 0 3 4\nQ -1.5 0.25 4e-3 2 0 0 0 0 0 1\n"
    );
    let scene = folder.good("a.xyz", &text, "");
    assert_eq!(rows(&scene), TWO);
    assert_eq!(scene.spheres.color(0), Some(Color([0.25, 0.5, 1.0])));
    assert!(scene.notes[0].contains("Lattice"), "{:?}", scene.notes);
    let scene = folder.good("a.extxyz", &text, "color_by = \"f\"");
    assert_eq!(scene.clouds[0].coloring.as_ref().unwrap().range, [1.0, 5.0]);
    // What lacks is the element's.
    let text = "2\nproperties = \"pos:R:3:species:S:1:charge:R:1\"\n1 2 3 O 0.5\n1 2 3 H -0.5\n";
    let scene = folder.good("a.xyz", text, "");
    assert_eq!([scene.spheres[0].radius, scene.spheres[1].radius], [1.5, 1.2]);
    let scene = folder.good(
        "a.xyz",
        text,
        "color_by = \"charge\"\nradius = 0.5\ncolumns = { radius = false }",
    );
    assert_eq!(scene.spheres[1].radius, 0.5);
    let keys = "color = \"#ff0000\"\nradius = 0.5\ncolumns = { element = false }";
    assert_eq!(bytes(&folder.good("a.xyz", text, keys)), [[255, 0, 0]; 2]);
}

#[test]
fn a_frame_is_chosen() {
    let folder = Folder::default();
    let xyz: String = (0..3).map(|k| format!("2\nstep {k}\nC {k} 0 0\nO 0 {k} 1\n")).collect();
    let dump: String = (0..3)
        .map(|k| {
            format!(
                "ITEM: TIMESTEP\n{k}\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 9\n0 9\n0 9\n\
                 ITEM: ATOMS id element x y z\n1 C {k} 0 0\n2 O 0 {k} 1\n"
            )
        })
        .collect();
    for (name, text) in [("a.xyz", xyz), ("a.dump", dump)] {
        for k in 0..3 {
            let scene = folder.good(name, &text, &format!("frame = {k}"));
            assert_eq!(
                rows(&scene),
                [[f64::from(k), 0.0, 0.0, 1.77], [0.0, f64::from(k), 1.0, 1.5]]
            );
        }
        let cut = &text[..text.trim_end().rfind('\n').unwrap() + 1];
        assert!(folder.cloud(name, cut, "frame = 1").is_ok());
        for frame in 2..6 {
            let (error, _) = folder.bad(name, cut, &format!("frame = {frame}"));
            assert!(error.message.contains("ends after 1"), "{error}");
        }
    }
}

#[test]
fn lammps_dumps_are_read() {
    let folder = Folder::default();
    let dump = |bounds: &str, columns: &str, rows: &str| {
        let n = rows.lines().count();
        format!(
            "ITEM: UNITS\nlj\nITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n{n}\nITEM: BOX BOUNDS {bounds}\n\
             ITEM: ATOMS {columns}\n{rows}"
        )
    };
    let bounds = "pp pp ff\n0 4\n-2 2\n1e1 2e1";
    let text =
        dump(bounds, "id type x y z radius v_q", "1 1 1 2 3 0.5 0\n2 1 -1.5 0.25 4e-3 2 1\n");
    let scene = folder.good("a.lammpstrj", &text, "color_by = \"v_q\"");
    assert_eq!(rows(&scene), TWO);
    assert!(scene.notes[0].contains("box"), "{:?}", scene.notes);
    // Scaled coordinates are those in the box, also in the colours.
    let text = dump(bounds, "type xs ys zs diameter", "1 0.5 0.25 1 1\n1 0 0 0.5 4\n");
    let scene = folder.good("a.dump", &text, "color_by = \"z\"");
    assert_eq!(rows(&scene), [[2.0, -1.0, 20.0, 0.5], [0.0, -2.0, 15.0, 2.0]]);
    assert_eq!(scene.clouds[0].coloring.as_ref().unwrap().range, [15.0, 20.0]);
}

#[test]
fn the_legend_has_a_bar_for_each_colouring() {
    let folder = Folder::default();
    folder.write("b.csv", SPEEDS.replace("speed [m/s]", "<T> & \u{1b}"));
    let more = "color_by = \"speed\"\nrange = [0, 2.5]\n\
                [[spheres]]\nfile = \"a.csv\"\ncolor_by = \"speed\"\nrange = [0, 2.5]\n\
                [[spheres]]\nfile = \"b.csv\"\ncolor_by = \"<T> & \\u001b\"\ncolormap = \"coolwarm\"";
    let scene = folder.good("a.csv", SPEEDS, more);
    let svg = legend_svg(&scene.clouds).unwrap();
    let document =
        roxmltree::Document::parse(&svg).unwrap_or_else(|error| panic!("{error}\n{svg}"));
    let all = |tag: &str| {
        document.descendants().filter(|node| node.has_tag_name(tag)).collect::<Vec<_>>()
    };
    let texts: Vec<&str> = all("text").iter().filter_map(|node| node.text()).collect();
    let expected = ["speed [m/s]", "no value", "0.0", "0.5", "1.0", "1.5", "2.0", "2.5"];
    assert_eq!(texts[..8], expected);
    assert_eq!(texts[8], "<T> & \\u{1b}");
    let stops: Vec<&str> =
        all("stop").iter().filter_map(|node| node.attribute("stop-color")).collect();
    assert_eq!((stops.len(), stops[0], stops[256]), (512, "#440154", "#3b4cc0"));
    // The numbers stand where their colours are: 0 at the lower end, 2.5 at the upper.
    let y = |text: &str| {
        let node = all("text").into_iter().find(|node| node.text() == Some(text)).unwrap();
        node.attribute("y").unwrap().parse::<f64>().unwrap()
    };
    assert_eq!(y("0.0") - y("2.5"), 256.0);
    // None without a column.
    assert!(legend_svg(&folder.good("a.csv", "x,y,z,r\n", WHITE).clouds).is_none());
}

/// Whatever a header is, every parser takes the legend.
#[test]
fn the_legend_is_xml_whatever_its_column_is_called() {
    let rows = [[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0]];
    let hostile =
        ["a]]>b", "a\u{fffe}b\u{ffff}", "<!--", "&#0;", "\"'`=", "\0\u{b}\u{1f}\u{85}\r\n\t"];
    for name in hostile {
        let spheres = Spheres::from_rows(rows.to_vec()).unwrap();
        let (map, missing) = (ColorMap::default(), Coloring::MISSING_COLOR);
        let (_, coloring) =
            spheres.with_numbers(name, &[1.0, f64::NAN], map, None, missing).unwrap();
        let svg = svg_of_colorings([&coloring]).unwrap();
        let document = roxmltree::Document::parse(&svg);
        let document = document.unwrap_or_else(|error| panic!("{name:?}: {error}\n{svg}"));
        let title = document.descendants().find(|node| node.has_tag_name("text")).unwrap();
        let title = title.text().unwrap();
        assert!(
            title == name || name.contains(|c: char| c.is_control() || c > '\u{fff0}'),
            "{title}"
        );
    }
}

#[test]
fn numbers_of_an_array_have_the_colours_of_a_file() {
    let folder = Folder::default();
    let numbers = [1.0, 2.5, f64::NAN, 7.0, f64::INFINITY];
    let lines = numbers.iter().enumerate().map(|(i, q)| format!("{i},0,0,1,{q}\n"));
    let text = "x,y,z,r,q\n".to_string() + &lines.collect::<String>();
    let rows: Vec<[f64; 4]> = (0..numbers.len()).map(|i| [i as f64, 0.0, 0.0, 1.0]).collect();
    let map = ColorMap::from_name("magma_r").unwrap();
    for (keys, range) in [("", None), ("\nrange = [2, 3]", Some([2.0, 3.0]))] {
        let keys = format!("color_by = \"q\"\ncolormap = \"magma_r\"{keys}");
        let scene = folder.good("a.csv", &text, &keys);
        let spheres = Spheres::from_rows(rows.clone()).unwrap();
        let missing = Coloring::MISSING_COLOR;
        let (spheres, coloring) = spheres.with_numbers("q", &numbers, map, range, missing).unwrap();
        assert!(spheres.colors().eq(scene.spheres.colors()));
        assert_eq!(Some(&coloring), scene.clouds[0].coloring.as_ref());
        assert_eq!(svg_of_colorings([&coloring]), legend_svg(&scene.clouds));
    }
    let of = |numbers: &[f64], range| {
        let spheres = Spheres::from_rows(rows.clone()).unwrap();
        spheres.with_numbers("q", numbers, map, range, Color::default()).map(|_| ())
    };
    for (numbers, range, words) in [
        (&numbers[..2], None, "2 numbers for 5"),
        (&[f64::NAN; 5][..], None, "no number is finite"),
        (&numbers[..], Some([3.0, 3.0]), "the lesser one"),
        (&numbers[..], Some([0.0, f64::INFINITY]), "the lesser one"),
    ] {
        let error = of(numbers, range).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}
