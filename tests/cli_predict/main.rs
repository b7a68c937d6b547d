//! `asperity predict` and its neighbours as a user meets them: the built program, its files, its words, its exit code.

mod bad_maps;
mod glossmeter;
mod json;
mod real_maps;
mod threads;
mod usage;

use asperity::heightmap::{RawMap, write};
use ndarray::Array2;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Small pictures: what is tested here is not how they look.
const QUICK: [&str; 4] = ["--tile-width", "64", "--spp", "16"];

/// What one call of the program left behind.
struct Run {
    code: i32,
    stdout: String,
    stderr: String,
}

/// Calls the program; whatever happens it must end by itself with 0, 1 or 2, and never by a panic.
fn asperity<S: AsRef<OsStr>>(arguments: impl IntoIterator<Item = S>) -> Run {
    let out = Command::new(env!("CARGO_BIN_EXE_asperity")).args(arguments).output().expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("the program writes UTF-8");
    let run = Run {
        code: out.status.code().expect("no signal ended the program"),
        stdout: text(out.stdout),
        stderr: text(out.stderr),
    };
    assert!(!run.stderr.contains("panicked"), "{}", run.stderr);
    assert!((0..=2).contains(&run.code), "exit code {}", run.code);
    run
}

impl Run {
    /// Lines of stderr that report an error.
    fn errors(&self) -> Vec<&str> {
        self.stderr.lines().filter(|l| l.starts_with("error:")).collect()
    }

    /// The one JSON object that stdout is.
    #[track_caller]
    fn json(&self) -> serde_json::Value {
        let values: Vec<serde_json::Value> = serde_json::Deserializer::from_str(&self.stdout)
            .into_iter()
            .collect::<Result<_, _>>()
            .unwrap_or_else(|e| panic!("{e} in {}", self.stdout));
        assert_eq!(values.len(), 1, "{}", self.stdout);
        assert!(values[0].is_object());
        values[0].clone()
    }
}

/// A call with paths and flags mixed.
fn words<'a>(parts: &[&'a dyn AsRef<OsStr>]) -> Vec<&'a OsStr> {
    parts.iter().map(|p| (*p).as_ref()).collect()
}

/// A rough map by `asperity synth`, 192 x 192 at 1 um.
fn synth(path: &Path, sq: &str, seed: &str) {
    let run = asperity(words(&[
        &"synth", &"-o", &path, &"--sq", &sq, &"--acl", &"8um", &"--size", &"192", &"--pitch", &"1um", &"--seed", &seed,
    ]));
    assert_eq!(run.code, 0, "{}", run.stderr);
}

/// A map of given heights [m] at 1 um.
fn map(heights: Array2<f64>) -> RawMap {
    RawMap { heights, pitch_x: 1e-6, pitch_y: 1e-6, format: "test", notes: Vec::new() }
}

fn write_npy(path: &Path, heights: Array2<f64>) {
    write::npy::write(path, &map(heights), write::npy::Precision::Float64).expect("the folder is writable");
}

/// Names in a folder, sorted.
fn listing(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the folder is there");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// A file of the shared collection, or `None` with a loud line if the collection is not there.
fn shared(name: &str) -> Option<PathBuf> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared");
    let folder = std::env::var_os("ASPERITY_SHARED").map_or_else(|| PathBuf::from(default), PathBuf::from);
    let path = folder.join("heightmaps").join(name);
    if !path.exists() {
        eprintln!("SKIPPED: {} is absent; set ASPERITY_SHARED to the folder that holds heightmaps/", path.display());
        return None;
    }
    Some(path)
}
