//! Machine and program of a report.

use std::time::SystemTime;

use kugelblitz::Result;
use kugelblitz::gpu::{AdapterFacts, Arithmetic, Gpu};
use kugelblitz::words::count;
use serde::Serialize;

/// Machine and program.
#[derive(Clone, Debug, Serialize)]
pub struct Environment {
    /// Version of the program.
    pub version: String,
    /// Commit of the program; `null` if the build did not know it.
    pub commit: Option<String>,
    /// Date and time of the start, UTC, as in `2026-11-21T07:00:00Z`.
    pub date: String,
    /// Command line.
    pub command: String,
    /// Operating system.
    pub system: String,
    /// Name of the CPU.
    pub host_cpu: String,
    /// Number of logical cores.
    pub n_cores: usize,
    /// Adapters, the best first.
    pub adapters: Vec<AdapterArithmetic>,
}

/// Adapter with its measured arithmetic.
#[derive(Clone, Debug, Serialize)]
pub struct AdapterArithmetic {
    /// Name, driver and limits.
    #[serde(flatten)]
    pub facts: AdapterFacts,
    /// Measured arithmetic in f32.
    pub arithmetic_f32: Arithmetic,
    /// Measured arithmetic in f64; `null` without f64.
    pub arithmetic_f64: Option<Arithmetic>,
}

impl AdapterArithmetic {
    /// Measures the arithmetic of a device.
    ///
    /// # Errors
    /// Returns the errors of [`Gpu::arithmetic`].
    pub fn of(gpu: &Gpu) -> Result<AdapterArithmetic> {
        Ok(AdapterArithmetic {
            facts: gpu.facts.clone(),
            arithmetic_f32: gpu.arithmetic()?,
            arithmetic_f64: gpu.arithmetic_f64()?,
        })
    }
}

impl Environment {
    /// Describes this machine. `command` is the command line, `commit` the commit of the program.
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

    /// Returns the facts with their names.
    pub(crate) fn facts(&self) -> Vec<(&'static str, String)> {
        let commit = self.commit.iter().map(|commit| format!(", commit {commit}"));
        let cores = count(self.n_cores, "core");
        let mut facts = vec![
            ("Program", format!("Kugelblitz {}{}", self.version, commit.collect::<String>())),
            ("Command", self.command.clone()),
            ("Date", self.date.clone()),
            ("CPU", format!("{}, {cores}, {}", self.host_cpu, self.system)),
        ];
        for AdapterArithmetic { facts: adapter, arithmetic_f32, arithmetic_f64 } in &self.adapters {
            let f64 = arithmetic_f64.as_ref().map_or("none".to_string(), ToString::to_string);
            facts.extend([
                ("Adapter", format!("{} ({}), {}", adapter.name, adapter.kind, adapter.driver)),
                ("f32, measured", arithmetic_f32.to_string()),
                ("f64, measured", f64),
                ("Kernel certified", arithmetic_f32.filter_in_words().to_string()),
            ]);
        }
        facts
    }
}

fn host_cpu() -> Option<String> {
    let mut system = sysinfo::System::new().ok()?;
    system.refresh_cpu_list(sysinfo::CpuRefreshKind::nothing());
    let brand = system.cpus().first()?.brand().trim().to_string();
    (!brand.is_empty()).then_some(brand)
}
