//! A run in one go or in parts: what a part leaves behind and how parts become the whole.

use super::accumulator::Accumulator;
use super::choice::Options;
use super::selection::Part;
use crate::error::{Error, Result};
use crate::heightmap::HeightMap;
use crate::output::write_atomically;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// How the sums of a run come about.
///
/// Every run sums its beams in one fixed order of incident directions and sub-areas; parts hold their shares of those sums.
#[derive(Debug)]
pub enum Run {
    /// All at once.
    Whole,
    /// Only a part, whose sums are kept.
    Part(Sums),
    /// Nothing is traced: the merged sums of all parts are read back in order.
    Merged { sums: Sums, next: usize },
}

impl Run {
    /// The sum of the next item, computed over the part of the beams that this run takes, or read back.
    pub fn sum(&mut self, compute: impl FnOnce(Part) -> Accumulator) -> Accumulator {
        match self {
            Run::Whole => compute(Part::default()),
            Run::Part(sums) => {
                let sum = compute(sums.part);
                sums.sums.push(sum.clone());
                sum
            }
            Run::Merged { sums, next } => {
                *next += 1;
                sums.sums[*next - 1].clone()
            }
        }
    }

    /// Whether the numbers of this run are those of the whole.
    pub fn is_whole(&self) -> bool {
        !matches!(self, Run::Part(_))
    }

    /// Refuses merged sums of another map or of other options.
    ///
    /// # Errors
    /// `Error::Parameter` if the sums are not `items` in number or belong to another fingerprint.
    pub fn check(&self, fingerprint: &str, items: usize) -> Result<()> {
        match self {
            Run::Merged { sums, .. } if sums.fingerprint != fingerprint || sums.sums.len() != items => {
                Err(Error::parameter(
                    "the parts were made from another map, with other options or by another version",
                    "merge with the same map and the same flags as the parts, only with --merge instead of --part",
                ))
            }
            _ => Ok(()),
        }
    }
}

/// The sums of one part of a run, as they are stored.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Sums {
    /// What the file is.
    format: String,
    part: Part,
    /// Of map and options: parts of different runs must not be merged.
    pub fingerprint: String,
    sums: Vec<Accumulator>,
}

const FORMAT: &str = "asperity sums of a part, version 1";

impl Sums {
    /// An empty part of the run with this fingerprint.
    pub fn new(part: Part, fingerprint: String) -> Self {
        Sums { format: FORMAT.to_owned(), part, fingerprint, sums: Vec::new() }
    }

    /// Which part this is.
    pub fn part(&self) -> Part {
        self.part
    }

    /// Writes the part as JSON.
    ///
    /// # Errors
    /// `Error::Io` naming the file.
    pub fn save(&self, path: &Path) -> Result<()> {
        write_atomically(path, |f| serde_json::to_writer(f, self).map_err(std::io::Error::other))
    }

    /// Reads a part.
    ///
    /// # Errors
    /// `Error::Io` if the file cannot be read, `Error::Content` if it is not a part.
    pub fn load(path: &Path) -> Result<Self> {
        let text = std::fs::read(path).map_err(|e| Error::io(path, "read", e))?;
        let advice = "give the files that `asperity brdf --part K/N -o FILE` wrote";
        let sums: Sums = serde_json::from_slice(&text)
            .map_err(|e| Error::content(path, format!("this is not a part of a run ({e})"), advice))?;
        if sums.format != FORMAT {
            return Err(Error::content(path, format!("this is `{}`, not `{FORMAT}`", sums.format), advice));
        }
        Ok(sums)
    }

    /// Reads all parts of a run and adds them up; the order of the files does not matter.
    ///
    /// # Errors
    /// `Error::Content` naming the file that does not belong to the others, comes twice, or lacks a companion.
    pub fn merge(paths: &[PathBuf]) -> Result<Self> {
        let mut paths = paths.iter();
        let first = paths.next().ok_or_else(|| Error::parameter("there is nothing to merge", "name the parts"))?;
        let mut whole = Sums::load(first)?;
        let of = whole.part.of();
        let mut seen = vec![whole.part.number()];
        for path in paths {
            let other = Sums::load(path)?;
            if other.fingerprint != whole.fingerprint || other.part.of() != of || other.sums.len() != whole.sums.len() {
                let what = format!("this part is not of the same run as {}", first.display());
                return Err(Error::content(path, what, "make all parts with the same map and flags, only K differs"));
            }
            if seen.contains(&other.part.number()) {
                let what = format!("part {} comes twice", other.part);
                return Err(Error::content(path, what, "name every part once"));
            }
            seen.push(other.part.number());
            for (a, b) in whole.sums.iter_mut().zip(&other.sums) {
                if a.detectors() != b.detectors() {
                    return Err(Error::content(
                        path,
                        "its detectors are not those of the other parts",
                        "make it again",
                    ));
                }
                a.merge(b);
            }
        }
        match (0..of).find(|k| !seen.contains(k)) {
            Some(missing) => Err(Error::content(
                first,
                format!("part {}/{of} of its run is missing", missing + 1),
                "name all parts; one can be made again on its own",
            )),
            None => Ok(whole),
        }
    }
}

/// A word that differs between runs whose sums must not be added: of the heights, the options and anything else that
/// decides what is summed.
pub fn fingerprint(map: &HeightMap, options: &Options, more: &str) -> String {
    let mut md5 = md5::Context::new();
    for h in &map.heights {
        md5.consume(h.to_le_bytes());
    }
    let HeightMap { heights, pitch_x, pitch_y, edges, .. } = map;
    let version = env!("CARGO_PKG_VERSION");
    md5.consume(format!("{:?} {pitch_x:e} {pitch_y:e} {edges:?} {options:?} {more} {version}", heights.dim()));
    format!("{:x}", md5.finalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(k: u64, n: u64, fingerprint: &str) -> Sums {
        let mut run = Run::Part(Sums::new(Part::new(k, n).unwrap(), fingerprint.to_owned()));
        for item in 0..3 {
            run.sum(|part| {
                let mut sum = Accumulator::new(40);
                for beam in (0..100u64).filter(|b| part.has(*b)) {
                    sum.escaped((beam % 7) as usize, 1 + (beam % 2) as u32, 0.1 + item as f64, 0.9);
                    sum.asked((beam % 40) as usize, 1);
                }
                sum
            });
        }
        let Run::Part(sums) = run else { panic!() };
        sums
    }

    #[test]
    fn parts_survive_the_disk_and_add_up() {
        let dir = tempfile::tempdir().unwrap();
        let path = |name: &str| dir.path().join(name);
        for k in 1..=3 {
            part(k, 3, "x").save(&path(&format!("{k}"))).unwrap();
        }
        let whole = part(1, 1, "x");
        let merged = Sums::merge(&[path("3"), path("1"), path("2")]).unwrap();
        assert_eq!(merged.sums, whole.sums);
        let mut run = Run::Merged { sums: merged, next: 0 };
        assert_eq!(run.sum(|_| panic!("nothing is computed")), whole.sums[0]);
        assert!(run.check("x", 3).is_ok() && run.check("y", 3).is_err() && run.check("x", 4).is_err());

        part(2, 3, "other").save(&path("stranger")).unwrap();
        std::fs::write(path("text"), "hello").unwrap();
        for (files, word) in [
            (vec!["1", "2"], "part 3/3 of its run is missing"),
            (vec!["1", "2", "2", "3"], "part 2/3 comes twice"),
            (vec!["1", "stranger", "3"], "not of the same run"),
            (vec!["1", "text"], "not a part"),
            (vec!["1", "absent"], "cannot read"),
            (vec![], "nothing to merge"),
        ] {
            let files: Vec<PathBuf> = files.into_iter().map(path).collect();
            let error = Sums::merge(&files).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        }
    }
}
