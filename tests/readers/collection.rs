//! Every file of the shared collection: read, or refused as what it is.

use crate::shared_folder;
use asperity::Error;
use asperity::error::Fault;
use asperity::heightmap::read::{ReadOptions, read};
use std::path::{Path, PathBuf};

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|e| e.path()) {
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_none_or(|e| e != "md") {
            found.push(path);
        }
    }
}

/// Point clouds, profiles and surfaces on irregular axes are unsupported, by their kind; all others are maps.
#[test]
fn every_file_is_read_or_refused_as_what_it_is() {
    let mut all = Vec::new();
    files(&shared_folder(), &mut all);
    if all.is_empty() {
        eprintln!("SKIPPED: no files; set ASPERITY_SHARED to the folder that holds heightmaps/");
        return;
    }
    let (mut maps, mut refused) = (0, 0);
    for path in &all {
        let name = path.file_name().unwrap().to_string_lossy();
        let kind = [
            ("profile", "a profile of"),
            ("point_cloud", "a point cloud of"),
            ("surface_irregular", "no regular grid"),
        ]
        .into_iter()
        .find(|(start, _)| name.starts_with(start));
        match (read(path, &ReadOptions::default()), kind) {
            (Ok(map), None) => {
                assert!(map.heights.iter().all(|h| h.is_finite() || h.is_nan()), "{name}");
                maps += 1;
            }
            (Err(error), Some((_, says))) => {
                assert!(matches!(error, Error::File { fault: Fault::Unsupported { .. }, .. }), "{error}");
                assert!(error.to_string().contains(says) && error.to_string().contains(&*name), "{error}");
                refused += 1;
            }
            // A build without HDF5 refuses these by design.
            (Err(_), None) if name.ends_with("datx") && !cfg!(feature = "datx") => {}
            (Ok(_), Some((_, says))) => panic!("{name} was read although it is {says}"),
            (Err(error), None) => panic!("{error}"),
        }
    }
    eprintln!("{} files: {maps} maps, {refused} refused", all.len());
    assert!(maps > 0 && refused > 0);
}
