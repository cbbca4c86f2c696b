//! `kugelblitz probe`

use std::fmt::Write;

use kugelblitz::gpu::{AdapterFacts, list_adapters};
use kugelblitz::{Error, Result};
use serde::Serialize;

use super::ProbeArgs;
use super::head::Head;
use super::output::{bytes, print, print_json};
use super::quiet::{self, quietly};

#[derive(Serialize)]
struct Summary {
    #[serde(flatten)]
    head: Head,
    adapters: Vec<AdapterFacts>,
}

/// Lists the adapters, the best first.
pub fn run(args: &ProbeArgs) -> Result<()> {
    let (adapters, noise) = quietly(list_adapters);
    if args.talk.verbose || adapters.is_empty() {
        quiet::show(&noise, args.talk.verbose);
    }
    let is_empty = adapters.is_empty();
    if args.talk.json {
        print_json(&Summary { head: Head::new("probe"), adapters })?;
    } else {
        let text: Vec<String> = adapters.iter().map(describe).collect();
        print(text.join("\n").as_bytes())?;
    }
    if is_empty {
        return Err(Error::NoAdapter(
            "no Vulkan device found: install a Vulkan driver (Debian: `apt install \
             mesa-vulkan-drivers` brings a software one); `--device cpu` works without"
                .into(),
        ));
    }
    Ok(())
}

fn describe(facts: &AdapterFacts) -> String {
    let kind = match facts.is_software() {
        true => "software: its shaders run on the CPU",
        false => facts.kind,
    };
    let lines = [
        ("type", kind.to_string()),
        ("driver", facts.driver.clone()),
        ("f64 in shaders", yes_or_no(facts.f64).into()),
        (
            "NoContraction",
            match facts.passthrough {
                true => "yes: shaders are passed through as they are".into(),
                false => {
                    "no: the ordinary way, on which the driver may fuse operations".to_string()
                }
            },
        ),
        ("largest binding", bytes(facts.max_binding_bytes)),
        ("largest buffer", bytes(facts.max_buffer_bytes)),
        ("workgroups an axis", facts.max_workgroups.to_string()),
    ];
    let mut text = format!("{}\n", facts.name);
    for (what, value) in lines {
        let _ = writeln!(text, "  {what:<19} {value}");
    }
    text
}

fn yes_or_no(yes: bool) -> &'static str {
    if yes { "yes" } else { "no" }
}
