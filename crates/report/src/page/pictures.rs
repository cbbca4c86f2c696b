//! Pictures beside what is wrong with them.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use kugelblitz_judge::judge::{FALSE_HIT, FALSE_MISS, WRONG_OBJECT};
use maud::{Markup, html};
use png::{BitDepth, ColorType, Encoder, SrgbRenderingIntent};

use crate::figures::{count, figure, percent, quantity, short_name, typeset};
use crate::plot::theme::kernel_class;
use crate::tables::with_epsilon;
use crate::{ErrorPicture, Fault, Of, Report};

/// A light that is left out: acne. False hits lie on the page's own colour, and this is seen on light and dark.
const FALSE_SHADOW: [u8; 3] = FALSE_HIT;
/// A light that is let in.
const LEAK: [u8; 3] = WRONG_OBJECT;

/// Small to large errors, evenly apart, as red, green, blue and opacity: a small error is faint on a
/// light and on a dark page.
const RAMP: [[u8; 4]; 3] =
    [[0x6a, 0xa6, 0xdd, 0x48], [0x41, 0x86, 0xcf, 0xa4], [0x1d, 0x5f, 0xb8, 0xff]];

/// Steps of the ramp in a picture, few enough for a small file.
const STEPS: f64 = 48.0;

/// Errors up to the first are drawn in the first colour of the ramp, from the second on in the last.
const ULP_RANGE: [f64; 2] = [0.5, 1e6];
const LEVEL_RANGE: [f64; 2] = [1.0, 64.0];

/// Pictures of one sort, and their legend.
struct Gallery {
    is_own: fn(&Of) -> bool,
    title: &'static str,
    about: &'static str,
    colors: &'static [([u8; 3], &'static str)],
    /// Words before and after the ramp.
    ramp: fn() -> [String; 2],
    /// What is wrong with so many pixels, as in `wrong pixel`.
    wrong: &'static str,
}

const RAYS: Gallery = Gallery {
    is_own: |of| matches!(of, Of::Scene { .. }),
    title: "Error pictures",
    about: "The scenes with the most wrong ids: what each kernel shows, and beside it what is wrong with \
            each pixel.",
    colors: &[(FALSE_HIT, "false hit"), (FALSE_MISS, "false miss"), (WRONG_OBJECT, "wrong object")],
    ramp: || {
        let [low, high] = ULP_RANGE.map(|ulp| typeset(&quantity(ulp)));
        [format!("right, error of t: up to {low} ulp"), format!("{high} ulp and more")]
    },
    wrong: "wrong pixel",
};

const LIGHT: Gallery = Gallery {
    is_own: |of| matches!(of, Of::Light { .. }),
    title: "Acne and leaks",
    about: "The scenes with the most wrong shadows: the certified picture, and below it what plain f32 shows \
            with each ε and how that differs.",
    colors: &[(FALSE_SHADOW, "wrongly in shadow"), (LEAK, "wrongly lit")],
    ramp: || {
        let [low, high] = LEVEL_RANGE;
        [format!("right shadows, byte off by {low}"), format!("{high} and more")]
    },
    wrong: "wrong shadow",
};

/// What kernels show, and what is wrong with it.
pub fn errors(report: &Report) -> Markup {
    RAYS.show(report)
}

/// How kernels light, and what is wrong with it.
pub fn light(report: &Report) -> Markup {
    LIGHT.show(report)
}

impl Gallery {
    /// All pictures, scene by scene.
    fn show(&self, report: &Report) -> Markup {
        let own = || report.pictures.iter().filter(|picture| (self.is_own)(&picture.key.of));
        let mut names: Vec<&str> = own().map(ErrorPicture::scene).collect();
        names.dedup();
        html! {
            @if !names.is_empty() {
                section {
                    h2 { (self.title) }
                    p { (self.about) }
                    (self.legend())
                    @for name in names {
                        h3 { (name) }
                        @if let Some(scene) = report.scene(name) { p.note { (scene.about) } }
                        div.rows {
                            @for picture in own().filter(|picture| picture.scene() == name) {
                                (self.row(picture))
                            }
                        }
                    }
                }
            }
        }
    }

    fn legend(&self) -> Markup {
        let [low, high] = (self.ramp)();
        let colors = RAMP.map(|color| css(&color)).join(",");
        html! {
            div.legend {
                @for (color, words) in self.colors {
                    span { i style=(format!("background:{}", css(color))) {} (words) }
                }
                span {
                    (low)
                    i.ramp style=(format!("background:linear-gradient(to right,{colors})")) {}
                    (high)
                }
            }
        }
    }

    fn row(&self, picture: &ErrorPicture) -> Markup {
        let kernel = &picture.key.kernel;
        let is_light = matches!(picture.key.of, Of::Light { .. });
        let epsilon = is_light.then(|| with_epsilon(picture.key.epsilon));
        let shown =
            [picture.scene().into(), format!("kernel {kernel}")].into_iter().chain(epsilon.clone());
        let what = shown.collect::<Vec<String>>().join(", ");
        let faults: Vec<[u8; 4]> = picture.faults.iter().map(color).collect();
        html! {
            p {
                span.key.(kernel_class(kernel)) {} strong { (kernel) } br;
                @if let Some(epsilon) = epsilon { (epsilon) br; }
                span.soft { (short_name(&picture.key.device)) }
                @for words in self.verdict(&picture.faults) { br; (typeset(&words)) }
            }
            (image(picture, ColorType::Rgb, picture.srgb.as_flattened(), &format!("{what}: the picture")))
            (image(picture, ColorType::Rgba, faults.as_flattened(), &format!("{what}: its errors")))
        }
    }

    /// How many pixels are wrong, and by how much the others are off.
    fn verdict(&self, faults: &[Fault]) -> Vec<String> {
        let counted = |n: usize, what: &str| match n {
            0 => format!("no {what}"),
            _ => format!("{} ({})", count(n, what), percent(n as u64, faults.len() as u64)),
        };
        let is_right =
            |fault: &&Fault| matches!(fault, Fault::Right | Fault::TUlp(_) | Fault::Levels(_));
        let wrong = faults.len() - faults.iter().filter(is_right).count();
        let largest = faults.iter().filter_map(|fault| match fault {
            Fault::TUlp(ulp) => Some(*ulp),
            _ => None,
        });
        let largest =
            largest.reduce(f64::max).map(|ulp| format!("t up to {} ulp off", figure(ulp)));
        let bytes = faults.iter().filter(|fault| matches!(fault, Fault::Levels(_))).count();
        let bytes = (self.wrong == LIGHT.wrong).then(|| counted(bytes, "other wrong pixel"));
        [counted(wrong, self.wrong)].into_iter().chain(largest).chain(bytes).collect()
    }
}

/// A picture that is in the page itself, as PNG in a `data:` address.
fn image(picture: &ErrorPicture, color: ColorType, bytes: &[u8], what: &str) -> Markup {
    let [width, height] = picture.size;
    html! {
        @match encode(picture.size, color, bytes) {
            Some(data) => img src=(data) width=(width) height=(height) alt=(what);,
            None => p { "no picture" },
        }
    }
}

fn encode([width, height]: [u32; 2], color: ColorType, bytes: &[u8]) -> Option<String> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, width, height);
    encoder.set_color(color);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header().ok()?;
    writer.write_image_data(bytes).ok()?;
    writer.finish().ok()?;
    Some(format!("data:image/png;base64,{}", STANDARD.encode(file)))
}

/// The colour of a fault; what is right is transparent.
fn color(fault: &Fault) -> [u8; 4] {
    let opaque = |[r, g, b]: [u8; 3]| [r, g, b, 0xff];
    match *fault {
        Fault::Right => [0; 4],
        Fault::FalseHit => opaque(FALSE_HIT),
        Fault::FalseMiss => opaque(FALSE_MISS),
        Fault::WrongObject => opaque(WRONG_OBJECT),
        Fault::FalseShadow => opaque(FALSE_SHADOW),
        Fault::Leak => opaque(LEAK),
        Fault::TUlp(ulp) => ramp(ulp, ULP_RANGE),
        Fault::Levels(levels) => ramp(f64::from(levels), LEVEL_RANGE),
    }
}

/// The ramp's colour of an error, by its logarithm.
fn ramp(error: f64, range: [f64; 2]) -> [u8; 4] {
    let [low, high] = range.map(f64::log10);
    let share = ((error.log10() - low) / (high - low)).clamp(0.0, 1.0);
    let place = (share * STEPS).round() / STEPS * (RAMP.len() - 1) as f64;
    let i = (place as usize).min(RAMP.len() - 2);
    let mix =
        |a: u8, b: u8| (f64::from(a) + (place - i as f64) * (f64::from(b) - f64::from(a))) as u8;
    std::array::from_fn(|channel| mix(RAMP[i][channel], RAMP[i + 1][channel]))
}

/// A colour for CSS, with its opacity if it has one.
fn css(color: &[u8]) -> String {
    let digits: String = color.iter().map(|channel| format!("{channel:02x}")).collect();
    format!("#{digits}")
}
