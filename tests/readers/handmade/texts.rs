//! Text files.

use super::RAW;

fn lines(separator: &str, number: impl Fn(i32) -> String) -> String {
    let line = |row: &[i32; 4]| row.iter().map(|&v| number(v)).collect::<Vec<_>>().join(separator);
    RAW.iter().map(|row| line(row) + "\n").collect()
}

/// A matrix in nm as Gwyddion exports it, with size and unit in the header.
pub fn gwyddion_matrix() -> Vec<u8> {
    let header = "# Channel: Height\n# Width: 8.0 \u{b5}m\n# Height: 9.0 \u{b5}m\n# Value units: nm\n";
    (header.to_owned() + &lines("\t", |v| if v == i32::MAX { "nan".to_owned() } else { format!("{v}.0") })).into_bytes()
}

/// A matrix from a spreadsheet with decimal commas; unit and pitch are unknown.
pub fn csv() -> Vec<u8> {
    let cell = |v: i32| if v == i32::MAX { String::new() } else { format!("{v},0") };
    ("Messung 7\r\n".to_owned() + &lines(";", cell)).into_bytes()
}

/// Points in no order; the missing one is absent, y points up, everything is in nm.
pub fn triples() -> Vec<u8> {
    let mut points: Vec<String> = Vec::new();
    for (r, row) in RAW.iter().enumerate() {
        for (c, &v) in row.iter().enumerate().filter(|(_, v)| **v != i32::MAX) {
            points.push(format!("{} {} {v}\n", 100 + 2000 * c, 3000 * (2 - r)));
        }
    }
    points.reverse();
    points.swap(2, 7);
    points.concat().into_bytes()
}

/// The ASCII surface data file, with and without line breaks after a profile.
pub fn sdf() -> Vec<u8> {
    let header = "aBCR-0.0\r\nManufacID = hand\r\nNumPoints = 4\r\nNumProfiles = 3\r\nXscale = 2.0E-6\r\n\
        Yscale=3e-6\r\nZscale = 1e-9\r\nCompression = 0\r\nDataType = 5\r\n*\r\n";
    let data = lines(" ", |v| if v == i32::MAX { "BAD".to_owned() } else { v.to_string() }).replacen('\n', " ", 1);
    format!("{header}{data}*\r\n<Remark> a < b </Remark>\r\n*\r\n").into_bytes()
}

const ZYGO_HEADER: &str = "0 0 0 0 \"Fri Mar  3 16:35:59 2023\"\n0 0 2 1 1 255\n1 1 4 3\n\"remark\"\n\"part\"\n\"\"\n\
    0 0.5 6e-07 0 1 0 2e-06 1678462559\n4 3 0 0 0 0 \"\"\n0 0 0 0 0 0 0 0 0 0\n1 1 20 2 0 0 0 0 0\n0 \"\"\n1 0\n\"\"\n#\n";

/// Zygo's list of points in um.
pub fn zygo_xyz() -> Vec<u8> {
    let mut text = "Zygo XYZ Data File - Format 2\n".to_owned() + ZYGO_HEADER;
    for (r, row) in RAW.iter().enumerate() {
        for (c, &v) in row.iter().enumerate() {
            let height = if v == i32::MAX { "No Data".to_owned() } else { format!("{}", f64::from(v) * 1e-3) };
            text += &format!("{c} {r} {height}\n");
        }
    }
    (text + "#\n").into_bytes()
}

/// Zygo's integers with an intensity image of 2 x 1 before them.
pub fn zygo_ascii() -> Vec<u8> {
    let heights = lines(" ", |v| if v == i32::MAX { "2147483640".to_owned() } else { v.to_string() });
    format!("Zygo ASCII Data File - Format 2\n{ZYGO_HEADER}17 18\n#\n{heights}#\n").into_bytes()
}
