//! The window: what comes in, and what goes out.

use std::panic::{self, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use eframe::egui::{self, Context, RawInput, Ui, ViewportBuilder, ViewportCommand, vec2};
use eframe::wgpu;
use kugelblitz::Control;
use kugelblitz::Session;
use kugelblitz::device::Device;
use kugelblitz::error::Message;
use kugelblitz::gpu::Gpu;
use kugelblitz::plain::Shown;
use kugelblitz::query::Kernel;
use kugelblitz::scene::Scene;
use kugelblitz::{Error, Result};
use kugelblitz_judge::explain::Lang;
use winit::window::Window;

use super::ask::{self, Answer, Question, Why};
use super::notice::Notice;
use super::panels;
use super::picture::{self, DrawnFrame, Order};
use super::present;
use super::reload::watch;
use super::save::{Save, Saving, free_name};
use super::state::{Explained, State, WindowCommand};
use super::turns::Turns;
use super::worker::Worker;

/// Size of the picture where neither the options nor the scene file has one.
const DEFAULT_SIZE: [u32; 2] = [1280, 720];

/// Frames farther apart than this do not belong to a movement.
const MOVEMENT: Duration = Duration::from_millis(300);

/// Reads a scene file, or another that makes a scene with a camera.
pub type Reread = Arc<dyn Fn(&Path, &Control) -> Result<Scene> + Send + Sync>;

/// The window's beginning.
pub struct Options {
    /// The scene file, which is watched.
    pub path: PathBuf,
    /// How it is read again when it has changed.
    pub reread: Reread,
    /// The scene in it; with a camera.
    pub scene: Arc<Scene>,
    /// The name of the device that traces, as [`Gpu::open`] takes it; the CPU where it is `None`.
    pub device: Option<String>,
    /// The kernel.
    pub kernel: Kernel,
    /// Size of the picture, px; that of the scene file where it is `None`.
    pub size: Option<[u32; 2]>,
    /// The language of explanations.
    pub lang: Lang,
    /// Cancelling it closes the window.
    pub control: Arc<Control>,
    /// Gives the device up after so many frames, as if it had been lost: for tests.
    pub lose_device_after: Option<u64>,
}

/// A message of another thread.
enum Event {
    Drawn(Result<DrawnFrame>),
    Hover(Result<Answer>),
    Explained(Result<([u32; 2], Why)>),
    /// The picture in this file is saved, or can't be.
    Saved(PathBuf),
    /// The scene file was read again.
    Scene((PathBuf, Read)),
    /// Another scene file was read.
    Opened((PathBuf, Read)),
    /// The window can't go on.
    Failed(Error),
}

/// A scene, which has a camera.
type Read = Result<Arc<Scene>>;

/// Opens the window and returns when it was closed.
///
/// # Errors
/// [`Error::NoAdapter`] where there is no display or no device that can show pictures,
/// [`Error::Scene`] for a scene without a camera, [`Error::Device`] when the device is lost,
/// [`Error::Io`] when the display is lost, [`Error::Interrupted`] when the control was
/// cancelled; those of [`Session::render_to_file`] where a picture was still being saved.
pub fn run(options: Options, mut notify: impl FnMut(&Notice)) -> Result<()> {
    let path = options.path.clone();
    let context = Context::default();
    style(&context);
    let mut end = WindowEnd::default();
    let mut app = App::new(options, context.clone(), &mut notify, &mut end)?;
    let (title, native) = (app.title(), app.native_options());
    let opened = Box::new(|creation: &eframe::CreationContext| {
        app.opened(creation);
        Ok(Box::new(app) as Box<dyn eframe::App>)
    });
    let ran = unless_lost(|| eframe::run_native_ext(&title, native, Some(context), opened), &path);
    let WindowEnd { saves, mut failure } = end;
    for save in saves {
        let (path, size) = (save.path.clone(), save.size);
        match save.end() {
            Ok(()) => notify(&Notice::Saved { path: &path, size }),
            Err(error) if failure.is_none() => failure = Some(error),
            Err(error) => notify(&Notice::Trouble { message: &error.to_string() }),
        }
    }
    failure.map_or(ran, Err)
}

/// Runs the window. Where the display is gone, winit panics when it is asked for the window's size, and egui-wgpu, in its
/// file about winit, when the surface has no formats any more: an error as others are.
fn unless_lost(run: impl FnOnce() -> eframe::Result, scene: &Path) -> Result<()> {
    let before = Arc::new(panic::take_hook());
    let is_lost = Arc::new(AtomicBool::new(false));
    let (others, seen) = (Arc::clone(&before), Arc::clone(&is_lost));
    panic::set_hook(Box::new(move |panic| match panic.location() {
        Some(place) if place.file().contains("winit") => seen.store(true, Ordering::Relaxed),
        _ => others(panic),
    }));
    let ran = panic::catch_unwind(AssertUnwindSafe(run));
    panic::set_hook(Box::new(move |panic| before(panic)));
    match ran {
        Ok(ran) => ran.map_err(|error| window_error(error, scene)),
        Err(_) if is_lost.load(Ordering::Relaxed) => Err(display_lost()),
        Err(panic) => panic::resume_unwind(panic),
    }
}

/// A window that no panic drops: winit might panic again, where its lock was held, and nobody could catch that.
struct Kept(Arc<Window>);

impl Drop for Kept {
    fn drop(&mut self) {
        if std::thread::panicking() {
            std::mem::forget(Arc::clone(&self.0));
        }
    }
}

fn display_lost() -> Error {
    let source = std::io::Error::other("the connection was lost");
    Error::Io { path: "the display".into(), source }
}

/// What the window's device could not do.
fn device_error(error: &wgpu::Error) -> Error {
    let words = error.to_string();
    match words.contains("Surface::") || words.contains("Queue::present") {
        true => display_lost(),
        false => Error::Device(words.into()),
    }
}

/// What was the matter with the window.
fn window_error(error: eframe::Error, scene: &Path) -> Error {
    use winit::error::EventLoopError;
    let render = format!("use `kugelblitz render {} -o picture.png`", scene.shown());
    let text = match error {
        // All that winit says of Wayland.
        eframe::Error::WinitEventLoop(EventLoopError::ExitFailure(_)) => {
            return display_lost();
        }
        eframe::Error::WinitEventLoop(error) => {
            // winit's words begin with the place in its source: `os error at FILE:LINE: why`.
            let words = error.to_string();
            let why =
                words.strip_prefix("os error at ").and_then(|rest| rest.splitn(3, ':').nth(2));
            let why = why.unwrap_or(&words).trim().trim_end_matches('.');
            // In the order in which winit looks.
            let asked =
                ["WAYLAND_DISPLAY", "WAYLAND_SOCKET", "DISPLAY"].into_iter().find_map(|name| {
                    let value = std::env::var(name).ok().filter(|value| !value.is_empty())?;
                    Some(format!(" ({name}={value})"))
                });
            let asked = asked.unwrap_or_default();
            format!("there is no display to open a window on: {why}{asked}")
        }
        eframe::Error::Wgpu(error) => {
            format!("no Vulkan device can show pictures in a window here: {error}")
        }
        error => format!("the window cannot be opened: {error}"),
    };
    Error::NoAdapter(Message::new(text, render))
}

/// Passes what other threads say to the window, and wakes it.
#[derive(Clone)]
struct Teller {
    to_window: Sender<Event>,
    context: Context,
}

impl Teller {
    fn of<T: 'static>(&self, event: fn(T) -> Event) -> impl Fn(T) + Send + 'static {
        let Teller { to_window, context } = self.clone();
        move |message| {
            // The window is gone only when nobody is interested any more.
            let _ = to_window.send(event(message));
            context.request_repaint();
        }
    }
}

fn style(context: &Context) {
    // A second pass over the same input would carry it out twice.
    context.options_mut(|options| options.max_passes = std::num::NonZeroUsize::MIN);
    context.all_styles_mut(|style| {
        style.interaction.selectable_labels = false;
        style.animation_time = 0.0;
        let edge = style.visuals.widgets.noninteractive.fg_stroke.color.gamma_multiply(0.45);
        style.visuals.widgets.inactive.bg_stroke = egui::Stroke::new(1.0, edge);
        style.visuals.window_shadow = egui::Shadow::NONE;
        style.visuals.popup_shadow = egui::Shadow::NONE;
    });
}

/// What is left when the window is closed.
#[derive(Default)]
struct WindowEnd {
    failure: Option<Error>,
    /// Pictures that are being saved.
    saves: Vec<Save>,
}

struct App<'a> {
    options: Options,
    notify: &'a mut dyn FnMut(&Notice),
    end: &'a mut WindowEnd,
    state: State,
    turns: Turns,
    window: Option<Kept>,
    events: Receiver<Event>,
    teller: Teller,
    artist: Worker<Order>,
    hover: Worker<Question>,
    explain: Worker<Question>,
    watch: Worker<()>,
    /// Reads other scenes.
    reader: Worker<PathBuf>,
    /// The last pixel that was asked for.
    hovered: Option<Question>,
    n_frames: u64,
    last_frame: Option<Instant>,
}

impl eframe::App for App<'_> {
    fn raw_input_hook(&mut self, _: &Context, input: &mut RawInput) {
        self.turns.give(input);
    }

    fn logic(&mut self, context: &Context, _: &mut eframe::Frame) {
        // Nobody reads any more what the window tells: what fails from here on is told behind it.
        if context.input(|input| input.viewport().close_requested()) {
            return;
        }
        while let Ok(event) = self.events.try_recv() {
            if let Err(error) = self.hear(event) {
                self.trouble(error);
            }
        }
    }

    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        if self.turns.taken() {
            ui.ctx().request_repaint();
        }
        panels::layout(ui, &mut self.state);
        // Where the pointer comes back from elsewhere, what it finds is looked up again.
        if self.hovered != self.state.pointed {
            self.hovered = self.state.pointed.clone();
            self.hovered.clone().into_iter().for_each(|question| self.hover.ask(question));
        }
        for command in std::mem::take(&mut self.state.commands) {
            self.carry_out(command);
        }
        if let Some(order) = self.state.order() {
            self.artist.ask(order);
        }
        self.count_frame();
        if self.options.lose_device_after == Some(self.n_frames) {
            self.fail(Error::Device("it was given up, as asked for".into()));
        }
    }
}

impl<'a> App<'a> {
    fn new(
        options: Options,
        context: Context,
        notify: &'a mut dyn FnMut(&Notice),
        end: &'a mut WindowEnd,
    ) -> Result<App<'a>> {
        let device = match &options.device {
            Some(name) => Device::Gpu(Arc::new(Gpu::open(name)?)),
            None => Device::Cpu,
        };
        let (path, scene) = (options.path.clone(), Arc::clone(&options.scene));
        let state = State::new(path, scene, device.clone(), options.kernel)?;
        let (to_window, events) = channel();
        let teller = Teller { to_window, context };
        Ok(App {
            artist: picture::start(device.clone(), teller.of(Event::Drawn))?,
            hover: ask::start_hover(device.clone(), teller.of(Event::Hover))?,
            explain: ask::start_explain(device, options.lang, teller.of(Event::Explained))?,
            watch: watch_scene(&options.path, &options, &teller)?,
            reader: start_reader(&options, teller.of(Event::Opened))?,
            options,
            notify,
            end,
            state,
            turns: Turns::default(),
            window: None,
            events,
            teller,
            hovered: None,
            n_frames: 0,
            last_frame: None,
        })
    }

    /// With room for the whole picture, a point a pixel, on a screen that has it.
    fn native_options(&mut self) -> eframe::NativeOptions {
        let [width, height] = self.full_size().unwrap_or(DEFAULT_SIZE).map(|px| px as f32);
        // Its own one: the window's must give its letters to the window first.
        let context = Context::default();
        style(&context);
        let size = vec2(width, height + panels::around(&context, &mut self.state, width));
        eframe::NativeOptions {
            viewport: ViewportBuilder::default().with_inner_size(size).with_app_id("kugelblitz"),
            // Colours of the legend are those of the picture, to the byte.
            dithering: false,
            ..eframe::NativeOptions::default()
        }
    }

    fn opened(&mut self, creation: &eframe::CreationContext) {
        self.window = creation.winit_window().cloned().map(Kept);
        if let Some(window) = &creation.wgpu_render_state {
            present::make_ready(window);
            let failed = self.teller.of(Event::Failed);
            window.device.on_uncaptured_error(Arc::new(move |error| failed(device_error(&error))));
        }
        let (adapter, software) = match self.state.device.facts() {
            Some(facts) => (facts.name.as_str(), facts.is_software()),
            None => ("the CPU", false),
        };
        (self.notify)(&Notice::Opened { adapter, software });
    }

    fn title(&self) -> String {
        let name = self.state.path.file_name().unwrap_or(self.state.path.as_os_str());
        format!("{} · Kugelblitz", Path::new(name).shown())
    }

    /// The size of a saved picture; `None` for that of the window.
    fn full_size(&self) -> Option<[u32; 2]> {
        self.options.size.or(self.state.scene.image)
    }

    fn fail(&mut self, error: Error) {
        self.end.failure.get_or_insert(error);
        self.teller.context.send_viewport_cmd(ViewportCommand::Close);
    }

    /// Tells what went wrong; without a device the window ends.
    fn trouble(&mut self, error: Error) {
        if matches!(error, Error::Device(_) | Error::Interrupted) {
            return self.fail(error);
        }
        let message = error.to_string();
        (self.notify)(&Notice::Trouble { message: &message });
        self.state.tell(message);
    }

    fn hear(&mut self, event: Event) -> Result<()> {
        match event {
            Event::Drawn(frame) => self.state.frame = Some(frame?),
            Event::Hover(answer) => {
                self.state.answer(answer?);
                (self.notify)(&Notice::Hover { text: &panels::hover_text(&self.state) });
            }
            Event::Explained(explained) => {
                let (pixel, why) = explained?;
                if let Some(shown) = &mut self.state.explained
                    && shown.question.at() == pixel
                {
                    (self.notify)(&Notice::Explained { pixel, text: &why.text });
                    shown.why = Some(why);
                }
            }
            Event::Saved(path) => {
                let saves = &mut self.end.saves;
                let ended = saves.extract_if(.., |save| save.path == path).next();
                let Some(save) = ended else { return Ok(()) };
                let size = save.size;
                save.end()?;
                (self.notify)(&Notice::Saved { path: &path, size });
                self.state.tell(format!("Saved {}: {} × {}", path.shown(), size[0], size[1]));
            }
            // Of the scene before this one.
            Event::Scene((path, _)) if path != self.state.path => {}
            Event::Scene((_, Ok(scene))) => {
                self.state.reload(scene);
                (self.notify)(&Notice::Reloaded);
            }
            Event::Scene((_, Err(error))) => self.state.scene_error = Some(self.wrong(error)),
            Event::Opened((path, Ok(scene))) => {
                self.watch = watch_scene(&path, &self.options, &self.teller)?;
                (self.notify)(&Notice::SceneOpened { path: &path });
                self.state.open(path, scene);
                let title = ViewportCommand::Title(self.title());
                self.teller.context.send_viewport_cmd(title);
            }
            Event::Opened((path, Err(error))) => {
                let error = self.wrong(error);
                self.state.tell(format!("{} can't be opened: {error}", path.shown()));
            }
            Event::Failed(error) => self.fail(error),
        }
        Ok(())
    }

    /// Shows the error of a scene and its next step.
    fn wrong(&mut self, error: Error) -> String {
        let hint = error.hint();
        let error = if hint.is_empty() { error.to_string() } else { format!("{error}\n{hint}") };
        (self.notify)(&Notice::SceneWrong { error: &error });
        error
    }

    fn carry_out(&mut self, command: WindowCommand) {
        match command {
            WindowCommand::PrintCamera => {
                let toml = self.state.rig.camera.to_toml();
                self.state.tell("The camera is copied as TOML, and printed on standard output");
                (self.notify)(&Notice::Camera { toml: &toml });
                self.teller.context.copy_text(toml);
            }
            WindowCommand::Save => self.save(),
            WindowCommand::Open(path) => self.reader.ask(path),
            WindowCommand::Explain(question) => {
                self.state.explained = Some(Explained { question: question.clone(), why: None });
                self.explain.ask(question);
            }
        }
    }

    fn save(&mut self) {
        let state = &self.state;
        let size = self.full_size().unwrap_or([state.area.width, state.area.height]);
        let mut session = Session::new(state.saved_scene(), state.device.clone(), state.kernels[1]);
        session.set_camera(state.rig.camera.clone());
        let (saves, kernels) = (&mut self.end.saves, state.shown_kernels());
        let path = free_name(Path::new("."), &state.path, state.show, &kernels, saves);
        let (control, &State { show, divider, .. }) = (Arc::clone(&self.options.control), state);
        let saving = Saving { session, size, show, kernels, divider, control };
        match Save::start(saving, path, self.teller.of(Event::Saved)) {
            Ok(save) => saves.push(save),
            Err(error) => self.state.tell(format!("The picture can't be saved: {error}")),
        }
    }

    fn count_frame(&mut self) {
        let since = self.last_frame.replace(Instant::now()).map(|last| last.elapsed());
        let ms = since.map_or(0.0, |since| since.as_secs_f64() * 1e3);
        // Smoothed, or nobody could read it.
        let smooth = |known: Option<f64>| known.map_or(ms, |known| 0.8 * known + 0.2 * ms);
        let state = &mut self.state;
        let moves = since.is_some_and(|since| since < MOVEMENT);
        state.frame_ms = moves.then(|| smooth(state.frame_ms));
        self.n_frames += 1;
        let (Some(order), area) = (&state.ordered, state.area) else { return };
        let kernels: Vec<_> = order.kernels.iter().map(|kernel| kernel.name()).collect();
        (self.notify)(&Notice::Shown {
            frame: self.n_frames,
            picture: state.frame.as_ref().map_or(0, |frame| frame.order.serial),
            area: [area.left, area.top, area.width, area.height],
            settled: state.share() >= 1.0,
            kernels: &kernels,
            show: order.show.name(),
            lit: order.is_lit(),
            samples: order.n_samples.across(),
            asked: order.serial,
            ms,
        });
    }
}

/// Watches the scene file, and the control.
fn watch_scene(path: &Path, options: &Options, teller: &Teller) -> Result<Worker<()>> {
    // On a thread of its own: a newer file, and the end, need not wait for an older one.
    let mut reader = start_reader(options, teller.of(Event::Scene))?;
    let (file, control) = (path.to_owned(), Arc::clone(&options.control));
    let failed = teller.of(Event::Failed);
    watch(path.to_owned(), move |changed| {
        if changed {
            reader.ask(file.clone());
        }
        if let Err(error) = control.check() {
            failed(error);
        }
    })
}

/// Starts a thread that reads scenes.
fn start_reader(
    options: &Options,
    say: impl Fn((PathBuf, Read)) + Send + 'static,
) -> Result<Worker<PathBuf>> {
    let reread = Arc::clone(&options.reread);
    let say = move |read: Result<_>| drop(read.map(&say));
    Worker::start("reading", say, move |path: PathBuf, turn, say| {
        let read = reread(&path, &turn.control).and_then(|scene| {
            scene.require_camera(&path)?;
            Ok(Arc::new(scene))
        });
        turn.control.check()?;
        say((path, read));
        Ok(())
    })
}
