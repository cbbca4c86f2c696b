//! The window's state: the picture that is wanted, the one that is there, and words for the user.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui;
use eframe::egui_wgpu::Callback;
use egui::{Color32, Painter, Pos2, Rect, pos2};
use glam::{DVec2, DVec3, Vec2};
use kugelblitz::Result;
use kugelblitz::device::Device;
use kugelblitz::query::Kernel;
use kugelblitz::rays::Pixels;
use kugelblitz::scene::{Samples, Scene, Sphere};
use kugelblitz_judge::explain::six_digits;
use kugelblitz_judge::show::{Entry, Show};

use super::ask::{Answer, Question, Why};
use super::picture::{DrawnFrame, Order};
use super::present::Presented;
use super::rig::{Rig, bounding_sphere};

/// How long a message is shown, and how much longer for each letter.
const MESSAGE_TIME: [Duration; 2] = [Duration::from_secs(2), Duration::from_millis(50)];

/// The samples across and down a pixel that can be chosen.
pub const SAMPLES: [Samples; 5] = [
    Samples::ONE,
    Samples::nearest(2),
    Samples::nearest(4),
    Samples::nearest(8),
    Samples::nearest(16),
];

/// A rectangle of the window, px.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Area {
    pub left: u32,
    pub top: u32,
    pub width: u32,
    pub height: u32,
    /// Pixels of a point.
    pub scale: f32,
}

impl Area {
    /// The pixels whose edges are next to the rectangle's, which is in points.
    pub fn of(rect: Rect, scale: f32) -> Area {
        let [left, top, right, bottom] = [rect.left(), rect.top(), rect.right(), rect.bottom()]
            .map(|edge| (edge * scale).round().max(0.0) as u32);
        let (width, height) = (right.saturating_sub(left), bottom.saturating_sub(top));
        Area { left, top, width, height, scale }
    }

    /// Columns and rows.
    pub fn size(self) -> DVec2 {
        DVec2::new(self.width.into(), self.height.into())
    }

    /// The rectangle in points of the window.
    fn rect(self) -> Rect {
        Rect::from_min_max(self.point(DVec2::ZERO), self.point(self.size()))
    }

    /// The place in the picture, pixels from its top left corner, of one in points of the window; `None` beside it.
    pub fn place(self, at: Pos2) -> Option<DVec2> {
        let corner = DVec2::new(self.left.into(), self.top.into());
        let at = Vec2::from_array(at.into()).as_dvec2() * f64::from(self.scale) - corner;
        (at.cmpge(DVec2::ZERO).all() && at.cmplt(self.size()).all()).then_some(at)
    }

    /// A place in the picture, pixels from its top left corner, in points of the window.
    pub fn point(self, at: DVec2) -> Pos2 {
        let Vec2 { x, y } = at.as_vec2();
        pos2(self.left as f32 + x, self.top as f32 + y) / self.scale
    }

    /// The middle of a pixel of the picture, in points of the window.
    pub fn of_pixel(self, [x, y]: [u32; 2]) -> Pos2 {
        self.point(DVec2::new(x.into(), y.into()) + 0.5)
    }
}

/// A wish of the user that is more than a change of [`State`].
#[derive(Clone)]
pub enum WindowCommand {
    /// Print the camera.
    PrintCamera,
    /// Save the picture.
    Save,
    /// Open another scene.
    Open(PathBuf),
    /// Explain a pixel.
    Explain(Question),
}

/// The text of `explain` for a pixel.
pub struct Explained {
    /// The pixel, with the picture that it is of.
    pub question: Question,
    /// `None` while it is being computed.
    pub why: Option<Why>,
}

/// Everything between the user and the threads.
pub struct State {
    pub path: PathBuf,
    pub scene: Arc<Scene>,
    /// The scene without its light; the same one where it has none.
    unlit: Arc<Scene>,
    pub extent: Sphere,
    /// What the user wants and nobody has carried out yet.
    pub commands: Vec<WindowCommand>,
    pub rig: Rig,
    /// The hand moves the camera.
    pub is_moving: bool,
    /// Left and right; the right one is shown where only one is.
    pub kernels: [Kernel; 2],
    pub compares: bool,
    /// Where the divider stands, 0 to 1.
    pub divider: f32,
    pub show: Show,
    /// The scene's light is on.
    pub has_light: bool,
    /// Samples across and down a pixel, where colours are shown.
    pub n_samples: Samples,
    /// Keys that went down without Ctrl and are not up again: one of Ctrl + S does not fly, even when Ctrl is up.
    pub flying: Vec<egui::Key>,
    pub has_panels: bool,
    pub has_help: bool,
    /// Where the picture is.
    pub area: Area,
    /// Traces all that is shown and asked for.
    pub device: Device,
    /// The newest picture.
    pub frame: Option<DrawnFrame>,
    /// The newest order.
    pub ordered: Option<Order>,
    /// The pixel under the pointer, unless that drags.
    pub pointed: Option<Question>,
    /// What is there.
    pub hover: Option<Answer>,
    /// The pixel that shall become the pivot when its answer comes.
    pub pivot_wanted: Option<[u32; 2]>,
    pub explained: Option<Explained>,
    /// The fault of the scene file as it is now.
    pub scene_error: Option<String>,
    message: Option<(String, Instant)>,
    /// Time between the last frames, while they followed each other closely.
    pub frame_ms: Option<f64>,
}

impl State {
    /// Begins with a scene's camera.
    ///
    /// # Errors
    /// Those of [`Scene::require_camera`].
    pub fn new(path: PathBuf, scene: Arc<Scene>, device: Device, kernel: Kernel) -> Result<State> {
        let rig = Rig::new(scene.require_camera(&path)?);
        Ok(State {
            path,
            extent: bounding_sphere(&scene),
            is_moving: false,
            commands: Vec::new(),
            rig,
            unlit: without_light(&scene),
            n_samples: scene.samples.unwrap_or_default(),
            scene,
            kernels: [Kernel::Lecture, kernel],
            compares: false,
            divider: 0.5,
            show: Show::Color,
            has_light: true,
            flying: Vec::new(),
            has_panels: true,
            has_help: false,
            area: Area::default(),
            device,
            frame: None,
            ordered: None,
            pointed: None,
            hover: None,
            pivot_wanted: None,
            explained: None,
            scene_error: None,
            message: None,
            frame_ms: None,
        })
    }

    /// A new scene from the file. The camera follows the file where the file's camera changed, and so do
    /// the samples.
    pub fn reload(&mut self, scene: Arc<Scene>) {
        let before = std::mem::replace(&mut self.scene, scene);
        if self.scene.camera != before.camera {
            self.take_file_camera();
        }
        if self.scene.samples != before.samples {
            self.n_samples = self.scene.samples.unwrap_or_default();
        }
        self.extent = bounding_sphere(&self.scene);
        self.unlit = without_light(&self.scene);
        self.scene_error = None;
        self.hover = None;
    }

    /// Another scene, from another file.
    pub fn open(&mut self, path: PathBuf, scene: Arc<Scene>) {
        self.reload(scene);
        self.n_samples = self.scene.samples.unwrap_or_default();
        self.take_file_camera();
        (self.path, self.explained) = (path, None);
    }

    /// Takes the camera of the scene file.
    pub fn take_file_camera(&mut self) {
        if let Some(camera) = &self.scene.camera {
            self.rig = Rig::new(camera);
        }
    }

    /// The kernels that are shown, from left to right.
    pub fn shown_kernels(&self) -> Vec<Kernel> {
        if self.compares { self.kernels.to_vec() } else { vec![self.kernels[1]] }
    }

    /// The scene with its light on or off, as it is wanted.
    pub fn colored_scene(&self) -> &Arc<Scene> {
        if self.has_light { &self.scene } else { &self.unlit }
    }

    /// The scene that is saved: with the light and the samples that are shown.
    pub fn saved_scene(&self) -> Scene {
        Scene { samples: Some(self.n_samples), ..Scene::clone(self.colored_scene()) }
    }

    /// More samples a pixel, or fewer.
    pub fn step_samples(&mut self, more: bool) {
        let mut all = SAMPLES.into_iter();
        let next = match more {
            true => all.find(|&n| n > self.n_samples),
            false => all.rfind(|&n| n < self.n_samples),
        };
        self.n_samples = next.unwrap_or(self.n_samples);
    }

    /// Orders the picture that is wanted now; `None` where it was ordered last. Samples change colours alone.
    pub fn order(&mut self) -> Option<Order> {
        let is_color = self.show == Show::Color;
        let order = Order {
            serial: self.asked() + 1,
            scene: Arc::clone(if is_color { self.colored_scene() } else { &self.scene }),
            pixels: self.pixels(),
            kernels: self.shown_kernels(),
            show: self.show,
            n_samples: if is_color { self.n_samples } else { Samples::ONE },
        };
        let is_known = self.ordered.as_ref().is_some_and(|known| known.is(&order));
        let is_wanted = !is_known && self.area.width > 0 && self.area.height > 0;
        is_wanted.then(|| self.ordered.insert(order).clone())
    }

    /// Number of the newest order.
    pub fn asked(&self) -> u64 {
        self.ordered.as_ref().map_or(0, |order| order.serial)
    }

    /// Draws the picture, of two kernels each on its side of the divider.
    pub fn paint(&self, painter: &Painter) {
        let whole = self.area.rect();
        let Some(DrawnFrame { images, .. }) = &self.frame else {
            painter.rect_filled(whole, 0.0, Color32::BLACK);
            return;
        };
        let split = if images.len() > 1 { self.divider_x() } else { whole.right() };
        let (left, right) = whole.split_left_right_at_x(split);
        for (image, side) in images.iter().zip([left, right]) {
            let presented = Presented(Arc::clone(image));
            painter.with_clip_rect(side).add(Callback::new_paint_callback(whole, presented));
        }
    }

    /// What the colours mean that are shown.
    pub fn legend(&self) -> Vec<Entry> {
        Entry::all(self.show, self.shown().and_then(|frame| frame.range))
    }

    /// The legends with the pixels of each meaning, of each kernel; nothing until all are drawn.
    pub fn legends(&self) -> &[Vec<Entry>] {
        self.shown().map_or(&[], |frame| &frame.legends)
    }

    /// The newest picture where it is the one that was ordered last.
    fn shown(&self) -> Option<&DrawnFrame> {
        self.frame.as_ref().filter(|frame| frame.order.serial == self.asked())
    }

    /// Looks at everything from where it looks now.
    pub fn frame_everything(&mut self) {
        self.rig.frame(self.extent, self.aspect());
    }

    /// Looks at everything from the side of a unit vector.
    pub fn look_from(&mut self, to_eye: DVec3) {
        self.rig.look_from(to_eye, self.extent, self.aspect());
    }

    /// Shows two kernels, or one again. Two of a kind would show nothing.
    pub fn toggle_compare(&mut self) {
        self.compares = !self.compares;
        if self.kernels[0] == self.kernels[1] {
            self.kernels[0] = match self.kernels[1] {
                Kernel::Lecture => Kernel::Certified,
                _ => Kernel::Lecture,
            };
        }
    }

    /// The offered kernel after `kernel`.
    pub fn kernel_after(&self, kernel: Kernel) -> Kernel {
        let offered = self.device.kernels();
        let mut after =
            Kernel::ALL.into_iter().cycle().skip_while(|&known| known != kernel).skip(1);
        after.find(|next| *next == kernel || offered.contains(next)).unwrap_or(kernel)
    }

    /// The place, among the kernels that are shown, of a column of the picture.
    pub fn place_at(&self, x: u32) -> usize {
        usize::from(self.compares && x >= self.divider_px())
    }

    /// Columns left of the divider.
    fn divider_px(&self) -> u32 {
        (f64::from(self.divider) * f64::from(self.area.width)).round() as u32
    }

    /// Where the divider is in the window: between two columns of pixels.
    pub fn divider_x(&self) -> f32 {
        self.area.point(DVec2::new(self.divider_px().into(), 0.0)).x
    }

    /// The pixels that the window has room for.
    pub fn pixels(&self) -> Pixels {
        Pixels::whole(self.rig.view(), self.area.width, self.area.height)
    }

    /// A question about a pixel as it is now: whatever changes later, it stays the same.
    pub fn question(&self, [x, y]: [u32; 2]) -> Question {
        let kernel = self.shown_kernels()[self.place_at(x)];
        let pixel = Pixels { x, y, width: 1, height: 1, ..self.pixels() };
        Question { scene: Arc::clone(&self.scene), pixel, kernel }
    }

    /// Width over height.
    pub fn aspect(&self) -> f64 {
        f64::from(self.area.width.max(1)) / f64::from(self.area.height.max(1))
    }

    /// Part of the picture that is drawn, 0 to 1.
    pub fn share(&self) -> f32 {
        self.shown().map_or(0.0, |frame| frame.share)
    }

    /// Tells the user something for a while.
    pub fn tell(&mut self, message: impl Into<String>) {
        let message = message.into();
        let [least, each] = MESSAGE_TIME;
        let until = Instant::now() + least + each * message.chars().count() as u32;
        self.message = Some((message, until));
    }

    /// The message for the user now, and how long it stays.
    pub fn message(&self) -> Option<(&str, Duration)> {
        let (message, until) = self.message.as_ref()?;
        let left = until.saturating_duration_since(Instant::now());
        (!left.is_zero()).then_some((message, left))
    }

    /// An answer of the hover thread.
    pub fn answer(&mut self, answer: Answer) {
        let is_wanted = self.pivot_wanted == Some(answer.pixel);
        self.hover = Some(answer);
        if is_wanted {
            self.set_pivot();
        }
    }

    /// The answer for a pixel, where it is known for this camera.
    pub fn known(&self, pixel: [u32; 2]) -> Option<&Answer> {
        let view = self.rig.view();
        self.hover.as_ref().filter(|answer| answer.pixel == pixel && answer.view == view)
    }

    /// Turns around what was looked up last.
    pub fn set_pivot(&mut self) {
        self.pivot_wanted = None;
        let Some(answer) = &self.hover else { return };
        if answer.id == 0 {
            self.tell("The background is no pivot");
        } else {
            self.rig.pivot = answer.position;
            let message = format!("Turning around {} at {}", answer.label, point(answer));
            self.tell(message);
        }
    }
}

fn without_light(scene: &Arc<Scene>) -> Arc<Scene> {
    if !scene.is_lit() {
        return Arc::clone(scene);
    }
    Arc::new(Scene { lights: Vec::new(), sky: None, ambient: None, ..Scene::clone(scene) })
}

/// `(1, 2, 3)`, to six digits.
pub fn point(answer: &Answer) -> String {
    let [x, y, z] = answer.position.to_array().map(six_digits);
    format!("({x}, {y}, {z})")
}

#[cfg(test)]
mod tests {
    use kugelblitz::scene::parse_scene;

    use super::*;

    const LIT: &str = include_str!("../../../scenes/lit/figure1.toml");

    fn lit(text: &str) -> Arc<Scene> {
        Arc::new(parse_scene(text, "figure1.toml".as_ref()).unwrap())
    }

    fn state() -> State {
        State::new("figure1.toml".into(), lit(LIT), Device::Cpu, Kernel::Certified).unwrap()
    }

    #[test]
    fn samples_go_up_and_down_from_any_number() {
        let mut state = state();
        let mut steps = |from, more| {
            state.n_samples = Samples::nearest(from);
            state.step_samples(more);
            state.n_samples.across()
        };
        for (down, from, up) in [(1, 1, 2), (1, 2, 4), (2, 3, 4), (8, 13, 16), (8, 16, 16)] {
            assert_eq!((steps(from, false), steps(from, true)), (down, up), "{from}");
        }
        assert_eq!(SAMPLES[SAMPLES.len() - 1].across(), Samples::MOST);
    }

    #[test]
    fn samples_follow_the_file_where_its_own_change() {
        let mut state = state();
        assert_eq!(state.n_samples.across(), 3);
        state.step_samples(true);
        let reload = |state: &mut State, text: &str| {
            state.reload(lit(text));
            state.n_samples.across()
        };
        assert_eq!(reload(&mut state, &LIT.replace("0.45", "0.3")), 4);
        assert_eq!(reload(&mut state, &LIT.replace("samples = 3", "samples = 5")), 5);
        assert_eq!(reload(&mut state, &LIT.replace("samples = 3", "")), 1);
    }

    #[test]
    fn light_and_samples_are_of_colours_and_are_saved() {
        let mut state = state();
        state.area = Area { width: 8, height: 6, ..Area::default() };
        let ordered = |state: &mut State| {
            let order = state.order().expect("another picture");
            assert!(state.order().is_none(), "the same again");
            (order.show, order.is_lit(), order.n_samples.across())
        };
        assert_eq!(ordered(&mut state), (Show::Color, true, 3));
        assert_eq!(state.saved_scene(), *state.scene);
        state.show = Show::Id;
        assert_eq!(ordered(&mut state), (Show::Id, false, 1));
        state.has_light = false;
        assert!(state.order().is_none(), "ids have no light");
        state.show = Show::Color;
        assert_eq!(ordered(&mut state), (Show::Color, false, 3));
        state.n_samples = Samples::ONE;
        assert_eq!(ordered(&mut state), (Show::Color, false, 1));
        let saved = state.saved_scene();
        assert!(!saved.is_lit() && saved.samples == Some(Samples::ONE));
        assert_eq!(saved.spheres, state.scene.spheres);
    }

    #[test]
    fn another_scene_begins_with_its_own_camera() {
        let mut state = state();
        state.look_from(DVec3::Z);
        let scene = lit(&LIT.replace("samples = 3", "samples = 2"));
        state.open("other.toml".into(), Arc::clone(&scene));
        let home = Rig::new(scene.camera.as_ref().unwrap());
        assert_eq!((&state.rig, state.n_samples), (&home, Samples::nearest(2)));
        assert!(Arc::ptr_eq(&state.scene, &scene));
    }

    #[test]
    fn pixels_are_where_the_window_shows_them() {
        let area = Area::of(Rect::from_min_max(pos2(10.0, 36.0), pos2(110.0, 116.0)), 1.0);
        assert_eq!(area, Area { left: 10, top: 36, width: 100, height: 80, scale: 1.0 });
        assert_eq!(area.of_pixel([0, 0]), pos2(10.5, 36.5));
        assert_eq!(Area { scale: 2.0, ..area }.of_pixel([5, 3]), pos2(7.75, 19.75));
    }
}
