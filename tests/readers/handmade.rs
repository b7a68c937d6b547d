//! Small files of each format put together byte by byte from the format descriptions, not by our writers.

use asperity::heightmap::read::{ReadOptions, read_bytes};
use std::io::Write;

/// 3 rows of 4 points; row 0 is the top row and the third point of the second row is missing.
pub const RAW: [[i32; 4]; 3] = [[10, -20, 30, 40], [50, 60, i32::MAX, -80], [90, 100, 110, 3]];

/// A MetroPro file of header format 1: W = 600 nm, S = 0.5, O = 1, R = 32768, pitch 2 um, an intensity image of 5 x 2.
pub fn metropro(sign: u16) -> Vec<u8> {
    let mut file = vec![0u8; 834];
    let mut put = |at: usize, bytes: &[u8]| file[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &0x881b_036f_u32.to_be_bytes());
    put(4, &1u16.to_be_bytes());
    put(6, &834u32.to_be_bytes());
    for (at, size) in [(52, 5u16), (54, 2), (56, 1), (68, 4), (70, 3), (218, 1), (232, sign)] {
        put(at, &size.to_be_bytes());
    }
    for (at, value) in [(164, 0.5f32), (168, 600e-9), (176, 1.0), (184, 2e-6)] {
        put(at, &value.to_be_bytes());
    }
    put(80, b"made by hand");
    file.extend([0xab; 5 * 2 * 2]);
    file.extend(RAW.iter().flatten().flat_map(|v| v.to_be_bytes()));
    file
}

/// A Vision file with int16 heights: W = 600 nm, Mult = 300, Aspect = 1.5, Pixel_size = 2 um, one skipped structure.
pub fn wyko() -> Vec<u8> {
    let mut array: Vec<u8> = [4u16, 3, 2].iter().flat_map(|v| v.to_le_bytes()).collect();
    // Column by column from the bottom up; 32767 is missing.
    let upward = |column: usize| RAW.iter().rev().map(move |row| row[column].min(32767) as i16);
    array.extend((0..4).flat_map(upward).flat_map(i16::to_le_bytes));
    let blocks: Vec<(&str, i16, Vec<u8>)> = vec![
        ("PrimaryData2D", 15, vec![1, 2, 3]),
        ("Wavelength", 7, 600f32.to_le_bytes().to_vec()),
        ("Empty", 5, vec![]),
        ("Mult", 7, 300i16.to_le_bytes().to_vec()),
        ("Aspect", 7, 1.5f32.to_le_bytes().to_vec()),
        ("Pixel_size", 7, 2e-3f32.to_le_bytes().to_vec()),
        ("RAW_DATA", 3, array),
        ("Title", 5, b"made by hand\0".to_vec()),
    ];
    let mut file = vec![1, 0];
    let mut entry = |name: &str, kind: i16, length: usize| {
        let mut own = [0u8; 16];
        own[..name.len()].copy_from_slice(name.as_bytes());
        file.extend(own);
        file.extend(kind.to_le_bytes());
        file.extend((length as i32).to_le_bytes());
        file.extend([8, 0]);
    };
    entry("Directory", 1, 24 * (blocks.len() + 1));
    for (name, kind, payload) in &blocks {
        entry(name, *kind, payload.len());
    }
    blocks.iter().for_each(|(_, _, payload)| file.extend(payload));
    file
}

/// An archive of stored (not deflated) members, so that mutations reach the content.
pub fn zip_stored(members: &[(&str, &[u8])]) -> Vec<u8> {
    let mut writer = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    for (name, content) in members {
        writer.start_file(*name, options).unwrap();
        writer.write_all(content).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

/// `main.xml` for int16 heights of 4 x 3 points with `record3` as given.
pub fn x3p_xml(record3: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?><ISO5436><Record1><Revision>ISO5436 \u{2013} 2000</Revision>\
         <FeatureType>SUR</FeatureType><Axes><CX><AxisType>I</AxisType><DataType>L</DataType>\
         <Increment>2e-006</Increment><Offset/></CX><CY><AxisType>I</AxisType><Increment>3E-6</Increment></CY>\
         <CZ><AxisType>A</AxisType><DataType>I</DataType><Increment>1e-9</Increment><Offset>5e-9</Offset></CZ></Axes>\
         </Record1><Record3><MatrixDimension><SizeX>4</SizeX><SizeY>3</SizeY><SizeZ>1</SizeZ></MatrixDimension>\
         {record3}</Record3></ISO5436>"
    )
}

/// An X3P file as a Mac packs it: a folder before everything, resource files, links relative to `main.xml`.
pub fn x3p() -> Vec<u8> {
    let xml = x3p_xml(
        "<DataLink><PointDataLink>bindata/data.bin</PointDataLink><ValidPointsLink>bindata/valid.bin\
         </ValidPointsLink></DataLink>",
    );
    let data: Vec<u8> = RAW.iter().flatten().flat_map(|&v| (v as i16).to_le_bytes()).collect();
    // Bit 6 (point 6 of 12) is 0: least significant bit first.
    zip_stored(&[
        ("__MACOSX/._main.xml", b"Mac OS X"),
        ("__MACOSX/main.xml", b"not this one"),
        ("map/main.xml", xml.as_bytes()),
        ("map/bindata/data.bin", &data),
        ("map/bindata/valid.bin", &[0b1011_1111, 0b0000_1111]),
    ])
}

/// The same points as text.
pub fn x3p_text() -> Vec<u8> {
    let datum = |v: &i32| if *v == i32::MAX { "<Datum/>".to_owned() } else { format!("<Datum> {v}</Datum>") };
    let list: String = RAW.iter().flatten().map(datum).collect();
    zip_stored(&[("main.xml", x3p_xml(&format!("<DataList>{list}</DataList>")).as_bytes())])
}

fn check(file: &[u8], unit: f64, offset: f64, pitch: [f64; 2]) {
    let map = read_bytes(file, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(map.heights.dim(), (3, 4));
    for ((r, c), &height) in map.heights.indexed_iter() {
        let raw = f64::from(RAW[r][c]);
        if RAW[r][c] == i32::MAX {
            assert!(height.is_nan());
        } else {
            assert!((height - raw * unit - offset).abs() <= 1e-6 * (raw * unit).abs(), "{r} {c}: {height}");
        }
    }
    assert!((map.pitch_x / pitch[0] - 1.0).abs() < 1e-6 && (map.pitch_y / pitch[1] - 1.0).abs() < 1e-6);
}

#[test]
fn metropro_follows_its_formula() {
    check(&metropro(0), 0.5 * 600e-9 / 32768.0, 0.0, [2e-6, 2e-6]);
    check(&metropro(1), -0.5 * 600e-9 / 32768.0, 0.0, [2e-6, 2e-6]);
}

#[test]
fn wyko_follows_its_formula() {
    check(&wyko(), 600e-9 / 300.0, 0.0, [2e-6, 3e-6]);
}

#[test]
fn x3p_follows_its_formula() {
    check(&x3p(), 1e-9, 5e-9, [2e-6, 3e-6]);
    check(&x3p_text(), 1e-9, 5e-9, [2e-6, 3e-6]);
}

#[test]
fn an_uncalibrated_metropro_file_asks_for_the_pitch() {
    let mut file = metropro(0);
    file[184..188].fill(0);
    let message = read_bytes(&file, &ReadOptions::default()).unwrap_err().to_string();
    assert!(message.contains("--pitch 0.5um"), "{message}");
    let options = ReadOptions { pitch: Some([1e-6, 4e-6]), ..Default::default() };
    let map = read_bytes(&file, &options).unwrap();
    assert_eq!((map.pitch_x, map.pitch_y), (1e-6, 4e-6));
}
