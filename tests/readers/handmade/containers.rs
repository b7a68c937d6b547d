//! Archives and pictures.

use super::RAW;
use std::io::Write;

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

/// An archive of arrays: a vector, which is no map, and a matrix.
pub fn npz() -> Vec<u8> {
    let matrix = asperity::npy::encode(&[3, 4], super::floats(f64::NAN));
    zip_stored(&[("x.npy", &asperity::npy::encode(&[4], [0u16, 1, 2, 3])), ("surface.npy", &matrix)])
}

/// A big-endian TIFF of f32 heights in two strips, or a little-endian one of u16 (missing point at 120).
pub fn tiff(floats: bool) -> Vec<u8> {
    let short = |v: u16| if floats { v.to_be_bytes() } else { v.to_le_bytes() };
    let long = |v: u32| if floats { v.to_be_bytes() } else { v.to_le_bytes() };
    let data: Vec<u8> = if floats {
        super::floats(f64::NAN).flat_map(|v| (v as f32).to_be_bytes()).collect()
    } else {
        RAW.iter().flatten().flat_map(|&v| (v.min(120) as u16).wrapping_add(200).to_le_bytes()).collect()
    };
    let (bits, kind, row) = if floats { (32, 3, 16) } else { (16, 1, 8) };
    let strips = 8 + data.len() as u32;
    let directory = strips + 16;
    let mut file = if floats { b"MM\0\x2a".to_vec() } else { b"II\x2a\0".to_vec() };
    file.extend(long(directory));
    file.extend(&data);
    // Where the two strips (of 2 and 1 rows) are, then their lengths.
    for value in [8, 8 + 2 * row, 2 * row, row] {
        file.extend(long(value));
    }
    let one = |value: u16| [short(value), [0, 0]].concat();
    let entries: [(u16, u16, u32, Vec<u8>); 10] = [
        (256, 3, 1, one(4)),
        (257, 3, 1, one(3)),
        (258, 3, 1, one(bits)),
        (259, 3, 1, one(1)),
        (262, 3, 1, one(1)),
        (273, 4, 2, long(strips).to_vec()),
        (277, 3, 1, one(1)),
        (278, 3, 1, one(2)),
        (279, 4, 2, long(strips + 8).to_vec()),
        (339, 3, 1, one(kind)),
    ];
    file.extend(short(entries.len() as u16));
    for (tag, field, count, value) in entries {
        file.extend(short(tag));
        file.extend(short(field));
        file.extend(long(count));
        file.extend(value);
    }
    file.extend(long(0));
    file
}

/// A grey picture of 16 bits with alpha, encoded by the png crate; raw values are offset by 200.
pub fn png() -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 4, 3);
    encoder.set_color(png::ColorType::GrayscaleAlpha);
    encoder.set_depth(png::BitDepth::Sixteen);
    let point = |v: i32| match v {
        i32::MAX => [0, 0, 0, 0],
        v => {
            let [high, low] = ((v + 200) as u16).to_be_bytes();
            [high, low, 0xff, 0xff]
        }
    };
    let data: Vec<u8> = RAW.iter().flatten().flat_map(|&v| point(v)).collect();
    encoder.write_header().unwrap().write_image_data(&data).unwrap();
    file
}

/// A one-channel picture of f32 heights, encoded by the exr crate.
pub fn exr() -> Vec<u8> {
    use exr::prelude::*;
    let heights: Vec<f32> = super::floats(f64::NAN).map(|v| v as f32).collect();
    let channel = AnyChannel::new("Y", FlatSamples::F32(heights));
    let layer = Layer::new(
        (4, 3),
        LayerAttributes::default(),
        Encoding::UNCOMPRESSED,
        AnyChannels::sort([channel].into_iter().collect()),
    );
    let mut file = std::io::Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut file).unwrap();
    file.into_inner()
}
