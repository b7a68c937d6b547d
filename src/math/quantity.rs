//! Numbers with units in text: `0.5um`, `20deg`.

/// Metres per unit.
const LENGTHS: [(&str, f64); 7] =
    [("nm", 1e-9), ("um", 1e-6), ("\u{b5}m", 1e-6), ("\u{3bc}m", 1e-6), ("mm", 1e-3), ("pm", 1e-12), ("m", 1.0)];

/// `0.5um` to metres; 0 needs no unit.
pub fn length(text: &str) -> Result<f64, String> {
    let text = text.trim();
    if text.parse::<f64>() == Ok(0.0) {
        return Ok(0.0);
    }
    let (number, unit) = split(text);
    let unit = LENGTHS.iter().find(|l| l.0 == unit).ok_or("write a number with nm, um, mm or m, such as 0.5um")?;
    number
        .parse::<f64>()
        .ok()
        .filter(|v| v.is_finite())
        .map(|v| v * unit.1)
        .ok_or_else(|| format!("`{number}` is not a number"))
}

/// `um` to 1e-6 \[m\].
pub fn length_unit(text: &str) -> Result<f64, String> {
    LENGTHS.iter().find(|l| l.0 == text.trim()).map(|l| l.1).ok_or_else(|| "write m, mm, um, nm or pm".to_owned())
}

/// `20`, `20deg` or `0.35rad` to radians.
pub fn angle(text: &str) -> Result<f64, String> {
    let (number, unit) = split(text.trim());
    let value =
        number.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| format!("`{text}` is not an angle"))?;
    match unit {
        "" | "deg" | "\u{b0}" => Ok(value.to_radians()),
        "rad" => Ok(value),
        other => Err(format!("unit `{other}`: write deg or rad")),
    }
}

/// Cuts after the number; an exponent belongs to it.
fn split(text: &str) -> (&str, &str) {
    let bytes = text.as_bytes();
    let mut end = 0;
    while end < bytes.len() {
        let b = bytes[end];
        let exponent = matches!(b, b'e' | b'E') && matches!(bytes.get(end + 1), Some(b'0'..=b'9' | b'-' | b'+'));
        if b.is_ascii_digit() || matches!(b, b'.' | b'-' | b'+') || exponent {
            end += 1;
        } else {
            break;
        }
    }
    (text[..end].trim(), text[end..].trim())
}
