//! The event loop.

mod device;
mod events;
mod frame;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use winit::application::ApplicationHandler;
use winit::error::EventLoopError;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::WindowId;

use self::device::Open;
use super::ask::Answer;
use super::display::{display_lost, no_display};
use super::notice::Notice;
use super::painter::Painted;
use super::recent::recent;
use super::reload::watch;
use super::save::Save;
use super::state::State;
use super::tracing::Traced;
use super::worker::Worker;
use crate::control::Control;
use crate::error::{Error, Result};
use crate::gpu::Pick;
use crate::plain::Shown;
use crate::scene::{Camera, ImageSize, Scene};
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
    /// Gives the device up after so many frames, as if it had been lost: for tests.
    pub lose_device_after: Option<u64>,
}

/// A message of another thread.
enum Event {
    /// Of a thread that works with the device.
    Said(Result<Said>),
    /// The picture in this file is saved, or can't be.
    Saved(PathBuf),
    /// The scene file was read again.
    Scene(PathBuf, Read),
    /// Another scene file was read.
    Opened(PathBuf, Read),
    Interrupted,
    /// The device is gone, and why.
    Lost(Error),
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
/// [`Error::Scene`] for a scene without a camera, [`Error::Device`] when the device is lost,
/// [`Error::Io`] when the display is lost, [`Error::Interrupted`] when the control was
/// cancelled; those of [`Session::render_to_file`](crate::Session::render_to_file) where a picture was still being saved.
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
        is_lost: false,
        start: Instant::now(),
        asked: 0,
        saves: Vec::new(),
        failure: None,
        context: egui::Context::default(),
        frame: 0,
        wake: None,
    };
    style(&app.context);
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

struct App<N> {
    options: Options,
    proxy: EventLoopProxy<Event>,
    notify: N,
    state: State,
    open: Option<Open>,
    /// Whether its device is gone.
    is_lost: bool,
    start: Instant,
    /// Counts questions about pixels.
    asked: u64,
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
            self.open = None;
            (self.notify)(&Notice::Destroyed);
            event_loop.exit();
        }
        let Some(open) = self.open.as_mut().filter(|_| !self.is_lost) else { return };
        if event == WindowEvent::RedrawRequested {
            if let Err(error) = self.redraw(event_loop) {
                self.trouble(error);
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
            self.trouble(error);
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
        format!("{} · Kugelblitz", Path::new(name).shown())
    }
}
