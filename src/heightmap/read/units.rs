//! Length units as instruments spell them.

/// Metres per `unit`, whatever its case and spelling; `None` for anything that is no length.
pub fn metres(unit: &str) -> Option<f64> {
    let name = unit.trim().to_lowercase();
    Some(match name.as_str() {
        "m" | "meter" | "meters" | "metre" | "metres" => 1.0,
        "cm" => 1e-2,
        "mm" | "millimeter" | "millimeters" => 1e-3,
        // U+00B5 and U+03BC; DOS code pages have the sign at E6, which Latin-1 shows as ae.
        "um" | "\u{b5}m" | "\u{3bc}m" | "\u{e6}m" | "micron" | "microns" | "micrometer" | "micrometers" => 1e-6,
        "nm" | "nanometer" | "nanometers" => 1e-9,
        "\u{e5}" | "\u{212b}" | "angstrom" | "angstroms" => 1e-10,
        "pm" | "picometer" | "picometers" => 1e-12,
        "in" | "inch" | "inches" => 0.0254,
        _ => return None,
    })
}

/// Text in UTF-8 or, failing that, Latin-1, up to the first NUL and without blanks around it.
pub fn decode_text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    let bytes = &bytes[..end];
    let text =
        std::str::from_utf8(bytes).map_or_else(|_| bytes.iter().map(|&b| char::from(b)).collect(), str::to_owned);
    text.trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_spelling_of_a_micrometre() {
        for bytes in [&b"um"[..], b"\xb5m", b"\xe6m", b"\xc2\xb5m", b"\xce\xbcm", b" UM\0garbage", b"MicroMeters"] {
            assert_eq!(metres(&decode_text(bytes)), Some(1e-6), "{bytes:?}");
        }
        assert_eq!((metres("NanoMeters"), metres("V"), metres("")), (Some(1e-9), None, None));
    }
}
