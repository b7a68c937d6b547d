//! Standard error of a ratio from the scatter over places of the surface.

/// Sums of `d_s^2`, `d_s I_s` and `I_s^2` over places s with all `I_s` that came in and `d_s = E_s - first I_s`, the energy of a
/// detector against its share at the first place. The shift keeps the digits when all are alike.
pub(super) struct Ratio {
    first: Vec<f64>,
    squares: Vec<f64>,
    cross: Vec<f64>,
    incident: f64,
    incident2: f64,
    places: f64,
}

impl Ratio {
    /// For so many detectors; one more counts all that escaped.
    pub fn new(detectors: usize) -> Self {
        let zero = vec![0.0; detectors + 1];
        Ratio { first: zero.clone(), squares: zero.clone(), cross: zero, incident: 0.0, incident2: 0.0, places: 0.0 }
    }

    /// Energies per detector, and in `all`, of one place where `incident` came in.
    pub fn add(&mut self, energy: &[f64], all: f64, incident: f64) {
        if incident <= 0.0 {
            return;
        }
        self.places += 1.0;
        self.incident += incident;
        self.incident2 += incident * incident;
        for (k, &e) in energy.iter().chain([&all]).enumerate() {
            if self.places == 1.0 {
                self.first[k] = e / incident;
            } else {
                let d = e - self.first[k] * incident;
                self.squares[k] += d * d;
                self.cross[k] += d * incident;
            }
        }
    }

    /// Standard error of the ratio `R = sum E / sum I` of n places: `sqrt(n / (n - 1) sum (E_s - R I_s)^2) / sum I`
    /// (Cochran, Sampling Techniques, 1977, eq. 6.9); `None` if there are not two of them.
    pub fn standard_error(&self, k: usize, ratio: f64) -> Option<f64> {
        if self.places < 2.0 {
            return None;
        }
        let shift = ratio - self.first[k];
        let squares = self.squares[k] - 2.0 * shift * self.cross[k] + shift * shift * self.incident2;
        Some((self.places / (self.places - 1.0) * squares.max(0.0)).sqrt() / self.incident)
    }
}
