//! Reference tables that lie beside the repository: `../shared/reference`, or `reference` below `$ASPERITY_SHARED`.

use std::collections::HashMap;
use std::path::PathBuf;

/// A CSV file of numbers; fields that are not numbers stay text.
pub struct Table {
    columns: Vec<String>,
    lines: Vec<Vec<String>>,
}

impl Table {
    /// Rows by column name; text fields are left out.
    pub fn rows(&self) -> impl Iterator<Item = HashMap<String, f64>> + '_ {
        self.lines.iter().map(|line| {
            self.columns
                .iter()
                .zip(line)
                .filter_map(|(name, field)| Some((name.clone(), field.parse().ok()?)))
                .collect()
        })
    }

    /// Text of one field.
    #[allow(dead_code)]
    pub fn text(&self, line: usize, column: &str) -> &str {
        let k = self.columns.iter().position(|c| c == column).expect(column);
        &self.lines[line][k]
    }
}

/// The table of that name, or `None` with a loud notice if it is not there.
pub fn table(name: &str) -> Option<Table> {
    let shared = std::env::var_os("ASPERITY_SHARED")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared"), PathBuf::from);
    let path = shared.join("reference").join(name);
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("SKIPPED: {} is not there; set ASPERITY_SHARED to the folder that holds reference/", path.display());
        return None;
    };
    let split = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let columns = split(lines.next().unwrap_or_default());
    Some(Table { columns, lines: lines.map(split).collect() })
}
