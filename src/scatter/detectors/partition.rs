//! A partition by name.

use super::{Detectors, Rings, ShirleyChiu};
use crate::error::{Error, Result};
use crate::facets::SlopeStatistics;
use crate::math::quantity;
use crate::scatter::cells::{HalfVectorCells, TOLERANCE};
use serde::{Deserialize, Serialize};

/// Which detectors to count into.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, Default)]
#[serde(rename_all = "snake_case")]
pub enum Partition {
    /// Cells in the plane of the half vector that follow the lobe of the map.
    #[default]
    HalfVector,
    /// The 145 patches of Klems.
    Klems,
    /// Steps of theta and phi \[rad\].
    EqualAngle { theta: f64, phi: f64 },
    /// So many detectors of equal projected solid angle.
    EqualArea { count: usize },
    /// `4^k` cells of Shirley and Chiu.
    ShirleyChiu { k: u32 },
}

impl Partition {
    /// Reads `half-vector`, `klems`, `theta-phi:DT,DP` in degrees, `equal-area:N` or `shirley-chiu:K`.
    ///
    /// # Errors
    /// `Error::Parameter` saying which part cannot be read or is out of range.
    pub fn parse(text: &str) -> Result<Self> {
        let bad = || {
            Error::parameter(
                format!("detectors `{text}` are unknown"),
                "write half-vector, klems, theta-phi:DT,DP in degrees, equal-area:N or shirley-chiu:K",
            )
        };
        let (name, numbers) = text.trim().split_once(':').unwrap_or((text.trim(), ""));
        let parsed = match (name, numbers) {
            ("half-vector", "") => Partition::HalfVector,
            ("klems", "") => Partition::Klems,
            ("theta-phi", steps) => {
                let (theta, phi) = steps.split_once(',').ok_or_else(bad)?;
                let angle = |s: &str| quantity::angle(s).map_err(|_| bad());
                Partition::EqualAngle { theta: angle(theta)?, phi: angle(phi)? }
            }
            ("equal-area", n) => Partition::EqualArea { count: n.trim().parse().map_err(|_| bad())? },
            ("shirley-chiu", k) => Partition::ShirleyChiu { k: k.trim().parse().map_err(|_| bad())? },
            _ => return Err(bad()),
        };
        parsed.fixed()?;
        Ok(parsed)
    }

    /// The detectors for a map of these slopes. `isotropic`: half-vector cells are round and centred on the mean normal.
    ///
    /// # Errors
    /// `Error::Parameter` if a step or count is out of range.
    pub fn detectors(&self, statistics: &SlopeStatistics, isotropic: bool) -> Result<Box<dyn Detectors>> {
        Ok(self.fixed()?.unwrap_or_else(|| Box::new(HalfVectorCells::for_lobe(statistics, isotropic, TOLERANCE))))
    }

    /// The detectors if they do not depend on the map.
    fn fixed(&self) -> Result<Option<Box<dyn Detectors>>> {
        Ok(Some(match *self {
            Partition::HalfVector => return Ok(None),
            Partition::Klems => Box::new(Rings::klems()),
            Partition::EqualAngle { theta, phi } => Box::new(Rings::equal_angle(theta, phi)?),
            Partition::EqualArea { count } => Box::new(Rings::equal_area(count)?),
            Partition::ShirleyChiu { k } => Box::new(ShirleyChiu::new(k)?),
        }))
    }
}
