//! What is compared: a question with its reference, and the methods that answer it.

use std::time::Duration;

/// The numbers a run comes to, and how long it took where that is less than the whole call.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    pub values: Vec<f64>,
    /// Time of the part that counts; `None`: the whole call.
    pub time: Option<Duration>,
}

impl From<Vec<f64>> for Answer {
    fn from(values: Vec<f64>) -> Self {
        Answer { values, time: None }
    }
}

/// How far an answer is from the reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Distance {
    /// `1/2 sum |a_k - b_k| / sum b_k`: share of the energy that lies in the wrong place.
    Moved,
    /// `max |a_k - b_k|` in gloss units.
    Gloss,
    /// `sqrt(mean (a_k - b_k)^2 / mean b_k^2)`.
    Relative,
}

impl Distance {
    /// The distance.
    pub fn between(self, a: &[f64], b: &[f64]) -> f64 {
        let pairs = || a.iter().zip(b);
        match self {
            Distance::Moved => {
                let moved: f64 = pairs().map(|(a, b)| (a - b).abs()).sum();
                0.5 * moved / b.iter().sum::<f64>().max(f64::MIN_POSITIVE)
            }
            Distance::Gloss => pairs().map(|(a, b)| (a - b).abs()).fold(0.0, f64::max),
            Distance::Relative => {
                let squares: f64 = pairs().map(|(a, b)| (a - b).powi(2)).sum();
                (squares / b.iter().map(|b| b * b).sum::<f64>().max(f64::MIN_POSITIVE)).sqrt()
            }
        }
    }

    /// Unit in files: `share` or `GU`.
    pub fn unit(self) -> &'static str {
        match self {
            Distance::Moved | Distance::Relative => "share",
            Distance::Gloss => "GU",
        }
    }
}

/// What answers are judged by.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Where it comes from, for people.
    pub text: String,
    pub values: Vec<f64>,
    /// The distance that its own error alone makes; 0 for a closed form.
    pub noise: f64,
}

/// One run at an effort with a seed.
pub type Work<'a> = Box<dyn Fn(f64, u64) -> Answer + 'a>;

/// One way to answer at rising effort.
pub struct Method<'a> {
    pub name: &'static str,
    /// What effort counts: rays, facets, draws, a tolerance.
    pub effort: &'static str,
    /// Efforts in order of rising cost.
    pub ladder: Vec<f64>,
    /// The effort that the program takes by itself, if this method is its choice.
    pub default: Option<f64>,
    /// Whether the seed changes the answer.
    pub random: bool,
    /// How much of the time this method may ask for, relative to others.
    pub appetite: f64,
    pub work: Work<'a>,
}

impl<'a> Method<'a> {
    /// A method without a default effort.
    pub fn new(
        name: &'static str,
        effort: &'static str,
        ladder: impl Into<Vec<f64>>,
        work: impl Fn(f64, u64) -> Answer + 'a,
    ) -> Self {
        Method {
            name,
            effort,
            ladder: ladder.into(),
            default: None,
            random: false,
            appetite: 1.0,
            work: Box::new(work),
        }
    }

    /// Its answer depends on the seed.
    pub fn random(mut self) -> Self {
        self.random = true;
        self
    }

    /// May ask for so many times the usual share of the time.
    pub fn hungry(mut self, appetite: f64) -> Self {
        self.appetite = appetite;
        self
    }

    /// The program takes this effort by itself.
    pub fn taken_at(mut self, effort: f64) -> Self {
        self.default = Some(effort);
        self
    }
}

/// One question, its reference, and the methods.
pub struct Family<'a> {
    /// Word in files.
    pub id: String,
    pub title: String,
    /// Label of the axis of errors.
    pub error: &'static str,
    pub distance: Distance,
    pub reference: Reference,
    pub methods: Vec<Method<'a>>,
}

/// `10^first, 10^first.5, ... 10^last`.
pub fn half_decades(first: i32, last: i32) -> Vec<f64> {
    (2 * first..=2 * last).map(|k| 10f64.powf(f64::from(k) / 2.0).round()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_by_hand() {
        let (a, b) = ([0.5, 0.3, 0.2], [0.4, 0.4, 0.2]);
        assert!((Distance::Moved.between(&a, &b) - 0.1).abs() < 1e-15);
        assert!((Distance::Gloss.between(&a, &b) - 0.1).abs() < 1e-15);
        assert!((Distance::Relative.between(&a, &b) - (0.02f64 / 0.36).sqrt()).abs() < 1e-15);
        assert_eq!(half_decades(3, 4), [1000.0, 3162.0, 10000.0]);
    }
}
