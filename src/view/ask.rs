//! Questions about one pixel, answered on threads of their own.

use std::sync::Arc;

use glam::DVec3;

use super::tracing::hits_of;
use super::worker::Worker;
use crate::device::Device;
use crate::error::{Error, Result};
use crate::explain::{DEFAULT_OBJECTS, explain, label, text};
use crate::rays::{Pixels, View};
use crate::scene::Scene;
use crate::session::Session;
use crate::trace::{Kernel, Rays};

/// A pixel of a picture, with all that the picture is made from.
#[derive(Clone)]
pub struct Question {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The whole picture.
    pub pixels: Pixels,
    /// The kernel that shows the pixel.
    pub kernel: Kernel,
    /// Column.
    pub x: u32,
    /// Row.
    pub y: u32,
}

impl Question {
    /// The pixel alone.
    pub fn pixel(&self) -> Pixels {
        Pixels { x: self.x, y: self.y, width: 1, height: 1, ..self.pixels }
    }
}

/// The object at a pixel, and where the ray hits it.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Column and row.
    pub pixel: [u32; 2],
    /// The camera that saw it.
    pub view: View,
    /// Object id; 0 is the background.
    pub id: u32,
    /// `sphere 3 (red)`
    pub label: String,
    /// `t`; +∞ on the background.
    pub t: f32,
    /// `o + t·d`, world units.
    pub position: DVec3,
}

/// Starts the thread that answers what is under the pointer.
///
/// # Errors
/// Those of [`Worker::start`].
pub fn start_hover(
    device: Device,
    say: impl Fn(Result<Answer>) + Send + 'static,
) -> Result<Worker<Question>> {
    let mut session = Session::new(Scene::default(), device, Kernel::Certified);
    Worker::start("hover", say, move |question: Question, turn, say| {
        let &Question { ref scene, pixels, kernel, x, y } = &question;
        let hits = hits_of(&mut session, scene, kernel, question.pixel(), &turn.control)?;
        let (id, t) = (hits.id[0], hits.t[0]);
        let ray = pixels.ray(x, y);
        let position = ray.origin + ray.direction * f64::from(t);
        say(Answer { pixel: [x, y], view: pixels.view, id, label: label(scene, id), t, position });
        Ok(())
    })
}

/// Starts the thread that explains pixels; it says the pixel and the text.
///
/// # Errors
/// Those of [`Worker::start`].
pub fn start_explain(
    device: Device,
    say: impl Fn(Result<([u32; 2], String)>) + Send + 'static,
) -> Result<Worker<Question>> {
    Worker::start("explaining", say, move |question: Question, _, say| {
        let text = match explained(&device, &question) {
            Ok(text) => text,
            // Without a device the window ends.
            Err(error @ Error::Device(_)) => return Err(error),
            Err(error) => error.to_string(),
        };
        say(([question.x, question.y], text));
        Ok(())
    })
}

fn explained(device: &Device, question: &Question) -> Result<String> {
    let rays = Rays::Pixels(question.pixel());
    let mut explanation = explain(&question.scene, &rays, Some(DEFAULT_OBJECTS))?;
    if let Some(facts) = device.facts() {
        explanation.add_device(&question.scene, &rays, |prepared, wants| {
            match facts.check_kernel(prepared.kernel) {
                Ok(()) => Ok(Some(device.tracer(prepared, wants)?.tracer)),
                Err(_) => Ok(None),
            }
        })?;
    }
    Ok(text::text(&explanation))
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;
    use crate::scene::Camera;

    #[test]
    fn a_pixel_that_cannot_be_explained_says_why() {
        let view = View::new(&Camera::new(DVec3::Z, DVec3::ZERO));
        let (scene, pixels) = (Arc::default(), Pixels::whole(view, 4, 3));
        let (send, answers) = channel();
        let explain = start_explain(Device::Cpu, move |answer| send.send(answer).unwrap()).unwrap();
        explain.ask(Question { scene, pixels, kernel: Kernel::Certified, x: 9, y: 1 });
        let (pixel, text) = answers.recv().unwrap().expect("words");
        assert_eq!(pixel, [9, 1]);
        assert!(text.contains("other rays"), "{text}");
    }
}
