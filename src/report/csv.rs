//! `gloss.csv`: one row per map.

use super::Prediction;
use std::fmt::Write;

/// Columns with their units; `rayleigh_g_*` below 9 means that rays do not hold there.
const HEADER: &str = "map,Sq_nm,Sdq,missing_fraction,\
gloss_20_GU,gloss_20_se_GU,gloss_60_GU,gloss_60_se_GU,gloss_85_GU,gloss_85_se_GU,\
rayleigh_g_20,rayleigh_g_60,rayleigh_g_85,ray_valid_20,ray_valid_60,ray_valid_85";

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
        text.push('\n');
    }
    text
}

/// A field with commas or quotes is quoted (RFC 4180).
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n']) { format!("\"{}\"", field.replace('"', "\"\"")) } else { field.to_owned() }
}
