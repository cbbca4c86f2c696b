//! The machine and the program that a report's figures are of.

use std::time::SystemTime;

use super::figures::count;
use super::{AdapterEvidence, Evidence};
use crate::error::Result;
use crate::gpu::Gpu;

impl AdapterEvidence {
    /// Measures what the device's arithmetic does.
    ///
    /// # Errors
    /// Those of [`Gpu::arithmetic`].
    pub fn of(gpu: &Gpu) -> Result<AdapterEvidence> {
        Ok(AdapterEvidence {
            facts: gpu.facts.clone(),
            arithmetic_f32: gpu.arithmetic()?,
            arithmetic_f64: gpu.arithmetic_f64()?,
        })
    }
}

impl Evidence {
    /// Of this machine, now. `command` is what the user typed; `commit` is what the program was
    /// built from.
    pub fn collect(
        command: String,
        commit: Option<&str>,
        adapters: Vec<AdapterEvidence>,
    ) -> Evidence {
        let unknown = || "unknown".to_string();
        let n_cores = std::thread::available_parallelism().map_or(1, usize::from);
        Evidence {
            version: env!("CARGO_PKG_VERSION").into(),
            commit: commit.map(str::to_string),
            date: humantime::format_rfc3339_seconds(SystemTime::now()).to_string(),
            command,
            system: sysinfo::System::long_os_version().unwrap_or_else(|_| unknown()),
            host_cpu: host_cpu().unwrap_or_else(unknown),
            n_cores,
            adapters,
        }
    }

    /// Each fact in words, with its name.
    pub(super) fn named_lines(&self) -> Vec<(&'static str, String)> {
        let commit = self.commit.as_ref().map(|commit| format!(", commit {commit}"));
        let program = format!("Kugelblitz {}{}", self.version, commit.unwrap_or_default());
        let cores = count(self.n_cores, "core");
        let mut lines = vec![
            ("Program", program),
            ("Command", self.command.clone()),
            ("Begun", self.date.clone()),
            ("CPU", format!("{}, {cores}, {}", self.host_cpu, self.system)),
        ];
        for AdapterEvidence { facts: adapter, arithmetic_f32, arithmetic_f64 } in &self.adapters {
            let f64 = arithmetic_f64.as_ref().map_or("none".to_string(), ToString::to_string);
            lines.extend([
                ("Adapter", format!("{} ({}), {}", adapter.name, adapter.kind, adapter.driver)),
                ("f32, measured", arithmetic_f32.to_string()),
                ("f64, measured", f64),
                ("Kernel certified", arithmetic_f32.filter_in_words().to_string()),
            ]);
        }
        lines
    }
}

fn host_cpu() -> Option<String> {
    let mut system = sysinfo::System::new().ok()?;
    system.refresh_cpu_list(sysinfo::CpuRefreshKind::nothing());
    let brand = system.cpus().first()?.brand().trim().to_string();
    (!brand.is_empty()).then_some(brand)
}
