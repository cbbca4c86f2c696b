//! The machine and the program that a report's figures are of.

use std::time::SystemTime;

use kugelblitz::Result;
use kugelblitz::gpu::{AdapterFacts, Arithmetic, Gpu};
use serde::Serialize;

use super::figures::count;

/// The machine and the program.
#[derive(Clone, Debug, Serialize)]
pub struct Environment {
    /// The program's version.
    pub version: String,
    /// The commit that it was built from, where the build was told.
    pub commit: Option<String>,
    /// Date and time of the start, UTC, as in `2026-11-21T07:00:00Z`.
    pub date: String,
    /// The command line.
    pub command: String,
    /// The host's operating system.
    pub system: String,
    /// The host's CPU.
    pub host_cpu: String,
    /// The CPU's logical cores.
    pub n_cores: usize,
    /// The adapters, the best first.
    pub adapters: Vec<AdapterArithmetic>,
}

/// An adapter and what its arithmetic really does.
#[derive(Clone, Debug, Serialize)]
pub struct AdapterArithmetic {
    /// The adapter's own account of itself.
    #[serde(flatten)]
    pub facts: AdapterFacts,
    /// The self-test's findings in f32.
    pub arithmetic_f32: Arithmetic,
    /// The self-test's findings in f64; `None` where the device has none.
    pub arithmetic_f64: Option<Arithmetic>,
}

impl AdapterArithmetic {
    /// Measures what the device's arithmetic does.
    ///
    /// # Errors
    /// Those of [`Gpu::arithmetic`].
    pub fn of(gpu: &Gpu) -> Result<AdapterArithmetic> {
        Ok(AdapterArithmetic {
            facts: gpu.facts.clone(),
            arithmetic_f32: gpu.arithmetic()?,
            arithmetic_f64: gpu.arithmetic_f64()?,
        })
    }
}

impl Environment {
    /// Describes this machine, now. `command` is what the user typed; `commit` is what the program was
    /// built from.
    pub fn collect(
        command: String,
        commit: Option<&str>,
        adapters: Vec<AdapterArithmetic>,
    ) -> Environment {
        let unknown = || "unknown".to_string();
        let n_cores = std::thread::available_parallelism().map_or(1, usize::from);
        Environment {
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
        let program = program(&self.version, self.commit.as_deref());
        let cores = count(self.n_cores, "core");
        let mut lines = vec![
            ("Program", program),
            ("Command", self.command.clone()),
            ("Begun", self.date.clone()),
            ("CPU", format!("{}, {cores}, {}", self.host_cpu, self.system)),
        ];
        for AdapterArithmetic { facts: adapter, arithmetic_f32, arithmetic_f64 } in &self.adapters {
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

/// `Kugelblitz 0.1.0, commit 9fc4bae1c0de`
pub fn program(version: &str, commit: Option<&str>) -> String {
    match commit {
        Some(commit) => format!("Kugelblitz {version}, commit {commit}"),
        None => format!("Kugelblitz {version}"),
    }
}

fn host_cpu() -> Option<String> {
    let mut system = sysinfo::System::new().ok()?;
    system.refresh_cpu_list(sysinfo::CpuRefreshKind::nothing());
    let brand = system.cpus().first()?.brand().trim().to_string();
    (!brand.is_empty()).then_some(brand)
}
