//! The event loop.

mod frame;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::ViewportId;
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::error::EventLoopError;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::{Window, WindowId};

use super::ask::{self, Answer, Question};
use super::bar::Widths;
use super::display::{display_lost, no_display};
use super::look::Look;
use super::notice::Notice;
use super::painter::{self, Painted, Painting};
use super::panels::{self, LINES};
use super::recent::{add_recent, recent};
use super::reload::watch;
use super::save::{Halves, Save, Saving, free_name};
use super::screen::{Panels, Screen};
use super::state::{Command, Explained, State};
use super::tracing::{self, Backend, Order, Traced};
use super::worker::Worker;
use super::x11;
use crate::control::Control;
use crate::device::Device;
use crate::error::{Error, Result};
use crate::gpu::{Pick, Pool, Words};
use crate::scene::{Camera, ImageSize, Scene, camera_text};
use crate::session::Session;
use crate::show::Show;
use crate::trace::Kernel;

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
    /// The device that traces and shows the picture. Where it is `None`, the CPU traces, and the
    /// best device shows.
    pub device: Option<Pick>,
    /// The kernel.
    pub kernel: Kernel,
    /// Size of the picture, px; that of the scene file where it is `None`.
    pub size: Option<[u32; 2]>,
    /// The file that keeps which scenes were opened last; none are kept where it is `None`.
    pub recent: Option<PathBuf>,
    /// Cancelling it closes the window.
    pub control: Arc<Control>,
    /// Called when the X server is gone, right before its library ends the process with exit code
    /// 1. Must not panic.
    pub on_display_lost: fn(),
    /// Gives the device up after so many frames, as if it had been lost: for tests.
    pub lose_device_after: Option<u64>,
}

/// Size of the picture where neither the options nor the scene file has one.
const DEFAULT_SIZE: [u32; 2] = [1280, 720];

/// Part of the screen that the window takes at most.
const SCREEN_PART: f64 = 0.92;

/// Devices that may be lost one soon after the other before the window gives up.
const MOST_LOSSES: usize = 4;

/// Losses within this time count as one soon after the other.
const SOON: Duration = Duration::from_secs(20);

/// A message of another thread.
enum Event {
    /// Of a thread that works with the device of this number.
    Said(u64, Result<Said>),
    /// The picture in this file is saved, or can't be.
    Saved(PathBuf),
    /// The scene file was read again.
    Scene(PathBuf, Read),
    /// Another scene file was read.
    Opened(PathBuf, Read),
    Interrupted,
    /// It is time to open a device in place of the one that was lost.
    Reopen,
}

/// A scene with its camera.
type Read = Result<(Arc<Scene>, Camera)>;

/// Reads a scene for a window, which waits for no writer.
fn read(reread: &Reread, path: &Path, control: &Control) -> Read {
    let scene = reread(path, control)?;
    let camera = scene.require_camera(path)?.clone();
    Ok((Arc::new(scene), camera))
}

/// A message of a thread that works with a device.
enum Said {
    Traced(Traced),
    Painted(Painted),
    Hover(Answer),
    Explained(([u32; 2], String)),
}

/// Opens the window and returns when it was closed.
///
/// # Errors
/// [`Error::NoAdapter`] where there is no display or no device that can show pictures,
/// [`Error::Scene`] for a scene without a camera, [`Error::Device`] when devices are lost again
/// and again, [`Error::Io`] when the display is lost, [`Error::Interrupted`] when the control was
/// cancelled; those of [`Session::render_to_file`] where a picture was still being saved.
pub fn run(options: Options, notify: impl FnMut(&Notice)) -> Result<()> {
    let camera = options.scene.require_camera(&options.path)?.clone();
    let path = options.path.clone();
    let no_display = |error: EventLoopError| no_display(&error, &path);
    let events = EventLoop::<Event>::with_user_event().build().map_err(no_display)?;
    let proxy = events.create_proxy();
    let watch = watch_scene(&options.path, &options, &proxy)?;
    let reader = start_reader(&options, &proxy)?;
    let mut state =
        State::new(options.path.clone(), Arc::clone(&options.scene), camera, options.kernel);
    state.recent = options.recent.as_deref().map(recent).unwrap_or_default();
    let mut app = App {
        closing: Arc::default(),
        watch,
        reader,
        options,
        proxy,
        notify,
        state,
        open: None,
        lost: None,
        start: Instant::now(),
        epoch: 0,
        asked: 0,
        losses: Vec::new(),
        saves: Vec::new(),
        failure: None,
        context: egui::Context::default(),
        frame: 0,
        wake: None,
    };
    style(&app.context);
    x11::on_loss(app.options.on_display_lost);
    let ran = events.run_app(&mut app).map_err(display_lost);
    app.watch.stop();
    app.reader.stop();
    app.closing.cancel();
    app.open = None;
    for save in std::mem::take(&mut app.saves) {
        match app.saved(save) {
            Ok(()) => {}
            Err(error) if app.failure.is_none() => app.failure = Some(error),
            Err(error) => (app.notify)(&Notice::Trouble { message: &error.to_string() }),
        }
    }
    app.failure.take().map_or(ran, Err)
}

/// Watches the scene file, and the control.
fn watch_scene(
    path: &Path,
    options: &Options,
    proxy: &EventLoopProxy<Event>,
) -> Result<Worker<()>> {
    let (file, to_window) = (path.to_owned(), proxy.clone());
    let (control, reread) = (Arc::clone(&options.control), Arc::clone(&options.reread));
    // The event loop is gone only when nobody is interested any more.
    let say = {
        let (file, to_window) = (file.clone(), proxy.clone());
        move |read| drop(to_window.send_event(Event::Scene(file.clone(), read)))
    };
    // On a thread of its own: a newer file, and the end, need not wait for an older one.
    let reader = Worker::start("reading", say, move |(), turn, say| {
        say(read(&reread, &file, &turn.control)?);
        Ok(())
    })?;
    let look = move |changed| {
        if changed {
            reader.ask(());
        }
        if control.check().is_err() {
            let _ = to_window.send_event(Event::Interrupted);
        }
    };
    watch(path.to_owned(), look)
}

/// Starts the thread that reads other scenes.
fn start_reader(options: &Options, proxy: &EventLoopProxy<Event>) -> Result<Worker<PathBuf>> {
    let (to_window, reread) = (proxy.clone(), Arc::clone(&options.reread));
    let say = move |opened: Result<(PathBuf, Read)>| {
        if let Ok((path, read)) = opened {
            let _ = to_window.send_event(Event::Opened(path, read));
        }
    };
    Worker::start("opening", say, move |path: PathBuf, turn, say| {
        let read = read(&reread, &path, &turn.control);
        if !turn.is_over() {
            say((path, read));
        }
        Ok(())
    })
}

/// An error in as many lines as it takes.
fn in_words(error: Error) -> String {
    match error {
        Error::Scene(wrong) => format!("{wrong}\n{}", wrong.help),
        other => other.to_string(),
    }
}

fn style(context: &egui::Context) {
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

/// All that is there while a device is open.
struct Open {
    window: Arc<Window>,
    input: egui_winit::State,
    screen: Screen,
    backend: Backend,
    trace: Worker<Order>,
    paint: Worker<Painting>,
    hover: Worker<Question>,
    explain: Worker<Question>,
    panels: Panels,
    /// Colours by id, with the picture and the mode that they are for.
    palette: Option<((u64, Show), Arc<Words>)>,
    palettes: Pool,
    ordered: Option<Order>,
    painting: Option<(u64, Look)>,
    /// The last pixel that was asked for.
    hovered: Option<Question>,
    /// The time of the last frame, and the picture in it.
    drawn: Option<(Instant, u64)>,
}

struct App<N> {
    options: Options,
    proxy: EventLoopProxy<Event>,
    notify: N,
    state: State,
    open: Option<Open>,
    /// A window whose device was lost, and why.
    lost: Option<(Arc<Window>, Error)>,
    start: Instant,
    /// Counts devices.
    epoch: u64,
    /// Counts questions about pixels.
    asked: u64,
    losses: Vec<Instant>,
    saves: Vec<Save>,
    failure: Option<Error>,
    closing: Arc<Control>,
    watch: Worker<()>,
    /// Reads other scenes.
    reader: Worker<PathBuf>,
    context: egui::Context,
    frame: u64,
    wake: Option<Instant>,
}

impl<N: FnMut(&Notice)> ApplicationHandler<Event> for App<N> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.open.is_some() {
            return;
        }
        let opened = self.window(event_loop).and_then(|window| self.open(window));
        match opened {
            Ok(()) => self.remember(),
            Err(error) => self.fail(event_loop, error),
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if let StartCause::ResumeTimeReached { .. } = cause {
            self.request_redraw();
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if event == WindowEvent::Destroyed {
            // Nothing may be asked of it any more.
            self.close();
            self.lost = None;
            (self.notify)(&Notice::Destroyed);
            event_loop.exit();
        }
        let Some(open) = &mut self.open else { return };
        if event == WindowEvent::RedrawRequested {
            if let Err(error) = self.redraw(event_loop) {
                self.recover(event_loop, error);
            }
            return;
        }
        let response = open.input.on_window_event(&open.window, &event);
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(size) => open.screen.resize(size),
            _ => {}
        }
        if response.repaint {
            self.request_redraw();
        }
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, event: Event) {
        if let Err(error) = self.hear(event_loop, event) {
            self.recover(event_loop, error);
        }
        self.request_redraw();
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        event_loop.set_control_flow(match self.wake {
            Some(at) => ControlFlow::WaitUntil(at),
            None => ControlFlow::Wait,
        });
    }
}

impl<N: FnMut(&Notice)> App<N> {
    fn request_redraw(&self) {
        if let Some(open) = &self.open {
            open.window.request_redraw();
        }
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, error: Error) {
        self.failure = Some(error);
        event_loop.exit();
    }

    /// The size of a saved picture; `None` for that of the window.
    fn full_size(&self) -> Option<[u32; 2]> {
        let of_scene = |image: ImageSize| [image.width, image.height];
        self.options.size.or(self.state.scene.image.map(of_scene))
    }

    fn title(&self) -> String {
        let name = self.state.path.file_name().unwrap_or(self.state.path.as_os_str());
        format!("{} · Kugelblitz", name.display())
    }

    fn window(&self, event_loop: &ActiveEventLoop) -> Result<Arc<Window>> {
        let [width, height] = self.full_size().unwrap_or(DEFAULT_SIZE);
        let monitor = event_loop
            .primary_monitor()
            .or_else(|| event_loop.available_monitors().next())
            .filter(|monitor| monitor.size().width > 0);
        let scale = monitor.as_ref().map_or(1.0, |monitor| monitor.scale_factor());
        let bar = Widths::default().height(false, width as f32 / scale as f32);
        let bars = (f64::from(bar + LINES) * scale).round() as u32;
        let fits = |wanted: u32, there: u32| wanted.min((f64::from(there) * SCREEN_PART) as u32);
        let size = match monitor.map(|monitor| monitor.size()) {
            Some(there) => {
                PhysicalSize::new(fits(width, there.width), fits(height + bars, there.height))
            }
            None => PhysicalSize::new(width, height + bars),
        };
        let attributes =
            Window::default_attributes().with_title(self.title()).with_inner_size(size);
        event_loop.create_window(attributes).map(Arc::new).map_err(|error| {
            Error::NoAdapter(format!(
                "the window can't be opened: {error}; use `kugelblitz render`"
            ))
        })
    }

    /// Opens a device for the window, and the threads that work with it.
    fn open(&mut self, window: Arc<Window>) -> Result<()> {
        (self.notify)(&Notice::Opening);
        let pick = self.options.device.as_ref();
        let screen = Screen::open(pick.unwrap_or(&Pick::Best), &window)?;
        let gpu = Device::Gpu(Arc::clone(&screen.gpu));
        let (device, name) = match pick {
            Some(_) => (gpu.clone(), gpu.label()),
            None => (Device::Cpu, format!("the CPU, shown by {}", gpu.label())),
        };
        self.state.device = name;
        self.state.offered = device.kernels();
        let backend = Backend { screen: Arc::clone(&screen.gpu), device };
        let closing = Arc::clone(&self.closing);
        let trace = tracing::start(backend.clone(), closing, self.say(Said::Traced))?;
        let paint = painter::start(backend.clone(), self.say(Said::Painted))?;
        let hover = ask::start_hover(backend.device.clone(), self.say(Said::Hover))?;
        let explain = ask::start_explain(backend.device.clone(), self.say(Said::Explained))?;
        let input = egui_winit::State::new(
            self.context.clone(),
            ViewportId::ROOT,
            &window,
            Some(window.scale_factor() as f32),
            window.theme(),
            Some(screen.max_texture_side()),
        );
        let facts = &screen.gpu.facts;
        (self.notify)(&Notice::Opened { adapter: &facts.name, software: facts.is_software() });
        window.request_redraw();
        self.open = Some(Open {
            window,
            input,
            screen,
            backend,
            trace,
            paint,
            hover,
            explain,
            panels: Panels::default(),
            palette: None,
            palettes: Pool::default(),
            ordered: None,
            painting: None,
            hovered: None,
            drawn: None,
        });
        Ok(())
    }

    /// Passes messages of a thread that works with the device to the window.
    fn say<T: 'static>(&self, said: fn(T) -> Said) -> impl Fn(Result<T>) + Send + 'static {
        let (proxy, epoch) = (self.proxy.clone(), self.epoch);
        // The event loop is gone only when nobody is interested any more.
        move |message| drop(proxy.send_event(Event::Said(epoch, message.map(said))))
    }

    /// Gives up the device. What its threads have said is not heard any more.
    fn close(&mut self) {
        self.open = None;
        self.epoch += 1;
        self.state.explained.take_if(|explained| explained.text.is_none());
    }

    /// Tells what went wrong, and has a device opened anew after one was lost.
    fn recover(&mut self, event_loop: &ActiveEventLoop, error: Error) {
        if !matches!(error, Error::Device(_)) {
            let message = error.to_string();
            (self.notify)(&Notice::Trouble { message: &message });
            self.state.tell(message);
            return;
        }
        self.losses.retain(|at| at.elapsed() < SOON);
        self.losses.push(Instant::now());
        let Some(window) = self.open.as_ref().map(|open| Arc::clone(&open.window)) else { return };
        // The old surface must be gone before the window can have another.
        self.close();
        self.state.picture = None;
        self.state.painted = [None, None];
        if self.losses.len() > MOST_LOSSES {
            return self.fail(event_loop, error);
        }
        self.lost = Some((window, error));
        // Not at once: what was lost may be the window, and that is heard before.
        let _ = self.proxy.send_event(Event::Reopen);
    }

    fn reopen(&mut self, event_loop: &ActiveEventLoop) {
        let Some((window, error)) = self.lost.take() else { return };
        // Textures of the panels are gone with the device.
        self.context = self.fresh_context();
        let message = format!("The device was opened anew: {error}");
        (self.notify)(&Notice::Trouble { message: &message });
        self.state.tell(message);
        if let Err(error) = self.open(window) {
            self.fail(event_loop, error);
        }
    }

    /// A context without textures, with the old one's theme.
    fn fresh_context(&self) -> egui::Context {
        let context = egui::Context::default();
        style(&context);
        context.set_theme(self.context.options(|options| options.theme_preference));
        context
    }

    fn hear(&mut self, event_loop: &ActiveEventLoop, event: Event) -> Result<()> {
        match event {
            Event::Said(epoch, said) if epoch == self.epoch => self.hear_of_device(said?),
            // By a thread whose device is gone.
            Event::Said(..) => {}
            Event::Saved(path) => {
                if let Some(at) = self.saves.iter().position(|save| save.path == path) {
                    let save = self.saves.swap_remove(at);
                    return self.saved(save);
                }
            }
            // Of the scene before this one.
            Event::Scene(path, _) if path != self.state.path => {}
            Event::Scene(_, Ok((scene, camera))) => {
                self.state.reload(scene, camera);
                (self.notify)(&Notice::Reloaded);
            }
            Event::Scene(_, Err(error)) => {
                let error = in_words(error);
                (self.notify)(&Notice::SceneWrong { error: &error });
                self.state.scene_error = Some(error);
            }
            Event::Opened(path, Ok((scene, camera))) => {
                self.watch = watch_scene(&path, &self.options, &self.proxy)?;
                self.state.open(path, scene, camera);
                if let Some(open) = &self.open {
                    open.window.set_title(&self.title());
                }
                let path = self.state.path.clone();
                (self.notify)(&Notice::SceneOpened { path: &path });
                self.remember();
            }
            Event::Opened(path, Err(error)) => {
                let error = in_words(error);
                (self.notify)(&Notice::SceneWrong { error: &error });
                match &mut self.state.opening {
                    Some(dialog) => dialog.answer = Some(Err(error)),
                    None => self.state.tell(format!("{} can't be opened: {error}", path.display())),
                }
            }
            Event::Reopen => self.reopen(event_loop),
            Event::Interrupted => self.fail(event_loop, Error::Interrupted),
        }
        Ok(())
    }

    fn hear_of_device(&mut self, said: Said) {
        match said {
            Said::Traced(Traced::Picture(picture)) => self.state.picture = Some(picture),
            Said::Traced(Traced::More) => {}
            Said::Painted(painted) => {
                let place = painted.place;
                self.state.painted[place] = Some(painted);
            }
            Said::Hover(answer) => {
                self.state.answer(answer);
                let text = panels::hover_text(&self.state);
                (self.notify)(&Notice::Hover { text: &text });
            }
            Said::Explained((pixel, text)) => {
                if let Some(shown) = &mut self.state.explained
                    && [shown.question.x, shown.question.y] == pixel
                {
                    (self.notify)(&Notice::Explained { pixel, text: &text });
                    shown.text = Some(text);
                }
            }
        }
    }

    fn carry_out(&mut self, event_loop: &ActiveEventLoop, command: Command) {
        match command {
            Command::PrintCamera => {
                let toml = camera_text(&self.state.rig.camera);
                self.state.tell("The camera is copied as TOML, and printed on standard output");
                (self.notify)(&Notice::Camera { toml: &toml });
            }
            Command::Save => self.save(),
            Command::Open(path) => self.reader.ask(path),
            Command::Explain(question) => {
                self.asked += 1;
                let serial = self.asked;
                let asked = question.clone();
                self.state.explained = Some(Explained { question: asked, text: None, serial });
                if let Some(open) = &self.open {
                    open.explain.ask(question);
                }
            }
            Command::Hover(question) => self.hover(question),
            Command::Quit => event_loop.exit(),
        }
    }

    fn hover(&mut self, question: Question) {
        let Some(open) = &mut self.open else { return };
        let is_known = |last: &Question| {
            Arc::ptr_eq(&last.scene, &question.scene)
                && (last.pixels, last.kernel, last.x, last.y)
                    == (question.pixels, question.kernel, question.x, question.y)
        };
        if !open.hovered.as_ref().is_some_and(is_known) {
            open.hovered = Some(question.clone());
            open.hover.ask(question);
        }
    }

    fn save(&mut self) {
        let Some(open) = &self.open else { return };
        let state = &self.state;
        let size = self.full_size().unwrap_or([state.area.width, state.area.height]);
        let (scene, device) = (state.saved_scene(), open.backend.device.clone());
        let mut session = Session::new(scene, device, state.kernels[1]);
        session.set_camera(state.rig.camera.clone());
        let halves =
            state.compares.then_some(Halves { kernels: state.kernels, divider: state.divider });
        let path = free_name(Path::new("."), &state.path, state.show, halves, &self.saves);
        let control = Arc::clone(&self.options.control);
        let saving = Saving { session, size, show: state.show, halves, control };
        let proxy = self.proxy.clone();
        let done = move |path| drop(proxy.send_event(Event::Saved(path)));
        match Save::start(saving, path, done) {
            Ok(save) => self.saves.push(save),
            Err(error) => self.state.tell(format!("The picture can't be saved: {error}")),
        }
    }

    /// Keeps that the scene was opened.
    fn remember(&mut self) {
        let Some(list) = &self.options.recent else { return };
        match add_recent(list, &self.state.path) {
            Ok(recent) => self.state.recent = recent,
            Err(error) => {
                let message = format!("Recent files can't be kept: {error}");
                (self.notify)(&Notice::Trouble { message: &message });
            }
        }
    }

    /// Tells that a picture was saved.
    fn saved(&mut self, save: Save) -> Result<()> {
        let (path, size) = (save.path.clone(), save.size);
        save.end()?;
        (self.notify)(&Notice::Saved { path: &path, size });
        self.state.tell(format!("Saved {}: {} × {}", path.display(), size[0], size[1]));
        Ok(())
    }
}
