//! On what the times were taken.

use serde::Serialize;

/// The machine and the program, to be printed beside every time.
#[derive(Debug, Clone, Serialize)]
pub struct Machine {
    pub processor: String,
    pub cores: usize,
    pub threads: usize,
    pub system: String,
    pub version: String,
    /// Whether the program was compiled with optimisation.
    pub optimised: bool,
}

impl Machine {
    /// As far as the system tells.
    pub fn here() -> Self {
        let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let named = info.lines().find(|l| l.starts_with("model name")).and_then(|l| l.split(':').nth(1));
        Machine {
            processor: named.map_or_else(|| std::env::consts::ARCH.to_owned(), |n| n.trim().to_owned()),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            threads: rayon::current_num_threads(),
            system: std::env::consts::OS.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            optimised: !cfg!(debug_assertions),
        }
    }
}

impl std::fmt::Display for Machine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Machine { processor, cores, threads, system, version, optimised } = self;
        let build = if *optimised { "" } else { ", built without optimisation" };
        let s = if *threads == 1 { "" } else { "s" };
        write!(f, "{processor}, {cores} cores, {threads} thread{s}, {system}; asperity {version}{build}")
    }
}

/// Peak resident memory of this process so far \[bytes\], where the system tells.
pub fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|kib| 1024.0 * kib)
}
