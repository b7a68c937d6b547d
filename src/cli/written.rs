//! Names of files to write: the ending says what goes into a file, and a wrong one is refused before any work.

use std::path::{Path, PathBuf};

/// What follows the last dot, in small letters.
pub fn ending(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

fn named(text: &str, endings: &[&str]) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if endings.contains(&ending(&path).as_str()) {
        return Ok(path);
    }
    let list: Vec<String> = endings.iter().map(|e| format!(".{e}")).collect();
    Err(match list.split_last() {
        Some((last, before)) if !before.is_empty() => format!("name it {} or {last}", before.join(", ")),
        _ => format!("name it {}", list.concat()),
    })
}

pub fn csv(text: &str) -> Result<PathBuf, String> {
    named(text, &["csv"])
}

pub fn npy(text: &str) -> Result<PathBuf, String> {
    named(text, &["npy"])
}

pub fn png(text: &str) -> Result<PathBuf, String> {
    named(text, &["png"])
}

pub fn toml(text: &str) -> Result<PathBuf, String> {
    named(text, &["toml"])
}

/// A drawing.
pub fn drawing(text: &str) -> Result<PathBuf, String> {
    named(text, &["svg", "png"])
}

/// A rendered picture.
pub fn picture(text: &str) -> Result<PathBuf, String> {
    named(text, &["png", "exr"])
}

/// Numbers, or a page that shows them.
pub fn csv_or_png(text: &str) -> Result<PathBuf, String> {
    named(text, &["csv", "png"])
}

/// A height map.
pub fn map(text: &str) -> Result<PathBuf, String> {
    named(text, &["x3p", "sdf", "npy", "png"])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ending_decides() {
        assert_eq!(drawing("a b/c.d.SVG").unwrap(), Path::new("a b/c.d.SVG"));
        assert_eq!(picture("a.jpg").unwrap_err(), "name it .png or .exr");
        assert_eq!(map("a").unwrap_err(), "name it .x3p, .sdf, .npy or .png");
        assert_eq!(csv("csv").unwrap_err(), "name it .csv");
        assert!(csv(".csv").is_err() && csv("").is_err() && csv("a.csv/").is_ok());
    }
}
