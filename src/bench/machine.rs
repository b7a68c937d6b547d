//! On what a time was measured.

use serde::Serialize;

/// The machine, the program and the seed: printed on every chart and in every file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Machine {
    /// Name of the processor, or its architecture where the system does not tell.
    pub cpu: String,
    pub cores: usize,
    /// Threads that the timed work used.
    pub threads: usize,
    pub system: String,
    pub program: String,
    pub seed: u64,
    /// Wide vector instructions that the kernels use here.
    pub vectors: String,
}

impl Machine {
    /// This one.
    pub fn here(seed: u64) -> Self {
        Machine {
            cpu: cpu_name().unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            threads: rayon::current_num_threads(),
            system: std::env::consts::OS.to_owned(),
            program: concat!("asperity ", env!("CARGO_PKG_VERSION")).to_owned(),
            seed,
            vectors: vectors(),
        }
    }
}

impl std::fmt::Display for Machine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let plural = |n: usize| if n == 1 { "" } else { "s" };
        write!(
            f,
            "{}, {} core{}, {} thread{} used, {}, {}; {}, seed {}",
            self.cpu,
            self.cores,
            plural(self.cores),
            self.threads,
            plural(self.threads),
            self.vectors,
            self.system,
            self.program,
            self.seed
        )
    }
}

fn cpu_name() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|l| l.starts_with("model name"))?;
    let name = line.split_once(':')?.1.trim();
    (!name.is_empty()).then(|| name.to_owned())
}

/// The instruction set that the kernels were dispatched to.
fn vectors() -> String {
    let level = format!("{:?}", fearless_simd::Level::new());
    level.split(['(', ' ']).next().unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_statement_names_cores_threads_version_and_seed() {
        let text = Machine::here(7).to_string();
        for part in [" core", " used", "asperity ", "seed 7"] {
            assert!(text.contains(part), "{text}");
        }
    }
}
