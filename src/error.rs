//! Errors that name the file, what is wrong and what to do about it.

use std::path::{Path, PathBuf};

/// Result of every fallible function of the library.
pub type Result<T> = std::result::Result<T, Error>;

/// What a reader found wrong with a file; the registry adds the file's name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// The bytes do not belong to the format: another reader may try.
    #[error("not a {0} file")]
    NotThisFormat(&'static str),
    /// The format is right but holds something that is not a height map we can use.
    #[error("{format}: {what} is not supported; {advice}")]
    Unsupported { format: &'static str, what: String, advice: String },
    /// The format is right but the bytes contradict themselves or end early.
    #[error("{format}: {what}; the file is damaged or truncated, copy or export it again")]
    Corrupt { format: &'static str, what: String },
    /// The heights are there, but pitch or unit is not.
    #[error("{format}: {what} is missing; {advice}")]
    MetadataMissing { format: &'static str, what: String, advice: String },
}

/// Any failure of the library, sorted by who can mend it.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused to read or write.
    #[error("{}: cannot {verb}: {cause}; {advice}", path.display())]
    Io { path: PathBuf, verb: &'static str, cause: String, advice: &'static str },
    /// A file is not what it should be.
    #[error("{}: {fault}", path.display())]
    File { path: PathBuf, fault: Fault },
    /// A file was read but what it holds cannot be used.
    #[error("{}: {what}; {advice}", path.display())]
    Content { path: PathBuf, what: String, advice: String },
    /// A parameter is outside its range.
    #[error("{what}; {advice}")]
    Parameter { what: String, advice: String },
}

impl Error {
    /// A failed system call on `path`.
    pub fn io(path: &Path, verb: &'static str, error: std::io::Error) -> Self {
        use std::io::ErrorKind::{InvalidData, IsADirectory, NotFound, PermissionDenied, StorageFull};
        let advice = match error.kind() {
            NotFound if verb == "read" => "check the name and the folder",
            NotFound => "make its folder first",
            PermissionDenied => "change its permissions or take another place",
            IsADirectory => "name a file",
            // What the standard library says of bytes that are no text.
            InvalidData => "this is no text file, name another",
            StorageFull => "make room on the disk",
            _ => "check the disk and try again",
        };
        // Errors that libraries wrap name temporary files, which say nothing to the user.
        let wrapped = error.raw_os_error().is_none() && error.kind() != std::io::ErrorKind::Other;
        let cause = if wrapped { error.kind().to_string() } else { error.to_string() };
        Error::Io { path: path.to_owned(), verb, cause, advice }
    }

    /// A usable file with unusable content.
    pub fn content(path: &Path, what: impl Into<String>, advice: impl Into<String>) -> Self {
        Error::Content { path: path.to_owned(), what: what.into(), advice: advice.into() }
    }

    /// A parameter outside its range.
    pub fn parameter(what: impl Into<String>, advice: impl Into<String>) -> Self {
        Error::Parameter { what: what.into(), advice: advice.into() }
    }
}
