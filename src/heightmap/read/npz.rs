//! NumPy `.npz`: an archive of `.npy` arrays, one of which is the matrix of heights.
//!
//! The array called `heights`, `height`, `z` or `data` is taken, else the only matrix there is.

use super::{ReadOptions, npy};
use crate::archive::Archive;
use crate::error::Fault;
use crate::heightmap::RawMap;

pub const NAME: &str = "npz";

const USUAL_NAMES: [&str; 4] = ["heights", "height", "z", "data"];

/// A ZIP whose first member is an array.
pub fn recognises(bytes: &[u8]) -> bool {
    let name_length = bytes.get(26..28).map_or(0, |b| usize::from(u16::from_le_bytes([b[0], b[1]])));
    bytes.starts_with(b"PK\x03\x04") && bytes.get(30..30 + name_length).is_some_and(|name| name.ends_with(b".npy"))
}

pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    let mut archive = Archive::open(bytes, NAME)?;
    let arrays: Vec<String> = archive.names().iter().filter(|n| n.ends_with(".npy")).cloned().collect();
    let usual = USUAL_NAMES.iter().find_map(|name| arrays.iter().find(|a| **a == format!("{name}.npy")));
    if let Some(name) = usual {
        return matrix(&archive.read(name, u64::MAX)?, name, options);
    }
    let mut matrices = Vec::new();
    for name in &arrays {
        let content = archive.read(name, u64::MAX)?;
        if crate::npy::decode(&content).is_ok_and(|array| array.shape.len() == 2) {
            matrices.push((name, content));
        }
        if matrices.len() > 1 {
            break;
        }
    }
    match &matrices[..] {
        [(name, content)] => matrix(content, name, options),
        _ => Err(Fault::Unsupported {
            format: NAME,
            what: format!("an archive with the arrays {}", arrays.join(", ")),
            advice: "call the matrix of heights `heights`".to_owned(),
        }),
    }
}

fn matrix(content: &[u8], name: &str, options: &ReadOptions) -> Result<RawMap, Fault> {
    let mut map = npy::read(content, options)?;
    map.format = NAME;
    map.notes.push(("array".to_owned(), name.trim_end_matches(".npy").to_owned()));
    Ok(map)
}
