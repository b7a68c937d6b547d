//! `gloss.csv`: one row per map.

use super::Prediction;
use std::fmt::Write;

/// Columns with their units. `gloss_*` is by rays or by waves as `served_*` says; `ray_gloss_*` by rays alone (empty for a stored
/// table), `wave_gloss_*` where waves served; `rayleigh_g_*` below 9 means that rays do not hold there; `holds_*` tells which
/// calculation does.
const HEADER: &str = "map,Sq_nm,Sdq,missing_fraction,\
gloss_20_GU,gloss_20_se_GU,gloss_60_GU,gloss_60_se_GU,gloss_85_GU,gloss_85_se_GU,\
rayleigh_g_20,rayleigh_g_60,rayleigh_g_85,ray_valid_20,ray_valid_60,ray_valid_85,\
served_20,served_60,served_85,holds_20,holds_60,holds_85,\
ray_gloss_20_GU,ray_gloss_60_GU,ray_gloss_85_GU,wave_gloss_20_GU,wave_gloss_60_GU,wave_gloss_85_GU";

/// The rows as text, comma separated, one line each.
pub fn gloss_csv<'a>(predictions: impl IntoIterator<Item = &'a Prediction>) -> String {
    let mut text = format!("{HEADER}\n");
    for p in predictions {
        let _ = write!(text, "{},{:.4},{:.6},{:.6}", quoted(&p.name), p.sq * 1e9, p.sdq, p.missing_fraction);
        for g in p.gloss {
            let _ = write!(text, ",{:.4},{:.4}", g.value, g.standard_error);
        }
        for g in p.rayleigh {
            let _ = write!(text, ",{g:.4}");
        }
        for valid in p.ray_valid() {
            let _ = write!(text, ",{valid}");
        }
        for wave in p.wave {
            let _ = write!(text, ",{}", if wave { "waves" } else { "rays" });
        }
        for holds in p.holds() {
            let _ = write!(text, ",{holds}");
        }
        let mut optional = |value: Option<f64>| {
            let _ = match value {
                Some(value) => write!(text, ",{value:.4}"),
                None => write!(text, ","),
            };
        };
        (0..3).for_each(|k| optional(p.ray_gloss.map(|g| g[k].value)));
        (0..3).for_each(|k| optional(p.wave_gloss(k).map(|g| g.value)));
        text.push('\n');
    }
    text
}

/// A field with commas or quotes is quoted (RFC 4180).
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n']) { format!("\"{}\"", field.replace('"', "\"\"")) } else { field.to_owned() }
}
