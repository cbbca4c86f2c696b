//! Why an object is seen, or isn't.

use rayon::prelude::*;

use super::ray::RayNumbers;
use super::{Approximation, ObjectExplanation, Quantity, Reason, Terms, label};
use crate::exact::{ExactHit, Root, Shape, visible_root};
use crate::scene::Scene;

/// A column of the table.
type Column = fn(&Quantity) -> Option<Approximation>;

impl ObjectExplanation {
    pub(super) fn reason(&self, root: Option<&Root>, hit: Option<&ExactHit>) -> Reason {
        match (root, hit) {
            (Some(_), Some(hit)) if hit.id == self.id => Reason::Visible,
            (Some(root), Some(hit)) if *root == hit.root => Reason::TieLost { to: hit.id },
            (Some(_), Some(hit)) => Reason::Farther { than: hit.id },
            (Some(_), None) => Reason::TooFar,
            (None, _) => self.why_missed(),
        }
    }

    fn why_missed(&self) -> Reason {
        let sign = |symbol| self.exact(symbol).map(|exact| exact.signum);
        match self.terms {
            Terms::Sphere { .. } if sign("t₁").is_some() => Reason::Behind,
            Terms::Sphere { .. } if sign("D") == Some(-1) => Reason::Missed,
            Terms::Plane { .. } if sign("t").is_some() => Reason::Behind,
            Terms::Plane { .. } if sign("d·n") == Some(0) => Reason::Parallel,
            _ => Reason::Degenerate,
        }
    }

    /// The reason in words, first, then what else is worth a remark.
    pub(super) fn why(
        &self,
        scene: &Scene,
        is_hit: bool,
        hit: Option<&ExactHit>,
        numbers: &RayNumbers,
    ) -> Vec<String> {
        let is_sphere = matches!(self.terms, Terms::Sphere { .. });
        let signs: Vec<i32> =
            self.roots().filter_map(|root| Some(root.exact.as_ref()?.signum)).collect();
        let mut why = vec![match self.reason {
            Reason::Visible => "nearest positive t: visible".into(),
            Reason::Farther { than } => format!("farther than {}", label(scene, than)),
            Reason::TieLost { to } => {
                format!("tie with {}: the lower id wins", label(scene, to))
            }
            Reason::Missed => "D < 0: the line misses the sphere".into(),
            Reason::Behind if !is_sphere && signs == [0] => {
                "t = 0: the origin lies in the plane, which does not count".into()
            }
            Reason::Behind if !is_sphere => "behind the camera: t < 0".into(),
            Reason::Behind if signs.contains(&0) => {
                "the origin lies on the sphere: no t > 0 (t = 0 does not count)".into()
            }
            Reason::Behind => "behind the camera: both t ≤ 0".into(),
            Reason::Parallel => match self.exact("(a−o)·n").map(|exact| exact.signum) {
                Some(0) => "parallel: d·n = 0 (the ray runs in the plane, which is no hit)".into(),
                _ => "parallel: d·n = 0".into(),
            },
            Reason::TooFar => "t is larger than any f32: counts as background".into(),
            Reason::Degenerate => "a number here can't be calculated with: no hit".into(),
        }];
        if self.reason == Reason::Visible {
            let tied = |&id: &u32| {
                let root = scene
                    .object(id)
                    .and_then(|object| visible_root(&numbers.exact, &Shape::from(object)));
                root.zip(hit).is_some_and(|((root, _), hit)| root == hit.root)
            };
            let others = self.id + 1..=scene.n_objects() as u32;
            if let Some(other) = others.into_par_iter().find_first(tied) {
                why.push(format!("tie with {}: the lower id wins", label(scene, other)));
            }
        }
        match signs.first() {
            Some(-1) if is_hit && is_sphere => {
                why.push("inside: near root behind, far root counts".into());
            }
            Some(0) if is_hit && is_sphere => {
                why.push("the origin lies on the sphere: near root 0, far root counts".into());
            }
            _ => {}
        }
        if self.exact("D").is_some_and(|exact| exact.signum == 0) {
            why.push("D = 0: the line touches the sphere".into());
        }
        let columns: [(&str, Column); 3] = [
            ("f32 lecture", |row| row.lecture),
            ("f32 stable", |row| row.stable),
            ("f64", |row| row.f64),
        ];
        for (name, column) in columns {
            let sees =
                self.roots().filter_map(column).any(|entry| entry.value.is_some_and(|t| t > 0.0));
            if sees != is_hit {
                let what = if sees { "a hit" } else { "no hit" };
                why.push(format!("wrong in {name}, which sees {what}"));
            }
        }
        why
    }
}
