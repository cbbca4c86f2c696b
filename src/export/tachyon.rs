//! Tachyon 0.99. Its world is left-handed, so z is mirrored, and its ray of column x and row y goes
//! through `left + (x+1)·(right − left)/W` and `top − y·(top − bottom)/H` of the picture, half a
//! pixel beside the centre to the right and to the top, so the picture is moved back.

use std::io::{self, Write};

use glam::DVec3;

use super::{FIRST_SPHERE, Numbers, first_plane, ids};
use crate::camera::{Lens, View};
use crate::scene::{Color, Scene};

pub(super) fn write(
    scene: &Scene,
    view: &View,
    [width, height]: [u32; 2],
    color_of: impl Fn(u32) -> Color,
    out: &mut impl Write,
) -> io::Result<()> {
    let half_width = view.h * f64::from(width) / f64::from(height);
    let half_pixel = view.h / f64::from(height);
    let frustum = [
        -half_width - half_pixel,
        half_width - half_pixel,
        -view.h - half_pixel,
        view.h - half_pixel,
    ];
    let projection = match view.lens {
        Lens::Perspective => "PERSPECTIVE",
        Lens::Orthographic => "ORTHOGRAPHIC",
    };
    // The zoom is that of the frustum, which wins.
    write!(
        out,
        "BEGIN_SCENE\nRESOLUTION {width} {height}\n\
         CAMERA\nPROJECTION {projection}\nZOOM {:?}\nASPECTRATIO 1.0\nANTIALIASING 0\nRAYDEPTH 1\n\
         CENTER {}\nVIEWDIR {}\nUPDIR {}\nFRUSTUM {}\nEND_CAMERA\n\
         BACKGROUND {}\n",
        0.5 / view.h,
        vector(view.position),
        vector(view.forward),
        vector(view.true_up),
        Numbers { numbers: frustum, separator: " " },
        rgb(color_of(0)),
    )?;
    for (id, sphere) in ids(&scene.spheres, FIRST_SPHERE) {
        write!(out, "SPHERE CENTER {} RAD {:?} ", vector(sphere.center), sphere.radius)?;
        end_object(color_of(id), out)?;
    }
    for (id, plane) in ids(&scene.planes, first_plane(scene)) {
        write!(out, "PLANE CENTER {} NORMAL {} ", vector(plane.point), vector(plane.normal))?;
        end_object(color_of(id), out)?;
    }
    writeln!(out, "END_SCENE")
}

/// A point or a direction in Tachyon's world.
fn vector(v: DVec3) -> Numbers<3> {
    Numbers { numbers: [v.x, v.y, -v.z], separator: " " }
}

/// Tachyon knows no gamma and cuts `255·colour` down to a whole number, so the half keeps it from
/// falling below.
fn rgb(color: Color) -> Numbers<3> {
    let numbers = color.to_srgb8().map(|byte| (f64::from(byte) + 0.5) / 255.0);
    Numbers { numbers, separator: " " }
}

fn end_object(color: Color, out: &mut impl Write) -> io::Result<()> {
    let ambient = "AMBIENT 1.0 DIFFUSE 0.0 SPECULAR 0.0 OPACITY 1.0";
    writeln!(out, "TEXTURE {ambient} COLOR {} TEXFUNC 0", rgb(color))
}
