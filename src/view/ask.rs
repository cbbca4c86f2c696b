//! Questions about one pixel, answered on threads of their own.

use std::sync::Arc;

use glam::DVec3;

use super::tracing::{Backend, Numbers};
use super::worker::{Turn, Worker};
use crate::camera::{Pixels, View};
use crate::error::{Error, Result};
use crate::explain::{DEFAULT_OBJECTS, explain, label, text};
use crate::gpu::GpuTracer;
use crate::scene::Scene;
use crate::trace::{Kernel, Rays};
use crate::tracer::Tracer;

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
/// [`Error::Io`] when the system has no thread to give.
pub fn start_hover(
    backend: Backend,
    say: impl Fn(Result<Answer>) + Send + 'static,
) -> Result<Worker<Question>> {
    let mut numbers = Numbers::new(backend);
    Worker::start("hover", move |question: Question, turn| {
        answer(&mut numbers, &question, turn, &say);
    })
    .map_err(Error::io("the hover thread"))
}

fn answer(
    numbers: &mut Numbers,
    question: &Question,
    turn: &Turn<Question>,
    say: &impl Fn(Result<Answer>),
) {
    let &Question { kernel, x, y, pixels, .. } = question;
    match numbers.trace(&question.scene, kernel, question.pixel(), &turn.control) {
        Ok(hits) => {
            let (id, t) = (hits.id[0], hits.t[0]);
            let ray = pixels.ray(x, y);
            let position = ray.origin + ray.direction * f64::from(t);
            let label = label(&question.scene, id);
            say(Ok(Answer { pixel: [x, y], view: pixels.view, id, label, t, position }));
        }
        Err(Error::Interrupted) => {}
        Err(error) => say(Err(error)),
    }
}

/// Starts the thread that explains pixels; it says the pixel and the text.
///
/// # Errors
/// [`Error::Io`] when the system has no thread to give.
pub fn start_explain(
    backend: Backend,
    say: impl Fn(Result<([u32; 2], String)>) + Send + 'static,
) -> Result<Worker<Question>> {
    Worker::start("explain", move |question: Question, _: &Turn<Question>| {
        let explained = explained(&backend, &question);
        say(explained.map(|text| ([question.x, question.y], text)));
    })
    .map_err(Error::io("the explaining thread"))
}

fn explained(backend: &Backend, question: &Question) -> Result<String> {
    let rays = Rays::Pixels(question.pixel());
    let mut explanation = explain(&question.scene, &rays, Some(DEFAULT_OBJECTS))?;
    if !backend.on_cpu {
        explanation.add_device(&question.scene, &rays, |prepared, wants| {
            let (gpu, prepared) = (Arc::clone(&backend.gpu), Arc::clone(prepared));
            if gpu.facts.check_kernel(prepared.kernel).is_err() {
                return Ok(None);
            }
            Ok(Some(Box::new(GpuTracer::new(gpu, prepared, wants)?) as Box<dyn Tracer>))
        })?;
    }
    Ok(text::text(&explanation))
}
