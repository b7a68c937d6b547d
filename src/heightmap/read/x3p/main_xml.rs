//! `main.xml` of an X3P file: axes, sizes, links, and the points if they are written as text.

use super::{NAME, corrupt};
use crate::error::Fault;
use crate::heightmap::read::fields::Sample;
use quick_xml::Reader;
use quick_xml::events::Event;
use std::collections::HashMap;

/// Deeper nesting than any X3P file has; a vendor's extension stays well below.
const MAX_DEPTH: usize = 64;

/// The records of ISO 25178-72 have about forty elements; hostile nesting must not multiply memory.
const MAX_LEAVES: usize = 1000;

/// One of CX, CY, CZ.
#[derive(Debug, Clone, Copy)]
pub struct Axis {
    /// Coordinates are stored per point; otherwise they follow from the index.
    pub absolute: bool,
    pub sample: Sample,
    /// Metres per index or per stored unit; `None` if absent, empty or zero.
    pub increment: Option<f64>,
    pub offset: Option<f64>,
}

/// What the reader needs of the document.
#[derive(Debug)]
pub struct MainXml {
    pub feature: String,
    pub axes: [Axis; 3],
    /// Columns, rows, layers; zero if not given.
    pub sizes: [usize; 3],
    pub list_length: Option<usize>,
    pub point_link: Option<String>,
    pub valid_link: Option<String>,
    /// `Datum` elements as (x, y, z), NaN where empty; x and y are NaN if only z is given.
    pub data: Vec<[f64; 3]>,
    pub notes: Vec<(String, String)>,
}

pub fn parse(xml: &str) -> Result<MainXml, Fault> {
    let (leaves, data) = leaves_and_data(xml.trim_start_matches('\u{feff}'))?;
    let text = |path: &str| leaves.get(path).map(|t| t.trim()).filter(|t| !t.is_empty());
    let size = |path: &str| match text(path) {
        None => Ok(None),
        Some(t) => t.parse::<usize>().map(Some).map_err(|_| corrupt(format!("{path} is {t:?}, not a count"))),
    };
    let extent = |name: &str| size(&format!("Record3/MatrixDimension/{name}"));
    let sizes = [extent("SizeX")?.unwrap_or(0), extent("SizeY")?.unwrap_or(0), extent("SizeZ")?.unwrap_or(1)];
    let axis = |name: &str, height: bool| read_axis(&text, name, height);
    let axes = [axis("CX", false)?, axis("CY", false)?, axis("CZ", true)?];
    let note = |key: &str, path: &str| text(path).map(|t| (key.to_owned(), t.to_owned()));
    Ok(MainXml {
        feature: text("Record1/FeatureType").unwrap_or_default().to_uppercase(),
        axes,
        sizes,
        list_length: size("Record3/ListDimension")?,
        point_link: text("Record3/DataLink/PointDataLink").map(clean_link),
        valid_link: text("Record3/DataLink/ValidPointsLink").map(clean_link),
        data,
        notes: [
            note("creator", "Record2/Creator"),
            note("manufacturer", "Record2/Instrument/Manufacturer"),
            note("instrument", "Record2/Instrument/Model"),
            note("date", "Record2/Date"),
            note("comment", "Record2/Comment"),
        ]
        .into_iter()
        .flatten()
        .collect(),
    })
}

fn read_axis<'a>(text: &impl Fn(&str) -> Option<&'a str>, name: &str, height: bool) -> Result<Axis, Fault> {
    let path = |leaf: &str| format!("Record1/Axes/{name}/{leaf}");
    let number = |leaf: &str| match text(&path(leaf)) {
        None => Ok(None),
        Some(t) => match t.parse::<f64>() {
            Ok(v) if v.is_finite() => Ok(Some(v)),
            _ => Err(corrupt(format!("{} is {t:?}, not a number", path(leaf)))),
        },
    };
    let absolute = match text(&path("AxisType")) {
        Some("A" | "a") => true,
        Some("I" | "i") => false,
        None => height,
        Some(t) => return Err(corrupt(format!("{} is {t:?}, neither A nor I", path("AxisType")))),
    };
    if height && !absolute {
        let what = "a height axis without stored heights".to_owned();
        return Err(Fault::Unsupported { format: NAME, what, advice: "export the surface with heights".to_owned() });
    }
    let sample = match text(&path("DataType")) {
        Some("I" | "i") => Sample::I16,
        Some("L" | "l") => Sample::I32,
        Some("F" | "f") => Sample::F32,
        Some("D" | "d") => Sample::F64,
        // An incremental axis stores nothing, so its type does not matter.
        _ if !absolute => Sample::F64,
        Some(t) => return Err(corrupt(format!("{} is {t:?}, none of I, L, F, D", path("DataType")))),
        None => return Err(corrupt(format!("{} is missing", path("DataType")))),
    };
    // A step of zero would flatten the surface; writers mean "none" by it.
    Ok(Axis { absolute, sample, increment: number("Increment")?.filter(|&i| i != 0.0), offset: number("Offset")? })
}

fn clean_link(link: &str) -> String {
    link.replace('\\', "/").trim_start_matches("./").trim_start_matches('/').to_owned()
}

type Leaves = HashMap<String, String>;

/// Text of every element by its path below the root, local names only; the first of a name counts.
fn leaves_and_data(xml: &str) -> Result<(Leaves, Vec<[f64; 3]>), Fault> {
    let mut reader = Reader::from_str(xml);
    reader.config_mut().allow_dangling_amp = true;
    reader.config_mut().expand_empty_elements = true;
    let mut leaves = Leaves::new();
    let mut data = Vec::new();
    // Path below the root, and the length it had before each open element was added.
    let mut path = String::new();
    let mut open: Vec<usize> = Vec::new();
    let mut text = String::new();
    loop {
        let event = reader.read_event().map_err(|e| corrupt(format!("main.xml is not well formed ({e})")))?;
        match event {
            Event::Start(tag) => {
                if open.len() == MAX_DEPTH {
                    return Err(corrupt("main.xml is nested too deeply".to_owned()));
                }
                open.push(path.len());
                // The root's own name differs between writers and is left out.
                if open.len() > 1 {
                    if !path.is_empty() {
                        path.push('/');
                    }
                    path.push_str(tag.local_name().into_inner());
                }
                text.clear();
            }
            Event::End(_) => {
                if path == "Record3/DataList/Datum" {
                    data.push(datum(&text)?);
                } else if wanted(&path) && !text.trim().is_empty() && leaves.len() < MAX_LEAVES {
                    leaves.entry(path.clone()).or_insert_with(|| text.clone());
                }
                text.clear();
                path.truncate(open.pop().unwrap_or(0));
            }
            Event::Text(t) => text.push_str(&t.into_inner()),
            Event::CData(t) => text.push_str(&t.into_inner()),
            Event::GeneralRef(r) => match (&*r, r.resolve_char_ref()) {
                (_, Ok(Some(c))) => text.push(c),
                ("amp", _) => text.push('&'),
                ("lt", _) => text.push('<'),
                ("gt", _) => text.push('>'),
                _ => {}
            },
            Event::Eof if open.is_empty() => return Ok((leaves, data)),
            Event::Eof => return Err(corrupt("main.xml ends early".to_owned())),
            _ => {}
        }
    }
}

/// Whether an element may be one of the standard's own.
fn wanted(path: &str) -> bool {
    path.starts_with("Record") && path.len() <= 100
}

/// `z` or `x;y;z`; an empty height is missing.
fn datum(text: &str) -> Result<[f64; 3], Fault> {
    let number = |t: &str| match t.trim() {
        "" => Ok(f64::NAN),
        t => t.parse::<f64>().map_err(|_| corrupt(format!("{t:?} in the data list is not a number"))),
    };
    let parts: Vec<&str> =
        if text.contains(';') { text.split(';').collect() } else { text.split_whitespace().collect() };
    match parts[..] {
        [] => Ok([f64::NAN; 3]),
        [z] => Ok([f64::NAN, f64::NAN, number(z)?]),
        [x, z] => Ok([number(x)?, f64::NAN, number(z)?]),
        [x, y, z] => Ok([number(x)?, number(y)?, number(z)?]),
        _ => Err(corrupt(format!("a datum with {} coordinates", parts.len()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odd_but_legal_documents_are_understood() {
        let xml = parse(
            "\u{feff}<?xml version=\"1.0\"?><ISO5436><Record1><Revision>ISO5436 \u{2013} 2000</Revision>\
             <FeatureType> SUR </FeatureType><Axes><CX><AxisType>I</AxisType><Increment>1.27656509837346e-007</Increment>\
             </CX><CY><AxisType>I</AxisType><Increment>2E-6</Increment></CY><CZ><AxisType>A</AxisType>\
             <DataType>I</DataType><Increment>0</Increment><Offset/></CZ></Axes></Record1>\
             <Record2><Comment>R&amp;D &#8211; 5</Comment></Record2><Record3><MatrixDimension><SizeX>2</SizeX>\
             <SizeY>1</SizeY></MatrixDimension><DataList><Datum/><Datum>7</Datum></DataList></Record3></ISO5436>",
        )
        .unwrap();
        assert_eq!(xml.feature, "SUR");
        assert_eq!(xml.sizes, [2, 1, 1]);
        assert_eq!(xml.axes[0].increment, Some(1.27656509837346e-7));
        assert_eq!((xml.axes[2].increment, xml.axes[2].offset, xml.axes[2].sample), (None, None, Sample::I16));
        assert!(xml.data[0][2].is_nan() && xml.data[1][2] == 7.0);
        assert_eq!(xml.notes, [("comment".to_owned(), "R&D \u{2013} 5".to_owned())]);
    }

    #[test]
    fn broken_documents_are_refused() {
        for (xml, says) in [
            ("<a><b></a>", "not well formed"),
            ("<a><b>", "ends early"),
            (&"<a>".repeat(100), "nested too deeply"),
            ("<a><Record3><MatrixDimension><SizeX>-1</SizeX></MatrixDimension></Record3></a>", "not a count"),
        ] {
            let message = parse(xml).unwrap_err().to_string();
            assert!(message.contains(says), "{message}");
        }
    }
}
