//! The figures by name: prepared, rendered, laid out.

use super::finish::Finish;
use super::{shells, spheres, tiles, vases};
use crate::error::{Error, Result};
use crate::render::sheet::{Caption, Layout, Panel, Sheet};
use crate::render::{Camera, Estimator, Film, RenderOptions, Scene, render, save_exr};
use std::path::{Path, PathBuf};

/// Surfaces with the lines below each.
type Prepared = Vec<(Finish, Vec<String>)>;

/// What a figure is, apart from its surfaces.
struct Plan {
    name: &'static str,
    heading: &'static str,
    /// Default size of a panel and paths per pixel.
    width: usize,
    samples: u32,
    max_reflections: u32,
    /// \[m2 sr/W\]
    exposure: f64,
    finishes: fn(&(dyn Fn(f64) + Sync)) -> Result<Prepared>,
    scene: for<'a> fn(&'a [Finish]) -> Result<Scene<'a>>,
    /// Width over height of a panel; the camera for an aspect; the column of a surface.
    aspect: fn(usize) -> f64,
    camera: fn(usize, f64) -> Result<Camera>,
    column: fn(usize, usize) -> f64,
    modes: &'static [(Estimator, &'static str)],
}

const PLAIN: &[(Estimator, &str)] = &[(Estimator::Mis, "")];

static PLANS: [Plan; 7] = [
    Plan {
        name: "fig7",
        heading: "Four spheres of rising gloss: three ways to find the light",
        width: 1000,
        samples: 160,
        max_reflections: 3,
        exposure: 0.8,
        finishes: spheres::finishes,
        scene: spheres::scene,
        aspect: |_| spheres::ASPECT,
        camera: |_, aspect| spheres::VIEW.camera(aspect),
        column: |k, _| spheres::VIEW.column(spheres::centre(k)),
        modes: &[
            (Estimator::Direct, "direct light of the lamps only"),
            (Estimator::Uniform, "directions uniform over the hemisphere"),
            (Estimator::Mis, "directions by the alias tables"),
        ],
    },
    Plan {
        name: "fig8",
        heading: "Black glass under epoxy, from its height maps",
        width: 960,
        samples: 256,
        finishes: tiles::epoxy,
        ..TILES
    },
    Plan {
        name: "fig9",
        heading: "Metallic paint with coarse and with fine flakes",
        width: 720,
        samples: 128,
        finishes: vases::flakes,
        ..VASES
    },
    Plan {
        name: "fig11",
        heading: "20\u{b0} specular gloss 80, 60, 40 and 20",
        width: 1280,
        samples: 256,
        exposure: 1.5,
        finishes: tiles::gloss_series,
        ..TILES
    },
    Plan {
        name: "fig12",
        heading: "2\u{b0} haze 10, 60, 110 and 160 at 20\u{b0} gloss 100",
        width: 1280,
        samples: 256,
        exposure: 0.75,
        finishes: tiles::haze_series,
        ..TILES
    },
    Plan {
        name: "fig13",
        heading: "Metallic paint without a clear coat",
        width: 880,
        samples: 96,
        finishes: vases::colours,
        ..VASES
    },
    Plan {
        name: "fig14",
        heading: "First surfaces of 20\u{b0} gloss 10 and 60",
        width: 960,
        samples: 192,
        max_reflections: 3,
        exposure: 0.7,
        finishes: shells::finishes,
        scene: shells::scene,
        aspect: |_| shells::ASPECT,
        camera: |_, aspect| shells::VIEW.camera(aspect),
        column: |k, _| shells::VIEW.column(shells::middle(k)),
        modes: PLAIN,
    },
];

/// What the figures of tiles share.
const TILES: Plan = Plan {
    name: "",
    heading: "",
    width: 0,
    samples: 0,
    max_reflections: 4,
    exposure: 1.0,
    finishes: tiles::epoxy,
    scene: tiles::scene,
    aspect: |n| tiles::stage(n).map_or(1.0, |s| s.aspect()),
    camera: |n, aspect| tiles::stage(n)?.camera(aspect),
    column: |k, n| tiles::stage(n).map_or(0.5, |s| s.column(k)),
    modes: PLAIN,
};

/// What the figures of vases share.
const VASES: Plan = Plan {
    max_reflections: 3,
    finishes: vases::flakes,
    scene: vases::scene,
    aspect: vases::aspect,
    camera: |n, aspect| vases::view(n).camera(aspect),
    column: |k, n| vases::view(n).column(vases::foot(k, n)),
    ..TILES
};

/// What the user may choose; `None` leaves the figure's own choice.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Settings {
    /// Width of a panel \[pixels\].
    pub width: Option<usize>,
    pub samples: Option<u32>,
    /// Relative error at which a block of pixels stops.
    pub error: Option<f64>,
    pub seed: Option<u64>,
    /// \[m2 sr/W\]
    pub exposure: Option<f64>,
}

/// A figure whose surfaces are computed.
pub struct Figure {
    plan: &'static Plan,
    finishes: Vec<Finish>,
    lines: Vec<Vec<String>>,
}

/// A rendered figure: one film per mode, and all of them laid out.
pub struct Picture {
    films: Vec<(Estimator, Film)>,
    sheet: Sheet,
    comment: String,
}

impl Figure {
    /// Names of all figures.
    pub fn names() -> Vec<&'static str> {
        PLANS.iter().map(|p| p.name).collect()
    }

    /// Computes the surfaces of a figure: scatters maps, asks the meter.
    ///
    /// # Errors
    /// `Error::Parameter` if there is no figure of that name, with the names.
    pub fn prepare(name: &str, progress: &(dyn Fn(f64) + Sync)) -> Result<Self> {
        let plan = PLANS.iter().find(|p| p.name == name).ok_or_else(|| {
            Error::parameter(
                format!("there is no figure `{name}`"),
                format!("choose one of {}", Self::names().join(", ")),
            )
        })?;
        let (finishes, lines) = (plan.finishes)(progress)?.into_iter().unzip();
        Ok(Figure { plan, finishes, lines })
    }

    /// Its name, such as `fig7`.
    pub fn name(&self) -> &'static str {
        self.plan.name
    }

    /// What covers the bodies, from left to right.
    pub fn finishes(&self) -> &[Finish] {
        &self.finishes
    }

    /// The words below each body.
    pub fn captions(&self) -> &[Vec<String>] {
        &self.lines
    }

    /// How its light is found, panel by panel.
    pub fn modes(&self) -> impl Iterator<Item = Estimator> {
        self.plan.modes.iter().map(|m| m.0)
    }

    /// The scene.
    ///
    /// # Errors
    /// None for a figure of the list.
    pub fn scene(&self) -> Result<Scene<'_>> {
        (self.plan.scene)(&self.finishes)
    }

    /// The camera for a picture of the given width over height.
    ///
    /// # Errors
    /// `Error::Parameter` if the aspect is not above 0.
    pub fn camera(&self, aspect: f64) -> Result<Camera> {
        (self.plan.camera)(self.finishes.len(), aspect)
    }

    /// The options of the renderer for one of its modes.
    pub fn options(&self, settings: &Settings, estimator: Estimator) -> RenderOptions {
        let width = settings.width.unwrap_or(self.plan.width);
        let height = (width as f64 / (self.plan.aspect)(self.finishes.len())).round().max(1.0) as usize;
        RenderOptions {
            width,
            height,
            samples_per_pixel: settings.samples.unwrap_or(self.plan.samples),
            seed: settings.seed.unwrap_or(1),
            max_reflections: self.plan.max_reflections,
            estimator,
            error: settings.error,
        }
    }

    /// Renders every mode and lays the panels out below each other.
    ///
    /// # Errors
    /// `Error::Parameter` if a setting is out of range.
    pub fn render(&self, settings: &Settings, progress: &(dyn Fn(f64) + Sync)) -> Result<Picture> {
        if let Some(e) = settings.exposure.filter(|e| !(*e > 0.0 && e.is_finite())) {
            return Err(Error::parameter(
                format!("the exposure {e} shows nothing"),
                "give an exposure above 0, or none",
            ));
        }
        let scene = self.scene()?;
        let modes = self.plan.modes;
        let mut films = Vec::new();
        for (k, (estimator, _)) in modes.iter().enumerate() {
            let options = self.options(settings, *estimator);
            let camera = self.camera(options.width as f64 / options.height as f64)?;
            let part = |done: f64| progress((k as f64 + done) / modes.len() as f64);
            films.push((*estimator, render(&scene, &camera, &options, &part)?));
        }
        let exposure = settings.exposure.unwrap_or(self.plan.exposure);
        let options = self.options(settings, Estimator::Mis);
        let note = format!(
            "Path traced, {}{} paths a pixel, {} reflections at most; display = sRGB({} m\u{b2} sr/W \u{d7} radiance).",
            if options.error.is_some() { "at most " } else { "" },
            options.samples_per_pixel,
            options.max_reflections,
            crate::render::tiles::short(exposure),
        );
        let bodies: Vec<String> = self.lines.iter().map(|l| l.join(", ")).collect();
        let comment = format!(
            "asperity render {}. From left to right: {}. Seed {}.",
            self.plan.name,
            bodies.join("; "),
            options.seed
        );
        let panels: Vec<Panel> = films
            .iter()
            .enumerate()
            .map(|(k, (_, film))| Panel { film: film.clone(), captions: self.captions_of(k) })
            .collect();
        let layout = Layout {
            heading: self.plan.heading.to_owned(),
            note,
            panels_per_row: 1,
            exposure,
            comment: comment.clone(),
        };
        Ok(Picture { films, sheet: Sheet::compose(&panels, &layout)?, comment })
    }

    /// A panel of a figure with several modes is named by its mode; the bodies are named below the last.
    fn captions_of(&self, panel: usize) -> Vec<Caption> {
        let count = self.finishes.len();
        let modes = self.plan.modes;
        let mut captions = Vec::new();
        if modes.len() > 1 {
            let letter = char::from(b'a' + panel as u8);
            let lines = vec![format!("({letter}) {}", modes[panel].1)];
            captions.push(Caption { centre: 0.5, width: 1.0, lines });
        }
        if panel + 1 == modes.len() {
            let blank = captions.len();
            let column = |k: usize| (self.plan.column)(k, count);
            for (k, lines) in self.lines.iter().enumerate() {
                let lines = std::iter::repeat_n(String::new(), blank).chain(lines.iter().cloned()).collect();
                captions.push(Caption { centre: column(k), width: self.room(), lines });
            }
        }
        captions
    }
}

impl Figure {
    /// Share of the width that the words of one body may take.
    fn room(&self) -> f64 {
        let count = self.finishes.len();
        let column = |k: usize| (self.plan.column)(k, count);
        let apart = (1..count).map(|k| column(k) - column(k - 1)).fold(1.0, f64::min);
        0.96 * apart
    }
}

impl Picture {
    /// The panels laid out, with captions.
    pub fn sheet(&self) -> &Sheet {
        &self.sheet
    }

    /// Radiance [W/(m2 sr)] by each mode.
    pub fn films(&self) -> &[(Estimator, Film)] {
        &self.films
    }

    /// Writes the labelled picture (`.png`) or the radiance (`.exr`). A figure of several modes also gets one `.exr` per
    /// mode, `NAME-direct.exr` and so on. Returns what was written.
    ///
    /// # Errors
    /// As [`Sheet::save`].
    pub fn save(&self, path: &Path) -> Result<Vec<PathBuf>> {
        self.sheet.save(path)?;
        let mut written = vec![path.to_owned()];
        if self.films.len() > 1 && path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
            let stem = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
            for (estimator, film) in &self.films {
                let file = path.with_file_name(format!("{stem}-{}.exr", estimator.name()));
                let comment = format!("{} Radiance in W/(m2 sr), estimator {}.", self.comment, estimator.name());
                save_exr(film, &comment, &file)?;
                written.push(file);
            }
        }
        Ok(written)
    }
}
