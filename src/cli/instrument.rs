//! `asperity instrument`: the named light meters, and files of one's own.

use super::print_json;
use crate::error::{Error, Result};
use crate::meter::{Instrument, standards};
use clap::Args;
use serde_json::json;
use std::path::Path;

#[derive(Args)]
pub struct Arguments {
    /// Name of an instrument, or a TOML file to be checked; printed as TOML. Without it: the list
    #[arg(value_name = "NAME|FILE.toml")]
    instrument: Option<String>,
}

/// The instrument of that name, or from that file.
pub fn open(text: &str) -> Result<Instrument> {
    if let Some(named) = standards::by_name(text) {
        return Ok(named);
    }
    let path = Path::new(text);
    if path.is_file() || text.ends_with(".toml") {
        return Instrument::load(path);
    }
    let names: Vec<String> = standards::instruments().into_iter().map(|i| i.name).collect();
    Err(Error::parameter(
        format!("there is no instrument `{text}`"),
        format!("name one of {}, or a .toml file", names.join(", ")),
    ))
}

pub fn run(a: &Arguments, json: bool) -> anyhow::Result<()> {
    if let Some(text) = &a.instrument {
        let instrument = open(text)?;
        if json {
            return print_json(&as_json(&instrument));
        }
        print!("{}", instrument.to_toml());
        return Ok(());
    }
    let all = standards::instruments();
    if json {
        return print_json(&json!({ "instruments": all.iter().map(as_json).collect::<Vec<_>>() }));
    }
    for i in &all {
        println!("{}  (reads {})", i.name, i.readings().join(", "));
        for line in wrapped(&i.about, 100) {
            println!("    {line}");
        }
    }
    println!(
        "\nPrint one with `asperity instrument NAME`, change it, and read with `asperity gloss SOURCE --instrument FILE`."
    );
    Ok(())
}

fn as_json(i: &Instrument) -> serde_json::Value {
    json!({ "name": i.name, "about": i.about, "readings": i.readings(), "toml": i.to_toml() })
}

/// Lines of at most `width` letters, broken between words.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("never empty");
        if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > width {
            lines.push(word.to_owned());
        } else {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines
}
