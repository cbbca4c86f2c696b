//! Colours for light and dark pages. Each drawn thing has a class; its colour is the CSS property
//! `color` of that class, so that one picture fits both.

/// A class with its colour on a light and on a dark page.
type Shade = (&'static str, &'static str, &'static str);

/// The neutral colours.
const NEUTRAL: [Shade; 5] = [
    ("ink", "#1b2027", "#e8eaee"),
    ("soft", "#59616d", "#a5adb9"),
    ("grid", "#e2e5e9", "#2c323b"),
    ("band", "#f3f5f8", "#1d2229"),
    ("paper", "#ffffff", "#15181d"),
];

/// A kernel has the same colour everywhere. Warm ones are plain f32. Told apart with each of the
/// three colour blindnesses (in Machado's simulation at least 0.14 apart in Oklab) and on paper at
/// a contrast of at least 3.
const KERNELS: [Shade; 5] = [
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
    let (light, dark) = both(|class, color| format!(".plot .{class}{{color:{color}}}"));
    format!("{light}@media screen and (prefers-color-scheme:dark){{{dark}}}")
}

/// The same colours as variables of a page, `--ink` and so on.
pub fn css_variables() -> String {
    let (light, dark) = both(|class, color| format!("--{class}:{color};"));
    format!(":root{{{light}}}@media screen and (prefers-color-scheme:dark){{:root{{{dark}}}}}")
}

/// All classes with their colours, on a light and on a dark page.
fn both(write: fn(&str, &str) -> String) -> (String, String) {
    let all = || NEUTRAL.iter().chain(&KERNELS);
    let light = all().map(|(class, light, _)| write(class, light)).collect();
    (light, all().map(|(class, _, dark)| write(class, dark)).collect())
}
