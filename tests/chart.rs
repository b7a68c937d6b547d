//! The chart of gloss against roughness: well-formed, complete, inside its sheet, and calm about odd input.

use asperity::chart::{GlossPoint, gloss_vs_roughness};
use asperity::math::Estimate;
use asperity::meter::Holds::{self, Neither, Rays, Waves};
use quick_xml::events::{BytesStart, Event};

/// Gloss of Gaussian surfaces by rays, n = 1.5, 550 nm, correlation length 20 um (series of Beckmann and Spizzichino).
fn surfaces() -> Vec<GlossPoint> {
    let rows = [
        (3.0, [82.0452, 89.1368, 98.9744], [Waves; 3]),
        (50.0, [79.8830, 89.1413, 98.9190], [Waves; 3]),
        (150.0, [39.2850, 82.8992, 88.8139], [Rays, Waves, Neither]),
        (201.0, [26.1761, 73.4296, 76.9896], [Rays, Waves, Waves]),
        (805.0, [2.0845, 21.8706, 22.8725], [Rays, Rays, Neither]),
    ];
    rows.map(|(nm, gloss, holds): (f64, [f64; 3], [Holds; 3])| GlossPoint {
        name: format!("epoxy <{nm} nm> & \"so on\""),
        sq: nm * 1e-9,
        gloss: gloss.map(|value| Estimate { value, standard_error: 1.5 }),
        holds,
        ray_gloss: Some(gloss.map(|g| 0.9 * g)),
    })
    .to_vec()
}

struct Shapes {
    texts: Vec<String>,
    white_filled: usize,
    /// Coordinates as shares of the sheet.
    xs: Vec<f64>,
    ys: Vec<f64>,
}

fn attribute(element: &BytesStart, key: &str) -> Option<String> {
    let found = element.attributes().filter_map(Result::ok).find(|a| a.key.as_ref() == key)?;
    Some(found.value.into_owned())
}

/// Reads the SVG as XML, which fails the test if it is not well-formed.
fn shapes(svg: &str) -> Shapes {
    let mut reader = quick_xml::Reader::from_str(svg);
    let mut found = Shapes { texts: Vec::new(), white_filled: 0, xs: Vec::new(), ys: Vec::new() };
    let mut size = (1.0, 1.0);
    let mut text = None;
    loop {
        match reader.read_event().expect("well-formed") {
            Event::Start(e) | Event::Empty(e) => {
                if let Some(view) = attribute(&e, "viewBox") {
                    let numbers: Vec<f64> = view.split(' ').map(|v| v.parse().unwrap()).collect();
                    size = (numbers[2], numbers[3]);
                }
                for (key, list, extent) in [("cx", &mut found.xs, size.0), ("cy", &mut found.ys, size.1)] {
                    list.extend(attribute(&e, key).map(|v| v.parse::<f64>().unwrap() / extent));
                }
                for pair in attribute(&e, "points").iter().flat_map(|p| p.split_whitespace()) {
                    let (x, y) = pair.split_once(',').unwrap();
                    found.xs.push(x.parse::<f64>().unwrap() / size.0);
                    found.ys.push(y.parse::<f64>().unwrap() / size.1);
                }
                let name = e.name().as_ref().to_owned();
                if name != "rect" && attribute(&e, "fill").as_deref() == Some("#FFFFFF") {
                    found.white_filled += 1;
                }
                text = (name == "text").then(String::new);
            }
            Event::Text(t) => {
                if let Some(text) = &mut text {
                    text.push_str(t.as_ref());
                }
            }
            Event::End(_) => found.texts.extend(text.take().map(|t| t.trim().to_owned())),
            Event::Eof => return found,
            _ => {}
        }
    }
}

#[test]
fn says_what_it_shows() {
    let svg = gloss_vs_roughness(&surfaces(), "Epoxy & glass");
    let found = shapes(&svg);
    for label in
        ["20\u{b0}", "60\u{b0}", "85\u{b0}", "nm", "GU", "standard error", "hollow", "rays alone", "neither", "Sq"]
    {
        assert!(found.texts.iter().any(|t| t.contains(label)), "{label} in {:?}", found.texts);
    }
    // Logarithmic axis of Sq, gloss from 0 to a round number above the highest bar.
    for tick in ["2", "5", "10", "1000", "0", "120"] {
        assert!(found.texts.iter().any(|t| t == tick), "{tick} in {:?}", found.texts);
    }
    // One hollow marker per reading that is not by rays, and twice three in the legend: by waves, and by neither.
    let hollow = surfaces().iter().flat_map(|p| p.holds).filter(|&h| h != Rays).count();
    assert_eq!(found.white_filled, hollow + 6);
    assert_eq!(svg, gloss_vs_roughness(&surfaces(), "Epoxy & glass"));
    let mut reversed = surfaces();
    reversed.reverse();
    assert_eq!(svg, gloss_vs_roughness(&reversed, "Epoxy & glass"));
}

#[test]
fn legends_only_for_what_is_there() {
    let mut exact = surfaces();
    for p in &mut exact {
        p.holds = [Rays; 3];
        p.gloss = p.gloss.map(|g| Estimate::exact(g.value));
    }
    let found = shapes(&gloss_vs_roughness(&exact, "exact"));
    assert!(!found.texts.iter().any(|t| t.contains("hollow") || t.contains("standard error")));
    assert_eq!(found.white_filled, 0);
}

#[test]
fn everything_stays_on_the_sheet() {
    let one = surfaces()[2..3].to_vec();
    let two = surfaces()[1..3].to_vec();
    let mut flat = surfaces();
    flat[0].sq = 0.0;
    let thirty: Vec<GlossPoint> = (0..30)
        .map(|k| GlossPoint { sq: 3e-9 * 1.2f64.powi(k), name: format!("{k}"), ..surfaces()[1].clone() })
        .collect();
    let same = vec![surfaces()[1].clone(); 4];
    let close: Vec<GlossPoint> =
        (0..12).map(|k| GlossPoint { sq: (200.0 + 0.01 * f64::from(k)) * 1e-9, ..surfaces()[1].clone() }).collect();
    let title = "A title that does not stop ".repeat(20);
    for points in [surfaces(), one, two, flat[..1].to_vec(), flat, thirty, same, close, Vec::new()] {
        let found = shapes(&gloss_vs_roughness(&points, &title));
        for share in found.xs.iter().chain(&found.ys) {
            assert!((0.0..=1.0).contains(share), "{} points: {share}", points.len());
        }
    }
}

#[test]
fn odd_numbers_leave_gaps_not_panics() {
    let mut points = surfaces();
    points[0].sq = f64::NAN;
    points[1].gloss[0].value = f64::NAN;
    points[2].gloss[1].standard_error = f64::INFINITY;
    points[3].sq = -1.0;
    points[4].gloss[2].value = -3.0;
    points[4].name = "bell\u{7}\nline".to_owned();
    let found = shapes(&gloss_vs_roughness(&points, "control \u{1} characters"));
    assert!(found.xs.iter().chain(&found.ys).all(|v| v.is_finite()));
    let nothing = vec![GlossPoint { gloss: [Estimate::exact(f64::NAN); 3], ..surfaces()[0].clone() }];
    assert!(shapes(&gloss_vs_roughness(&nothing, "")).texts.iter().any(|t| t == "no surface to show"));
    for sq in [1e-300, 1e300, f64::MIN_POSITIVE] {
        let huge = [GlossPoint { sq, ..surfaces()[0].clone() }, surfaces()[1].clone()];
        shapes(&gloss_vs_roughness(&huge, "extremes"));
    }
}
