//! SOURCE on the command line: a height map, a table or a model.

use super::map_options::{MapOptions, print_report};
use super::scatter_options::ScatterOptions;
use crate::error::{Error, Result};
use crate::heightmap::prepare::Report;
use crate::math::Estimate;
use crate::meter;
use crate::model;
use crate::optics::Brdf;
use crate::report::{Prediction, predict, prediction};
use crate::table::Table;
use std::path::{Path, PathBuf};

/// A source ready to be looked at.
pub enum Source {
    /// A table has no preparation.
    Surface {
        prediction: Box<Prediction>,
        preparation: Option<(PathBuf, Report)>,
    },
    Model {
        text: String,
        brdf: Box<dyn Brdf>,
        gloss: [Estimate; 3],
    },
}

impl Source {
    /// Model by name, table by its header, height map by its content.
    pub fn open(
        text: &str,
        map: &MapOptions,
        scatter: &ScatterOptions,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Result<Source> {
        let settings = scatter.settings()?;
        if model::is_model(text) {
            let brdf = model::parse_with(text, &|part| layer(part, map, scatter))?;
            let gloss = settings.glossmeter.clone().map(|g| meter::gloss(brdf.as_ref(), &g, &settings.meter));
            progress(1.0);
            return Ok(Source::Model { text: text.to_owned(), brdf, gloss });
        }
        let path = Path::new(text);
        let name = file_name(path);
        let bytes = std::fs::read(path).map_err(|e| {
            if e.kind() == std::io::ErrorKind::NotFound {
                Error::content(
                    path,
                    "there is no such file, and no model of that name",
                    "`asperity models` lists the models",
                )
            } else {
                Error::io(path, "read", e)
            }
        })?;
        let (found, preparation) = if Table::recognises(&bytes) {
            (prediction::from_table(Table::load(path)?, &name, &settings)?, None)
        } else {
            let prepared = map.load(path)?;
            let found = predict(&prepared.map, &name, &settings, progress)?;
            if let Some(warning) = scatter.unused_azimuths(found.isotropic) {
                eprintln!("warning: {warning}");
            }
            (found, Some((path.to_owned(), prepared.report)))
        };
        progress(1.0);
        Ok(Source::Surface { prediction: Box::new(found), preparation })
    }

    /// File name or model text.
    pub fn name(&self) -> &str {
        match self {
            Source::Surface { prediction, .. } => &prediction.name,
            Source::Model { text, .. } => text,
        }
    }

    /// What reflects.
    pub fn brdf(&self) -> &dyn Brdf {
        match self {
            Source::Surface { prediction, .. } => &prediction.brdf,
            Source::Model { brdf, .. } => brdf.as_ref(),
        }
    }

    /// Gloss at 20, 60, 85 deg.
    pub fn gloss(&self) -> [Estimate; 3] {
        match self {
            Source::Surface { prediction, .. } => prediction.gloss,
            Source::Model { gloss, .. } => *gloss,
        }
    }

    /// Whether one azimuth of the source stands for all. A model is read as it is written, from azimuth 0.
    pub fn isotropic(&self) -> bool {
        self.surface().is_none_or(|p| p.isotropic)
    }

    /// How the height map behind it was prepared, if there is one.
    pub fn preparation(&self) -> Option<&Report> {
        match self {
            Source::Surface { preparation: Some((_, report)), .. } => Some(report),
            _ => None,
        }
    }

    /// Says on stderr how the height map behind it was prepared.
    pub fn print_preparation(&self) {
        if let Source::Surface { preparation: Some((path, report)), .. } = self {
            print_report(path, report);
        }
    }

    /// The surface behind it, if there is one.
    pub fn surface(&self) -> Option<&Prediction> {
        match self {
            Source::Surface { prediction, .. } => Some(prediction),
            Source::Model { .. } => None,
        }
    }
}

/// One layer of a model: a model itself, a table or a height map.
fn layer(text: &str, map: &MapOptions, scatter: &ScatterOptions) -> Result<Box<dyn Brdf>> {
    if model::is_model(text) {
        return model::parse(text, scatter.wavelength());
    }
    match Source::open(text, map, scatter, &|_| ())? {
        Source::Surface { prediction, .. } => Ok(Box::new(prediction.brdf)),
        Source::Model { brdf, .. } => Ok(brdf),
    }
}

/// Last component of a path, for people.
pub fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |n| n.to_string_lossy().into_owned())
}
