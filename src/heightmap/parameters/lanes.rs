//! Eight f64 side by side: short loops over them are what the compiler turns into vector code.

/// Lanes: enough for any vector unit, and the order of summation is the same on all of them.
pub(super) const LANES: usize = 8;

/// One number per lane.
pub(super) type Lane = [f64; LANES];

/// `f` applied to every lane.
#[inline(always)]
pub(super) fn each(f: impl Fn(usize) -> f64) -> Lane {
    let mut lane = [0.0; LANES];
    for (k, value) in lane.iter_mut().enumerate() {
        *value = f(k);
    }
    lane
}

/// `sum += value`, lane by lane.
#[inline(always)]
pub(super) fn add(sum: &mut Lane, value: &Lane) {
    for (sum, value) in sum.iter_mut().zip(value) {
        *sum += value;
    }
}

/// Calls `visit` with every run of eight of the slices; the last run is filled up with `filling`.
///
/// All slices must be as long as the first.
#[inline(always)]
pub(super) fn runs<const S: usize>(slices: [&[f32]; S], filling: f32, mut visit: impl FnMut([&[f32; LANES]; S])) {
    let count = slices[0].len();
    let mut first = 0;
    while first + LANES <= count {
        let mut run = [&[0.0; LANES]; S];
        for (run, slice) in run.iter_mut().zip(slices) {
            // The slice is that long, so the conversion cannot fail; a fallback keeps the code free of panics.
            *run = slice[first..first + LANES].try_into().unwrap_or(&[f32::NAN; LANES]);
        }
        visit(run);
        first += LANES;
    }
    if first < count {
        let mut padded = [[filling; LANES]; S];
        for (padded, slice) in padded.iter_mut().zip(slices) {
            padded[..count - first].copy_from_slice(&slice[first..count]);
        }
        visit(padded.each_ref());
    }
}
