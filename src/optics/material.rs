//! What a facet is made of: its Fresnel reflectance by name, index or measured metal.

use super::fresnel;
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// n, k of seven metals, 380-780 nm in 5 nm steps. Al: Rakic 1995 and McPeak 2015; Cu, Ag, Au: Johnson and
/// Christy 1972; Fe, Cr, Ni: Johnson and Christy 1974. From the refractiveindex.info database (CC0).
const METALS: &str = include_str!("metal_nk_5nm.csv");

/// Index of the black glass that defines 100 gloss units (ISO 2813, ASTM D523).
pub const STANDARD_GLASS_INDEX: f64 = 1.567;

/// The interface that reflects, seen from air.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Material {
    /// R = 1 at every angle.
    Mirror,
    /// Clear material of index `n`.
    Dielectric { n: f64 },
    /// Absorbing material of index `n + i k`.
    Conductor { n: f64, k: f64 },
}

impl Material {
    /// Fresnel reflectance at the facet, `cos_beta = n . wi`.
    #[inline]
    pub fn reflectance(&self, cos_beta: f64) -> f64 {
        match *self {
            Material::Mirror => 1.0,
            Material::Dielectric { n } => fresnel::dielectric(cos_beta, n),
            Material::Conductor { n, k } => fresnel::conductor(cos_beta, n, k),
        }
    }

    /// The same from `cos^2_beta` in `[0, 1]`: a root less.
    #[inline(always)]
    pub fn reflectance_of_square(&self, cos2_beta: f64) -> f64 {
        match *self {
            Material::Mirror => 1.0,
            Material::Dielectric { n } => fresnel::dielectric_of_square(cos2_beta, n),
            Material::Conductor { n, k } => fresnel::conductor_of_square(cos2_beta, n, k),
        }
    }

    /// Reads `mirror`, `n=1.5`, `n=1.0+6.6k`, or a name: `black-glass`, the clear materials `epoxy bk7 noa61 pmma
    /// polycarbonate` and the metals `al al-mcpeak cu au ag fe cr ni`, the latter two kinds at `wavelength` \[m\].
    ///
    /// # Errors
    /// `Error::Parameter` saying which part cannot be read, or that the wavelength lies outside 380-780 nm for a metal.
    pub fn parse(text: &str, wavelength: f64) -> Result<Self> {
        let bad = |what: String| {
            Error::parameter(
                what,
                "write mirror, n=1.5, n=1.0+6.6k, black-glass, a clear material: epoxy bk7 noa61 pmma polycarbonate, or a \
                 metal: al al-mcpeak cu au ag fe cr ni",
            )
        };
        let number = |s: &str| s.trim().parse::<f64>().ok().filter(|v| v.is_finite());
        let name = text.trim().to_ascii_lowercase();
        if let Some(index) = name.strip_prefix("n=") {
            let (n, k) = match index.strip_suffix('k') {
                Some(both) => {
                    let cut = both.rfind('+').ok_or_else(|| bad(format!("material `{text}`: no + before k")))?;
                    (number(&both[..cut]), number(&both[cut + 1..]))
                }
                None => (number(index), Some(0.0)),
            };
            return match (n, k) {
                (Some(n), Some(0.0)) if n >= 1.0 => Ok(Material::Dielectric { n }),
                (Some(n), Some(k)) if n > 0.0 && k > 0.0 => Ok(Material::Conductor { n, k }),
                _ => Err(bad(format!("material `{text}` is not an index (a clear material needs n >= 1)"))),
            };
        }
        match name.as_str() {
            "mirror" => Ok(Material::Mirror),
            "black-glass" => Ok(Material::Dielectric { n: STANDARD_GLASS_INDEX }),
            clear if CLEAR.contains(&clear) => clear_index(clear, wavelength).map(|n| Material::Dielectric { n }),
            metal => metal_index(metal, wavelength)?
                .map(|(n, k)| Material::Conductor { n, k })
                .ok_or_else(|| bad(format!("material `{text}` is unknown"))),
        }
    }
}

impl std::fmt::Display for Material {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Material::Mirror => write!(f, "mirror"),
            Material::Dielectric { n } => write!(f, "n={n}"),
            Material::Conductor { n, k } => write!(f, "n={n}+{k}k"),
        }
    }
}

/// Clear materials with a dispersion formula.
const CLEAR: [&str; 5] = ["epoxy", "bk7", "noa61", "pmma", "polycarbonate"];

/// Index of a clear material at `wavelength` \[m\], makers' formulas in um.
///
/// SU-8 3000 epoxy resist and NOA61 adhesive: Cauchy coefficients of their makers; N-BK7: Schott 2017; PMMA, polycarbonate:
/// Sultanova, Kasarova, Nikolov 2009. All as in the refractiveindex.info database (CC0).
fn clear_index(name: &str, wavelength: f64) -> Result<f64> {
    let nm = wavelength * 1e9;
    if !(300.0..=1600.0).contains(&nm) {
        return Err(Error::parameter(
            format!("no index of `{name}` at {nm} nm"),
            "the dispersion formulas of clear materials hold from 300 nm to 1600 nm; give the index as n=1.5",
        ));
    }
    let l2 = (wavelength * 1e6).powi(2);
    let one_term = |b: f64, c: f64| (1.0 + b * l2 / (l2 - c)).sqrt();
    Ok(match name {
        "bk7" => {
            let terms = [(1.03961212, 0.00600069867), (0.231792344, 0.0200179144), (1.01046945, 103.560653)];
            (1.0 + terms.iter().map(|(b, c)| b * l2 / (l2 - c)).sum::<f64>()).sqrt()
        }
        "noa61" => 1.5375 + 0.00829045 / l2 - 0.000211046 / (l2 * l2),
        "pmma" => one_term(1.1819, 0.011313),
        "polycarbonate" => one_term(1.4182, 0.021304),
        _ => 1.5525 + 0.00629 / l2 + 0.0004 / (l2 * l2),
    })
}

/// Linear interpolation of the metal table at `wavelength` \[m\]; `None` if the metal is not in it.
fn metal_index(name: &str, wavelength: f64) -> Result<Option<(f64, f64)>> {
    let column = match name {
        "al" => 1,
        "al-mcpeak" => 3,
        "cu" => 5,
        "au" => 7,
        "ag" => 9,
        "fe" => 11,
        "cr" => 13,
        "ni" => 15,
        _ => return Ok(None),
    };
    let nm = wavelength * 1e9;
    let mut rows = METALS.lines().skip(1).map(|line| {
        let field = |k: usize| line.split(',').nth(k).and_then(|v| v.parse::<f64>().ok());
        [field(0), field(column), field(column + 1)].map(|v| v.expect("the embedded table is complete"))
    });
    let mut low = rows.next().expect("the embedded table is not empty");
    if nm >= low[0] {
        for high in rows {
            if nm <= high[0] {
                let t = (nm - low[0]) / (high[0] - low[0]);
                return Ok(Some((low[1] + t * (high[1] - low[1]), low[2] + t * (high[2] - low[2]))));
            }
            low = high;
        }
    }
    Err(Error::parameter(
        format!("no index of `{name}` at {nm} nm"),
        "the metal table covers 380 nm to 780 nm; give the index as n=1.0+6.6k",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_indices() {
        let l = 550e-9;
        assert_eq!(Material::parse("mirror", l).unwrap(), Material::Mirror);
        assert_eq!(Material::parse("n=1.5", l).unwrap(), Material::Dielectric { n: 1.5 });
        assert_eq!(Material::parse("n=1.0+6.6k", l).unwrap(), Material::Conductor { n: 1.0, k: 6.6 });
        // physics table: R(0) of copper at 550 nm is .624, of gold .792, of silver .983.
        for (name, r) in [("cu", 0.624), ("au", 0.792), ("ag", 0.983), ("cr", 0.555)] {
            let got = Material::parse(name, l).unwrap().reflectance(1.0);
            assert!((got - r).abs() < 6e-4, "{name} {got}");
        }
        // SU-8 at 550 nm: 1.5777.
        match Material::parse("epoxy", l).unwrap() {
            Material::Dielectric { n } => assert!((n - 1.5777).abs() < 1e-4),
            other => panic!("{other:?}"),
        }
        // TV50, and the lines of the Schott catalogue to its five digits.
        for (nm, n) in
            [(587.5618, 1.5168), (486.13, 1.522376), (546.07, 1.518721), (632.8, 1.515089), (656.27, 1.514322)]
        {
            match Material::parse("bk7", nm * 1e-9).unwrap() {
                Material::Dielectric { n: got } => assert!((got - n).abs() < 2e-6, "{nm}: {got}"),
                other => panic!("{other:?}"),
            }
        }
        for (name, n) in [("pmma", 1.4906), ("polycarbonate", 1.5848), ("noa61", 1.5596)] {
            match Material::parse(name, 587.6e-9).unwrap() {
                Material::Dielectric { n: got } => assert!((got - n).abs() < 2e-3, "{name}: {got}"),
                other => panic!("{other:?}"),
            }
        }
        assert!(Material::parse("bk7", 5e-6).unwrap_err().to_string().contains("1600 nm"));
        for text in ["", "n=", "n=0.5", "n=1+k", "n=nan", "glue", "n=1.0+-2k"] {
            assert!(Material::parse(text, l).is_err(), "{text}");
        }
        assert!(Material::parse("cu", 1e-6).unwrap_err().to_string().contains("380"));
    }
}
