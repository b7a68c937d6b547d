//! Rows of numbers in any usual spelling: separated by blanks, tabs, commas or semicolons, with decimal point or comma.

use super::NAME;
use crate::error::Fault;

/// A rectangular table and the lines above it.
pub struct Table<'a> {
    pub header: Vec<&'a str>,
    pub columns: usize,
    /// Row by row, NaN where a cell is empty or says that nothing was measured.
    pub values: Vec<f64>,
}

/// What parts the cells of a line.
#[derive(Clone, Copy, PartialEq)]
enum Separator {
    Blanks,
    Character(char),
}

#[derive(Clone, Copy)]
struct Style {
    separator: Separator,
    decimal_comma: bool,
}

const MISSING_WORDS: [&str; 12] = ["", "nan", "na", "n/a", "bad", "null", "-", "--", "---", "*", "***", "nodata"];

/// Whether a line holds at least two cells and all of them are numbers or words for a missing one.
pub fn is_row(line: &str) -> bool {
    style_of(line).is_some()
}

/// Reads everything from the first row on; blank lines and lines with `#` are skipped.
pub fn parse(text: &str) -> Result<Table<'_>, Fault> {
    let corrupt = |what: String| Fault::Corrupt { format: NAME, what };
    let mut header = Vec::new();
    let mut found: Option<(Style, usize)> = None;
    let mut values: Vec<f64> = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let Some((style, columns)) = found.or_else(|| Some((style_of(line)?, 0))) else {
            header.push(line);
            continue;
        };
        if line.trim().is_empty() || line.starts_with('#') {
            continue;
        }
        let before = values.len();
        for cell in cells(line, style.separator) {
            let value = number_in(cell, style.decimal_comma);
            values.push(value.ok_or_else(|| corrupt(format!("{cell:?} in line {} is not a number", number + 1)))?);
        }
        let width = values.len() - before;
        if columns != 0 && width != columns {
            return Err(corrupt(format!("line {} has {width} numbers, the first row {columns}", number + 1)));
        }
        found = Some((style, width));
    }
    let (style, columns) = found.ok_or(Fault::NotThisFormat(NAME))?;
    let columns = drop_empty_last_column(&mut values, columns, style);
    Ok(Table { header, columns, values })
}

/// Many programs end every line with a separator, which looks like one more column of nothing.
fn drop_empty_last_column(values: &mut Vec<f64>, columns: usize, style: Style) -> usize {
    let last_is_empty = || values.chunks(columns).all(|row| row[columns - 1].is_nan());
    if style.separator == Separator::Blanks || columns < 2 || !last_is_empty() {
        return columns;
    }
    let mut place = 0;
    values.retain(|_| {
        place += 1;
        place % columns != 0
    });
    columns - 1
}

/// The way in which a line can be read as numbers, if there is one.
fn style_of(line: &str) -> Option<Style> {
    let fits = |separator, decimal_comma| {
        let mut count = 0;
        let mut measured = 0;
        for cell in cells(line, separator) {
            count += 1;
            measured += usize::from(!number_in(cell, decimal_comma)?.is_nan());
        }
        // Words such as "NaN - -" alone do not make a row.
        (count >= 2 && measured >= 1).then_some(Style { separator, decimal_comma })
    };
    let with = |c: char| line.contains(c).then_some(Separator::Character(c));
    // A semicolon or tab parts cells even where commas are decimal; a comma does so only if nothing else does.
    let strong = with(';').or_else(|| with('\t'));
    match strong {
        Some(separator) => fits(separator, false).or_else(|| fits(separator, true)),
        None => with(',')
            .and_then(|comma| fits(comma, false))
            .or_else(|| fits(Separator::Blanks, false))
            .or_else(|| fits(Separator::Blanks, true)),
    }
}

fn cells(line: &str, separator: Separator) -> Box<dyn Iterator<Item = &str> + '_> {
    match separator {
        Separator::Blanks => Box::new(line.split_whitespace()),
        Separator::Character(c) => Box::new(line.split(c).map(str::trim)),
    }
}

fn number_in(cell: &str, decimal_comma: bool) -> Option<f64> {
    let cell = cell.trim_matches('"');
    if let Ok(value) = cell.parse::<f64>() {
        return Some(value);
    }
    if MISSING_WORDS.iter().any(|word| cell.eq_ignore_ascii_case(word)) {
        return Some(f64::NAN);
    }
    if decimal_comma && cell.contains(',') { cell.replacen(',', ".", 1).parse().ok() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_spelling_gives_the_same_table() {
        for text in [
            "1.5 -2 3e1\n4 nan 6\n",
            "a header\r\n\r\n1.5, -2, 3e1\r\n4,,6\r\n",
            "1.5,-2,3e1,\n4,BAD,6,\n",
            "1,5;-2;3e1\n4;;6\n",
            "# x\n1,5\t-2\t3e1\n4\t\t6\n",
            "\"1.5\";\"-2\";\"3e1\"\n4;--;6\n\n",
            "  1,5  -2   3e1\n  4    *   6",
        ] {
            let table = parse(text).unwrap();
            assert_eq!(table.columns, 3, "{text:?}");
            assert_eq!(table.values[..4], [1.5, -2.0, 30.0, 4.0], "{text:?}");
            assert!(table.values[4].is_nan() && table.values[5] == 6.0, "{text:?}");
        }
    }

    #[test]
    fn prose_and_lists_are_no_rows() {
        for line in ["Dear reader, 2 and 3", "2024-01-02 10:20", "17", "", "x;y;z", "- -"] {
            assert!(!is_row(line), "{line:?}");
        }
    }

    #[test]
    fn uneven_rows_are_named() {
        let says = |text: &str| parse(text).err().unwrap().to_string();
        assert!(says("1 2 3\n4 5\n").contains("line 2 has 2 numbers, the first row 3"));
        assert!(says("1 2 3\n\n4 x 6\n").contains("\"x\" in line 3"));
    }
}
