//! Tachyon 0.99. Its world is left-handed, so z is mirrored, and its ray of column x and row y goes
//! through `left + (x+1)·(right − left)/W` and `top − y·(top − bottom)/H` of the picture, half a
//! pixel beside the centre to the right and to the top, so the picture is moved back.

use glam::DVec3;

use super::{Numbers, Syntax};
use crate::rays::{Lens, View};
use crate::scene::{Color, Object};

pub(super) struct Tachyon;

impl Syntax for Tachyon {
    fn head(&self, view: &View, [width, height]: [u32; 2], background: Color) -> String {
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
        format!(
            "BEGIN_SCENE\nRESOLUTION {width} {height}\n\
             CAMERA\nPROJECTION {projection}\nZOOM {:?}\nASPECTRATIO 1.0\nANTIALIASING 0\n\
             RAYDEPTH 1\nCENTER {}\nVIEWDIR {}\nUPDIR {}\nFRUSTUM {}\nEND_CAMERA\n\
             BACKGROUND {}\n",
            0.5 / view.h,
            vector(view.position),
            vector(view.forward),
            vector(view.true_up),
            Numbers { numbers: frustum, separator: " " },
            rgb(background),
        )
    }

    fn object(&self, _: u32, _: Option<&str>, object: Object, color: Color) -> String {
        let shape = match object {
            Object::Sphere(s) => format!("SPHERE CENTER {} RAD {:?}", vector(s.center), s.radius),
            Object::Plane(p) => {
                format!("PLANE CENTER {} NORMAL {}", vector(p.point), vector(p.normal))
            }
        };
        let texture = "TEXTURE AMBIENT 1.0 DIFFUSE 0.0 SPECULAR 0.0 OPACITY 1.0";
        format!("{shape} {texture} COLOR {} TEXFUNC 0", rgb(color))
    }

    fn end(&self) -> &'static str {
        "END_SCENE\n"
    }
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
