//! `kugelblitz probe`

use std::fmt::Write;

use kugelblitz::gpu::{AdapterFacts, Arithmetic, Gpu, list_adapters, no_device};
use kugelblitz::support::memory;
use kugelblitz::words::{bytes, joined};
use kugelblitz::{Error, Result};
use serde::Serialize;

use crate::Run;
use crate::head::Done;
use crate::quiet::{self, quietly};

/// The Vulkan adapters.
#[derive(Serialize)]
pub struct ProbeSummary {
    /// Adapters, the best first.
    adapters: Vec<Probed>,
}

/// An adapter and what its arithmetic really does.
#[derive(Serialize)]
pub struct Probed {
    #[serde(flatten)]
    facts: AdapterFacts,
    /// Measured arithmetic; `null` if it could not be measured.
    arithmetic: Option<MeasuredAdapter>,
    /// Reason why the arithmetic could not be measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    failure: Option<String>,
}

/// The findings of the self-test.
#[derive(Serialize)]
struct MeasuredAdapter {
    /// Arithmetic in f32.
    f32: Arithmetic,
    /// Arithmetic in f64; `null` if shaders do not support it.
    f64: Option<Arithmetic>,
    /// Whether the f32 stage of the kernel `certified` runs on this adapter instead of the CPU.
    certified_on_device: bool,
}

impl Probed {
    fn new(facts: AdapterFacts) -> Probed {
        let measured = Gpu::open(&facts.name).and_then(|gpu| measure(&gpu));
        let failure = measured.as_ref().err().map(Error::to_string);
        Probed { facts, arithmetic: measured.ok(), failure }
    }
}

fn measure(gpu: &Gpu) -> Result<MeasuredAdapter> {
    let f32 = gpu.arithmetic()?;
    let f64 = gpu.arithmetic_f64()?;
    Ok(MeasuredAdapter { f32, f64, certified_on_device: f32.suits_filter() })
}

/// Lists the adapters, the best first.
pub fn run(run: &Run) -> Result<Done<ProbeSummary>> {
    memory::require_device()?;
    let (adapters, noise): (Vec<Probed>, _) =
        quietly(|| list_adapters().into_iter().map(Probed::new).collect());
    if run.talk.verbose || adapters.is_empty() {
        quiet::show(&noise, run.talk.verbose);
    }
    let failure = adapters.is_empty().then(no_device);
    let text = joined(adapters.iter().map(describe), "\n");
    Ok(Done { failure, ..Done::in_words(ProbeSummary { adapters }, text) })
}

fn describe(probed: &Probed) -> String {
    let facts = &probed.facts;
    let kind =
        if facts.is_software() { "software: its shaders run on the CPU" } else { facts.kind };
    let mut lines = vec![
        ("type", kind.to_string()),
        ("driver", facts.driver.clone()),
        ("f64 in shaders", if facts.f64 { "yes" } else { "no" }.into()),
        (
            "NoContraction",
            if facts.passthrough {
                "yes: shaders are passed through as they are".into()
            } else {
                "no: shaders go the ordinary way, where the driver may rearrange".to_string()
            },
        ),
        ("largest binding", bytes(facts.max_binding_bytes)),
        ("largest buffer", bytes(facts.max_buffer_bytes)),
        ("workgroups an axis", facts.max_workgroups.to_string()),
        ("texels a side", facts.max_texture_side.to_string()),
    ];
    if let Some(MeasuredAdapter { f32, f64, .. }) = &probed.arithmetic {
        lines.push(("certified kernel", f32.filter_in_words().to_string()));
        lines.push(("f32, measured", f32.to_string()));
        lines.extend(f64.as_ref().map(|f64| ("f64, measured", f64.to_string())));
    }
    let not_measured = |why| ("arithmetic", format!("not measured: {why}"));
    lines.extend(probed.failure.as_ref().map(not_measured));
    let mut text = format!("{}\n", facts.name);
    for (what, value) in lines {
        let _ = writeln!(text, "  {what:<19} {value}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No adapter here lacks passthrough, so one is told that it does.
    #[test]
    fn a_device_without_passthrough_leaves_the_f32_stage_to_the_cpu() {
        for passthrough in [true, false] {
            let mut gpu = Gpu::open("").expect("a Vulkan device; ci/setup.sh installs one");
            gpu.facts.passthrough = passthrough;
            let probed = Probed {
                facts: gpu.facts.clone(),
                arithmetic: Some(measure(&gpu).unwrap()),
                failure: None,
            };
            let json = serde_json::to_value(&probed).unwrap();
            assert_eq!(json["arithmetic"]["certified_on_device"], passthrough);
            assert_eq!(json["arithmetic"]["f32"]["passthrough"], passthrough);
            let text = describe(&probed);
            assert_eq!(text.contains("f32 stage on this device"), passthrough, "{text}");
            let reason = "f32 stage on the CPU: shaders can't be passed through";
            assert_eq!(text.contains(reason), !passthrough, "{text}");
        }
    }
}
