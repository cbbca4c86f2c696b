//! Tachyon 0.99. Its world is left-handed, so z is mirrored, and its ray of column x and row y goes
//! through `left + (x+1)·(right − left)/W` and `top − y·(top − bottom)/H` of the picture, half a
//! pixel beside the centre to the right and to the top, so the picture is moved back.

use glam::DVec3;
use kugelblitz::lighting::PreparedLight;
use kugelblitz::rays::{Lens, View};
use kugelblitz::scene::{Color, Object, Source};

use super::{Syntax, separated};

pub(super) struct Tachyon {
    pub ambient: Option<[f64; 3]>,
}

impl Tachyon {
    /// Tachyon knows no gamma and cuts `255·colour` down to a whole number. Where colours are shown as they
    /// are, they are those of sRGB, and the half keeps them from falling below.
    fn rgb(&self, color: Color) -> String {
        let channels = match self.ambient {
            None => color.to_srgb8().map(|byte| (f64::from(byte) + 0.5) / 255.0),
            Some(_) => color.0,
        };
        separated(&channels, " ")
    }
}

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
        let about = match self.ambient {
            None => "",
            Some(_) => "# The picture holds linear light: no gamma, no sRGB.\n",
        };
        // The zoom is that of the frustum, which wins.
        format!(
            "BEGIN_SCENE\nRESOLUTION {width} {height}\n\
             CAMERA\nPROJECTION {projection}\nZOOM {:?}\nASPECTRATIO 1.0\nANTIALIASING 0\n\
             RAYDEPTH 1\nCENTER {}\nVIEWDIR {}\nUPDIR {}\nFRUSTUM {}\nEND_CAMERA\n\
             BACKGROUND {}\n{about}",
            0.5 / view.h,
            vector(view.position),
            vector(view.forward),
            vector(view.true_up),
            separated(&frustum, " "),
            self.rgb(background),
        )
    }

    /// A comment stands before one that casts shadows here, but not in the scene.
    fn lamp(&self, lamp: &PreparedLight, eye: DVec3, _: f64) -> String {
        let at = |position| format!("LIGHT CENTER {} RAD 0.0", vector(position));
        let place = match lamp.origin {
            Source::Eye => at(eye),
            Source::Point(position) => at(position),
            Source::Sun(direction) => {
                format!("DIRECTIONAL_LIGHT DIRECTION {}", vector(direction))
            }
        };
        let shadows = if lamp.shadows { "" } else { "# Without shadows, if Tachyon could:\n" };
        format!("{shadows}{place} COLOR {}", separated(&lamp.weight, " "))
    }

    fn object(&self, _: u32, _: Option<&str>, object: Object, color: Color) -> String {
        let shape = match object {
            Object::Sphere(s) => format!("SPHERE CENTER {} RAD {:?}", vector(s.center), s.radius),
            Object::Plane(p) => {
                format!("PLANE CENTER {} NORMAL {}", vector(p.point), vector(p.normal))
            }
        };
        let [ambient_gray, diffuse] = match self.ambient {
            None => [1.0, 0.0],
            Some(ambient) => [ambient.iter().sum::<f64>() / 3.0, 1.0],
        };
        let texture =
            format!("AMBIENT {ambient_gray:?} DIFFUSE {diffuse:?} SPECULAR 0.0 OPACITY 1.0");
        format!("{shape} TEXTURE {texture} COLOR {} TEXFUNC 0", self.rgb(color))
    }

    fn end(&self) -> &'static str {
        "END_SCENE\n"
    }
}

/// A point or a direction in Tachyon's world.
fn vector(v: DVec3) -> String {
    separated(&[v.x, v.y, -v.z], " ")
}
