//! The report's page as a browser shows it.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use base64::Engine;
use kugelblitz_report::page;
use kugelblitz_tests::made_report::whole_report;
use serde_json::{Value, json};
use tempfile::TempDir;

const INSTALL: &str = "Chromium is missing: apt-get install chromium, or ci/setup.sh --tests";

/// Chromium without a window, which listens to two pipes in the Chrome DevTools Protocol: JSON between
/// zero bytes.
struct Browser {
    child: Arc<Mutex<Child>>,
    to: File,
    from: File,
    unread: Vec<u8>,
    session: String,
    n_calls: u64,
    /// What the page complained about.
    complaints: Vec<String>,
    folder: TempDir,
}

impl Browser {
    fn start() -> Browser {
        let folder = tempfile::tempdir().unwrap();
        for pipe in ["to", "from"] {
            assert!(
                Command::new("mkfifo").arg(folder.path().join(pipe)).status().unwrap().success()
            );
        }
        let there = Command::new("chromium").arg("--version").stderr(Stdio::null()).output();
        assert!(there.is_ok_and(|output| output.status.success()), "{INSTALL}");
        let child = Command::new("sh")
            .args(["-c", "exec chromium \"$@\" 3<to 4>from", "sh"])
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic"])
            .args(["--no-first-run", "--disable-background-networking"])
            .args(["--disable-component-update", "--disable-sync", "--remote-debugging-pipe"])
            .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
            .arg("about:blank")
            .current_dir(&folder)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let child = Arc::new(Mutex::new(child));
        let watched = Arc::clone(&child);
        // A browser that hangs would hang the test.
        std::thread::spawn(move || {
            std::thread::sleep(Duration::from_secs(120));
            let _ = watched.lock().unwrap().kill();
        });
        let to = File::options().write(true).open(folder.path().join("to")).unwrap();
        let from = File::open(folder.path().join("from")).unwrap();
        let mut browser = Browser {
            child,
            to,
            from,
            unread: Vec::new(),
            session: String::new(),
            n_calls: 0,
            complaints: Vec::new(),
            folder,
        };
        let target = browser.call("Target.createTarget", json!({"url": "about:blank"}));
        let target = json!({"targetId": target["targetId"], "flatten": true});
        let session = browser.call("Target.attachToTarget", target);
        browser.session = session["sessionId"].as_str().unwrap().to_string();
        for domain in ["Page", "Log", "Runtime"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        browser
    }

    fn message(&mut self) -> Value {
        loop {
            if let Some(end) = self.unread.iter().position(|byte| *byte == 0) {
                let message: Vec<u8> = self.unread.drain(..=end).collect();
                return serde_json::from_slice(&message[..end]).unwrap();
            }
            let mut bytes = [0; 1 << 16];
            let n = self.from.read(&mut bytes).unwrap();
            assert!(n > 0, "the browser ended or took two minutes");
            self.unread.extend(&bytes[..n]);
        }
    }

    fn call(&mut self, method: &str, params: Value) -> Value {
        self.try_call(method, params).unwrap_or_else(|error| panic!("{method}: {error}"))
    }

    fn try_call(&mut self, method: &str, params: Value) -> Result<Value, Value> {
        self.n_calls += 1;
        let mut request = json!({"id": self.n_calls, "method": method, "params": params});
        if !self.session.is_empty() {
            request["sessionId"] = self.session.as_str().into();
        }
        self.to.write_all(format!("{request}\0").as_bytes()).unwrap();
        loop {
            let mut message = self.message();
            if message["id"] == self.n_calls {
                return match message["error"].is_null() {
                    true => Ok(message["result"].take()),
                    false => Err(message),
                };
            }
            let is_complaint = match message["method"].as_str() {
                Some("Log.entryAdded") => message["params"]["entry"]["level"] == "error",
                Some("Runtime.consoleAPICalled") => message["params"]["type"] == "error",
                Some("Runtime.exceptionThrown") => true,
                _ => false,
            };
            if is_complaint {
                self.complaints.push(message["params"].to_string());
            }
        }
    }

    /// The value of an expression of JavaScript.
    fn value(&mut self, expression: &str) -> Value {
        let params = json!({"expression": expression, "returnByValue": true});
        let mut result = self.call("Runtime.evaluate", params);
        assert!(result["exceptionDetails"].is_null(), "{expression}: {result}");
        result["result"]["value"].take()
    }

    fn open(&mut self, html: &str, width: u32, theme: &str) {
        let size = json!({"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": false});
        self.call("Emulation.setDeviceMetricsOverride", size);
        self.call(
            "Emulation.setEmulatedMedia",
            json!({"features": [
                {"name": "prefers-color-scheme", "value": theme}
            ]}),
        );
        let name = format!("page{}.html", self.n_calls);
        let path = self.folder.path().join(&name);
        fs::write(&path, html).unwrap();
        self.complaints.clear();
        self.call("Page.navigate", json!({"url": format!("file://{}", path.display())}));
        let loaded =
            format!("document.readyState == 'complete' && location.href.endsWith('{name}')");
        let start = Instant::now();
        let params = json!({"expression": loaded, "returnByValue": true});
        // Amid the change from page to page there is nobody to ask.
        while !self
            .try_call("Runtime.evaluate", params.clone())
            .is_ok_and(|result| result["result"]["value"] == true)
        {
            assert!(start.elapsed() < Duration::from_secs(60), "the page never was loaded");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Moves the mouse over the middle of an element, and tells what is below it.
    fn titled_below_mouse(&mut self, element: &str) -> Value {
        let at = self.value(&format!(
            "(() => {{ const e = {element}; e.scrollIntoView({{block: 'center'}}); \
             const r = e.getBoundingClientRect(); \
             return [r.x + r.width / 2, r.y + r.height / 2]; }})()"
        ));
        let params = json!({"type": "mouseMoved", "x": at[0], "y": at[1]});
        self.call("Input.dispatchMouseEvent", params);
        self.value("[...document.querySelectorAll('g:hover > title')].pop()?.textContent ?? ''")
    }

    /// The page as a picture, where a person wants to look at it.
    fn shoot(&mut self, width: u32, name: &str) {
        let Some(folder) = std::env::var_os("KUGELBLITZ_SHOTS") else { return };
        let height = self.value("document.documentElement.scrollHeight");
        let clip = json!({"x": 0, "y": 0, "width": width, "height": height, "scale": 1});
        let params = json!({"captureBeyondViewport": true, "clip": clip});
        let picture = self.call("Page.captureScreenshot", params);
        let picture = picture["data"].as_str().unwrap();
        let bytes = base64::engine::general_purpose::STANDARD.decode(picture).unwrap();
        fs::write(Path::new(&folder).join(name), bytes).unwrap();
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let mut child = self.child.lock().unwrap();
        let _ = child.kill();
        let _ = child.wait();
    }
}

/// The marks of the plots that are shown.
const MARKS: &str = "[...document.querySelectorAll('.plot g > title')]\
    .map(t => t.parentElement).filter(g => g.getClientRects().length)";

/// What is wrong with a page at a width in a theme.
fn faults(browser: &mut Browser, html: &str, width: u32, theme: &str) -> Vec<String> {
    browser.open(html, width, theme);
    let mut faults: Vec<String> =
        browser.complaints.iter().map(|complaint| format!("console: {complaint}")).collect();
    let scroll = browser
        .value("document.documentElement.scrollWidth - document.documentElement.clientWidth");
    if scroll.as_f64() != Some(0.0) {
        faults.push(format!("scrolls sideways by {scroll} px"));
    }
    // Letters have 13 px in a plot's own measure. It is scrolled in its box where that is narrower.
    let plots = browser.value(
        "[...document.querySelectorAll('svg.plot')]\
         .map(e => [e, e.getBoundingClientRect(), e.parentElement.getBoundingClientRect()])\
         .filter(([_, r]) => r.width > 0)\
         .map(([e, r, b]) => [b.left, b.right, 13 * r.width / e.viewBox.baseVal.width])",
    );
    let plots = plots.as_array().unwrap();
    if plots.is_empty() {
        faults.push("no plot is shown".into());
    }
    for plot in plots {
        let [left, right, letters] = [0, 1, 2].map(|i| plot[i].as_f64().unwrap());
        if left < 0.0 || right > f64::from(width) {
            faults.push(format!("a plot from {left} to {right} px"));
        }
        if letters < 11.0 {
            faults.push(format!("letters of {letters} px in a plot"));
        }
    }
    let n_marks = browser.value(&format!("{MARKS}.length")).as_u64().unwrap();
    if n_marks < 20 {
        faults.push(format!("{n_marks} marks with a tooltip"));
    }
    // The middle of a mark: of its shape, for its title has no place.
    let shape = |i: u64| format!("{MARKS}[{i}].querySelector('circle, rect, polygon')");
    for i in [0, n_marks / 2, n_marks.saturating_sub(1)].into_iter().filter(|i| *i < n_marks) {
        let title = browser.titled_below_mouse(&shape(i));
        if !title.as_str().is_some_and(|title| title.contains(", ")) {
            faults.push(format!("no tooltip over mark {i}: {title}"));
        }
    }
    // Lightness of text and paper, 0 to 1, on the page and in a plot.
    let colors = browser.value(
        "(() => { const plot = [...document.querySelectorAll('.plot')]\
           .find(e => e.getClientRects().length); \
         const light = c => { const [r, g, b] = c.match(/[0-9.]+/g).map(Number); \
           return (0.2126 * r + 0.7152 * g + 0.0722 * b) / 255; }; \
         const of = (e, what) => e ? light(getComputedStyle(e)[what]) : 0.5; \
         return [of(document.body, 'color'), of(document.body, 'backgroundColor'), \
           of(plot?.querySelector('text.ink'), 'color'), of(plot?.querySelector('.paper'), 'color')]; })()",
    );
    let is_dark = theme == "dark";
    for (i, what) in
        ["the page's text", "the page", "a plot's text", "a plot's paper"].iter().enumerate()
    {
        let lightness = colors[i].as_f64().unwrap();
        // Text is the other way round.
        let is_light = lightness > 0.5;
        if (is_light == is_dark) == (i % 2 == 1) || (0.2..0.8).contains(&lightness) {
            faults.push(format!("{theme} theme: {what} has lightness {lightness:.2}"));
        }
    }
    faults
}

#[test]
fn a_browser_shows_the_report_on_telephones_and_desktops() {
    let browser = &mut Browser::start();
    let whole = page::html(&whole_report());
    for width in [400, 1280] {
        for theme in ["light", "dark"] {
            let found = faults(browser, &whole, width, theme);
            browser.shoot(width, &format!("report-{width}-{theme}.png"));
            assert_eq!(found, [""; 0], "{width} px, {theme}");
        }
    }
    assert_eq!(faults(browser, &whole, 360, "light"), [""; 0]);

    // What would spoil it is seen.
    let spoiled = |browser: &mut Browser, from: &str, to: &str, theme: &str| {
        assert!(whole.contains(from), "{from}");
        faults(browser, &whole.replace(from, to), 400, theme).join("\n")
    };
    for (from, to, theme, expected) in [
        ("<main>", "<main><div style=\"width:500px\">wide</div>", "light", "scrolls sideways"),
        ("<main>", "<main><script>alert(1)</script>", "light", "console: "),
        ("<title>", "<desc>", "light", "0 marks with a tooltip"),
        ("<g class=\"paper\"", "<g display=\"none\" class=\"paper\"", "light", "no tooltip"),
        ("prefers-color-scheme:dark", "prefers-color-scheme:none", "dark", "dark theme: the page"),
        (".plot{display:block;", ".plot{display:none;", "light", "no plot is shown"),
        ("width:100%;min-width:46rem;", "width:100%;", "light", "letters of"),
    ] {
        let found = spoiled(browser, from, to, theme);
        assert!(found.contains(expected), "{from} as {to}: {found:?}");
    }
}
