//! The doorway between what scatters and what looks at it.

use crate::math::frame::theta;
use glam::DVec3;

/// One direction drawn by [`Brdf::sample`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BrdfSample {
    /// Unit vector to the detector, above the surface.
    pub wo: DVec3,
    /// `f_r cos_theta_r / pdf`, or reflectance over branch probability for the specular core.
    pub weight: f64,
    /// Density of `wo` per steradian among all draws; infinite for the specular core.
    pub pdf: f64,
    /// Drawn from the specular core: no other strategy can produce this direction.
    pub specular: bool,
}

/// A bidirectional reflectance distribution function `f_r(wi, wo)` [1/sr], without the cosine
/// (Nicodemus et al., NBS Monograph 160, 1977).
///
/// `wi` points to the source, `wo` to the detector, both unit and above the surface (z > 0); anything
/// at or below the horizon gives 0. The specular core is a delta apart: it is in `sample`,
/// `specular_core` and `albedo`, never in `eval` or `pdf`.
pub trait Brdf: Send + Sync {
    /// `f_r(wi, wo)` [1/sr], specular core excluded.
    fn eval(&self, wi: DVec3, wo: DVec3) -> f64;

    /// Draws `wo` for `u` in `[0, 1)^2`; `None` when the draw leaves the upper hemisphere and carries nothing.
    fn sample(&self, wi: DVec3, u: [f64; 2]) -> Option<BrdfSample>;

    /// [`Brdf::sample`] of many pairs at once, which a table does several times faster.
    ///
    /// # Panics
    /// If the three lists are not of one length.
    fn sample_many(&self, wi: &[DVec3], u: &[[f64; 2]], out: &mut [Option<BrdfSample>]) {
        assert!(wi.len() == u.len() && u.len() == out.len(), "as many numbers and places as directions");
        for ((wi, u), out) in wi.iter().zip(u).zip(out) {
            *out = self.sample(*wi, *u);
        }
    }

    /// Density per steradian with which [`Brdf::sample`] draws `wo`, specular core excluded.
    fn pdf(&self, wi: DVec3, wo: DVec3) -> f64;

    /// [`Brdf::eval`] and [`Brdf::pdf`] of one pair: what both need is worked out once.
    fn eval_and_pdf(&self, wi: DVec3, wo: DVec3) -> (f64, f64) {
        (self.eval(wi, wo), self.pdf(wi, wo))
    }

    /// [`Brdf::eval_and_pdf`] of many pairs at once, which a table does in lanes.
    ///
    /// # Panics
    /// If the three lists are not of one length.
    fn eval_and_pdf_many(&self, wi: &[DVec3], wo: &[DVec3], out: &mut [(f64, f64)]) {
        assert!(wi.len() == wo.len() && wo.len() == out.len(), "as many places and directions out as directions in");
        for ((wi, wo), out) in wi.iter().zip(wo).zip(out) {
            *out = self.eval_and_pdf(*wi, *wo);
        }
    }

    /// Directional-hemispherical reflectance at `theta_i` \[rad\], specular core included.
    fn albedo(&self, theta_i: f64) -> f64;

    /// The same for `wi`: of a surface with a grain [`Brdf::albedo`] is the mean over azimuths.
    fn albedo_towards(&self, wi: DVec3) -> f64 {
        self.albedo(theta(wi))
    }

    /// Reflectance of the specular core (mirror part) for `wi`; 0 if there is none.
    fn specular_core(&self, _wi: DVec3) -> f64 {
        0.0
    }

    /// Albedo of an ideal diffuser, for those that need not ask it direction by direction: `f_r = rho / pi`, draws by the
    /// cosine. `None` for everything else.
    fn diffuser(&self) -> Option<f64> {
        None
    }
}
