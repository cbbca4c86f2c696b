//! Colours for light and dark pages. Each drawn thing has a class; its colour is the CSS property
//! `color` of that class, so that one picture fits both.

/// A class with its colour on a light and on a dark page.
type Entry = (&'static str, &'static str, &'static str);

/// The neutral colours.
const NEUTRAL: [Entry; 5] = [
    ("ink", "#1b2027", "#e8eaee"),
    ("soft", "#59616d", "#a5adb9"),
    ("grid", "#e2e5e9", "#2c323b"),
    ("band", "#f3f5f8", "#1d2229"),
    ("paper", "#ffffff", "#15181d"),
];

/// A kernel has the same colour everywhere. Warm ones are plain f32. Told apart with each of the
/// three colour blindnesses (in Machado's simulation at least 0.14 apart in Oklab) and on paper at
/// a contrast of at least 3.
const KERNELS: [Entry; 5] = [
    ("lecture", "#c2304a", "#df4a62"),
    ("stable", "#c28a00", "#edc158"),
    ("double", "#3a9ad9", "#86cdf7"),
    ("certified", "#0b4f94", "#3f87e5"),
    ("other", "#59616d", "#a5adb9"),
];

/// The class of a kernel's colour.
pub fn kernel_class(kernel: &str) -> &'static str {
    let known = KERNELS.iter().find(|(class, ..)| *class == kernel);
    known.map_or("other", |(class, ..)| class)
}

/// The rules for all classes.
pub fn css() -> String {
    let rules = |color: fn(&Entry) -> &'static str| {
        let rule = |entry: &Entry| format!(".plot .{}{{color:{}}}", entry.0, color(entry));
        NEUTRAL.iter().chain(&KERNELS).map(rule).collect::<String>()
    };
    let (light, dark) = (rules(|entry| entry.1), rules(|entry| entry.2));
    format!("{light}@media screen and (prefers-color-scheme:dark){{{dark}}}")
}

/// The same colours as variables of a page, `--ink` and so on.
pub fn css_variables() -> String {
    let variables = |color: fn(&Entry) -> &'static str| {
        let variable = |entry: &Entry| format!("--{}:{};", entry.0, color(entry));
        NEUTRAL.iter().chain(&KERNELS).map(variable).collect::<String>()
    };
    let (light, dark) = (variables(|entry| entry.1), variables(|entry| entry.2));
    format!(":root{{{light}}}@media screen and (prefers-color-scheme:dark){{:root{{{dark}}}}}")
}
