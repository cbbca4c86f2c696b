//! The report's page as a browser shows it.

use std::fs;
use std::process::{Command, Stdio};

use base64::Engine;
use kugelblitz_report::html;
use kugelblitz_tests::made_report::report;

const INSTALL: &str = "Chromium is missing: apt-get install chromium, or ci/setup.sh --tests";

/// What [`LOOK`] finds of a page: how many pixels are beside the screen; of each plot its left and right end and the size of its
/// letters, px; how many marks there are; what is told under the mouse over the first mark, one amid them and the last one; and
/// lightness from 0 to 1, of text and paper of the page, and of a plot.
type Shown = (f64, Vec<[f64; 3]>, usize, Vec<String>, [f64; 4]);

/// Looks at the page in a frame, and puts what it finds into the body.
const LOOK: &str = r#"
const d = frame.contentDocument, root = d.documentElement;
const all = what => [...d.querySelectorAll(what)].filter(e => e.getClientRects().length);
// Letters have 13 px in a plot's own measure. It is scrolled in its box where that is narrower.
const plots = all('svg.plot').map(e => {
  const box = e.parentElement.getBoundingClientRect();
  return [box.left, box.right, 13 * e.getBoundingClientRect().width / e.viewBox.baseVal.width];
});
const marks = [...d.querySelectorAll('.plot g > title')]
  .map(title => title.parentElement).filter(e => e.getClientRects().length);
const titles = [0, marks.length >> 1, marks.length - 1].filter(i => marks[i]).map(i => {
  // The middle of its shape, for a title has no place.
  const shape = marks[i].querySelector('path:not(.line)');
  shape.scrollIntoView({block: 'center'});
  const r = shape.getBoundingClientRect();
  const below = d.elementFromPoint(r.x + r.width / 2, r.y + r.height / 2);
  return below?.closest('g:has(> title)')?.querySelector('title')?.textContent ?? '';
});
const light = (e, what) => {
  const [r, g, b] = e ? getComputedStyle(e)[what].match(/[0-9.]+/g).map(Number) : [127, 127, 127];
  return (0.2126 * r + 0.7152 * g + 0.0722 * b) / 255;
};
const plot = all('.plot')[0];
const lightness = [light(d.body, 'color'), light(d.body, 'backgroundColor'),
  light(plot?.querySelector('text.ink'), 'color'), light(plot?.querySelector('.paper'), 'color')];
const scrolls = root.scrollWidth - root.clientWidth;
const found = [scrolls, plots, marks.length, titles, lightness];
document.body.textContent = btoa(unescape(encodeURIComponent(JSON.stringify(found))));
"#;

/// A page as Chromium has it in the end, and what that complained about.
fn dom_of(path: &str, theme: &str) -> (String, Vec<String>) {
    let scheme = format!("--blink-settings=preferredColorScheme={}", u8::from(theme == "light"));
    let profile = tempfile::tempdir().unwrap();
    let output = Command::new("timeout")
        .args(["120", "chromium", "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run"])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
        .args(["--window-size=1400,1000", "--enable-logging=stderr", &scheme])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .args(["--dump-dom", path])
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{INSTALL}\n{said}");
    let complaints = said.lines().filter(|line| line.contains(":CONSOLE")).map(str::to_string);
    (String::from_utf8(output.stdout).unwrap(), complaints.collect())
}

/// What is wrong with a page at a width in a theme.
fn faults(html: &str, width: u32, theme: &str) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("page.html");
    let quoted = html.replace('&', "&amp;").replace('"', "&quot;");
    let style = format!("border: 0; width: {width}px; height: 900px");
    let around = format!(
        "<!doctype html><meta charset=utf-8><meta name=color-scheme content='light dark'>\
         <body><iframe id=frame style='{style}' srcdoc=\"{quoted}\"></iframe>\
         <script>frame.onload = () => {{ {LOOK} }}</script>"
    );
    fs::write(&path, around).unwrap();
    let (dom, complaints) = dom_of(path.to_str().unwrap(), theme);
    let found = dom.split_once("<body>").and_then(|(_, rest)| rest.split_once("</body>"));
    let found = found.unwrap_or_else(|| panic!("no page: {dom}")).0.trim();
    let found = base64::engine::general_purpose::STANDARD.decode(found).unwrap();
    let (scrolls, plots, n_marks, titles, lightness): Shown =
        serde_json::from_slice(&found).unwrap();

    let mut faults: Vec<String> =
        complaints.iter().map(|complaint| format!("console: {complaint}")).collect();
    if scrolls != 0.0 {
        faults.push(format!("scrolls sideways by {scrolls} px"));
    }
    if plots.is_empty() {
        faults.push("no plot is shown".into());
    }
    for [left, right, letters] in plots {
        if left < 0.0 || right > f64::from(width) {
            faults.push(format!("a plot from {left} to {right} px"));
        }
        if letters < 11.0 {
            faults.push(format!("letters of {letters} px in a plot"));
        }
    }
    if n_marks < 20 {
        faults.push(format!("{n_marks} marks with a tooltip"));
    }
    let untold = titles.iter().filter(|title| !title.contains(", "));
    faults.extend(untold.map(|title| format!("no tooltip over a mark: {title:?}")));
    let things = ["the page's text", "the page", "a plot's text", "a plot's paper"];
    for (i, (what, lightness)) in things.iter().zip(lightness).enumerate() {
        // Text is the other way round.
        let is_right = (lightness > 0.5) == ((theme == "dark") == (i % 2 == 0));
        if !is_right || (0.2..0.8).contains(&lightness) {
            faults.push(format!("{theme} theme: {what} has lightness {lightness:.2}"));
        }
    }
    faults
}

#[test]
fn a_browser_shows_the_report_on_telephones_and_desktops() {
    let whole = html::html(&report());
    for width in [360, 400, 1280] {
        for theme in ["light", "dark"] {
            assert_eq!(faults(&whole, width, theme), [""; 0], "{width} px, {theme}");
        }
    }

    // What would spoil it is seen.
    for (from, to, theme, expected) in [
        ("<main>", "<main><div style=\"width:500px\">wide</div>", "light", "scrolls sideways"),
        ("<main>", "<main><script>alert(1)</script>", "light", "console: "),
        ("<title>", "<desc>", "light", "0 marks with a tooltip"),
        (".plot .line{", ".plot g{pointer-events:none}.plot .line{", "light", "no tooltip"),
        ("prefers-color-scheme:dark", "prefers-color-scheme:none", "dark", "dark theme: the page"),
        (".plot{display:block;", ".plot{display:none;", "light", "no plot is shown"),
        ("width:100%;min-width:46rem;", "width:100%;", "light", "letters of"),
    ] {
        assert!(whole.contains(from), "{from}");
        let found = faults(&whole.replace(from, to), 400, theme).join("\n");
        assert!(found.contains(expected), "{from} as {to}: {found:?}");
    }
}
