//! Floor 10: one file per verb; each reads, calls the library and prints.

mod bench;
mod brdf;
mod check;
mod convert;
mod correspondence;
mod eval;
mod figure;
mod fit;
mod fit_target;
mod gloss;
mod inspect;
mod instrument;
mod lobe;
mod map_options;
mod models;
mod predict;
mod progress;
mod protocol;
mod quantity;
mod readings;
mod render;
mod sample;
mod scan;
mod scatter_options;
mod source;
mod synth;
mod tiles;
mod written;

use crate::error::Error;
use clap::{Parser, Subcommand};

/// Predicts how a surface looks from how it was measured: height map to BRDF, gloss and picture.
#[derive(Parser)]
#[command(version, max_term_width = 110)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
    /// Print one JSON object on stdout instead of text
    #[arg(long, global = true)]
    json: bool,
    /// Threads to use [default: all cores]; the results do not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

#[derive(Subcommand)]
enum Verb {
    /// Whole chain for maps or folders of maps: tables, gloss, chart and comparison tiles
    Predict(predict::Arguments),
    /// What a height map is: size, ISO 25178 parameters, slopes, spectrum, and whether it can be trusted
    Inspect(inspect::Arguments),
    /// Height map to tabulated BRDF (.npz), or to energies counted detector by detector (.csv)
    Brdf(brdf::Arguments),
    /// Gloss at 20, 60 and 85 deg, haze, image quality and any instrument, of maps, tables or models
    Gloss(gloss::Arguments),
    /// Parameters of a model from a map, table, list of f_r or model, or from gloss and haze to be reached
    Fit(fit::Arguments),
    /// Picture of lobes: slices in the plane of incidence and in the round (.svg, .png)
    Lobe(lobe::Arguments),
    /// A NEF-BM material from the scans of a goniometer, with residuals and standard errors
    Protocol(protocol::Arguments),
    /// f_r and its error at listed directions, of a map, table or model
    Eval(eval::Arguments),
    /// Directions drawn from a map, table or model, with pdf and weight (.npy)
    Sample(sample::Arguments),
    /// Audit of a map, table or model: energy, reciprocity, and whether draws follow their pdf
    Check(check::Arguments),
    /// The BRDF in the plane of incidence as a goniometer scans it: CSV and chart
    Scan(scan::Arguments),
    /// The named light meters with the sources of their numbers, as TOML to start from; checks a file of one's own
    Instrument(instrument::Arguments),
    /// What the meters read along one parameter of a model
    Correspondence(correspondence::Arguments),
    /// Comparison picture of maps, tables or models
    Tiles(tiles::Arguments),
    /// Picture of a scene file, path-traced (.exr radiance, .png); radiance read back from a picture
    Render(render::Arguments),
    /// Height map to another format (.x3p, .sdf, .npy, 16-bit .png), or to a picture in colour
    Convert(convert::Arguments),
    /// Time against error of every method; what auto chooses; how cost grows; the budgets
    Bench(bench::Arguments),
    /// Make a synthetic height map (.x3p, .npy or .sdf)
    Synth(synth::Arguments),
    /// The BRDF models with their parameters and ranges, and the materials of the library
    Models(models::Arguments),
}

/// A reader that has gone away, such as `head`, is no failure of this program: it leaves without a word, with the code that a
/// shell reports for a closed pipe. `println!` panics on one, and nothing else tells. A full disk is an error like any other.
fn leave_when_nobody_reads() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let words = panic.payload().downcast_ref::<String>().map_or("", String::as_str);
        let closed = ["Broken pipe", "pipe is being closed"].iter().any(|word| words.contains(word));
        if words.starts_with("failed printing to std") && closed {
            crate::output::abandon(141);
        }
        if let Some(cause) = words.strip_prefix("failed printing to stdout: ") {
            eprintln!("error: the output cannot be written: {cause}");
            crate::output::abandon(1);
        }
        usual(panic);
    }));
}

/// Runs the command line. Exit code 0 done, 1 failed, 2 usage.
pub fn run() -> std::process::ExitCode {
    let cli = Cli::parse();
    // 130 is what a shell reports for a program ended by Ctrl-C.
    let _ = ctrlc::set_handler(|| crate::output::abandon(130));
    leave_when_nobody_reads();
    if let Some(threads) = cli.threads {
        // Only the first call can set the pool, and this is it.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global();
    }
    let done = match cli.verb {
        Verb::Predict(a) => predict::run(&a, cli.json),
        Verb::Inspect(a) => inspect::run(&a, cli.json),
        Verb::Brdf(a) => brdf::run(&a, cli.json),
        Verb::Gloss(a) => gloss::run(&a, cli.json),
        Verb::Fit(a) => fit::run(&a, cli.json),
        Verb::Lobe(a) => lobe::run(&a, cli.json),
        Verb::Protocol(a) => protocol::run(&a, cli.json),
        Verb::Eval(a) => eval::run(&a, cli.json),
        Verb::Sample(a) => sample::run(&a, cli.json),
        Verb::Check(a) => check::run(&a, cli.json),
        Verb::Scan(a) => scan::run(&a, cli.json),
        Verb::Instrument(a) => instrument::run(&a, cli.json),
        Verb::Correspondence(a) => correspondence::run(&a, cli.json),
        Verb::Tiles(a) => tiles::run(&a, cli.json),
        Verb::Render(a) => render::run(&a, cli.json),
        Verb::Convert(a) => convert::run(&a, cli.json),
        Verb::Bench(a) => bench::run(&a, cli.json),
        Verb::Synth(a) => synth::run(&a, cli.json),
        Verb::Models(a) => models::run(&a, cli.json),
    };
    match done {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("error: {e:#}");
            // A parameter that names no file is a flag out of its range.
            match e.downcast_ref() {
                Some(Error::Parameter { .. }) => std::process::ExitCode::from(2),
                _ => std::process::ExitCode::FAILURE,
            }
        }
    }
}

/// Prints one JSON object.
fn print_json(value: &serde_json::Value) -> anyhow::Result<()> {
    println!("{}", serde_json::to_string_pretty(value)?);
    Ok(())
}
