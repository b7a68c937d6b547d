//! Mutation fuzzing of every reader, with an account of the memory it takes.
//!
//! A fixed number of rounds by default; for a long run, whose seeds go on from there:
//! `ASPERITY_FUZZ_SECONDS=600 cargo test --release --test fuzz_readers -- --nocapture`
//!
//! A mutant may be read or refused; it must not panic, take a second, or take more memory than a stated multiple of its
//! size: [`PLAIN`] bytes a byte, and for formats that can be compressed that for every byte that Deflate can unpack.

#[allow(dead_code)]
#[path = "../readers/handmade/mod.rs"]
mod handmade;
mod mutate;

use asperity::archive::unpack_limit;
use asperity::heightmap::read::{ReadOptions, read_bytes};
use asperity::math::random::CounterRng;
use mutate::Seed;
use peak_alloc::PeakAlloc;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Bytes of memory that a byte of an uncompressed file may cost.
const PLAIN: usize = 100;
/// Bytes of memory that an unpacked byte may cost.
const UNPACKED: usize = 32;
/// Bytes that a reader may take whatever the file.
const FIXED: usize = 64 << 10;

/// Fewest rounds over all files.
const ROUNDS: u64 = 800;

struct Target {
    name: String,
    seed: Seed,
    options: ReadOptions,
    compressed: bool,
    handmade: bool,
}

#[derive(Default)]
struct Outcome {
    read: u64,
    refused: u64,
    /// Largest memory taken, in bytes a byte of the file, of what exceeds [`FIXED`].
    dearest: f64,
    slowest: Duration,
}

#[test]
fn mutants_neither_panic_nor_take_more_than_their_share() {
    let seconds: f64 = std::env::var("ASPERITY_FUZZ_SECONDS").ok().and_then(|n| n.parse().ok()).unwrap_or(0.0);
    let targets = targets();
    let mut outcomes: Vec<Outcome> = targets.iter().map(|_| Outcome::default()).collect();
    let start = Instant::now();
    let mut round = 0u64;
    while round < ROUNDS || start.elapsed().as_secs_f64() < seconds {
        for (number, target) in targets.iter().enumerate() {
            // A large file takes its time, so it gets fewer turns.
            if round.is_multiple_of(1 + target.seed.size() as u64 / 4096) {
                try_one(target, CounterRng::new(0xf022, number as u32, round), &mut outcomes[number], round);
            }
        }
        round += 1;
    }
    for (target, o) in targets.iter().zip(&outcomes) {
        eprintln!(
            "{:40} {:>9} read {:>9} refused, at most {:>7.1} bytes a byte, slowest {:.1} ms",
            target.name,
            o.read,
            o.refused,
            o.dearest,
            o.slowest.as_secs_f64() * 1e3
        );
    }
    let mutants: u64 = outcomes.iter().map(|o| o.read + o.refused).sum();
    eprintln!("{mutants} mutants of {} files in {:.0} s", targets.len(), start.elapsed().as_secs_f64());
    // Where nothing is ever refused or ever read, the mutations do not test the reader.
    for (target, o) in targets.iter().zip(&outcomes).filter(|(t, _)| t.handmade) {
        assert!(o.read > 0 && o.refused > 0, "{}", target.name);
    }
}

fn try_one(target: &Target, mut rng: CounterRng, outcome: &mut Outcome, round: u64) {
    let mutant = target.seed.mutant(&mut rng);
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let start = Instant::now();
    let result = catch_unwind(AssertUnwindSafe(|| read_bytes(&mutant, &target.options)));
    let took = start.elapsed();
    let memory = MEMORY.peak_usage() - before;
    let keep = |what: &str| -> ! {
        let path = std::env::temp_dir().join(format!("mutant-{round}-{}", target.name.replace(['/', ' '], "-")));
        std::fs::write(&path, &mutant).unwrap();
        panic!("{}, round {round}: {what}; kept as {}", target.name, path.display());
    };
    let Ok(result) = result else { keep("the reader panicked") };
    match result {
        Ok(map) => {
            outcome.read += 1;
            if map.pitch_x.is_nan() || map.pitch_y.is_nan() || map.heights.iter().any(|h| h.is_infinite()) {
                keep("a pitch that is no number, or an infinite height");
            }
        }
        Err(fault) => {
            outcome.refused += 1;
            if fault.to_string().len() < 10 {
                keep("a fault without a sentence");
            }
        }
    }
    let allowed = match target.compressed {
        true => FIXED + UNPACKED * unpack_limit(mutant.len()) as usize,
        false => FIXED + PLAIN * mutant.len(),
    };
    if memory > allowed {
        keep(&format!("{memory} bytes of memory for a file of {}", mutant.len()));
    }
    outcome.dearest = outcome.dearest.max(memory.saturating_sub(FIXED) as f64 / mutant.len().max(1) as f64);
    outcome.slowest = outcome.slowest.max(took);
    if took > Duration::from_secs(2) {
        keep(&format!("{took:?} to read"));
    }
}

/// Every handmade file, archives also opened up, and the shared collection if it is there.
fn targets() -> Vec<Target> {
    let mut targets = Vec::new();
    for sample in handmade::samples() {
        add(&mut targets, sample.name, sample.file, sample.options, true);
    }
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared");
    let folder = std::env::var_os("ASPERITY_SHARED").map_or_else(|| PathBuf::from(default), PathBuf::from);
    let mut files = Vec::new();
    collect(&folder.join("heightmaps"), &mut files);
    if files.is_empty() {
        eprintln!("SKIPPED the shared collection: set ASPERITY_SHARED to the folder that holds heightmaps/");
    }
    for path in files {
        let name = path.strip_prefix(&folder).unwrap().display().to_string();
        add(&mut targets, &name, std::fs::read(&path).unwrap(), ReadOptions::default(), false);
    }
    targets
}

fn add(targets: &mut Vec<Target>, name: &str, file: Vec<u8>, options: ReadOptions, handmade: bool) {
    let starts = |magic: &[u8]| file.starts_with(magic);
    let compressed =
        starts(b"PK") || starts(b"\x89") || starts(b"DSCOMP") || starts(b"v/1\x01") || starts(b"II") || starts(b"MM");
    if starts(b"PK") {
        let mut archive = asperity::archive::Archive::open(&file, "test").unwrap();
        let names = archive.names().to_vec();
        let members = names.into_iter().map(|n| (n.clone(), archive.read(&n, u64::MAX).unwrap())).collect();
        targets.push(Target {
            name: format!("{name}, members"),
            seed: Seed::Members(members),
            options,
            compressed,
            handmade,
        });
    }
    let seed = if starts(b"\x89PNG") { Seed::Chunks(file) } else { Seed::Plain(file) };
    targets.push(Target { name: name.to_owned(), seed, options, compressed, handmade });
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_none_or(|e| e != "md") {
            files.push(path);
        }
    }
}
