//! What the page's tables are made of.

use maud::{Markup, html};

use crate::report::figures::{NONE, distribution, figure, spread, wrong};
use crate::report::plot::theme::kernel_class;
use crate::report::plot::typeset;
use crate::report::summary::Cast;
use crate::report::{Contestant, Distribution, Errors, Spread};

/// The head over counts of wrong ids.
pub const FAULTS: [&str; 3] = ["false hits", "false misses", "wrong object"];

/// A figure.
pub fn number(text: &str) -> Markup {
    html! { td { (typeset(text)) } }
}

/// Figures.
pub fn numbers(texts: &[String]) -> Markup {
    html! { @for text in texts { (number(text)) } }
}

/// A kernel's name with its colour.
pub fn kernel(name: &str) -> Markup {
    html! { span.key.(kernel_class(name)) {} (name) }
}

/// Kernel and device.
pub fn names(contestant: &Contestant, cast: &Cast) -> Markup {
    html! {
        td.name { (kernel(&contestant.kernel)) }
        td.name { (cast.short(&contestant.device)) }
    }
}

/// The share of wrong ids and the counts of each sort.
pub fn faults(errors: &Errors) -> Markup {
    let class = if errors.wrong_ids() > 0 { "some" } else { "none" };
    html! {
        td class=(class) { (typeset(&wrong(errors))) }
        @for n in [errors.false_hits, errors.false_misses, errors.wrong_object] { (number(&n.to_string())) }
    }
}

/// Median and, softer, its range.
pub fn time(time: Option<&Spread>) -> Markup {
    html! {
        td {
            @match time {
                Some(time) if time.n > 1 => {
                    (typeset(&figure(time.median)))
                    span.range { " (" (typeset(&figure(time.min))) "–" (typeset(&figure(time.max))) ")" }
                }
                Some(time) => (typeset(&spread(time))),
                None => (NONE),
            }
        }
    }
}

/// Heads of columns.
pub fn heads(texts: &[&str]) -> Markup {
    html! { @for text in texts { th { (text) } } }
}

/// A table, scrolled where it is wider than the page.
pub fn table(head: &Markup, body: &Markup) -> Markup {
    html! { div.wide { table { thead { (head) } (body) } } }
}

/// The heads over a distribution.
pub const QUANTILES: [&str; 3] = ["median", "99.9 %", "largest"];

/// Median, 99.9 % and largest.
pub fn quantiles(of: Option<&Distribution>) -> Markup {
    numbers(&distribution(of))
}
