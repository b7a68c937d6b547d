//! Files appear whole or not at all: write under a temporary name in the target folder, then rename.

use crate::error::{Error, Result};
use image::ImageEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Temporary files being written.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Calls `write` with a buffered temporary file beside `path` and renames it to `path` when it succeeds.
///
/// # Errors
/// `Error::Io` naming `path`; the target keeps its former content.
pub fn write_atomically<F>(path: &Path, write: F) -> Result<()>
where
    F: FnOnce(&mut BufWriter<std::fs::File>) -> std::io::Result<()>,
{
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".asperity-");
    // A temporary file is private by default; an output should be as readable as any other new file.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let temporary = builder.tempfile_in(folder).map_err(|e| Error::io(path, "create", e))?;
    let (file, name) = temporary.into_parts();
    let unfinished = Unfinished::new(name.to_path_buf());
    let mut buffered = BufWriter::new(file);
    write(&mut buffered).and_then(|()| buffered.flush()).map_err(|e| Error::io(path, "write", e))?;
    drop(buffered);
    let renamed = name.persist(path).map_err(|e| Error::io(path, "rename to", e.error));
    drop(unfinished);
    renamed
}

/// The bytes of a `.png` file of 8-bit sRGB, `size` columns and rows; the same picture gives the same bytes.
///
/// # Errors
/// `io::Error` if the picture is too large for the format.
pub fn png(rgb: &[u8], size: [usize; 2]) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let too_large = |_| std::io::Error::other("the picture is too large for a .png file");
    let [width, height] = [u32::try_from(size[0]).map_err(too_large)?, u32::try_from(size[1]).map_err(too_large)?];
    // The quick compression that is the encoder's default makes smooth pictures twice as large.
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
        .write_image(rgb, width, height, image::ExtendedColorType::Rgb8)
        .map_err(std::io::Error::other)?;
    Ok(bytes)
}

/// Ends the program with `code` after taking away the files it was writing.
pub fn abandon(code: i32) -> ! {
    let names = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    for name in names.iter() {
        // Gone already if it was just renamed.
        let _ = std::fs::remove_file(name);
    }
    // The lock is held to the end: no other thread begins a file.
    std::process::exit(code)
}

/// A name on the list of unfinished files while it lives.
struct Unfinished(PathBuf);

impl Unfinished {
    fn new(name: PathBuf) -> Self {
        UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).push(name.clone());
        Unfinished(name)
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).retain(|name| *name != self.0);
    }
}

/// Writes `bytes` to `path` atomically.
///
/// # Errors
/// As [`write_atomically`].
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    write_atomically(path, |f| f.write_all(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_keeps_the_old_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        write_bytes(&path, b"old").unwrap();
        let failed = write_atomically(&path, |f| {
            f.write_all(b"half")?;
            Err(std::io::Error::other("planted"))
        });
        assert!(failed.unwrap_err().to_string().contains("a.txt"));
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
    }
}
