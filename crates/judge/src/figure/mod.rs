//! The lecture's figures 2 to 5, drawn from a scene as SVG: the rays of a camera among objects, a plane with its
//! point and normal, a sphere with its centre and radius, and a ray that misses, touches or pierces spheres.
//!
//! Figures 3 and 4 are projected by the camera of the scene, so such a figure lies exactly over the picture that is
//! rendered of it at the same size; what the plane or the sphere hides is dashed. Figures 2 and 5 are plans: they show the
//! camera itself. `prefers-color-scheme` chooses the colours, so that a figure is legible on light and on dark pages.

mod axes;
mod drawing;
mod labels;
mod legend;
mod plan;
mod plane;
mod sphere;
mod words;

pub use legend::legend_svg;

use kugelblitz::error::{Hint, Message, Setting};
use kugelblitz::rays::Pixels;
use kugelblitz::scene::{Object, SHIPPED_SCENES, Scene};
use kugelblitz::{Error, Result};

use crate::explain::Lang;
use crate::wrong_usage;
use drawing::Drawing;

/// A figure of the lecture that is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// Figure 2, rays of the camera.
    Rays,
    /// Figure 3, an implicit plane.
    Plane,
    /// Figure 4, a sphere.
    Sphere,
    /// Figure 5, the points of a ray on spheres.
    Discriminant,
}

impl Figure {
    /// All that are drawn.
    pub const ALL: [Figure; 4] =
        [Figure::Rays, Figure::Plane, Figure::Sphere, Figure::Discriminant];

    /// Most objects that a plan is legible with.
    const MOST_OBJECTS: usize = 50;

    /// The number of the figure in the lecture.
    pub fn number(self) -> &'static str {
        match self {
            Figure::Rays => "2",
            Figure::Plane => "3",
            Figure::Sphere => "4",
            Figure::Discriminant => "5",
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
            _ => "sphere",
        }
    }

    /// The object that is drawn: the named one, else the first of the figure's kind; none for a figure of all objects.
    ///
    /// # Errors
    /// [`Error::Usage`] where it is of another kind, or the scene has none.
    pub fn object(self, scene: &Scene, named: Option<u32>) -> Result<Option<u32>> {
        let (number, kind) = (self.number(), self.kind());
        let first = || scene.objects().find(|(_, object)| object.shape() == kind).map(|(id, _)| id);
        let Some(id) = named.or_else(first) else {
            return wrong_usage(format!(
                "figure {number} shows a {kind}, and the scene has none; name another scene"
            ));
        };
        let other = match scene.object(id) {
            Some(object) if object.shape() == kind => {
                let is_of_one = matches!(self, Figure::Plane | Figure::Sphere);
                return Ok(if is_of_one { Some(id) } else { named });
            }
            None => format!("the scene has {} objects", scene.n_objects()),
            Some(object) => format!("that is a {}", object.shape()),
        };
        wrong_usage(format!(
            "object {id}: figure {number} shows a {kind}, and {other}; spheres count from 1, planes \
             after them"
        ))
    }

    /// Draws a scene, or one object of it, with the camera of `pixels`.
    ///
    /// # Errors
    /// Those of [`Figure::object`]; [`Error::Usage`] where it is not before the camera, or where there are too many objects.
    pub fn draw(
        self,
        scene: &Scene,
        object: Option<u32>,
        pixels: &Pixels,
        lang: Lang,
    ) -> Result<String> {
        let (number, kind, named) = (self.number(), self.kind(), self.object(scene, object)?);
        let is_drawn = |(id, _): &(u32, Object)| named.is_none_or(|named| named == *id);
        let objects: Vec<_> =
            scene.objects().filter(is_drawn).take(Figure::MOST_OBJECTS + 1).collect();
        if objects.len() > Figure::MOST_OBJECTS {
            let text = format!(
                "figure {number} shows at most {} objects, and the scene has {}",
                Figure::MOST_OBJECTS,
                scene.n_objects()
            );
            return wrong_usage(Message::new(
                text,
                Hint::new("name one with {}", [Setting::named("object")]),
            ));
        }
        let mut drawing = Drawing::new(*pixels);
        match (self, &objects[..]) {
            (Figure::Rays, objects) => Some(plan::rays(objects, &mut drawing)?),
            (Figure::Discriminant, objects) => Some(plan::discriminants(objects, &mut drawing)?),
            (Figure::Plane, [(_, Object::Plane(plane))]) => plane::draw(plane, &mut drawing),
            (Figure::Sphere, [(_, Object::Sphere(sphere))]) => {
                let beads = scene.spheres.iter().map(|bead| bead.center);
                sphere::draw(sphere, beads, &mut drawing)
            }
            _ => None,
        }
        .ok_or_else(|| {
            let text = format!(
                "figure {number} shows {kind} {} from outside and from the front",
                named.unwrap_or_default()
            );
            let hint = Hint::new(
                "move the scene's camera, or name another object with {}",
                [Setting::named("object")],
            );
            Error::Usage(Message::new(text, hint))
        })?;
        Ok(drawing.svg(self, lang))
    }
}
