//! X3P of ISO 25178-72 (first published as ISO 5436-2 by openGPS): a ZIP of `main.xml` and binary samples.
//!
//! `height = raw * Increment + Offset` \[m\] with the values of axis CZ; the pitch is the Increment of CX and CY \[m\].
//! Checksums are not compared: instruments and editors leave stale ones behind, and ZIP guards every member itself.
//!
//! What the file holds is read leniently (folder before `main.xml`, root without namespace, empty elements, +Inf as
//! missing); what is not a regular surface is refused by name. The file's row order is kept as top row first.

mod grid;
mod main_xml;

use super::ReadOptions;
use super::fields::{Sample, into_grid, plane_bytes};
use crate::archive::{Archive, EXPANSION};
use crate::error::Fault;
use crate::heightmap::RawMap;
use main_xml::{Axis, MainXml};

pub const NAME: &str = "x3p";

/// `main.xml` may have this many bytes if that is more than 64 times the file: half a million points of a flat map. Each
/// becomes up to three numbers, so the limit is lower than for binary samples.
const XML_FLOOR_BYTES: u64 = 16 << 20;

/// Any ZIP; `main.xml` is looked for when reading.
pub fn recognises(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04")
}

pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<RawMap, Fault> {
    let mut archive = Archive::open(bytes, NAME)?;
    let (folder, main) = find_main_xml(&archive)?;
    let xml = archive.read(&main, XML_FLOOR_BYTES.max(EXPANSION * bytes.len() as u64))?;
    let xml = main_xml::parse(&String::from_utf8_lossy(&xml))?;
    refuse_other_features(&xml)?;
    let [columns, rows, layers] = xml.sizes;
    let layer = chosen_layer(options, layers)?;
    // The size of everything announced is checked before anything is unpacked.
    let points = plane_bytes(rows, columns, layers, NAME)?;
    let mut data = match &xml.point_link {
        Some(link) => unpack_points(&mut archive, &folder, link, &xml, points)?,
        None => points_of_list(xml.data, &xml.axes, points)?,
    };
    if let Some(link) = &xml.valid_link {
        let bits = archive.read(&format!("{folder}{link}"), points.div_ceil(8) as u64 + 8)?;
        mark_missing(&mut data.z, &bits)?;
    }
    let one_layer = layer * rows * columns..(layer + 1) * rows * columns;
    let [x_axis, y_axis, z_axis] = &xml.axes;
    let pitch_x = grid::pitch(x_axis, &data.x, one_layer.clone(), columns, grid::Along::Row)?;
    let pitch_y = grid::pitch(y_axis, &data.y, one_layer.clone(), columns, grid::Along::Column)?;
    let stated = pitch_x.zip(pitch_y).map(|(x, y)| [x, y]);
    let [pitch_x, pitch_y] = options.pitch_or(NAME, stated)?;
    let (increment, offset) = (z_axis.increment.unwrap_or(1.0), z_axis.offset.unwrap_or(0.0));
    let heights: Vec<f64> =
        data.z[one_layer].iter().map(|raw| if raw.is_finite() { raw * increment + offset } else { f64::NAN }).collect();
    Ok(RawMap { heights: into_grid(rows, columns, heights, NAME)?, pitch_x, pitch_y, format: NAME, notes: xml.notes })
}

/// Coordinates as stored; `x` and `y` are empty where the axis is incremental.
#[derive(Default)]
struct Points {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

/// Shallowest `main.xml` outside Apple's resource folder, with the folder that links are relative to.
fn find_main_xml(archive: &Archive) -> Result<(String, String), Fault> {
    let candidates = archive.names().iter().filter(|n| {
        let file = n.rsplit('/').next().unwrap_or(n);
        file.eq_ignore_ascii_case("main.xml") && !n.starts_with("__MACOSX/")
    });
    let main = candidates.min_by_key(|n| n.matches('/').count()).ok_or_else(|| Fault::Unsupported {
        format: NAME,
        what: "a ZIP archive without main.xml".to_owned(),
        advice: "it is no X3P surface; export the map as X3P".to_owned(),
    })?;
    Ok((main[..main.len() - "main.xml".len()].to_owned(), main.clone()))
}

fn refuse_other_features(xml: &MainXml) -> Result<(), Fault> {
    let [columns, rows, _] = xml.sizes;
    let what = match (xml.feature.as_str(), xml.list_length) {
        ("PCL", Some(n)) => format!("a point cloud of {n} points"),
        ("PCL", None) => "a point cloud".to_owned(),
        ("PRF", n) => format!("a profile of {} points", n.unwrap_or(columns)),
        ("SUR" | "", None) if rows > 0 && columns > 0 => return Ok(()),
        ("SUR" | "", Some(n)) => format!("a list of {n} points without a grid"),
        ("SUR" | "", None) => return Err(corrupt("the matrix dimension is missing or zero".to_owned())),
        (other, _) => format!("feature type {other:?}"),
    };
    let advice = "export an areal surface on a regular grid (FeatureType SUR)".to_owned();
    Err(Fault::Unsupported { format: NAME, what, advice })
}

fn chosen_layer(options: &ReadOptions, layers: usize) -> Result<usize, Fault> {
    let layer = options.layer.unwrap_or(0);
    if layer < layers {
        return Ok(layer);
    }
    Err(Fault::Unsupported {
        format: NAME,
        what: format!("layer {layer} of a file with {layers} layer(s)"),
        advice: "count from 0".to_owned(),
    })
}

/// Binary points: the absolute axes are stored side by side, X fastest, then Y, then layers.
fn unpack_points(
    archive: &mut Archive,
    folder: &str,
    link: &str,
    xml: &MainXml,
    points: usize,
) -> Result<Points, Fault> {
    let stored: Vec<(usize, Sample)> =
        xml.axes.iter().enumerate().filter(|(_, a)| a.absolute).map(|(i, a)| (i, a.sample)).collect();
    let stride: usize = stored.iter().map(|(_, s)| s.size()).sum();
    let needed = plane_bytes(points, 1, stride, NAME)?;
    let bytes = archive.read(&format!("{folder}{link}"), needed as u64)?;
    if bytes.len() != needed {
        let what = format!("{points} points need {needed} bytes, {link} has {}", bytes.len());
        return Err(corrupt(what));
    }
    let mut data = Points::default();
    let mut start = 0;
    for (axis, sample) in stored {
        let column: Vec<f64> = if stride == sample.size() {
            sample.decode_all(&bytes, false)
        } else {
            let place = start..start + sample.size();
            bytes.chunks_exact(stride).map(|point| sample.decode_all(&point[place.clone()], false)[0]).collect()
        };
        start += sample.size();
        *[&mut data.x, &mut data.y, &mut data.z][axis] = column;
    }
    Ok(data)
}

/// Points written as text in `main.xml`.
fn points_of_list(list: Vec<[f64; 3]>, axes: &[Axis; 3], points: usize) -> Result<Points, Fault> {
    if list.len() != points {
        return Err(corrupt(format!("{points} points are announced, the data list has {}", list.len())));
    }
    let column = |i: usize| if axes[i].absolute { list.iter().map(|p| p[i]).collect() } else { Vec::new() };
    Ok(Points { x: column(0), y: column(1), z: column(2) })
}

/// One bit per point, least significant first; 1 = measured.
fn mark_missing(z: &mut [f64], bits: &[u8]) -> Result<(), Fault> {
    if bits.len() < z.len().div_ceil(8) {
        return Err(corrupt(format!("{} points need as many validity bits, {} bytes follow", z.len(), bits.len())));
    }
    for (i, height) in z.iter_mut().enumerate() {
        if bits[i / 8] >> (i % 8) & 1 == 0 {
            *height = f64::NAN;
        }
    }
    Ok(())
}

fn corrupt(what: String) -> Fault {
    Fault::Corrupt { format: NAME, what }
}
