//! Acne and leaks: the light of kernels, and beside it what is wrong with it.

use maud::{Markup, html};

use super::heat::{FALSE_SHADOW, LEAK, LEVEL_RANGE, light_data, light_fault_data};
use super::pictures::{image, ramp, swatch};
use crate::report::figures::{count, percent, short_name, typeset};
use crate::report::plot::theme::kernel_class;
use crate::report::summary::Cast;
use crate::report::tables::{self, with_epsilon};
use crate::report::{LIGHT_SIZE, LightFault, LightPicture, Report, print};

const LIGHT: &str = "\
    A shadow is wrong where a light counts for a pixel that exactly does not, or the other way round; \
    shares are of pixels times lights. Bytes are wrong where any of a pixel’s three is another one. ε is \
    how far from the surface shadow rays start, in units of the scene; it is no number that suits all \
    scenes. The kernel certified has none.";

/// The section of light; nothing where none was measured.
pub fn section(report: &Report, cast: &Cast) -> Markup {
    let pixels = report.light.iter().flat_map(|scene| &scene.rows).map(|row| row.errors.pixels);
    let n_pixels = typeset(&pixels.max().unwrap_or(0).to_string());
    html! {
        @if !report.light.is_empty() {
            section {
                h2 { "Light" }
                (print::html(&tables::light(report, cast)))
                p.note {
                    (LIGHT_SIZE[0]) " × " (LIGHT_SIZE[1]) " pixels, of which " (n_pixels)
                    " were compared with exact arithmetic. " (LIGHT)
                }
                (pictures(report))
            }
        }
    }
}

fn pictures(Report { light, light_pictures, .. }: &Report) -> Markup {
    let mut names: Vec<&str> =
        light_pictures.iter().map(|picture| picture.scene.as_str()).collect();
    names.dedup();
    let of_scene = |name| light_pictures.iter().filter(move |picture| picture.scene == name);
    html! {
        @if !light_pictures.is_empty() {
            h3 { "Acne and leaks" }
            p {
                "The scenes with the most wrong shadows: the certified picture, and below it what plain \
                 f32 shows with each ε and how that differs."
            }
            (legend())
            @for name in names {
                h3 { (name) }
                @if let Some(scene) = light.iter().find(|scene| scene.scene == name) {
                    p.note { (scene.about) }
                }
                div.rows { @for picture in of_scene(name) { (row(picture)) } }
            }
        }
    }
}

fn legend() -> Markup {
    html! {
        div.legend {
            (swatch(FALSE_SHADOW, "wrongly in shadow"))
            (swatch(LEAK, "wrongly lit"))
            span {
                "right shadows, byte off by " (LEVEL_RANGE.0)
                (ramp())
                (LEVEL_RANGE.1) " and more"
            }
        }
    }
}

fn row(picture: &LightPicture) -> Markup {
    let kernel = &picture.contestant.kernel;
    let epsilon = with_epsilon(picture.epsilon);
    let what = format!("{}, kernel {kernel}, {epsilon}", picture.scene);
    let size = [picture.width, picture.height];
    html! {
        p {
            span.key.(kernel_class(kernel)) {} strong { (kernel) } br;
            (epsilon) br;
            span.soft { (short_name(&picture.contestant.device)) } br;
            (summary(&picture.faults))
        }
        (image(size, light_data(picture), &format!("{what}: the picture")))
        (image(size, light_fault_data(picture), &format!("{what}: its errors")))
    }
}

/// How many pixels have a wrong shadow, and how many others a wrong byte.
fn summary(faults: &[LightFault]) -> Markup {
    let n = |is: fn(&LightFault) -> bool| faults.iter().filter(|fault| is(fault)).count();
    let shadows = n(|fault| matches!(fault, LightFault::FalseShadow | LightFault::Leak));
    let bytes = n(|fault| matches!(fault, LightFault::Bytes { .. }));
    let share = |wrong: usize| typeset(&percent(wrong as u64, faults.len() as u64));
    html! {
        @match shadows {
            0 => "no wrong shadow",
            _ => {
                (typeset(&count(shadows, "wrong shadow"))) " (" (share(shadows)) ")"
            }
        }
        br;
        @match bytes {
            0 => "no other wrong byte",
            _ => { (typeset(&count(bytes, "other wrong pixel"))) " (" (share(bytes)) ")" }
        }
    }
}
