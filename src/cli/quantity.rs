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

/// `0.75,2.5` to the two full angles of a stop \[rad\].
pub fn stop(text: &str) -> Result<[f64; 2], String> {
    let parts: Vec<f64> = text.split(',').map(angle).collect::<Result<_, _>>()?;
    let open = |v: &f64| *v > 0.0 && v.to_degrees() < 90.0;
    match <[f64; 2]>::try_from(parts) {
        Ok(pair) if pair.iter().all(open) => Ok(pair),
        _ => Err("write two angles above 0 and below 90 deg as IN,ACROSS, such as 0.75,2.5".to_owned()),
    }
}

/// A length above zero.
pub fn wavelength(text: &str) -> Result<f64, String> {
    length(text).and_then(|l| if l > 0.0 { Ok(l) } else { Err("a wavelength is above zero, such as 550nm".to_owned()) })
}

/// `10000`, `10_000` or `1e4`, at least 1.
pub fn count(text: &str) -> Result<u64, String> {
    let text = text.trim().replace('_', "");
    // What a float holds exactly.
    let whole = |v: &f64| v.fract() == 0.0 && (0.0..9e15).contains(v);
    let number = text.parse().ok().or_else(|| text.parse::<f64>().ok().filter(whole).map(|v| v as u64));
    number
        .filter(|n| *n > 0)
        .ok_or_else(|| format!("`{text}` is no count; write a number from 1 up, such as 10000 or 1e4"))
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

/// `5%` or `0.05` to 0.05, anything from 0 to 1.
pub fn share(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let (number, of) = text.strip_suffix('%').map_or((text, 1.0), |number| (number.trim(), 100.0));
    let value = number.parse::<f64>().map_err(|_| format!("`{text}` is no share; write 5% or 0.05"))? / of;
    if of == 1.0 && value > 1.0 {
        return Err(format!("`{text}` is above 1; write {text}% or {}", value / 100.0));
    }
    if (0.0..=1.0).contains(&value) { Ok(value) } else { Err(format!("`{text}` is not between 0% and 100%")) }
}

/// A share below 1; 0 asks for nothing.
pub fn error_share(text: &str) -> Result<f64, String> {
    share(text).and_then(|v| if v < 1.0 { Ok(v) } else { Err(format!("`{text}` is all of it; write 2% or 0.02")) })
}

/// A share above 0 and below 1.
pub fn tolerance(text: &str) -> Result<f64, String> {
    share(text).and_then(|v| {
        if v > 0.0 && v < 1.0 { Ok(v) } else { Err(format!("`{text}` is no tolerance; write 1% or 0.01")) }
    })
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
        assert_eq!(stop("0.75,2.5deg").unwrap(), [0.75f64, 2.5].map(f64::to_radians));
        assert!(["1", "1,2,3", "0,1", "1,90", "-1,1"].iter().all(|bad| stop(bad).is_err()));
        assert_eq!(size("64x32").unwrap(), [64, 32]);
        assert!(size("64x").is_err());
        assert_eq!(pair("0.1,-2e-2").unwrap(), [0.1, -0.02]);
        assert!(pair("1").is_err());
    }

    #[test]
    fn counts_and_wavelengths() {
        assert!(["10000", "10_000", "1e4", "1.0e4"].iter().all(|text| count(text) == Ok(10_000)));
        assert_eq!(count("18446744073709551615"), Ok(u64::MAX));
        assert!(["0", "-1", "1.5", "1e30", "nan", "", "many"].iter().all(|bad| count(bad).is_err()));
        assert!(wavelength("550nm").is_ok() && wavelength("0").is_err() && wavelength("-1nm").is_err());
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
        assert!(share("map.x3p").is_err() && share("nan").is_err());
    }

    #[test]
    fn every_share_with_and_without_a_sign() {
        for parse in [share, error_share, tolerance] {
            assert_eq!((parse("1%"), parse(" 5 % "), parse("0.05")), (Ok(0.01), Ok(0.05), Ok(0.05)));
            assert_eq!(parse("20").unwrap_err(), "`20` is above 1; write 20% or 0.2");
            for bad in ["", "%", "-1%", "-0.1", "101%", "inf", "inf%", "nan%", "x", "5%%", "5 percent"] {
                assert!(parse(bad).is_err(), "{bad}");
            }
        }
        assert_eq!((share("0"), share("1"), share("100%")), (Ok(0.0), Ok(1.0), Ok(1.0)));
        assert_eq!(error_share("0%"), Ok(0.0));
        assert!(error_share("100%").is_err() && tolerance("1").is_err() && tolerance("0%").is_err());
    }
}
