//! What was verified, in words.

use super::{ColorDifferences, OfKernel, Parity, Verified};
use crate::compare::RayDifferences;

impl Verified {
    /// Promises that are broken, one sentence each.
    pub fn broken(&self) -> Vec<String> {
        self.kernels.iter().flat_map(|result| result.broken.clone()).collect()
    }

    /// The results in lines for people.
    pub fn in_words(&self) -> String {
        let rows = |row: &dyn Fn(&OfKernel) -> Vec<String>| -> String {
            self.kernels.iter().flat_map(row).collect()
        };
        let colors = |differ: &str, title: &str| {
            let columns = ["in 8 bits", "in 16", "floats"].map(|what| format!("{differ} {what}"));
            let [srgb8, srgb16, linear] = columns;
            color_row(title, ["pixels".into(), srgb8, srgb16, linear])
        };
        let parts = [
            (
                "GPU against CPU   rays  hit or miss  other object  t differs  ulp max  normal differs  distance max\n"
                    .into(),
                rows(&|of| of.gpu_against_cpu.iter().map(|found| found.row(of.kernel)).collect()),
            ),
            (
                "against exact     rays   false hits  false misses  wrong object  t error, ulp  normal error\n".into(),
                rows(&|of| of.against_exact.rows().map(|(on, found)| found.row(of.kernel, on)).collect()),
            ),
            (
                colors("other", "colours, GPU against CPU"),
                rows(&|of| {
                    let found = of.colors.iter().flat_map(|colors| &colors.gpu_against_cpu);
                    found.map(|found| found.row(of.kernel)).collect()
                }),
            ),
            (
                colors("wrong", "colours against exact"),
                rows(&|of| {
                    let found = of.colors.iter().flat_map(|colors| colors.against_exact.rows());
                    found.map(|(on, found)| found.row(&format!("{:<10} {on}", of.kernel))).collect()
                }),
            ),
        ];
        let parts = parts.iter().filter(|(_, rows)| !rows.is_empty());
        let mut text: String = parts.map(|(head, rows)| format!("\n{head}{rows}")).collect();
        text.push('\n');
        for OfKernel { kernel, promise, broken, .. } in &self.kernels {
            let kept = if broken.is_empty() { "kept" } else { "BROKEN" };
            text += &format!("{kernel} promises: {promise}: {kept}\n");
        }
        text
    }
}

impl Parity {
    fn row(&self, kernel: &str) -> String {
        let Parity { rays, hit_or_miss, other_object, t_differs, t_ulp_max, .. } = self;
        let (normals, distance) = (self.normal_differs, self.normal_distance_max);
        format!(
            "{kernel:<10} {rays:>11} {hit_or_miss:>12} {other_object:>13} {t_differs:>10} {t_ulp_max:>8} {normals:>15} \
             {distance:>13.2e}\n"
        )
    }
}

impl RayDifferences {
    fn row(&self, kernel: &str, device: &str) -> String {
        let RayDifferences { rays, false_hits, false_misses, wrong_object, .. } = self;
        let (ulp, distance) = (self.t_ulp_max, self.normal_distance_max);
        format!(
            "{kernel:<10} {device} {rays:>7} {false_hits:>12} {false_misses:>13} {wrong_object:>13} {ulp:>13.2} \
             {distance:>13.2e}\n"
        )
    }
}

impl ColorDifferences {
    fn row(&self, name: &str) -> String {
        let ColorDifferences { pixels, srgb8, srgb16, linear, .. } = self;
        color_row(name, [pixels, srgb8, srgb16, linear].map(u64::to_string))
    }
}

fn color_row(name: &str, [pixels, srgb8, srgb16, linear]: [String; 4]) -> String {
    format!("{name:<24} {pixels:>7} {srgb8:>16} {srgb16:>12} {linear:>13}\n")
}
