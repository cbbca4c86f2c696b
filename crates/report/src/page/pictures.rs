//! Pictures beside what is wrong with them.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use kugelblitz::picture::rgb8_file;
use kugelblitz::scene::hex;
use kugelblitz_judge::compare::{FALSE_HIT, FALSE_MISS, RAMP, WRONG_OBJECT};
use maud::{Markup, html};

use crate::figures::{joined, short_name, typeset};
use crate::order::grouped;
use crate::plot::theme::kernel_class;
use crate::tables::with_epsilon;
use crate::{ErrorPicture, Of, Report};

/// Pictures of one sort, and their legend.
pub struct Gallery {
    is_own: fn(&Of) -> bool,
    title: &'static str,
    about: &'static str,
    colors: &'static [([u8; 3], &'static str)],
    /// Words before and after the ramp.
    ramp: [&'static str; 2],
}

/// What kernels show, and what is wrong with it.
pub const ERRORS: Gallery = Gallery {
    is_own: |of| matches!(of, Of::Scene { .. }),
    title: "Error pictures",
    about: "The scenes with the most wrong ids: what each kernel shows, and beside it what is wrong with \
            each pixel.",
    colors: &[(FALSE_HIT, "false hit"), (FALSE_MISS, "false miss"), (WRONG_OBJECT, "wrong object")],
    ramp: ["right, t within 0.5 ulp and the normal within 10⁻⁵°", "off by 10⁶ ulp or 10° and more"],
};

/// How kernels light, and what is wrong with it.
pub const LIGHT: Gallery = Gallery {
    is_own: |of| matches!(of, Of::Light { .. }),
    title: "Acne and leaks",
    about: "The scenes with the most wrong shadows: the certified picture, and below it what plain f32 shows \
            with each ε and how that differs.",
    colors: &[(FALSE_HIT, "wrongly in shadow"), (WRONG_OBJECT, "wrongly lit")],
    ramp: ["right", "right shadows, byte off by 64 and more"],
};

impl Gallery {
    /// All pictures, scene by scene.
    pub fn show(&self, report: &Report) -> Markup {
        let own = report.pictures.iter().filter(|picture| (self.is_own)(&picture.key.of));
        let scenes = grouped(own, |picture| picture.key.of.name());
        html! {
            @if !scenes.is_empty() {
                section {
                    h2 { (self.title) }
                    p { (self.about) }
                    (self.legend())
                    @for (name, pictures) in scenes {
                        h3 { (name) }
                        @for scene in report.scenes.iter().filter(|scene| scene.name == name) {
                            p.note { (scene.about) }
                        }
                        div.rows { @for picture in pictures { (row(report.settings.picture_size, picture)) } }
                    }
                }
            }
        }
    }

    fn legend(&self) -> Markup {
        let [low, high] = self.ramp;
        let ramp = RAMP.map(hex).join(",");
        html! {
            div.legend {
                @for (color, words) in self.colors {
                    span { i style=(format!("background:{}", hex(*color))) {} (words) }
                }
                span {
                    (low)
                    i.ramp style=(format!("background:linear-gradient(to right,{ramp})")) {}
                    (high)
                }
            }
        }
    }
}

fn row(size: [u32; 2], picture: &ErrorPicture) -> Markup {
    let kernel = &picture.key.kernel;
    let is_light = matches!(picture.key.of, Of::Light { .. });
    let epsilon = is_light.then(|| with_epsilon(picture.key.epsilon));
    let what = [picture.key.of.name(), format!("kernel {kernel}")];
    let what = joined(what.into_iter().chain(epsilon.clone()), ", ");
    html! {
        p {
            span.key.(kernel_class(kernel)) {} strong { (kernel) } br;
            @if let Some(epsilon) = epsilon { (epsilon) br; }
            span.soft { (short_name(&picture.key.device)) }
            @for words in &picture.verdict { br; (typeset(words)) }
        }
        (image(size, &picture.srgb, &format!("{what}: the picture")))
        (image(size, &picture.errors, &format!("{what}: its errors")))
    }
}

/// A picture that is in the page itself, as PNG in a `data:` address.
fn image(size: [u32; 2], pixels: &[[u8; 3]], what: &str) -> Markup {
    let [width, height] = size;
    let data = |file| format!("data:image/png;base64,{}", STANDARD.encode(file));
    html! {
        @match rgb8_file(size, pixels).map(data) {
            Ok(data) => img src=(data) width=(width) height=(height) alt=(what);,
            Err(_) => p { "no picture" },
        }
    }
}
