#![doc = include_str!("../../../docs/scene.md")]

mod build;
mod materials;
mod schema;
mod shapes;

pub use build::{Described, Picturing};
pub use materials::{Materials, Wanted};

use crate::error::{Error, Result};
use schema::File;
use std::path::{Path, PathBuf};

/// The page that explains scene files.
pub const PAGE: &str = include_str!("../../../docs/scene.md");

/// A scene file that was read but not yet built.
pub struct Description {
    file: File,
    place: Place,
}

/// Where the text came from: what errors name.
pub(super) struct Place {
    /// The scene file; files in it are looked for beside it.
    path: PathBuf,
    text: String,
}

impl Description {
    /// Reads a scene file.
    ///
    /// # Errors
    /// `Error::Io` naming the file, or as [`Description::parse`].
    pub fn load(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
        Self::parse(&text, path)
    }

    /// Reads a scene from text; `path` is named in errors, and other files are looked for beside it.
    ///
    /// # Errors
    /// `Error::Content` naming `path`, the line and the key.
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        let place = Place { path: path.to_owned(), text: text.to_owned() };
        let file: File = toml::from_str(text).map_err(|e| {
            let at = e.span().map_or(0, |span| span.start);
            place.error_at(at, e.message().replace('\n', " "), "`asperity render --explain` explains every key")
        })?;
        Ok(Description { file, place })
    }
}

impl Place {
    /// Line number of a byte of the text, from 1.
    fn line(&self, byte: usize) -> usize {
        self.text.get(..byte).map_or(1, |before| before.matches('\n').count() + 1)
    }

    /// An error at a byte of the text.
    fn error_at(&self, byte: usize, what: impl std::fmt::Display, advice: impl Into<String>) -> Error {
        Error::content(&self.path, format!("line {}: {what}", self.line(byte)), advice)
    }

    /// An error about a key of the table that fills the bytes `table`: at the line of the key, if it is there.
    fn error_in(
        &self,
        table: &std::ops::Range<usize>,
        key: &str,
        what: impl std::fmt::Display,
        advice: impl Into<String>,
    ) -> Error {
        self.error_at(self.key(table, key), what, advice)
    }

    /// First byte of the line that sets `key` in the table that starts with the bytes `table`.
    fn key(&self, table: &std::ops::Range<usize>, key: &str) -> usize {
        let mut at = table.start;
        for (number, line) in self.text.get(table.start..).unwrap_or("").split_inclusive('\n').enumerate() {
            let trimmed = line.trim_start();
            if number > 0 && trimmed.starts_with('[') {
                break;
            }
            if trimmed.strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with('=')) {
                return at;
            }
            at += line.len();
        }
        table.start
    }

    /// A file that the scene names.
    fn beside(&self, name: &str) -> PathBuf {
        self.path.parent().map_or_else(|| PathBuf::from(name), |folder| folder.join(name))
    }
}
