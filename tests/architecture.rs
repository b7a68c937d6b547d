//! The house stands: no file uses a floor above its own.

use std::path::{Path, PathBuf};

/// Rooms from the ground up; those in one row share a floor and may not use each other.
const FLOORS: [&[&str]; 11] = [
    &["error", "output", "npy", "archive", "columns", "math"],
    &["optics"],
    &["heightmap"],
    &["facets"],
    &["scatter"],
    &["table", "model"],
    &["sample", "fit"],
    &["render", "meter"],
    &["chart", "figure"],
    &["report", "bench"],
    &["cli"],
];

fn floor(room: &str) -> Option<usize> {
    FLOORS.iter().position(|rooms| rooms.contains(&room))
}

/// Every upward or sideways use of `crate::ROOM` in the text of a file that lives in `room`.
fn violations(room: &str, text: &str) -> Vec<String> {
    let own = floor(room).unwrap_or_else(|| panic!("room `{room}` has no floor: add it to FLOORS and to lib.rs"));
    // Tests inside a file may look upstairs for their material.
    let code = text.split("#[cfg(test)]").next().unwrap_or(text);
    let mut found = Vec::new();
    for (number, line) in code.lines().enumerate() {
        let line = line.split("//").next().unwrap_or(line);
        for (at, _) in line.match_indices("crate::") {
            let rest = &line[at + "crate::".len()..];
            let names: Vec<&str> = match rest.strip_prefix('{') {
                Some(list) => list.split(['}', ',']).map(|n| n.trim().split("::").next().unwrap_or("")).collect(),
                None => vec![rest.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or("")],
            };
            for name in names {
                if let Some(used) = floor(name)
                    && name != room
                    && (used > own || (used == own && own > 0))
                {
                    found.push(format!("line {}: {room} (floor {own}) uses {name} (floor {used})", number + 1));
                }
            }
        }
    }
    found
}

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            files.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
    files
}

#[test]
fn no_arrow_points_upward() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    let mut seen = 0;
    for file in sources(&src) {
        let inside = file.strip_prefix(&src).unwrap();
        let room = inside.components().next().unwrap().as_os_str().to_string_lossy().replace(".rs", "");
        if room == "lib" || room == "main" {
            continue;
        }
        seen += 1;
        let text = std::fs::read_to_string(&file).unwrap();
        found.extend(violations(&room, &text).into_iter().map(|v| format!("{}: {v}", inside.display())));
    }
    assert!(seen > 50, "only {seen} files were looked at");
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn the_test_sees_an_upward_arrow() {
    assert_eq!(violations("facets", "use crate::scatter::Tally;").len(), 1);
    assert_eq!(violations("optics", "let x = crate::table::eval(a);").len(), 1);
    assert_eq!(violations("meter", "use crate::{math, render};").len(), 1);
    assert!(violations("table", "use crate::scatter::Tally;\n// use crate::cli::run;").is_empty());
    assert!(violations("math", "use crate::error::Result;").is_empty());
}
