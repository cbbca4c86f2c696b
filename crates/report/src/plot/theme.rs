//! Colours for light and dark pages. Each drawn thing has a class; its colour is the CSS property
//! `color` of that class, so that one picture fits both.

use kugelblitz_judge::markup::{Shade, for_light_and_dark};

/// The colours of all that is drawn: first the neutral ones, then a kernel's, which is the same everywhere. Warm ones
/// are plain f32. Told apart with each of the three colour blindnesses (in Machado's simulation at least 0.14 apart in
/// Oklab) and on paper at a contrast of at least 3.
const SHADES: [Shade; 10] = [
    ("ink", "#1b2027", "#e8eaee"),
    ("soft", "#59616d", "#a5adb9"),
    ("grid", "#e2e5e9", "#2c323b"),
    ("band", "#f3f5f8", "#1d2229"),
    ("paper", "#ffffff", "#15181d"),
    ("lecture", "#c2304a", "#df4a62"),
    ("stable", "#c28a00", "#edc158"),
    ("double", "#3a9ad9", "#86cdf7"),
    ("certified", "#0b4f94", "#3f87e5"),
    ("other", "#59616d", "#a5adb9"),
];

/// The class of a kernel's colour.
pub fn kernel_class(kernel: &str) -> &'static str {
    let known = SHADES.iter().find(|(class, ..)| *class == kernel);
    known.map_or("other", |(class, ..)| class)
}

/// The rules for all classes.
pub fn css() -> String {
    let rule = |class: &str, color: &str| format!(".plot .{class}{{color:{color}}}");
    for_light_and_dark(&SHADES, rule, |rules| rules)
}

/// The colours of [`css`] as variables of a page, `--ink` and so on.
pub fn css_variables() -> String {
    let variable = |class: &str, color: &str| format!("--{class}:{color};");
    for_light_and_dark(&SHADES, variable, |all| format!(":root{{{all}}}"))
}
