//! Comma-separated text with named columns: directions, measured scans, lists of `f_r`.

use crate::error::{Error, Result};
use std::path::{Path, PathBuf};

/// A table of text fields under names; lines that are empty or start with `#` do not count.
#[derive(Debug, Clone)]
pub struct Columns {
    path: PathBuf,
    names: Vec<String>,
    /// Line number in the file, from 1, and the fields.
    rows: Vec<(usize, Vec<String>)>,
}

impl Columns {
    /// Reads a file; its first line that counts holds the names.
    ///
    /// # Errors
    /// `Error::Io` if it cannot be read, `Error::Content` naming the line if a row is shorter or longer than the header, or
    /// there is no row.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|e| Error::io(path, "read", e))?;
        let text = String::from_utf8(bytes)
            .map_err(|_| Error::content(path, "it is not text", "write it as comma-separated UTF-8 text"))?;
        Columns::parse(path, &text)
    }

    /// The same from text; `path` is for error messages.
    ///
    /// # Errors
    /// As [`Columns::read`].
    pub fn parse(path: &Path, text: &str) -> Result<Self> {
        let fields = |line: &str| line.split(',').map(|f| f.trim().trim_matches('"').to_owned()).collect::<Vec<_>>();
        let mut lines = text
            .trim_start_matches('\u{feff}')
            .lines()
            .enumerate()
            .map(|(k, line)| (k + 1, line.trim()))
            .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let names = lines.next().map(|(_, line)| fields(line)).unwrap_or_default();
        let rows: Vec<(usize, Vec<String>)> = lines.map(|(k, line)| (k, fields(line))).collect();
        if let Some((k, row)) = rows.iter().find(|(_, row)| row.len() != names.len()) {
            return Err(Error::content(
                path,
                format!("line {k} has {} fields, the header {}", row.len(), names.len()),
                "give every line one field per column",
            ));
        }
        if rows.is_empty() {
            return Err(Error::content(
                path,
                if names.is_empty() { "the file is empty" } else { "there are no rows" },
                "give a line of column names and at least one of numbers",
            ));
        }
        Ok(Columns { path: path.to_owned(), names, rows })
    }

    /// The file, for messages.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Never true: a table without rows is refused.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Whether there is a column of that name.
    pub fn has(&self, name: &str) -> bool {
        self.names.iter().any(|n| n == name)
    }

    /// The text of a column.
    ///
    /// # Errors
    /// `Error::Content` listing the columns there are.
    pub fn texts(&self, name: &str) -> Result<Vec<&str>> {
        let column = self.names.iter().position(|n| n == name).ok_or_else(|| {
            Error::content(
                &self.path,
                format!("there is no column `{name}` (there are {})", self.names.join(", ")),
                "name the columns in the first line",
            )
        })?;
        Ok(self.rows.iter().map(|(_, row)| row[column].as_str()).collect())
    }

    /// The finite numbers of a column.
    ///
    /// # Errors
    /// `Error::Content` naming the column that is missing, or the line that is not a number.
    pub fn numbers(&self, name: &str) -> Result<Vec<f64>> {
        let texts = self.texts(name)?;
        let number = |((k, _), text): (&(usize, Vec<String>), &str)| {
            text.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| {
                self.fault(
                    *k,
                    format!("`{name}` is `{text}`, not a number"),
                    "write a finite number with a decimal point",
                )
            })
        };
        self.rows.iter().zip(texts).map(number).collect()
    }

    /// The same, `None` if there is no such column.
    ///
    /// # Errors
    /// `Error::Content` naming the line that is not a number.
    pub fn optional_numbers(&self, name: &str) -> Result<Option<Vec<f64>>> {
        if self.has(name) { self.numbers(name).map(Some) } else { Ok(None) }
    }

    /// The numbers of a column, each between `low` and `high`.
    ///
    /// # Errors
    /// As [`Columns::numbers`], and naming the first line outside.
    pub fn numbers_within(&self, name: &str, low: f64, high: f64) -> Result<Vec<f64>> {
        let numbers = self.numbers(name)?;
        match numbers.iter().position(|v| !(*v >= low && *v <= high)) {
            Some(row) => Err(self.row_fault(
                row,
                format!("`{name}` is {}, outside {low} to {high}", numbers[row]),
                "correct or leave out that line",
            )),
            None => Ok(numbers),
        }
    }

    /// An error about row number `row`, counted from 0.
    pub fn row_fault(&self, row: usize, what: impl std::fmt::Display, advice: &str) -> Error {
        self.fault(self.rows[row].0, what, advice)
    }

    fn fault(&self, line: usize, what: impl std::fmt::Display, advice: &str) -> Error {
        Error::content(&self.path, format!("line {line}: {what}"), advice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Columns> {
        Columns::parse(Path::new("scan.csv"), text)
    }

    #[test]
    fn reads_named_numbers_between_comments() {
        let c = parse("\u{feff}# a scan\ntheta_deg, f_r ,note\n0,1.5,peak\n\n# more\n10,2e-3,\"tail\"\n").unwrap();
        assert_eq!(c.numbers("f_r").unwrap(), [1.5, 2e-3]);
        assert_eq!(c.texts("note").unwrap(), ["peak", "tail"]);
        assert_eq!(c.optional_numbers("error").unwrap(), None);
        assert_eq!((c.len(), c.has("note")), (2, true));
    }

    #[test]
    fn faults_name_file_line_and_column() {
        let message = |text: &str| parse(text).and_then(|c| c.numbers_within("a", 0.0, 90.0)).unwrap_err().to_string();
        for (text, what) in [
            ("", "is empty"),
            ("a,b\n", "no rows"),
            ("a,b\n1\n", "line 2 has 1 fields"),
            ("b\n1\n", "no column `a`"),
            ("a\n1\nx\n", "line 3: `a` is `x`"),
            ("a\nnan\n", "not a number"),
            ("# c\na\n95\n", "line 3: `a` is 95, outside"),
        ] {
            let m = message(text);
            assert!(m.contains("scan.csv") && m.contains(what), "{text:?}: {m}");
        }
    }
}
