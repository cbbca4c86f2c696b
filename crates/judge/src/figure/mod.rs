//! The lecture's figures 3 and 4, drawn from a scene as SVG: a plane with its point and normal, and a
//! sphere with its centre and radius, in the coordinate system of the world.
//!
//! All is projected by the camera of the scene, so a figure lies exactly over the picture that is
//! rendered of it at the same size. What the plane or the sphere hides is dashed. `prefers-color-scheme`
//! chooses the colours, so that a figure is legible on light and on dark pages.

mod axes;
mod drawing;
mod labels;
mod legend;
mod plane;
mod sphere;
mod words;

pub use legend::{legend_svg, svg_of_colorings};

use kugelblitz::rays::Pixels;
use kugelblitz::scene::{Object, SHIPPED_SCENES, Scene};
use kugelblitz::{Error, Result};

use crate::explain::Lang;
use crate::wrong_usage;
use drawing::Drawing;

/// A figure of the lecture that is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// Figure 3, an implicit plane.
    Plane,
    /// Figure 4, a sphere.
    Sphere,
}

impl Figure {
    /// All that are drawn.
    pub const ALL: [Figure; 2] = [Figure::Plane, Figure::Sphere];

    /// The number of the figure in the lecture.
    pub fn number(self) -> &'static str {
        match self {
            Figure::Plane => "3",
            Figure::Sphere => "4",
        }
    }

    /// The scene that is drawn where no other is given: its name and its text.
    pub fn scene(self) -> (&'static str, &'static str) {
        let file = format!("figure{}.toml", self.number());
        SHIPPED_SCENES.iter().copied().find(|(path, _)| *path == file).unwrap_or_default()
    }

    /// The kind of object that it shows.
    fn kind(self) -> &'static str {
        match self {
            Figure::Plane => "plane",
            Figure::Sphere => "sphere",
        }
    }

    /// The object that is drawn where none is named: the first of its kind.
    ///
    /// # Errors
    /// [`Error::Usage`] where the scene has none.
    pub fn object(self, scene: &Scene) -> Result<u32> {
        let (before, count) = match self {
            Figure::Plane => (scene.spheres.len(), scene.planes.len()),
            Figure::Sphere => (0, scene.spheres.len()),
        };
        if count == 0 {
            let (number, kind) = (self.number(), self.kind());
            let message = format!("figure {number} shows a {kind}, and the scene has none");
            return wrong_usage(message);
        }
        Ok(before as u32 + 1)
    }

    /// Draws an object of a scene as the camera of `pixels` sees it.
    ///
    /// # Errors
    /// [`Error::Usage`] where the object is of another kind, or where it is not before the camera.
    pub fn draw(self, scene: &Scene, id: u32, pixels: &Pixels, lang: Lang) -> Result<String> {
        let (number, kind, mut drawing) = (self.number(), self.kind(), Drawing::new(*pixels));
        match (self, scene.object(id)) {
            (Figure::Plane, Some(Object::Plane(plane))) => plane::draw(plane, &mut drawing),
            (Figure::Sphere, Some(Object::Sphere(sphere))) => {
                let beads = scene.spheres.iter().map(|bead| bead.center);
                sphere::draw(sphere, beads, &mut drawing)
            }
            (_, found) => {
                let other = match found {
                    None => format!("the scene has {} objects", scene.n_objects()),
                    Some(Object::Plane(_)) => "that is a plane".into(),
                    Some(Object::Sphere(_)) => "that is a sphere".into(),
                };
                return wrong_usage(format!(
                    "object {id}: figure {number} shows a {kind}, and {other}; spheres count from 1, \
                     planes after them"
                ));
            }
        }
        .ok_or_else(|| {
            Error::Usage(format!(
                "figure {number} shows {kind} {id} from outside and from before it; move the scene's \
                 camera, or name another object with --object"
            ))
        })?;
        Ok(drawing.svg(self, lang))
    }
}
