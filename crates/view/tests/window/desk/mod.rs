//! A desktop without a screen, and a window on it.

pub mod usage;

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use kugelblitz::scene::{Camera, parse_scene};
use kugelblitz_tests::{log_device, root};
use rustix::process::{Pid, Resource, Rlimit, Signal, WaitOptions, kill_process, prlimit, waitpid};
use serde_json::Value;
use tempfile::TempDir;
use x11rb::connection::Connection;
use x11rb::protocol::Event as XEvent;
use x11rb::protocol::xproto::{
    Atom, AtomEnum, ClientMessageEvent, ConnectionExt, CreateWindowAux, EventMask, ImageFormat,
    PropMode, SELECTION_NOTIFY_EVENT, SelectionNotifyEvent, SelectionRequestEvent, Window,
    WindowClass,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

/// Longer than this, nothing takes on any machine.
const PATIENCE: Duration = Duration::from_secs(90);

/// Between two looks at the screen.
const LOOK: Duration = Duration::from_millis(30);

/// Where the window's standard error goes.
const STDERR: &str = "stderr.txt";

/// A scene of the repository.
pub fn scene(name: &str) -> PathBuf {
    root().join(format!("scenes/{name}.toml"))
}

/// The program `kugelblitz`, whose command `view` starts that of the window.
pub fn kugelblitz() -> PathBuf {
    let beside = Path::new(env!("CARGO_BIN_EXE_kugelblitz-view")).with_file_name("kugelblitz");
    assert!(
        beside.is_file(),
        "{} is missing: cargo build --profile ci -p kugelblitz-cli",
        beside.display()
    );
    beside
}

/// The program with this display, in this folder.
pub fn program(display: &str, folder: &Path) -> Command {
    // A write beyond a limit of the file's size fails, and does not end the program.
    let mut command = Command::new("sh");
    command
        .args(["-c", "trap '' XFSZ; exec \"$0\" \"$@\""])
        .arg(kugelblitz())
        .current_dir(folder)
        .env("DISPLAY", display)
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        // Without it, Mesa has something to say.
        .env_remove("XDG_RUNTIME_DIR")
        .env_remove("WGPU_ADAPTER_NAME")
        .stdin(Stdio::null());
    command
}

fn need(program: &str, error: &std::io::Error) -> ! {
    panic!("{program} can't be run: {error}; ci/setup.sh --tests installs it")
}

/// An X server without a screen.
pub struct Desk {
    server: Child,
    display: String,
    wayland: Option<Compositor>,
    /// Two cores are enough for one window at a time.
    _alone: MutexGuard<'static, ()>,
}

impl Desk {
    pub fn new() -> Desk {
        static ALONE: Mutex<()> = Mutex::new(());
        let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
        // The server chooses a free number and tells it.
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1400x900x24", "-nolisten", "tcp"])
            // Else it resets when a window closes, and the next one may come just then.
            .arg("-noreset")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap_or_else(|error| need("Xvfb", &error));
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        assert!(!number.trim().is_empty(), "Xvfb did not start");
        let display = format!(":{}", number.trim());
        Desk { server, display, wayland: None, _alone: alone }
    }

    /// With a Wayland compositor: its screen is a window of the X server, and a window of the program
    /// fills it.
    pub fn with_wayland() -> Desk {
        let mut desk = Desk::new();
        desk.wayland = Some(Compositor::new(&desk.display));
        desk
    }

    /// The X server or the compositor ends, as when somebody logs out.
    pub fn end(&mut self) {
        if self.wayland.take().is_some() {
            return;
        }
        let _ = self.server.kill();
        let _ = self.server.wait();
    }

    /// The program on this desk, in this folder.
    pub fn program(&self, folder: &Path) -> Command {
        let Some(wayland) = &self.wayland else { return program(&self.display, folder) };
        let mut command = program("", folder);
        command.env("WAYLAND_DISPLAY", wayland.folder.path().join(SOCKET));
        command.env("XDG_RUNTIME_DIR", wayland.folder.path());
        command
    }

    /// What xdotool finds the X window by that shows the program.
    fn window(&self) -> [&'static str; 2] {
        match self.wayland {
            Some(_) => ["--class", "weston"],
            None => ["--name", "Kugelblitz"],
        }
    }
}

const SOCKET: &str = "wayland";

/// Weston.
struct Compositor {
    weston: Child,
    folder: TempDir,
}

impl Compositor {
    fn new(display: &str) -> Compositor {
        // Others may not look into it: a rule for this folder.
        let folder = tempfile::tempdir().unwrap();
        let mut weston = Command::new("weston")
            .args(["--no-config", "--backend=x11-backend.so", "--use-pixman"])
            .args(["--width=1400", "--height=900", "--shell=kiosk-shell.so"])
            .arg(format!("--socket={SOCKET}"))
            .env("DISPLAY", display)
            .env("XDG_RUNTIME_DIR", folder.path())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap_or_else(|error| need("weston", &error));
        let end = Instant::now() + PATIENCE;
        while !folder.path().join(SOCKET).exists() {
            assert!(Instant::now() < end, "weston did not start");
            assert!(weston.try_wait().unwrap().is_none(), "weston has ended");
            std::thread::sleep(LOOK);
        }
        Compositor { weston, folder }
    }
}

impl Drop for Compositor {
    fn drop(&mut self) {
        let _ = self.weston.kill();
        let _ = self.weston.wait();
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        self.wayland = None;
        self.end();
    }
}

/// RGB pixels.
#[derive(Clone, PartialEq)]
pub struct Image {
    width: u32,
    pixels: Vec<[u8; 3]>,
}

impl Image {
    pub fn open(path: &Path) -> Image {
        let image = image::open(path).unwrap().into_rgb8();
        Image { width: image.width(), pixels: image.pixels().map(|pixel| pixel.0).collect() }
    }

    pub fn at(&self, x: u32, y: u32) -> [u8; 3] {
        self.pixels[(y * self.width + x) as usize]
    }
}

/// The picture that `render` draws of a scene seen by another camera.
pub fn render(scene: &Path, camera: &str, size: [u32; 2], kernel: &str) -> Image {
    render_show(scene, camera, size, kernel, "color")
}

/// The picture that `render` draws in a mode of `--show` of a scene seen by another camera.
pub fn render_show(
    scene: &Path,
    camera: &str,
    [width, height]: [u32; 2],
    kernel: &str,
    show: &str,
) -> Image {
    let folder = tempfile::tempdir().unwrap();
    let text = with_camera(&fs::read_to_string(scene).unwrap(), camera);
    let [path, picture] = ["scene.toml", "picture.png"].map(|name| folder.path().join(name));
    fs::write(&path, text).unwrap();
    let size = format!("{width}x{height}");
    let output = program("", folder.path())
        .args(["render", "scene.toml", "-o", "picture.png", "--size", &size, "--kernel", kernel])
        .args(["--show", show])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Image::open(&picture)
}

/// The scene with this table `[camera]` in place of its own.
fn with_camera(scene: &str, camera: &str) -> String {
    let (before, after) = scene.split_once("[camera]").unwrap();
    let rest = after.find("\n[").map_or("", |at| &after[at..]);
    format!("{before}{camera}{rest}")
}

/// The camera of a table `[camera]`.
pub fn camera_of(toml: &str) -> Camera {
    parse_scene(toml, Path::new("camera.toml")).unwrap().camera.unwrap()
}

/// Leaves a line in `gpu-tests.log`, which `ci/test.sh` reads.
pub fn log_gpu(test: &str, seen: &Seen) {
    let opened = seen.log.iter().find(|event| event.name() == "opened").expect("a device");
    let adapter = opened.0["adapter"].as_str().unwrap();
    log_device(&format!("{test} on {adapter} (in a window)"));
}

/// A line of --log-events.
#[derive(Clone, Debug)]
pub struct Event(Value);

impl Event {
    pub fn name(&self) -> &str {
        self.0["event"].as_str().unwrap()
    }

    fn field(&self, name: &str) -> &str {
        self.0[name].as_str().unwrap_or_default()
    }

    pub fn show(&self) -> &str {
        self.field("show")
    }

    pub fn text(&self) -> &str {
        self.field("text")
    }

    pub fn error(&self) -> &str {
        self.field("error")
    }

    pub fn path(&self) -> &str {
        self.field("path")
    }

    pub fn message(&self) -> &str {
        self.field("message")
    }

    pub fn hover(&self) -> Option<&str> {
        (self.name() == "hover").then(|| self.text())
    }

    pub fn is_settled(&self) -> bool {
        self.0["settled"] == true
    }

    pub fn kernels(&self) -> Vec<&str> {
        let kernels = self.0["kernels"].as_array();
        kernels.map_or_else(Vec::new, |all| all.iter().filter_map(Value::as_str).collect())
    }

    pub fn is_lit(&self) -> bool {
        self.0["lit"] == true
    }

    pub fn number(&self, name: &str) -> u64 {
        self.0[name].as_u64().unwrap()
    }

    pub fn pixel(&self) -> [u32; 2] {
        serde_json::from_value(self.0["pixel"].clone()).unwrap_or_default()
    }

    pub fn area(&self) -> [u32; 4] {
        serde_json::from_value(self.0["area"].clone()).unwrap_or_default()
    }
}

/// A window of the program, and everything that it said.
pub struct Seen {
    child: Child,
    display: String,
    x: RustConnection,
    pub window: Window,
    events: Receiver<Value>,
    pub log: Vec<Event>,
    folder: TempDir,
}

impl Seen {
    /// Opens a scene and waits until its picture is there.
    pub fn open(desk: &Desk, scene: &Path, args: &[&str]) -> Seen {
        let folder = tempfile::tempdir().unwrap();
        let mut command = desk.program(folder.path());
        command.arg("view").arg(scene).args(args).arg("--log-events").stdout(Stdio::piped());
        command.stderr(fs::File::create(folder.path().join(STDERR)).unwrap());
        let mut child = command.spawn().unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let (say, events) = channel();
        std::thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                // Vulkan's validation layers print as well.
                let event = serde_json::from_str(&line)
                    .unwrap_or_else(|_| serde_json::json!({ "event": "printed", "text": line }));
                if say.send(event).is_err() {
                    break;
                }
            }
        });
        let (x, _) = RustConnection::connect(Some(&desk.display)).unwrap();
        let mut seen = Seen {
            child,
            display: desk.display.clone(),
            x,
            window: 0,
            events,
            log: Vec::new(),
            folder,
        };
        seen.wait(Event::is_settled);
        let [by, name] = desk.window();
        let found = seen.ask_xdotool(&["search", "--onlyvisible", by, name]);
        seen.window = found.lines().last().expect("a window").parse().unwrap();
        // Without a window manager nobody gives it the keyboard.
        seen.xdotool(&["windowfocus", "--sync", &seen.window.to_string()]);
        if desk.wayland.is_some() {
            // A compositor may not give the keyboard to a window that comes up while it gets the keyboard itself; a click
            // gives it, here on the status line, where it does nothing else.
            let [left, top, width, height] = seen.area();
            seen.point([left + width / 2, top + height + 10]);
            seen.xdotool(&["click", "1"]);
        }
        seen
    }

    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    fn ask_xdotool(&self, args: &[&str]) -> String {
        let output = Command::new("xdotool")
            .args(args)
            .env("DISPLAY", &self.display)
            .output()
            .unwrap_or_else(|error| need("xdotool", &error));
        assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    pub fn xdotool(&self, args: &[&str]) {
        self.ask_xdotool(args);
    }

    pub fn key(&self, key: &str) {
        self.xdotool(&["key", key]);
    }

    /// The next event that `is_it`; all before it are only logged.
    #[track_caller]
    pub fn wait(&mut self, is_it: impl Fn(&Event) -> bool) -> Event {
        let end = Instant::now() + PATIENCE;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let Ok(value) = self.events.recv_timeout(left) else {
                let tail = &self.log[self.log.len().saturating_sub(12)..];
                panic!("it did not come; the last events:\n{tail:#?}");
            };
            let event = self.note(value);
            if is_it(&event) {
                return event;
            }
        }
    }

    /// The last frame.
    pub fn last_shown(&self) -> &Event {
        self.log.iter().rfind(|event| event.name() == "shown").expect("a frame")
    }

    /// Does something that changes the camera or the size, and waits until the new picture is
    /// there.
    #[track_caller]
    pub fn moves(&mut self, act: impl FnOnce(&Seen)) {
        let asked = self.last_shown().number("asked");
        act(self);
        self.wait(|event| event.is_settled() && event.number("picture") > asked);
    }

    /// Where the picture is in the window.
    pub fn area(&self) -> [u32; 4] {
        self.last_shown().area()
    }

    /// The window's point at a pixel of the picture.
    pub fn at(&self, x: u32, y: u32) -> [u32; 2] {
        let [left, top, ..] = self.area();
        [left + x, top + y]
    }

    pub fn point(&self, [x, y]: [u32; 2]) {
        let window = self.window.to_string();
        self.xdotool(&["mousemove", "--window", &window, &x.to_string(), &y.to_string()]);
    }

    /// Drags in steps, as a hand does, and waits until the last picture of it is there.
    #[track_caller]
    pub fn drag(&mut self, from: [u32; 2], to: [u32; 2], button: u32, held: Option<&str>) {
        self.pull(from, to, button, held);
        self.catch_up();
    }

    /// Drags in steps.
    pub fn pull(&self, from: [u32; 2], to: [u32; 2], button: u32, held: Option<&str>) {
        let (window, button) = (self.window.to_string(), button.to_string());
        let mut args: Vec<String> = Vec::new();
        let mut add = |some: &[&str]| args.extend(some.iter().map(|&arg| arg.to_owned()));
        let held = |act| held.map(|key| [act, key]);
        add(held("keydown").as_ref().map_or(&[], |held| held));
        for step in 0..=10 {
            let between = |axis: usize| (from[axis] * (10 - step) + to[axis] * step) / 10;
            let [x, y] = [0, 1].map(|axis| between(axis).to_string());
            add(&["mousemove", "--window", &window, &x, &y]);
            if step == 0 {
                add(&["mousedown", &button]);
            }
        }
        add(&["mouseup", &button]);
        add(held("keyup").as_ref().map_or(&[], |held| held));
        self.xdotool(&args.iter().map(String::as_str).collect::<Vec<_>>());
    }

    /// All that is done in `act` comes in one frame of the window.
    pub fn at_once(&self, act: impl FnOnce(&Seen)) {
        let pid = Pid::from_child(&self.child);
        kill_process(pid, Signal::STOP).unwrap();
        waitpid(Some(pid), WaitOptions::UNTRACED).unwrap();
        act(self);
        kill_process(pid, Signal::CONT).unwrap();
    }

    pub fn drag_divider(&self, from: u32, to: u32) {
        let [from, to] = [from, to].map(|x| self.at(x, 60));
        self.pull(from, to, 1, None);
    }

    /// Waits until all that was done so far is done, and its picture is there: P is answered after what came before it.
    #[track_caller]
    fn catch_up(&mut self) {
        self.camera();
        self.wait(Event::is_settled);
    }

    fn note(&mut self, value: Value) -> Event {
        let event = Event(value);
        self.log.push(event.clone());
        event
    }

    /// Back to the file's camera.
    #[track_caller]
    pub fn reset(&mut self) {
        self.key("r");
        self.catch_up();
    }

    /// The camera that P prints.
    #[track_caller]
    pub fn camera(&mut self) -> String {
        self.key("p");
        self.wait(|event| event.name() == "camera").field("toml").to_owned()
    }

    /// Waits until the status line tells of this.
    #[track_caller]
    pub fn hovers(&mut self, text: &str) -> Event {
        self.wait(|event| event.hover().is_some_and(|shown| shown.contains(text)))
    }

    #[track_caller]
    pub fn resize(&mut self, width: u32, height: u32) {
        self.xdotool(&[
            "windowsize",
            &self.window.to_string(),
            &width.to_string(),
            &height.to_string(),
        ]);
        self.wait(|event| event.is_settled() && event.area()[2] == width);
    }

    /// The pixels of the window where the picture is.
    pub fn image(&self) -> Image {
        let [left, top, width, height] = self.area();
        let all = u32::MAX;
        let [x, y] = [left, top].map(|px| px as i16);
        let [w, h] = [width, height].map(|px| px as u16);
        let request = self.x.get_image(ImageFormat::Z_PIXMAP, self.window, x, y, w, h, all);
        let reply = request.unwrap().reply().unwrap();
        let pixels = reply.data.chunks_exact(4).map(|bgrx| [bgrx[2], bgrx[1], bgrx[0]]).collect();
        Image { width, pixels }
    }

    /// Looks at the window until it is as `is_it` wants.
    #[track_caller]
    pub fn wait_until(&mut self, what: &str, is_it: impl Fn(&Seen) -> bool) {
        let end = Instant::now() + PATIENCE;
        while !is_it(self) {
            assert!(Instant::now() < end, "{what} did not come");
            std::thread::sleep(LOOK);
        }
    }

    #[track_caller]
    pub fn wait_for(&mut self, what: &str, is_it: impl Fn(&Image) -> bool) -> Image {
        let found = std::cell::RefCell::new(None);
        self.wait_until(what, |seen| {
            let image = seen.image();
            let fits = is_it(&image);
            if fits {
                *found.borrow_mut() = Some(image);
            }
            fits
        });
        found.into_inner().expect("an image")
    }

    /// Looks at the window until each pixel of the picture is as expected.
    #[track_caller]
    pub fn wait_for_picture(&mut self, expected: &Image) -> Image {
        let end = Instant::now() + PATIENCE;
        loop {
            let image = self.image();
            if image == *expected {
                return image;
            }
            if Instant::now() > end {
                let n = image.pixels.iter().zip(&expected.pixels).filter(|(a, b)| a != b).count();
                let first = image.pixels.iter().zip(&expected.pixels).position(|(a, b)| a != b);
                let first = first.map(|i| (i % image.width as usize, i / image.width as usize));
                panic!("{n} of {} pixels differ, first {first:?}", expected.pixels.len());
            }
            std::thread::sleep(LOOK);
        }
    }

    fn atom(&self, name: &str) -> Atom {
        self.x.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom
    }

    /// Creates an invisible window, which takes part in what programs exchange.
    fn helper_window(&self) -> Window {
        let (x, window) = (&self.x, self.x.generate_id().unwrap());
        let root = x.setup().roots[0].root;
        let depth = x11rb::COPY_DEPTH_FROM_PARENT;
        let aux = CreateWindowAux::new().event_mask(EventMask::PROPERTY_CHANGE);
        let class = WindowClass::INPUT_OUTPUT;
        x.create_window(depth, window, root, 0, 0, 1, 1, 0, class, 0, &aux).unwrap();
        window
    }

    fn send_message(&self, kind: &str, data: [u32; 5]) {
        let message = ClientMessageEvent::new(32, self.window, self.atom(kind), data);
        self.x.send_event(false, self.window, EventMask::NO_EVENT, message).unwrap();
        self.x.flush().unwrap();
    }

    /// Drops a file on the window as a file manager does, by version 5 of the protocol XDND.
    pub fn drop_file(&self, path: &Path) {
        const VERSION: u32 = 5;
        let (x, source, time) = (&self.x, self.helper_window(), x11rb::CURRENT_TIME);
        let (selection, list) = (self.atom("XdndSelection"), self.atom("text/uri-list"));
        x.set_selection_owner(source, selection, time).unwrap();
        self.send_message("XdndEnter", [source, VERSION << 24, list, 0, 0]);
        self.send_message("XdndPosition", [source, 0, 0, time, self.atom("XdndActionCopy")]);
        // The window asks for the path while the file is over it.
        let request = loop {
            if let XEvent::SelectionRequest(request) = x.wait_for_event().unwrap() {
                break request;
            }
        };
        let SelectionRequestEvent { requestor, target, property, .. } = request;
        let text = format!("file://{}\r\n", path.display());
        x.change_property8(PropMode::REPLACE, requestor, property, target, text.as_bytes())
            .unwrap();
        let answer = SelectionNotifyEvent {
            response_type: SELECTION_NOTIFY_EVENT,
            sequence: 0,
            time,
            requestor,
            selection,
            target,
            property,
        };
        x.send_event(false, requestor, EventMask::NO_EVENT, answer).unwrap();
        self.send_message("XdndDrop", [source, 0, time, 0, 0]);
    }

    /// The text in the clipboard.
    pub fn clipboard(&self) -> String {
        let (x, window) = (&self.x, self.helper_window());
        let (selection, target) = (self.atom("CLIPBOARD"), self.atom("UTF8_STRING"));
        let end = Instant::now() + PATIENCE;
        while Instant::now() < end {
            let time = x11rb::CURRENT_TIME;
            x.convert_selection(window, selection, target, selection, time).unwrap();
            x.flush().unwrap();
            loop {
                match x.wait_for_event().unwrap() {
                    XEvent::SelectionNotify(notify) if notify.property != 0 => {
                        let property = x
                            .get_property(true, window, selection, AtomEnum::ANY, 0, u32::MAX / 4)
                            .unwrap()
                            .reply()
                            .unwrap();
                        return String::from_utf8(property.value).unwrap();
                    }
                    // Nobody owns it yet.
                    XEvent::SelectionNotify(_) => break,
                    _ => {}
                }
            }
            std::thread::sleep(LOOK);
        }
        panic!("nothing came into the clipboard");
    }

    /// Sends what a click on the window's close button does.
    pub fn close(mut self) {
        self.send_message("WM_PROTOCOLS", [self.atom("WM_DELETE_WINDOW"), 0, 0, 0, 0]);
        self.assert_ended();
    }

    /// Ctrl + Q.
    pub fn quit(mut self) {
        self.key("ctrl+q");
        self.assert_ended();
    }

    /// Moves the camera from now on.
    pub fn keep_moving(&self) {
        self.xdotool(&["keydown", "d"]);
    }

    pub fn stderr(&self) -> String {
        fs::read_to_string(self.folder.path().join(STDERR)).unwrap()
    }

    /// Waits for the end; gives the exit code, with all that was said until then noted.
    #[track_caller]
    pub fn exit_code(&mut self) -> Option<i32> {
        let status = self.ended();
        while let Ok(value) = self.events.recv_timeout(PATIENCE) {
            self.note(value);
        }
        assert!(!self.stderr().contains("panicked"), "{}", self.stderr());
        status.code()
    }

    #[track_caller]
    fn assert_ended(&mut self) {
        let status = self.ended();
        assert!(status.success(), "{status}");
        // Mesa has said something, and nobody asked for it.
        assert!(!self.stderr().contains("XDG_RUNTIME_DIR"), "{}", self.stderr());
        let trouble = self.log.iter().filter(|event| event.name() == "trouble");
        let trouble: Vec<_> =
            trouble.filter(|event| !event.message().contains("as asked for")).collect();
        assert!(trouble.is_empty(), "{trouble:?}");
        let printed: Vec<_> =
            self.log.iter().filter(|event| event.name() == "printed").map(Event::text).collect();
        assert!(printed.is_empty(), "{printed:#?}");
    }

    /// From now on the program can write no file of more than `bytes`.
    pub fn allow_files_of(&self, bytes: u64) {
        let limit = Rlimit { current: Some(bytes), maximum: None };
        prlimit(Some(Pid::from_child(&self.child)), Resource::Fsize, limit).unwrap();
    }

    fn ended(&mut self) -> ExitStatus {
        let end = Instant::now() + PATIENCE;
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return status;
            }
            assert!(Instant::now() < end, "the window does not close");
            std::thread::sleep(LOOK);
        }
    }

    /// Memory of the process, MiB.
    fn memory(&self) -> f64 {
        let status = fs::read_to_string(format!("/proc/{}/status", self.child.id())).unwrap();
        let line = status.lines().find(|line| line.starts_with("VmRSS:")).unwrap();
        let kib: f64 = line.split_whitespace().nth(1).unwrap().parse().unwrap();
        kib / 1024.0
    }
}

impl Drop for Seen {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("{}", self.stderr());
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
