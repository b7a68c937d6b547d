//! `report.html`: everything a run of `predict` found, on one page that needs no other file and no network.

use super::{Prediction, Settings};
use crate::chart::lobe::{Lobe, RadiusScale, lobe_page};
use crate::meter::Holds;
use std::fmt::Write;

/// One map of the page.
pub struct Section<'a> {
    pub prediction: &'a Prediction,
    /// Points across and down, and their distances \[m\].
    pub size: [usize; 2],
    pub pitch: [f64; 2],
    /// What was done to the heights, in a line, and what the preparation had to say.
    pub preparation: String,
    pub doubts: Vec<String>,
    /// Name of the file that holds the table.
    pub table: String,
    /// Picture of the heights (.png).
    pub heights: Vec<u8>,
}

/// The page.
pub struct Page<'a> {
    pub sections: Vec<Section<'a>>,
    pub settings: &'a Settings,
    /// SVG text of gloss against roughness.
    pub chart: &'a str,
    /// Comparison picture (.png).
    pub tiles: &'a [u8],
    /// Maps that could not be used, and why.
    pub failed: Vec<(String, String)>,
}

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;color:#1e1e1e;max-width:1100px;margin:2em auto;padding:0 1em}\
h1{font-size:1.6em;margin-bottom:.2em}h2{font-size:1.25em;margin-top:2.4em;border-top:1px solid #ddd;padding-top:1em}\
h3{font-size:1.05em;margin-bottom:.3em}table{border-collapse:collapse;margin:.6em 0}\
td,th{padding:.25em .9em .25em 0;text-align:left;vertical-align:top;border-bottom:1px solid #eee}\
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}.w{background:#fff6e0;border-left:4px solid #d55e00;\
padding:.4em .8em;margin:.5em 0}.s{color:#5f5f5f}img,svg{max-width:100%;height:auto}figure{margin:1em 0}\
nav a{margin-right:1em}";

/// The page as HTML text. The same predictions give the same bytes.
pub fn page(p: &Page) -> String {
    let mut html = String::from("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">");
    let name = match p.sections.as_slice() {
        [one] => one.prediction.name.clone(),
        many => format!("{} surfaces", many.len()),
    };
    let _ = write!(
        html,
        "<meta name=\"viewport\" content=\"width=device-width\"><title>asperity: {0}</title><style>{STYLE}</style></head>\n\
         <body><h1>Predicted gloss of {0}</h1><p class=\"s\">asperity {1}: height map to facets, scattered light, BRDF table, \
         glossmeter and picture.</p>\n",
        escaped(&name),
        env!("CARGO_PKG_VERSION")
    );
    summary(&mut html, p);
    let _ = writeln!(html, "<figure>{}</figure>", inline_svg(p.chart));
    let _ = writeln!(html, "<figure><img alt=\"comparison tiles\" src=\"{}\"></figure>", png_uri(p.tiles));
    parameters(&mut html, p.settings);
    for (k, section) in p.sections.iter().enumerate() {
        surface(&mut html, k, section);
    }
    if !p.failed.is_empty() {
        html.push_str("<h2>Maps that could not be used</h2>\n");
        for (_, error) in &p.failed {
            let _ = writeln!(html, "<p class=\"w\">{}</p>", escaped(error));
        }
    }
    html.push_str("</body></html>\n");
    html
}

/// One line per map with its gloss.
fn summary(html: &mut String, p: &Page) {
    html.push_str(
        "<table><tr><th>map</th><th class=\"n\">Sq / nm</th><th class=\"n\">Sdq</th><th class=\"n\">gloss 20\u{b0} / GU</th>\
         <th class=\"n\">60\u{b0}</th><th class=\"n\">85\u{b0}</th></tr>\n",
    );
    for (k, section) in p.sections.iter().enumerate() {
        let d = section.prediction;
        let _ = write!(
            html,
            "<tr><td><a href=\"#map{k}\">{}</a></td><td class=\"n\">{:.2}</td><td class=\"n\">{:.4}</td>",
            escaped(&d.name),
            d.sq * 1e9,
            d.sdq
        );
        for (g, holds) in d.gloss.iter().zip(d.holds()) {
            let _ = write!(html, "<td class=\"n\">{:.2} \u{b1} {:.2} {}</td>", g.value, g.standard_error, holds.mark());
        }
        html.push_str("</tr>\n");
    }
    html.push_str(
        "</table><p class=\"s\">Gloss units: flat black glass of index 1.567 reads 100. \u{b1} one standard error of map and \
         integration. ~ by waves, where rays do not hold; * neither calculation holds, see the warnings.</p>\n",
    );
}

/// What the run was asked for.
fn parameters(html: &mut String, settings: &Settings) {
    let s = &settings.scatter;
    let list = |angles: &[f64]| {
        angles.iter().map(|a| format!("{:.4}", a.to_degrees())).map(trimmed).collect::<Vec<_>>().join(", ")
    };
    let rows = [
        ("method", format!("{:?}", s.method).to_lowercase()),
        ("material", s.material.to_string()),
        ("wavelength", format!("{:.1} nm", settings.wavelength * 1e9)),
        ("band", format!("{:.1} nm", s.wave.band * 1e9)),
        ("incident angles", format!("{}\u{b0}", list(&s.theta_i))),
        ("source azimuths", format!("{}\u{b0}, where the surface has a direction", list(&s.phi_i))),
        ("tolerance", format!("{} % of the energy", 100.0 * s.tolerance)),
        ("bounces", s.bounces.to_string()),
        ("rays", format!("{}, where rays are traced", s.rays)),
        ("seed", s.seed.to_string()),
        ("source stop", settings.glossmeter.first().map(|g| format!("{}\u{b0}", list(&g.source))).unwrap_or_default()),
    ];
    html.push_str("<h2>Parameters</h2><table>\n");
    for (name, value) in rows {
        let _ = writeln!(html, "<tr><td>{name}</td><td>{}</td></tr>", escaped(&value));
    }
    html.push_str("</table>\n");
}

fn surface(html: &mut String, k: usize, section: &Section) {
    let d = section.prediction;
    let [width, height] = section.size;
    let _ = writeln!(html, "<h2 id=\"map{k}\">{}</h2>", escaped(&d.name));
    let _ = writeln!(
        html,
        "<p>{width} x {height} points, {:.4} x {:.4} \u{b5}m apart; {:.3} % missing; {} facets. Sq {:.3} nm, Sdq {:.5}. \
         Prepared: {}. Table: {}.</p>",
        section.pitch[0] * 1e6,
        section.pitch[1] * 1e6,
        100.0 * d.missing_fraction,
        d.facets,
        d.sq * 1e9,
        d.sdq,
        escaped(&section.preparation),
        escaped(&section.table)
    );
    for doubt in &section.doubts {
        let _ = writeln!(html, "<p class=\"w\">{}</p>", escaped(doubt));
    }
    gloss(html, d);
    for warning in &d.warnings {
        let class = if warning.is_doubt() { "w" } else { "s" };
        let _ = writeln!(html, "<p class=\"{class}\">{}</p>", escaped(&warning.to_string()));
    }
    choice(html, d);
    let lobes: Vec<Lobe> = [20.0f64, 45.0, 70.0]
        .iter()
        .map(|t| Lobe { label: format!("theta_i {t:.0}\u{b0}"), brdf: &d.brdf, theta_i: t.to_radians(), phi_i: 0.0 })
        .collect();
    let drawing = lobe_page(&lobes, "Lobes in the plane of incidence and in the round", RadiusScale::Auto, None);
    if let Ok(png) = drawing.to_raster().png_bytes() {
        let _ = writeln!(html, "<figure><img alt=\"lobes\" src=\"{}\"></figure>", png_uri(&png));
    }
    let _ = writeln!(html, "<figure><img alt=\"heights\" src=\"{}\"></figure>", png_uri(&section.heights));
}

fn gloss(html: &mut String, d: &Prediction) {
    html.push_str(
        "<h3>Gloss</h3><table><tr><th>angle</th><th class=\"n\">gloss / GU</th><th class=\"n\">\u{b1}</th><th>by</th>\
         <th class=\"n\">rays alone</th><th class=\"n\">Rayleigh g</th><th>believe</th></tr>\n",
    );
    for (k, angle) in ["20", "60", "85"].iter().enumerate() {
        let believe = match d.holds()[k] {
            Holds::Rays => "rays",
            Holds::Waves => "waves",
            Holds::Neither => "neither",
        };
        let rays = d.ray_gloss.map_or_else(String::new, |g| format!("{:.3}", g[k].value));
        let _ = writeln!(
            html,
            "<tr><td>{angle}\u{b0}</td><td class=\"n\">{:.3}</td><td class=\"n\">{:.3}</td><td>{}</td><td class=\"n\">{rays}</td>\
             <td class=\"n\">{:.3}</td><td>{believe}</td></tr>",
            d.gloss[k].value,
            d.gloss[k].standard_error,
            if d.wave[k] { "waves" } else { "rays" },
            d.rayleigh[k]
        );
    }
    html.push_str("</table>\n");
}

/// Which method served which incident angle, and why.
fn choice(html: &mut String, d: &Prediction) {
    if d.decisions.is_empty() {
        return;
    }
    html.push_str(
        "<h3>What was computed, and why</h3><table><tr><th class=\"n\">incident</th><th>reason</th>\
         <th class=\"n\">light of several bounces</th></tr>\n",
    );
    for (decision, bounces) in d.decisions.iter().zip(&d.bounce_fractions) {
        let _ = writeln!(
            html,
            "<tr><td class=\"n\">{}\u{b0}</td><td>{}</td><td class=\"n\">{:.3} %</td></tr>",
            trimmed(format!("{:.2}", decision.theta_i.to_degrees())),
            escaped(&decision.to_string()),
            100.0 * bounces[1..].iter().sum::<f64>()
        );
    }
    html.push_str("</table>\n");
}

/// Without zeros behind the decimal point.
fn trimmed(number: String) -> String {
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.').to_owned() } else { number }
}

/// Text that HTML cannot mistake for markup.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// The drawing itself, without what stands before `<svg`.
fn inline_svg(svg: &str) -> &str {
    svg.find("<svg").map_or("", |at| &svg[at..])
}

fn png_uri(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", base64(png))
}

/// RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let word = group.iter().enumerate().fold(0u32, |w, (k, b)| w | u32::from(*b) << (16 - 8 * k));
        for k in 0..4 {
            let letter = LETTERS[(word >> (18 - 6 * k)) as usize & 63];
            out.push(if k <= group.len() { char::from(letter) } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The test vectors of RFC 4648, section 10.
    #[test]
    fn base64_by_the_book() {
        for (plain, coded) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
        assert_eq!(base64(&[0xfb, 0xff]), "+/8=");
    }

    #[test]
    fn names_of_files_cannot_break_the_page() {
        assert_eq!(escaped("a<b>&\"c\"\n"), "a&lt;b&gt;&amp;&quot;c&quot; ");
        assert_eq!(trimmed("20.0500".into()), "20.05");
        assert_eq!(trimmed("100".into()), "100");
    }
}
