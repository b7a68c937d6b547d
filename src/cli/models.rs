//! `asperity models`: the model library.

use super::print_json;
use crate::model::MODELS;

pub fn run(json: bool) -> anyhow::Result<()> {
    if json {
        let list: Vec<_> = MODELS
            .iter()
            .map(|m| {
                let parameters: Vec<_> = m
                    .parameters
                    .iter()
                    .map(|p| {
                        serde_json::json!({
                            "name": p.name, "meaning": p.meaning, "unit": p.unit.name(), "range": p.range(), "default": p.default(),
                        })
                    })
                    .collect();
                serde_json::json!({
                    "name": m.name, "summary": m.summary, "formula": m.formula, "parameters": parameters,
                    "material": m.interface, "reciprocal": m.reciprocal, "energy": m.energy, "source": m.source,
                    "example": m.example,
                })
            })
            .collect();
        return print_json(&serde_json::json!({ "models": list }));
    }
    for m in MODELS {
        println!("{}\n    {}\n    {}\n    for example {}", m.name, m.summary, m.formula, m.example);
        for p in m.parameters {
            let unit = if p.unit.name().is_empty() { String::new() } else { format!(" [{}]", p.unit.name()) };
            let default = p.default().map_or(String::new(), |d| format!(", default {d}"));
            println!("      {:<10} {}{unit}: {}{default}", p.name, p.meaning, p.range());
        }
        if m.interface {
            println!(
                "      {:<10} name of the interface instead of n and k: black-glass, epoxy, al, cu, ...",
                "material"
            );
        }
        println!(
            "    reciprocal: {}; energy: {}; source: {}\n",
            if m.reciprocal { "yes" } else { "no" },
            m.energy,
            m.source
        );
    }
    Ok(())
}
