//! Meshes from .ply and .obj files.

use super::mesh::Mesh;
use crate::error::{Error, Result};
use crate::math::frame::DVec3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use std::collections::HashMap;
use std::io::BufReader;
use std::path::Path;

/// What a file holds; polygons are cut into fans.
#[derive(Default)]
struct Content {
    vertices: Vec<DVec3>,
    normals: Option<Vec<DVec3>>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Reads a `.ply` (ASCII or binary) or `.obj` file; `unit` is the length in metres of one unit of the file. `smooth`
    /// interpolates normals, those of the file if it has some; `None` is smooth if it has.
    ///
    /// # Errors
    /// `Error::Io`, or `Error::Content` naming the file and what is wrong with it, see [`Mesh::new`].
    pub fn load(path: &Path, unit: f64, smooth: Option<bool>) -> Result<Mesh> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let mut content = match extension.as_deref() {
            Some("ply") => ply(path)?,
            Some("obj") => obj(path)?,
            _ => {
                return Err(Error::content(path, "this kind of mesh cannot be read", "save it as .ply or .obj"));
            }
        };
        if content.triangles.is_empty() {
            return Err(Error::content(path, "the file has no faces", "export it as a mesh, not as points"));
        }
        content.vertices.iter_mut().for_each(|p| *p *= unit);
        content.normals = match smooth {
            Some(false) => None,
            None => content.normals,
            Some(true) => content.normals.or_else(|| Some(Mesh::vertex_normals(&content.vertices, &content.triangles))),
        };
        Mesh::new(content.vertices, content.normals, content.triangles).map_err(|e| match e {
            Error::Parameter { what, advice } => Error::content(path, what, advice),
            other => other,
        })
    }
}

/// A vertex or a face of a PLY file, whichever properties it has.
#[derive(Default)]
struct Element {
    position: [f64; 3],
    normal: [f64; 3],
    corners: Vec<i64>,
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Element::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let number = match property {
            Property::Char(v) => f64::from(v),
            Property::UChar(v) => f64::from(v),
            Property::Short(v) => f64::from(v),
            Property::UShort(v) => f64::from(v),
            Property::Int(v) => f64::from(v),
            Property::UInt(v) => f64::from(v),
            Property::Float(v) => f64::from(v),
            Property::Double(v) => v,
            list => {
                if name == "vertex_indices" || name == "vertex_index" {
                    self.corners = integers(list);
                }
                return PropertyAccessResult::Set;
            }
        };
        match name {
            "x" => self.position[0] = number,
            "y" => self.position[1] = number,
            "z" => self.position[2] = number,
            "nx" => self.normal[0] = number,
            "ny" => self.normal[1] = number,
            "nz" => self.normal[2] = number,
            _ => {}
        }
        PropertyAccessResult::Set
    }
}

/// Indices of a list property; none of a list of fractions.
fn integers(list: Property) -> Vec<i64> {
    match list {
        Property::ListChar(v) => v.into_iter().map(i64::from).collect(),
        Property::ListUChar(v) => v.into_iter().map(i64::from).collect(),
        Property::ListShort(v) => v.into_iter().map(i64::from).collect(),
        Property::ListUShort(v) => v.into_iter().map(i64::from).collect(),
        Property::ListInt(v) => v.into_iter().map(i64::from).collect(),
        Property::ListUInt(v) => v.into_iter().map(i64::from).collect(),
        _ => Vec::new(),
    }
}

fn ply(path: &Path) -> Result<Content> {
    let file = std::fs::File::open(path).map_err(|e| Error::io(path, "read", e))?;
    let mut reader = Reader::new(BufReader::new(file));
    let parser = Parser::<Element>::new();
    let damaged = |e: &dyn std::fmt::Display| {
        Error::content(path, format!("the .ply file cannot be read: {e}"), "copy or export it again")
    };
    let header = parser.read_header(&mut reader).map_err(|e| damaged(&e))?;
    let mut content = Content::default();
    for (name, element) in &header.elements {
        let has = |property: &str| element.properties.iter().any(|(key, _)| key.as_str() == property);
        let list = parser.read_payload_for_element(&mut reader, element, &header).map_err(|e| damaged(&e))?;
        match name.as_str() {
            "vertex" => {
                content.vertices = list.iter().map(|e| e.position.into()).collect();
                content.normals = has("nx").then(|| list.iter().map(|e| e.normal.into()).collect());
            }
            "face" => {
                for (k, face) in list.iter().enumerate() {
                    fan(&face.corners, &mut content.triangles).map_err(|what| {
                        Error::content(path, format!("face {k} {what}"), "mend the mesh or export it again")
                    })?;
                }
            }
            _ => {}
        }
    }
    Ok(content)
}

/// Cuts a polygon into triangles about its first corner.
fn fan(corners: &[i64], triangles: &mut Vec<[u32; 3]>) -> std::result::Result<(), String> {
    if corners.len() < 3 {
        return Err(format!("has {} corners", corners.len()));
    }
    let index = |k: i64| u32::try_from(k).map_err(|_| format!("names vertex {k}"));
    for pair in corners[1..].windows(2) {
        triangles.push([index(corners[0])?, index(pair[0])?, index(pair[1])?]);
    }
    Ok(())
}

fn obj(path: &Path) -> Result<Content> {
    let file = std::fs::File::open(path).map_err(|e| Error::io(path, "read", e))?;
    let options =
        tobj::LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..Default::default() };
    // Materials come from the scene, not from the file.
    let no_materials = |_: &Path| Ok((Vec::new(), HashMap::default()));
    let (models, _) = tobj::load_obj_buf(&mut BufReader::new(file), &options, no_materials).map_err(|e| {
        Error::content(path, format!("the .obj file cannot be read: {e}"), "mend the mesh or export it again")
    })?;
    let mut content = Content::default();
    let smooth = models.iter().all(|m| m.mesh.normal_indices.len() == m.mesh.indices.len());
    let mut normals = Vec::new();
    for model in &models {
        let mesh = &model.mesh;
        let vector = |list: &[f32], k: u32| -> Option<DVec3> {
            let at = 3 * k as usize;
            let v = list.get(at..at + 3)?;
            Some(DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2])))
        };
        // A vertex with two normals, along an edge, becomes two.
        let mut known: HashMap<(u32, u32), u32> = HashMap::new();
        let mut corners = Vec::with_capacity(mesh.indices.len());
        for (k, &position) in mesh.indices.iter().enumerate() {
            let normal = if smooth { mesh.normal_indices[k] } else { 0 };
            let next = content.vertices.len() as u32;
            let index = *known.entry((position, normal)).or_insert(next);
            if index == next {
                let bad = || {
                    let what = format!("a face of `{}` names vertex {position} or normal {normal}", model.name);
                    Error::content(path, what + ", which there is not", "mend the mesh or export it again")
                };
                content.vertices.push(vector(&mesh.positions, position).ok_or_else(bad)?);
                if smooth {
                    normals.push(vector(&mesh.normals, normal).ok_or_else(bad)?);
                }
            }
            corners.push(index);
        }
        content.triangles.extend(corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]));
    }
    content.normals = (smooth && !normals.is_empty()).then_some(normals);
    Ok(content)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(name: &str, text: &str, smooth: Option<bool>) -> Result<Mesh> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        Mesh::load(&path, 1e-3, smooth)
    }

    const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n2 0 0\n2 3 0\n0 3 0\n4 0 1 2 3\n";

    #[test]
    fn a_polygon_of_a_ply_file_is_cut_and_scaled() {
        let mesh = load("a.ply", PLY, None).unwrap();
        assert_eq!(mesh.len(), 2);
        assert!((mesh.area() - 6e-6).abs() < 1e-18);
    }

    #[test]
    fn an_obj_file_brings_its_normals() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0.6 0.8\nf 1//1 2//1 3//1\n";
        let normal = |smooth| load("a.obj", text, smooth).unwrap().normals(0, [0.2, 0.2]).1;
        assert!((normal(None) - DVec3::new(0.0, 0.6, 0.8)).length() < 1e-6);
        assert_eq!(normal(Some(false)), DVec3::Z);
        let plain = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n";
        assert_eq!(load("a.obj", plain, Some(true)).unwrap().normals(0, [0.2, 0.2]).1, DVec3::Z);
    }

    #[test]
    fn bad_meshes_are_refused_by_name() {
        let message = |name: &str, text: &str| load(name, text, None).err().expect(text).to_string();
        let beyond = message("a.ply", &PLY.replace("4 0 1 2 3", "4 0 1 2 9"));
        assert!(beyond.contains("a.ply") && beyond.contains("triangle 1"), "{beyond}");
        let negative = message("a.ply", &PLY.replace("4 0 1 2 3", "4 0 1 2 -1"));
        assert!(negative.contains("face 0") && negative.contains("vertex -1"), "{negative}");
        assert!(message("a.ply", &PLY[..PLY.len() - 20]).contains("cannot be read"));
        assert!(message("a.ply", &PLY.replace("4 0 1 2 3", "2 0 1")).contains("2 corners"));
        assert!(message("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 8\n").contains("a.obj"));
        assert!(message("a.obj", "v 0 0 0\n").contains("no faces"));
        assert!(message("a.stl", "solid").contains(".ply"));
        assert!(Mesh::load(Path::new("nowhere.ply"), 1.0, None).err().unwrap().to_string().contains("nowhere.ply"));
    }
}
