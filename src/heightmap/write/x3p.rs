//! X3P of ISO 25178-72: `main.xml`, binary samples and, for integers with gaps, validity bits in a ZIP.
//!
//! `height = raw * Increment + Offset` \[m\]. Same map, same bytes: the archive and the document carry a fixed date, and
//! Increment and Offset are rounded so that a last-bit difference between two machines' maps does not reach the file.

use crate::archive;
use crate::error::{Error, Result};
use crate::heightmap::RawMap;
use crate::output::write_bytes;
use std::path::Path;

/// How heights are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Samples {
    /// 65 000 steps over the range of the map; a height moves by at most half a step.
    Int16,
    /// 24 bits of fraction about the middle of the range.
    Float32,
    /// As in memory.
    Float64,
}

/// Largest raw value used: one step less than int16 has, since rounding the offset may shift by half a step.
const INT16_REACH: f64 = 32766.0;

/// Smallest step \[m\], used for a flat map: a femtometre is below any instrument.
const SMALLEST_STEP: f64 = 1e-15;

/// Writes the map; missing points are validity bits (int16) or NaN (floats).
///
/// # Errors
/// `Error::Parameter` if every point is missing, `Error::Io` otherwise.
pub fn write(path: &Path, map: &RawMap, samples: Samples) -> Result<()> {
    let bytes = encode(map, samples)?;
    write_bytes(path, &bytes)
}

/// Raw value to height.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Scale {
    increment: f64,
    offset: f64,
}

fn encode(map: &RawMap, samples: Samples) -> Result<Vec<u8>> {
    let scale = scale_for(map, samples)?;
    let raw = |h: f64| (h - scale.offset) / scale.increment;
    let mut points = Vec::with_capacity(map.heights.len() * 8);
    let mut valid = vec![0u8; map.heights.len().div_ceil(8)];
    let mut gaps = false;
    for (i, &height) in map.heights.iter().enumerate() {
        let measured = height.is_finite();
        gaps |= !measured;
        valid[i / 8] |= u8::from(measured) << (i % 8);
        let height = if measured { height } else { f64::NAN };
        match samples {
            // NaN becomes 0; the validity bit says that it is none.
            Samples::Int16 => points.extend((raw(height).round() as i16).to_le_bytes()),
            Samples::Float32 => points.extend((raw(height) as f32).to_le_bytes()),
            Samples::Float64 => points.extend(height.to_le_bytes()),
        }
    }
    let valid = (gaps && samples == Samples::Int16).then_some(valid);
    let xml = main_xml(map, samples, scale, &points, valid.as_deref());
    let checksum = format!("{:x} *main.xml\n", md5::compute(&xml));
    let mut members: Vec<(&str, &[u8])> =
        vec![("main.xml", xml.as_bytes()), ("md5checksum.hex", checksum.as_bytes()), ("bindata/data.bin", &points)];
    if let Some(valid) = &valid {
        members.push(("bindata/valid.bin", valid));
    }
    archive::pack(&members).map_err(|e| Error::parameter(format!("the X3P archive cannot be made: {e}"), "report it"))
}

fn scale_for(map: &RawMap, samples: Samples) -> Result<Scale> {
    let measured = || map.heights.iter().copied().filter(|h| h.is_finite());
    let (low, high) = measured().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), z| (l.min(z), h.max(z)));
    if low > high {
        return Err(Error::parameter("every point of the map is missing", "there is nothing to write"));
    }
    // Halved before adding, so that the largest finite heights do not overflow.
    let (half_range, middle) = (high / 2.0 - low / 2.0, high / 2.0 + low / 2.0);
    match samples {
        Samples::Float64 => Ok(Scale { increment: 1.0, offset: 0.0 }),
        // A coarse offset is as good as an exact one for keeping the digits of the heights about it.
        Samples::Float32 => Ok(Scale { increment: 1.0, offset: multiple_near(middle, up_to_six_digits(half_range)) }),
        Samples::Int16 => {
            let increment = up_to_six_digits((half_range / INT16_REACH).max(SMALLEST_STEP));
            Ok(Scale { increment, offset: multiple_near(middle, increment) })
        }
    }
}

/// The smallest number of six significant decimal digits that is not below `value`; 0 stays 0.
fn up_to_six_digits(value: f64) -> f64 {
    let parsed = |text: String| text.parse::<f64>().unwrap_or(value);
    let nearest = parsed(format!("{value:.5e}"));
    // A value that is such a number already, but for its last bits, must not be pushed to the next one.
    if nearest >= value * (1.0 - 1e-12) {
        return nearest;
    }
    let exponent = format!("{value:e}").split_once('e').and_then(|(_, e)| e.parse::<i32>().ok()).unwrap_or(0);
    parsed(format!("{:.5e}", value + 0.5 * 10f64.powi(exponent - 5)))
}

/// `value` rounded to a whole number of `step`s.
fn multiple_near(value: f64, step: f64) -> f64 {
    if step == 0.0 { value } else { (value / step).round() * step }
}

fn main_xml(map: &RawMap, samples: Samples, scale: Scale, points: &[u8], valid: Option<&[u8]>) -> String {
    let (rows, columns) = map.heights.dim();
    let kind = match samples {
        Samples::Int16 => 'I',
        Samples::Float32 => 'F',
        Samples::Float64 => 'D',
    };
    let axis = |name: &str, axis_type: char, kind: char, increment: f64, offset: f64| {
        format!(
            "      <{name}>\n        <AxisType>{axis_type}</AxisType>\n        <DataType>{kind}</DataType>\n        \
             <Increment>{increment:e}</Increment>\n        <Offset>{offset:e}</Offset>\n      </{name}>\n"
        )
    };
    let axes = [
        axis("CX", 'I', 'D', map.pitch_x, 0.0),
        axis("CY", 'I', 'D', map.pitch_y, 0.0),
        axis("CZ", 'A', kind, scale.increment, scale.offset),
    ]
    .concat();
    let link = |name: &str, checksum: &str, file: &str, content: &[u8]| {
        let sum = md5::compute(content);
        format!("      <{name}>bindata/{file}</{name}>\n      <{checksum}>{sum:x}</{checksum}>\n")
    };
    let mut links = link("PointDataLink", "MD5ChecksumPointData", "data.bin", points);
    if let Some(valid) = valid {
        links += &link("ValidPointsLink", "MD5ChecksumValidPoints", "valid.bin", valid);
    }
    // The schema asks for dates, which a reproducible file cannot have.
    let date = "1970-01-01T00:00:00Z";
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:schemaLocation="http://www.opengps.eu/2008/ISO5436_2 http://www.opengps.eu/2008/ISO5436_2/ISO5436_2.xsd">
  <Record1>
    <Revision>ISO5436 - 2000</Revision>
    <FeatureType>SUR</FeatureType>
    <Axes>
{axes}    </Axes>
  </Record1>
  <Record2>
    <Date>{date}</Date>
    <Creator>asperity</Creator>
    <Instrument>
      <Manufacturer>not available</Manufacturer>
      <Model>not available</Model>
      <Serial>not available</Serial>
      <Version>not available</Version>
    </Instrument>
    <CalibrationDate>{date}</CalibrationDate>
    <ProbingSystem>
      <Type>Software</Type>
      <Identification>not available</Identification>
    </ProbingSystem>
  </Record2>
  <Record3>
    <MatrixDimension>
      <SizeX>{columns}</SizeX>
      <SizeY>{rows}</SizeY>
      <SizeZ>1</SizeZ>
    </MatrixDimension>
    <DataLink>
{links}    </DataLink>
  </Record3>
  <Record4>
    <ChecksumFile>md5checksum.hex</ChecksumFile>
  </Record4>
</p:ISO5436_2>
"#
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    #[test]
    fn six_digits_round_up() {
        for (value, expected) in
            [(1.234_561e-9, 1.23457e-9), (1.23456e-9, 1.23456e-9), (9.999_991, 10.0), (1.0, 1.0), (0.0, 0.0)]
        {
            assert_eq!(up_to_six_digits(value), expected);
            assert!(up_to_six_digits(value) >= value);
        }
        // One last bit either way gives the same digits.
        let value = 1.23456e-9_f64;
        assert_eq!(up_to_six_digits(value.next_up()), up_to_six_digits(value.next_down()));
    }

    #[test]
    fn last_bits_do_not_change_the_file() {
        let heights = Array2::from_shape_fn((20, 30), |(r, c)| 1e-3 + 1e-6 * ((r * 31 + c * 17) as f64).sin());
        let nudged = heights.mapv(|h: f64| h.next_up());
        let map = |heights| RawMap { heights, pitch_x: 1e-6, pitch_y: 2e-6, format: "test", notes: vec![] };
        let (a, b) = (map(heights), map(nudged));
        assert_eq!(encode(&a, Samples::Int16).unwrap(), encode(&b, Samples::Int16).unwrap());
    }

    #[test]
    fn nothing_measured_is_nothing_to_write() {
        let heights = Array2::from_elem((3, 3), f64::NAN);
        let map = RawMap { heights, pitch_x: 1e-6, pitch_y: 1e-6, format: "test", notes: vec![] };
        assert!(encode(&map, Samples::Int16).unwrap_err().to_string().contains("missing"));
    }
}
