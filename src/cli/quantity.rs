//! Numbers with units, and what is made of them, as the command line writes them.

use crate::heightmap::crop::Region;
use crate::heightmap::despike::Despike;
use crate::heightmap::form::Form;

pub use crate::math::quantity::{angle, length, length_unit};

/// `0.5um` or `0.5um,0.7um` to the sampling distance along x and y \[m\].
pub fn pitch(text: &str) -> Result<[f64; 2], String> {
    let parts: Vec<f64> = text.split(',').map(length).collect::<Result<_, _>>()?;
    let pair = match parts[..] {
        [both] => [both, both],
        [x, y] => [x, y],
        _ => return Err("write one pitch, or two as X,Y".to_owned()),
    };
    if pair.iter().all(|p| *p > 0.0) { Ok(pair) } else { Err("a pitch must be above zero".to_owned()) }
}

/// `0um,2.5um` to the lowest and the highest height \[m\].
pub fn height_range(text: &str) -> Result<[f64; 2], String> {
    let parts: Vec<f64> = text.split(',').map(length).collect::<Result<_, _>>()?;
    match parts[..] {
        [low, high] if low < high => Ok([low, high]),
        _ => Err("write two heights as LOW,HIGH".to_owned()),
    }
}

/// `1024` or `1024x768` to columns and rows.
pub fn size(text: &str) -> Result<[usize; 2], String> {
    let parts: Vec<usize> = text
        .split('x')
        .map(|n| n.trim().parse().map_err(|_| format!("`{n}` is not a number of samples")))
        .collect::<Result<_, _>>()?;
    match parts[..] {
        [both] => Ok([both, both]),
        [w, h] => Ok([w, h]),
        _ => Err("write N or WIDTHxHEIGHT".to_owned()),
    }
}

/// `0.1,-0.05` to two numbers.
pub fn pair(text: &str) -> Result<[f64; 2], String> {
    let parts: Vec<f64> = text
        .split(',')
        .map(|n| n.trim().parse().map_err(|_| format!("`{n}` is not a number")))
        .collect::<Result<_, _>>()?;
    <[f64; 2]>::try_from(parts).map_err(|_| "write two numbers as X,Y".to_owned())
}

/// `0.25,0.25,0.75,0.75` or `0,0,50um,50um` to a region.
pub fn region(text: &str) -> Result<Region, String> {
    let four =
        |parts: Vec<f64>| <[f64; 4]>::try_from(parts).map_err(|_| "write four numbers as X0,Y0,X1,Y1".to_owned());
    let plain: Result<Vec<f64>, _> = text.split(',').map(|n| n.trim().parse::<f64>()).collect();
    match plain {
        Ok(fractions) => four(fractions).map(Region::Fraction),
        Err(_) => {
            let lengths: Result<Vec<f64>, String> = text.split(',').map(length).collect();
            let hint = |e| format!("{e}; write all four as fractions or all as lengths");
            four(lengths.map_err(hint)?).map(Region::Length)
        }
    }
}

/// `6` or `6,5` to a rule for spikes: threshold in MADs and side of the window.
pub fn despike(text: &str) -> Result<Despike, String> {
    let usual = Despike::default();
    let (threshold, window) = match text.split_once(',') {
        Some((k, n)) => (k, n.trim().parse().map_err(|_| format!("`{n}` is not a number of points"))?),
        None => (text, usual.window),
    };
    let threshold = threshold.trim().parse().map_err(|_| format!("`{threshold}` is not a number of deviations"))?;
    Ok(Despike { threshold, window })
}

/// `plane`, `poly:4`, `sphere` or `none`.
pub fn form(text: &str) -> Result<Form, String> {
    match text.trim() {
        "none" => Ok(Form::None),
        "plane" => Ok(Form::Plane),
        "sphere" => Ok(Form::Sphere),
        other => other
            .strip_prefix("poly:")
            .and_then(|n| n.parse().ok())
            .map(Form::Polynomial)
            .ok_or_else(|| "write plane, poly:N such as poly:4, sphere or none".to_owned()),
    }
}

/// A share between 0 and 1.
pub fn share(text: &str) -> Result<f64, String> {
    text.trim()
        .parse::<f64>()
        .ok()
        .filter(|v| (0.0..=1.0).contains(v))
        .ok_or_else(|| format!("`{text}` is not between 0 and 1; before a file name write it out, such as --fill=0.05"))
}

/// A percentage with its sign, from 0 % to below 100 %.
pub fn percentage(text: &str) -> Result<f64, String> {
    text.trim()
        .strip_suffix('%')
        .and_then(|number| number.trim().parse::<f64>().ok())
        .filter(|v| (0.0..100.0).contains(v))
        .map(|v| v / 100.0)
        .ok_or_else(|| format!("`{text}` is not a percentage below 100 %; write it with its sign, such as 2%"))
}

/// `1%` or `0.01`, above 0 and below 1.
pub fn tolerance(text: &str) -> Result<f64, String> {
    let number =
        text.trim().strip_suffix('%').map_or_else(|| text.trim().parse(), |t| t.parse().map(|v: f64| v / 100.0));
    match number {
        Ok(v) if v > 0.0 && v < 1.0 => Ok(v),
        _ => Err(format!("`{text}` is no tolerance; write 1% or 0.01")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_need_units() {
        assert!((length("0.5um").unwrap() - 5e-7).abs() < 1e-20);
        assert!((length("1e-3 mm").unwrap() - 1e-6).abs() < 1e-20);
        assert_eq!(length("0").unwrap(), 0.0);
        for bad in ["", "5", "um", "1e", "nan nm", "5 inch", "--1um"] {
            assert!(length(bad).is_err(), "{bad}");
        }
        assert_eq!(pitch("1um,2um").unwrap(), [1e-6, 2e-6]);
        assert!(pitch("1um,2um,3um").is_err() && pitch("0").is_err());
        assert_eq!(height_range("-1um,0").unwrap(), [-1e-6, 0.0]);
        assert!(height_range("1um").is_err() && height_range("2um,1um").is_err());
    }

    #[test]
    fn angles_sizes_pairs() {
        assert!((angle("20deg").unwrap() - 20f64.to_radians()).abs() < 1e-15);
        assert!((angle("0.5rad").unwrap() - 0.5).abs() < 1e-15);
        assert!(angle("20grad").is_err());
        assert_eq!(size("64x32").unwrap(), [64, 32]);
        assert!(size("64x").is_err());
        assert_eq!(pair("0.1,-2e-2").unwrap(), [0.1, -0.02]);
        assert!(pair("1").is_err());
    }

    #[test]
    fn regions_spikes_forms_shares() {
        assert_eq!(region("0.1,0, 0.9,1").unwrap(), Region::Fraction([0.1, 0.0, 0.9, 1.0]));
        let Region::Length(lengths) = region("0,1um,2mm,0.5m").unwrap() else { panic!("not lengths") };
        assert!(lengths.iter().zip([0.0, 1e-6, 2e-3, 0.5]).all(|(a, b)| (a - b).abs() < 1e-18));
        for bad in ["", "1,2,3", "0,0,1,1,1", "0.5,0,2um,2um", "a,b,c,d"] {
            assert!(region(bad).is_err(), "{bad}");
        }
        assert_eq!(despike("6").unwrap(), Despike::default());
        assert_eq!(despike("4.5, 5").unwrap(), Despike { threshold: 4.5, window: 5 });
        assert!(despike("").is_err() && despike("6,x").is_err() && despike("6,5,3").is_err());
        assert_eq!(form("poly:4").unwrap(), Form::Polynomial(4));
        assert_eq!([form("none"), form("plane"), form("sphere")], [Form::None, Form::Plane, Form::Sphere].map(Ok));
        assert!(form("poly").is_err() && form("poly:-1").is_err() && form("cylinder").is_err());
        assert_eq!(share("0.2").unwrap(), 0.2);
        assert!(share("20").is_err() && share("map.x3p").is_err() && share("nan").is_err());
    }

    #[test]
    fn tolerances_with_and_without_a_sign() {
        assert_eq!((tolerance("1%"), tolerance("0.05")), (Ok(0.01), Ok(0.05)));
        assert!(tolerance("100%").is_err() && tolerance("-1%").is_err() && tolerance("x").is_err());
    }
}
