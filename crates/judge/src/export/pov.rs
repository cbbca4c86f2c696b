//! POV-Ray 3.7. Its camera takes the three vectors of the picture as they are, so nothing is
//! mirrored: the ray of column x and row y is
//! `direction + ((x+½)/W − ½)·right + (½ − (y+½)/H)·up`. An orthographic camera, named before its
//! vectors, adds the same to `location`.

use glam::DVec3;
use kugelblitz::lighting::PreparedLight;
use kugelblitz::rays::{Lens, View};
use kugelblitz::scene::{Color, Object, Source};

use super::{Syntax, separated};

pub(super) struct Pov {
    pub ambient: Option<[f64; 3]>,
}

impl Syntax for Pov {
    fn head(&self, view: &View, [width, height]: [u32; 2], background: Color) -> String {
        let up = view.true_up * (2.0 * view.h);
        let right = view.right * (2.0 * view.h * f64::from(width) / f64::from(height));
        let projection = match view.lens {
            Lens::Perspective => "perspective",
            Lens::Orthographic => "orthographic",
        };
        let finish = match self.ambient {
            None => "ambient 0.0 diffuse 0.0 emission 1.0".to_string(),
            Some(ambient) => format!("ambient {} diffuse 1.0", rgb(ambient)),
        };
        // Colours are linear light, and the picture file's gamma is sRGB unless the user wants
        // another.
        format!(
            "// For {width} x {height} pixels without anti-aliasing: +W{width} +H{height} -A\n\
             #version 3.7;\n\
             global_settings {{ assumed_gamma 1.0 }}\n\
             #default {{ finish {{ {finish} }} }}\n\
             camera {{\n  {projection}\n  location {}\n  direction {}\n  right {}\n  up {}\n}}\n\
             background {{ {} }}\n",
            vector(view.position),
            vector(view.forward),
            vector(right),
            vector(up),
            rgb(background.0),
        )
    }

    fn lamp(&self, lamp: &PreparedLight, eye: DVec3, reach: f64) -> String {
        let (position, kind) = match lamp.origin {
            Source::Eye => (eye, String::new()),
            Source::Point(position) => (position, String::new()),
            Source::Sun(direction) => {
                let position = eye - direction.normalize() * (FAR * reach);
                (position, format!(" parallel point_at {}", vector(eye)))
            }
        };
        let shadowless = if lamp.shadows { "" } else { " shadowless" };
        let (position, color) = (vector(position), rgb(lamp.weight));
        format!("light_source {{ {position}, {color}{kind}{shadowless} }}")
    }

    fn object(&self, id: u32, name: Option<&str>, object: Object, color: Color) -> String {
        let shape = match object {
            Object::Sphere(s) => format!("sphere {{ {}, {:?}", vector(s.center), s.radius),
            // Of the plane through the origin, moved: its distance from there is no number of the
            // scene.
            Object::Plane(p) => {
                format!("plane {{ {}, 0.0 translate {}", vector(p.normal), vector(p.point))
            }
        };
        // A comment that no name can leave.
        let name = name.map(|name| format!(": {}", name.escape_default()));
        let name = name.unwrap_or_default();
        format!("{shape} pigment {{ {} }} }} // {id}{name}", rgb(color.0))
    }
}

/// A sun's distance, as a multiple of that of the farthest object: a parallel light shines from a plane.
const FAR: f64 = 1000.0;

fn vector(v: DVec3) -> String {
    format!("<{}>", separated(&v.to_array(), ", "))
}

fn rgb(channels: [f64; 3]) -> String {
    format!("rgb <{}>", separated(&channels, ", "))
}
