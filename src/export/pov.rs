//! POV-Ray 3.7. Its camera takes the three vectors of the picture as they are, so nothing is
//! mirrored: the ray of column x and row y is
//! `direction + ((x+½)/W − ½)·right + (½ − (y+½)/H)·up`. An orthographic camera, named before its
//! vectors, adds the same to `location`.

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
    let up = view.true_up * (2.0 * view.h);
    let right = view.right * (2.0 * view.h * f64::from(width) / f64::from(height));
    let projection = match view.lens {
        Lens::Perspective => "perspective",
        Lens::Orthographic => "orthographic",
    };
    // Colours are linear light, and the picture file's gamma is sRGB unless the user wants another.
    write!(
        out,
        "// For {width} x {height} pixels without anti-aliasing: +W{width} +H{height} -A\n\
         #version 3.7;\n\
         global_settings {{ assumed_gamma 1.0 }}\n\
         #default {{ finish {{ ambient 0.0 diffuse 0.0 emission 1.0 }} }}\n\
         camera {{\n  {projection}\n  location {}\n  direction {}\n  right {}\n  up {}\n}}\n\
         background {{ {} }}\n",
        Vector(view.position),
        Vector(view.forward),
        Vector(right),
        Vector(up),
        rgb(color_of(0)),
    )?;
    for (id, sphere) in ids(&scene.spheres, FIRST_SPHERE) {
        write!(out, "sphere {{ {}, {:?} ", Vector(sphere.center), sphere.radius)?;
        end_object(id, color_of(id), sphere.name.as_deref(), out)?;
    }
    for (id, plane) in ids(&scene.planes, first_plane(scene)) {
        // Of the plane through the origin, moved: its distance from there is no number of the scene.
        write!(out, "plane {{ {}, 0.0 translate {} ", Vector(plane.normal), Vector(plane.point))?;
        end_object(id, color_of(id), plane.name.as_deref(), out)?;
    }
    Ok(())
}

struct Vector(DVec3);

impl std::fmt::Display for Vector {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "<{}>", Numbers { numbers: self.0.to_array(), separator: ", " })
    }
}

fn rgb(color: Color) -> String {
    format!("rgb <{}>", Numbers { numbers: color.0.map(f64::from), separator: ", " })
}

/// The colour, and a comment that no name can leave.
fn end_object(id: u32, color: Color, name: Option<&str>, out: &mut impl Write) -> io::Result<()> {
    write!(out, "pigment {{ {} }} }} // {id}", rgb(color))?;
    match name {
        Some(name) => writeln!(out, ": {}", name.escape_default()),
        None => writeln!(out),
    }
}
