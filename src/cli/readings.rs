//! What `asperity gloss` reads beside the three gloss angles: haze, image, instruments of choice.

use super::instrument;
use super::source::Source;
use crate::error::Result;
use crate::math::Estimate;
use crate::meter::appearance::flop_index;
use crate::meter::{Appearance, Colour, Instrument, Options, Reading, Warning, appearance, colours, surface_scatter};
use crate::model;
use crate::optics::Brdf;
use crate::optics::colour::Illuminant;
use clap::Args;
use serde_json::json;
use std::fmt::Write;
use std::path::PathBuf;

#[derive(Args)]
#[command(next_help_heading = "Readings")]
pub struct Flags {
    /// Read with this instrument as well: a name from `asperity instrument`, or a TOML file
    #[arg(long, value_name = "NAME|FILE.toml")]
    instrument: Vec<String>,
    /// Light of the colours that the metallic instruments read on a model: E, A, C, D65
    #[arg(long, default_value = "D65", value_name = "NAME")]
    illuminant: String,
    /// Check every reading of an instrument by adaptive subdivision of both stops
    #[arg(long)]
    check: bool,
    /// Write all readings as CSV
    #[arg(long, value_name = "FILE.csv", value_parser = super::written::csv)]
    pub csv: Option<PathBuf>,
}

/// The instruments to read with beside the usual set.
pub struct Bench {
    instruments: Vec<Instrument>,
    illuminant: Illuminant,
    check: bool,
}

/// What one instrument read.
struct Sheet {
    instrument: String,
    readings: Vec<Reading>,
    checks: Vec<Reading>,
    colours: Vec<Colour>,
}

/// Everything read on one source.
pub struct Readings {
    usual: Appearance,
    sheets: Vec<Sheet>,
}

impl Flags {
    /// Opens the instruments.
    pub fn bench(&self) -> Result<Bench> {
        let instruments = self.instrument.iter().map(|text| instrument::open(text)).collect::<Result<Vec<_>>>()?;
        Ok(Bench { instruments, illuminant: Illuminant::parse(&self.illuminant)?, check: self.check })
    }
}

impl Bench {
    /// Reads one source, averaged over source azimuths \[rad\].
    pub fn read(&self, source: &Source, azimuths: &[f64]) -> Result<Readings> {
        let options = Options::default().with_azimuths(azimuths);
        let brdf = source.brdf();
        let mut usual = appearance(brdf, &options)?;
        let mut sheets: Vec<Sheet> =
            self.instruments.iter().map(|meter| self.sheet(meter, source, &options)).collect::<Result<_>>()?;
        if let Some(surface) = source.surface() {
            let read = |brdf: &dyn Brdf, options: &Options| -> Result<Vec<f64>> {
                let mut numbers = appearance(brdf, options)?.numbers();
                for meter in &self.instruments {
                    numbers.extend(meter.measure(brdf, options)?.iter().map(|r| r.estimate.value));
                }
                Ok(numbers)
            };
            let mut values = usual.numbers();
            let of_usual = values.len();
            values.extend(sheets.iter().flat_map(|s| &s.readings).map(|r| r.estimate.value));
            let errors = surface_scatter(&surface.brdf, &values, &options, &read)?;
            usual = usual.with_errors(&errors[..of_usual]);
            for (reading, error) in sheets.iter_mut().flat_map(|s| &mut s.readings).zip(&errors[of_usual..]) {
                reading.estimate = reading.estimate.with_error(*error);
            }
        }
        Ok(Readings { usual, sheets })
    }

    fn sheet(&self, meter: &Instrument, source: &Source, options: &Options) -> Result<Sheet> {
        let brdf = source.brdf();
        let metallic = meter.name.starts_with("metallic");
        Ok(Sheet {
            instrument: meter.name.clone(),
            readings: meter.measure(brdf, options)?,
            checks: if self.check { meter.subdivide(brdf, options)? } else { Vec::new() },
            colours: match source {
                Source::Model { text, .. } if metallic => {
                    colours(&|l| model::parse(text, l), meter, self.illuminant, &Options::quick())?
                }
                _ => Vec::new(),
            },
        })
    }
}

impl Sheet {
    /// Flop index, where the three angles were read in colour.
    fn flop(&self) -> Option<f64> {
        let lightness = |name: &str| self.colours.iter().find(|c| c.name == name).map(|c| c.lab[0]);
        flop_index(lightness("15")?, lightness("45")?, lightness("110")?)
    }
}

impl Readings {
    /// Adds the readings to the JSON of a source.
    pub fn add_to(&self, entry: &mut serde_json::Value) {
        let u = &self.usual;
        entry["haze"] = estimate(&u.haze);
        entry["log_haze"] = json!(u.log_haze);
        entry["haze_index"] = json!(u.haze_index);
        entry["doi"] = u.doi.as_ref().map_or(serde_json::Value::Null, estimate);
        entry["rspec"] = estimate(&u.rspec);
        entry["converged"] = json!(self.unconverged().is_empty());
        if !self.sheets.is_empty() {
            entry["instruments"] = self.sheets.iter().map(sheet_json).collect();
        }
    }

    /// Names of the readings whose error stayed above the tolerance.
    pub fn unconverged(&self) -> Vec<&str> {
        let u = &self.usual;
        let usual = u.gloss.iter().chain([&u.haze, &u.rspec]).chain(&u.doi);
        let all = usual.chain(self.sheets.iter().flat_map(|s| &s.readings));
        all.filter(|r| !r.converged).map(|r| r.name.as_str()).collect()
    }

    /// What there is to say against them.
    pub fn doubt(&self) -> Option<Warning> {
        self.usual.doubt()
    }

    /// One line of the table of haze and image.
    pub fn line(&self) -> [String; 5] {
        let u = &self.usual;
        let text = |e: Estimate| format!("{:.2} +- {:.2}", e.value, e.standard_error);
        [
            text(u.haze.estimate),
            format!("{:.1} +- {:.1}", u.log_haze.value, u.log_haze.standard_error),
            text(u.haze_index),
            u.doi.as_ref().map_or("none".into(), |doi| text(doi.estimate)),
            text(u.rspec.estimate),
        ]
    }

    /// Prints what the instruments of choice read.
    pub fn print_sheets(&self, source: &str) {
        for sheet in &self.sheets {
            println!("\n{} on {source}", sheet.instrument);
            for (k, r) in sheet.readings.iter().enumerate() {
                let mut line =
                    format!("  {:<12} {:>10.3} +- {:.3}", r.name, r.estimate.value, r.estimate.standard_error);
                if let Some(c) = sheet.checks.get(k) {
                    let _ =
                        write!(line, "   by subdivision {:.3} +- {:.3}", c.estimate.value, c.estimate.standard_error);
                }
                if let Some(c) = sheet.colours.get(k) {
                    let [l, a, b] = c.lab;
                    let _ = write!(line, "   L* {l:.2}  a* {a:.2}  b* {b:.2}");
                }
                println!("{line}");
            }
            if let Some(flop) = sheet.flop() {
                println!("  flop index   {flop:>10.2}");
            }
        }
    }

    /// Rows `source,instrument,reading,value,standard_error` of the CSV.
    pub fn csv(&self, source: &str, gloss: [Estimate; 3]) -> String {
        let u = &self.usual;
        let mut rows = String::new();
        let mut row = |instrument: &str, reading: &str, e: Estimate| {
            let name = source.replace('"', "\"\"");
            let _ = writeln!(rows, "\"{name}\",{instrument},{reading},{:.6},{:.6}", e.value, e.standard_error);
        };
        for (angle, e) in ["20", "60", "85"].iter().zip(gloss) {
            row(&format!("gloss-{angle}"), "gloss", e);
        }
        row("haze-20", "haze", u.haze.estimate);
        row("haze-20", "log haze", u.log_haze);
        row("gloss-60 gloss-20", "haze index", u.haze_index);
        if let Some(doi) = &u.doi {
            row("doi", "doi", doi.estimate);
        }
        row("rspec", "rspec", u.rspec.estimate);
        for sheet in &self.sheets {
            sheet.readings.iter().for_each(|r| row(&sheet.instrument, &r.name, r.estimate));
        }
        rows
    }
}

/// Heads of [`Readings::line`].
pub const HEADS: [&str; 5] = ["haze", "log haze", "haze index", "DOI", "Rspec"];

/// Head of [`Readings::csv`].
pub const CSV_HEAD: &str = "source,instrument,reading,value,standard_error\n";

fn estimate(r: &Reading) -> serde_json::Value {
    json!({ "value": r.estimate.value, "standard_error": r.estimate.standard_error })
}

fn sheet_json(sheet: &Sheet) -> serde_json::Value {
    let readings: Vec<_> = sheet
        .readings
        .iter()
        .enumerate()
        .map(|(k, r)| {
            let mut entry = json!({
                "name": r.name, "value": r.estimate.value, "standard_error": r.estimate.standard_error,
                "converged": r.converged,
            });
            if let Some(c) = sheet.checks.get(k) {
                entry["by_subdivision"] = estimate(c);
            }
            if let Some(c) = sheet.colours.get(k) {
                entry["xyz"] = json!(c.xyz.map(|x| x.value));
                entry["lab"] = json!(c.lab);
            }
            entry
        })
        .collect();
    json!({ "instrument": sheet.instrument, "readings": readings, "flop_index": sheet.flop() })
}

/// Source azimuths to average a source over \[rad\].
pub fn azimuths(source: &Source) -> Vec<f64> {
    if source.isotropic() { vec![0.0] } else { crate::report::prediction::GLOSS_AZIMUTHS.to_vec() }
}
