//! Questions about one pixel, answered on threads of their own.

use std::sync::Arc;

use glam::DVec3;
use kugelblitz::Session;
use kugelblitz::device::Device;
use kugelblitz::query::{Kernel, Outputs, Rays};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::Scene;
use kugelblitz::{Error, Result};
use kugelblitz_judge::explain::{ExplainStyle, Lang, explain, label, text};

use super::worker::Worker;

/// A pixel of a picture, with all that the picture is made from.
#[derive(Clone)]
pub struct Question {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The pixel alone, as part of its picture.
    pub pixel: Pixels,
    /// The kernel that shows the pixel.
    pub kernel: Kernel,
}

impl Question {
    /// Column and row.
    pub fn at(&self) -> [u32; 2] {
        [self.pixel.x, self.pixel.y]
    }
}

impl PartialEq for Question {
    fn eq(&self, other: &Question) -> bool {
        Arc::ptr_eq(&self.scene, &other.scene)
            && (self.pixel, self.kernel) == (other.pixel, other.kernel)
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
        let (at, Question { scene, pixel, kernel }) = (question.at(), question);
        session.set_scene(Arc::clone(&scene));
        session.set_kernel(kernel);
        let wants = Outputs { surface: true, level: false };
        let hits = session.hits(&pixel, wants, &turn.control)?;
        let (id, t) = (hits.id[0], hits.t[0]);
        let ray = pixel.ray(pixel.x, pixel.y);
        let position = ray.origin + ray.direction * f64::from(t);
        say(Answer { pixel: at, view: pixel.view, id, label: label(&scene, id), t, position });
        Ok(())
    })
}

/// Why a pixel is as it is.
pub struct Why {
    /// What the pixel shows, in short.
    pub verdict: String,
    /// The text of `explain`.
    pub text: String,
}

/// Starts the thread that explains pixels.
///
/// # Errors
/// Those of [`Worker::start`].
pub fn start_explain(
    device: Device,
    lang: Lang,
    say: impl Fn(Result<([u32; 2], Why)>) + Send + 'static,
) -> Result<Worker<Question>> {
    let style = ExplainStyle { lang, ..ExplainStyle::default() };
    Worker::start("explaining", say, move |question: Question, _, say| {
        let why = match explained(&device, &question, &style) {
            // Without a device the window ends.
            Err(error @ Error::Device(_)) => return Err(error),
            Err(error) => Why { verdict: error.to_string(), text: String::new() },
            Ok(why) => why,
        };
        say((question.at(), why));
        Ok(())
    })
}

fn explained(device: &Device, question: &Question, style: &ExplainStyle) -> Result<Why> {
    let rays = Rays::Pixels(question.pixel);
    let mut explanation = explain(&question.scene, &rays, style)?;
    let runs = device.kernels();
    let device_of = |kernel| if runs.contains(&kernel) { device } else { &Device::Cpu };
    explanation.add_device(&question.scene, &rays, device_of)?;
    Ok(Why { verdict: text::verdict(&explanation), text: text::text(&explanation) })
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use kugelblitz::scene::Camera;

    use super::*;

    #[test]
    fn a_pixel_says_why_also_where_it_cannot_be_explained() {
        let view = View::new(&Camera::new(DVec3::Z, DVec3::ZERO));
        let (scene, pixels) = (Arc::<Scene>::default(), Pixels::whole(view, 4, 3));
        let (send, answers) = channel();
        let say = move |answer: Result<_>| send.send(answer.expect("words")).unwrap();
        let mut explain = start_explain(Device::Cpu, Lang::German, say).unwrap();
        let mut ask = |at @ [x, y]: [u32; 2]| {
            let (scene, kernel) = (Arc::clone(&scene), Kernel::Certified);
            let pixel = Pixels { x, y, width: 1, height: 1, ..pixels };
            explain.ask(Question { scene, pixel, kernel });
            let (pixel, why) = answers.recv().unwrap();
            assert_eq!(pixel, at);
            why
        };
        let Why { verdict, text } = ask([9, 1]);
        assert!(verdict.contains("other rays") && text.is_empty(), "{verdict}");
        let Why { verdict, text } = ask([1, 1]);
        assert!(verdict.starts_with("Der Strahl sieht den Hintergrund."), "{verdict}");
        assert!(text.contains(verdict.lines().next().unwrap()), "{text}");
    }
}
