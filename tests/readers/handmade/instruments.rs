//! Binary files of instruments.

use super::RAW;

/// `value` as i16, with its largest value for a missing point.
fn short(value: i32) -> i16 {
    value.min(32767) as i16
}

/// The points row by row in the given spelling of one number.
fn row_by_row<const N: usize>(bytes: impl Fn(i32) -> [u8; N]) -> Vec<u8> {
    RAW.iter().flatten().flat_map(|&v| bytes(v)).collect()
}

/// Overwrites `file` at each offset.
fn put(file: &mut [u8], fields: &[(usize, &[u8])]) {
    for (at, bytes) in fields {
        file[*at..at + bytes.len()].copy_from_slice(bytes);
    }
}

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
    let upward = |column: usize| RAW.iter().rev().map(move |row| short(row[column]));
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

/// A surface file of MountainsMap with i16 heights: dz = 1 nm, offset 5 nm, pitch 2 x 3 um with three spellings of um.
pub fn sur(compressed: bool) -> Vec<u8> {
    let lowest = -80i16;
    let mut file = vec![0u8; 512];
    put(
        &mut file,
        &[
            (0, if compressed { b"DSCOMPRESSED" } else { b"DIGITAL SURF" }),
            (14, &[1, 0, 1, 0, 2, 0]),
            (20, b"made by hand"),
            (86, &[1, 0]),
            (98, &[16, 0]),
            (100, &i32::from(lowest).to_le_bytes()),
            (108, &4i32.to_le_bytes()),
            (112, &3i32.to_le_bytes()),
            (120, &2f32.to_le_bytes()),
            (124, &3f32.to_le_bytes()),
            (128, &1f32.to_le_bytes()),
            (180, b"\xb5m"),
            (196, b"\xc2\xb5m"),
            (212, b"nm"),
            (334, &3u16.to_le_bytes()),
            (336, &2u16.to_le_bytes()),
            (474, &5f32.to_le_bytes()),
        ],
    );
    file.extend(b"commepr");
    file.truncate(512 + 3 + 2);
    let data = row_by_row(|v| if v == i32::MAX { lowest - 2 } else { v as i16 }.to_le_bytes());
    if !compressed {
        file.extend(data);
        return file;
    }
    let (first, second) = data.split_at(10);
    let pack = |bytes: &[u8]| {
        let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        std::io::Write::write_all(&mut encoder, bytes).unwrap();
        encoder.finish().unwrap()
    };
    let streams = [pack(first), pack(second)];
    file.extend(2u32.to_le_bytes());
    for (raw, packed) in [(first, &streams[0]), (second, &streams[1])] {
        file.extend((raw.len() as u32).to_le_bytes());
        file.extend((packed.len() as u32).to_le_bytes());
    }
    file.extend(streams.concat());
    file
}

/// A binary surface data file with i16 heights in nm, pitch 2 x 3 um.
pub fn sdf_binary() -> Vec<u8> {
    let mut file = b"bISO-1.0handmade\0\xff010120260000010120260000".to_vec();
    file.extend([4, 0, 3, 0]);
    file.extend([2e-6f64, 3e-6, 1e-9, -1.0].iter().flat_map(|v| v.to_le_bytes()));
    file.extend([0, 5, 0]);
    file.extend(row_by_row(|v| if v == i32::MAX { i16::MIN } else { v as i16 }.to_le_bytes()));
    file
}

/// An Alicona file of f32 metres with the first `columns` of the points; rows are padded to 8 bytes, but for the last.
pub fn al3d(columns: usize) -> Vec<u8> {
    let mut file = b"AliconaImaging\0\r\n".to_vec();
    let mut tag = |key: &str, value: &str| {
        let mut own = [0u8; 52];
        put(&mut own, &[(0, key.as_bytes()), (20, value.as_bytes()), (50, b"\r\n")]);
        file.extend(own);
    };
    tag("Version", "1");
    tag("TagCount", "7");
    for (key, value) in [
        ("Cols", columns.to_string().as_str()),
        ("Rows", "3"),
        ("PixelSizeXMeter", "2e-06"),
        ("PixelSizeYMeter", "3e-06"),
        ("DepthImageOffset", "600"),
        ("InvalidPixelValue", "3.0e+15"),
        ("CreatingApplication", "by hand"),
    ] {
        tag(key, value);
    }
    file.resize(600, 0);
    for row in &RAW {
        file.resize(600 + (file.len() - 600).next_multiple_of(8), 0xee);
        for &value in &row[..columns] {
            let height = if value == i32::MAX { 3e15f32 } else { value as f32 * 1e-9 };
            file.extend(height.to_le_bytes());
        }
    }
    file
}

/// A Sensofar file with two layers of f32 um; the second holds the points, the first is flat.
pub fn plu() -> Vec<u8> {
    let mut file = vec![0u8; 500];
    put(
        &mut file,
        &[
            (0, b"Fri Mar  3 16:35:59 2023"),
            (132, b"made by hand"),
            (404, &2f32.to_le_bytes()),
            (408, &3f32.to_le_bytes()),
            (428, &[3]),
            (489, &[2]),
            (492, &[1]),
        ],
    );
    let mut layer = |values: Vec<u8>| {
        file.extend([3, 0, 0, 0, 4, 0, 0, 0]);
        file.extend(values);
        file.extend([0; 8 + 3 * 12]);
    };
    layer(row_by_row(|_| 0f32.to_le_bytes()));
    layer(row_by_row(|v| if v == i32::MAX { 1_000_001.0 } else { v as f32 * 1e-3 }.to_le_bytes()));
    file
}

/// A NanoFocus file: u16 from 1 um to 1 um + 65.535 um, so one step is 1 nm; no missing points (the marked one is 120).
pub fn nms() -> Vec<u8> {
    let mut file = vec![0u8; 1400];
    put(
        &mut file,
        &[
            (12, &[0xff, 0xff]),
            (16, &1f64.to_le_bytes()),
            (24, &66.535f64.to_le_bytes()),
            (1076, b"2026-01-01T00:00"),
            (1352, &1400u32.to_le_bytes()),
            (1368, &[4, 0, 0, 0, 3, 0, 0, 0]),
            (1376, &2000f64.to_le_bytes()),
            (1384, &3000f64.to_le_bytes()),
        ],
    );
    file.extend(row_by_row(|v| (v.min(120) + 1000).cast_unsigned().to_le_bytes()).chunks(4).flat_map(|c| [c[0], c[1]]));
    file
}

/// A SPIP file: f32 um after a header in UTF-16, or big-endian i16 with a step of 2 nm after one in Latin-1.
pub fn bcrf(floats: bool) -> Vec<u8> {
    let kind = if floats { "bcrf_unicode" } else { "bcrstm" };
    let length = if floats { "headersize = 2100\n" } else { "intelmode = 0\nbit2nm = 2.0\n" };
    let units = if floats { "zunit = um\n" } else { "" };
    let mut text = format!(
        "fileformat = {kind}\n%remark = 1\n{length}xpixels = 4\nypixels = 3\nxlength = 8\nylength = 9\n\
         xunit = um\nyunit = um\n{units}"
    );
    text += &" ".repeat(if floats { 2100 } else { 2048 } - text.len());
    if floats {
        let mut file: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        file.extend(row_by_row(|v| if v == i32::MAX { f32::MAX } else { v as f32 * 1e-3 }.to_le_bytes()));
        return file;
    }
    let mut file = text.into_bytes();
    file.extend(row_by_row(|v| short(v).to_be_bytes()));
    file
}

/// A Gwyddion file with heights in nm and a mask over the missing point, which holds `filled`.
pub fn gwy(filled: [f64; 2]) -> Vec<u8> {
    let name = |text: &str| [text.as_bytes(), b"\0"].concat();
    let component = |key: &str, kind: u8, value: &[u8]| [&name(key), [kind].as_slice(), value].concat();
    let object = |class: &str, parts: &[Vec<u8>]| {
        let content = parts.concat();
        [&name(class), (content.len() as u32).to_le_bytes().as_slice(), &content].concat()
    };
    let unit = |text: &str| object("GwySIUnit", &[component("unitstr", b's', &name(text))]);
    let field = |z: &str, data: Vec<f64>| {
        let bytes: Vec<u8> = data.iter().flat_map(|v| v.to_le_bytes()).collect();
        object(
            "GwyDataField",
            &[
                component("xres", b'i', &4i32.to_le_bytes()),
                component("yres", b'i', &3i32.to_le_bytes()),
                component("xreal", b'd', &8e-6f64.to_le_bytes()),
                component("yreal", b'd', &9e-6f64.to_le_bytes()),
                component("si_unit_xy", b'o', &unit("m")),
                component("si_unit_z", b'o', &unit(z)),
                component("data", b'D', &[12u32.to_le_bytes().as_slice(), &bytes].concat()),
            ],
        )
    };
    let values = || RAW.iter().flatten();
    // The mask also covers the last point, so that two heights lie under it.
    let heights = values().enumerate().map(|(i, &v)| match (v, i) {
        (i32::MAX, _) => filled[0],
        (_, 11) => filled[1],
        _ => f64::from(v),
    });
    let mask = values().enumerate().map(|(i, &v)| f64::from(u8::from(v == i32::MAX || i == 11)));
    let top = object(
        "GwyContainer",
        &[
            component("/0/data", b'o', &field("V", vec![1.0; 12])),
            component("/2/data", b'o', &field("nm", heights.collect())),
            component("/2/data/title", b's', &name("Height")),
            component("/2/mask", b'o', &field("", mask.collect())),
            component("/2/base/palette", b's', &name("Gray")),
            component("/strings", b'S', &[2u32.to_le_bytes().as_slice(), b"a\0bc\0"].concat()),
            component("/flag", b'b', &[1]),
        ],
    );
    [b"GWYP".as_slice(), &top].concat()
}
