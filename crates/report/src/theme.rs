//! Colours for light and dark pages. Each element of a plot has a class, whose CSS property `color` is the element's
//! colour, so that one plot suits both.

use kugelblitz_judge::markup::{ThemeColor, for_light_and_dark};

/// Colours of all classes: first the neutral ones, then one for each kernel, the same in all plots. Kernels without
/// a proof in f32 have warm colours. All differ for each of the three colour blindnesses (in Machado's
/// simulation at least 0.14 apart in Oklab), and have a contrast of at least 3 on paper.
const SHADES: [ThemeColor; 9] = [
    ("ink", "#1b2027", "#e8eaee"),
    ("soft", "#59616d", "#a5adb9"),
    ("grid", "#e2e5e9", "#2c323b"),
    ("paper", "#ffffff", "#15181d"),
    ("lecture", "#c2304a", "#df4a62"),
    ("stable", "#c28a00", "#edc158"),
    ("double", "#3a9ad9", "#86cdf7"),
    ("certified", "#0b4f94", "#3f87e5"),
    ("other", "#59616d", "#a5adb9"),
];

/// Style of the elements of a plot, apart from their colours.
const PLOT: &str = "\
    .plot{font:13px system-ui,sans-serif}.plot *{fill:currentColor}\
    .plot .line{fill:none;stroke:currentColor}.plot g g .line,.plot g>.line:not(.grid){stroke-width:1.5}\
    .plot .title{font-weight:600}.plot .middle{text-anchor:middle}.plot .end{text-anchor:end}";

/// Returns the style of a plot.
pub fn plot_css() -> String {
    let rule = |class: &str, color: &str| format!(".plot .{class}{{color:{color}}}");
    PLOT.to_owned() + &for_light_and_dark(&SHADES, rule, |rules| rules)
}

/// Returns the colours as variables of a page, `--ink` and so on.
pub fn css_variables() -> String {
    let variable = |class: &str, color: &str| format!("--{class}:{color};");
    for_light_and_dark(&SHADES, variable, |all| format!(":root{{{all}}}"))
}
