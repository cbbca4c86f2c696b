//! Pictures beside what is wrong with them.

use maud::{Markup, html};

use super::heat::{
    FALSE_HIT, FALSE_MISS, RAMP, ULP_RANGE, WRONG_OBJECT, css, fault_data, picture_data,
};
use crate::report::figures::{count, figure, percent, quantity, short_name, typeset};
use crate::report::plot::theme::kernel_class;
use crate::report::{ErrorPicture, Fault, SceneResult};

/// All pictures, scene by scene.
pub fn section(pictures: &[ErrorPicture], scenes: &[SceneResult]) -> Markup {
    let mut names: Vec<&str> = pictures.iter().map(|picture| picture.scene.as_str()).collect();
    names.dedup();
    let of_scene = |name| pictures.iter().filter(move |picture| picture.scene == name);
    html! {
        @if !pictures.is_empty() {
            section {
                h2 { "Error pictures" }
                p {
                    "The scenes with the most wrong ids: what each kernel shows, and beside it \
                     what is wrong with each pixel."
                }
                (legend())
                @for name in names {
                    h3 { (name) }
                    @if let Some(scene) = scenes.iter().find(|scene| scene.name == name) {
                        p.note { (scene.about) }
                    }
                    div.rows { @for picture in of_scene(name) { (row(picture)) } }
                }
            }
        }
    }
}

/// A colour of a legend and its meaning.
pub fn swatch(color: [u8; 3], words: &str) -> Markup {
    html! { span { i style=(format!("background:{}", css(&color))) {} (words) } }
}

/// The colours of a legend from small to large errors.
pub fn ramp() -> Markup {
    let colors: Vec<String> = RAMP.iter().map(|color| css(color)).collect();
    html! { i.ramp style=(format!("background:linear-gradient(to right,{})", colors.join(","))) {} }
}

fn legend() -> Markup {
    html! {
        div.legend {
            (swatch(FALSE_HIT, "false hit"))
            (swatch(FALSE_MISS, "false miss"))
            (swatch(WRONG_OBJECT, "wrong object"))
            span {
                "right, error of t: up to " (quantity(ULP_RANGE.0)) " ulp"
                (ramp())
                (typeset(&quantity(ULP_RANGE.1))) " ulp and more"
            }
        }
    }
}

fn row(picture: &ErrorPicture) -> Markup {
    let kernel = &picture.contestant.kernel;
    let what = format!("{}, kernel {kernel}", picture.scene);
    let size = [picture.width, picture.height];
    html! {
        p {
            span.key.(kernel_class(kernel)) {} strong { (kernel) } br;
            span.soft { (short_name(&picture.contestant.device)) } br;
            (summary(&picture.faults))
        }
        (image(size, picture_data(picture), &format!("{what}: the picture")))
        (image(size, fault_data(picture), &format!("{what}: its errors")))
    }
}

/// A picture that is in the page itself.
pub fn image([width, height]: [u32; 2], data: Option<String>, what: &str) -> Markup {
    html! {
        @match data {
            Some(data) => img src=(data) width=(width) height=(height) alt=(what);,
            None => p { "no picture" },
        }
    }
}

/// How many pixels are wrong, and the largest error of those that are right.
fn summary(faults: &[Fault]) -> Markup {
    let errors = faults.iter().filter_map(|fault| match fault {
        Fault::Right { t_ulp } => Some(*t_ulp),
        _ => None,
    });
    let largest = errors.clone().reduce(f64::max);
    let right = faults.iter().filter(|fault| **fault == Fault::Background).count() + errors.count();
    let wrong = faults.len() - right;
    html! {
        @match wrong {
            0 => "no wrong pixel",
            _ => {
                (typeset(&count(wrong, "wrong pixel"))) " ("
                (typeset(&percent(wrong as u64, faults.len() as u64))) ")"
            }
        }
        @if let Some(largest) = largest { br; "t up to " (typeset(&figure(largest))) " ulp off" }
    }
}
