//! Normal equations of linear least squares.

/// Smallest share of a scaled column that must not be explained by the columns before it.
const INDEPENDENT: f64 = 1e-10;

/// Sums `A^T A` and `A^T b` over the rows `a` of a linear least-squares problem `A x = b`.
#[derive(Debug, Clone)]
pub struct NormalEquations {
    unknowns: usize,
    /// Lower triangle in use, row-major.
    matrix: Vec<f64>,
    right: Vec<f64>,
}

impl NormalEquations {
    /// No rows yet.
    pub fn new(unknowns: usize) -> Self {
        NormalEquations { unknowns, matrix: vec![0.0; unknowns * unknowns], right: vec![0.0; unknowns] }
    }

    /// Adds one equation `a . x = b`.
    #[inline]
    pub fn add(&mut self, a: &[f64], b: f64) {
        for i in 0..self.unknowns {
            self.right[i] += a[i] * b;
            for j in 0..=i {
                self.matrix[i * self.unknowns + j] += a[i] * a[j];
            }
        }
    }

    /// Adds `value` to the entry `(i, j)` of the matrix, `j <= i`.
    #[inline]
    pub fn add_entry(&mut self, i: usize, j: usize, value: f64) {
        self.matrix[i * self.unknowns + j] += value;
    }

    /// Adds `value` to the entry `i` of the right-hand side.
    #[inline]
    pub fn add_right(&mut self, i: usize, value: f64) {
        self.right[i] += value;
    }

    /// Adds the equations of another part of the problem.
    pub fn merge(&mut self, other: &NormalEquations) {
        self.matrix.iter_mut().zip(&other.matrix).for_each(|(a, b)| *a += b);
        self.right.iter_mut().zip(&other.right).for_each(|(a, b)| *a += b);
    }

    /// `x = (A^T A)^-1 A^T b` by Cholesky's factorisation of the matrix scaled to a unit diagonal.
    ///
    /// `None` if a column is zero or depends on the others: the data do not determine the unknowns.
    pub fn solve(&self) -> Option<Vec<f64>> {
        let n = self.unknowns;
        let scale: Vec<f64> = (0..n).map(|i| self.matrix[i * n + i].sqrt()).collect();
        if !scale.iter().all(|s| s.is_finite() && *s > 0.0) {
            return None;
        }
        let mut l = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                let dot: f64 = (0..j).map(|k| l[i * n + k] * l[j * n + k]).sum();
                let rest = self.matrix[i * n + j] / (scale[i] * scale[j]) - dot;
                if i == j {
                    if rest.is_nan() || rest <= INDEPENDENT {
                        return None;
                    }
                    l[i * n + i] = rest.sqrt();
                } else {
                    l[i * n + j] = rest / l[j * n + j];
                }
            }
        }
        let mut x = vec![0.0; n];
        for i in 0..n {
            let dot: f64 = (0..i).map(|k| l[i * n + k] * x[k]).sum();
            x[i] = (self.right[i] / scale[i] - dot) / l[i * n + i];
        }
        for i in (0..n).rev() {
            let dot: f64 = (i + 1..n).map(|k| l[k * n + i] * x[k]).sum();
            x[i] = (x[i] - dot) / l[i * n + i];
        }
        x.iter_mut().zip(&scale).for_each(|(x, s)| *x /= s);
        x.iter().all(|x| x.is_finite()).then_some(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recovers_a_cubic_of_badly_scaled_columns() {
        let truth = [3.0, -2e3, 5e-4, 7.0];
        let mut e = NormalEquations::new(4);
        let mut other = NormalEquations::new(4);
        for k in 0..50 {
            let t = f64::from(k) / 25.0 - 1.0;
            let row = [1.0, 1e-3 * t, 1e4 * t * t, t * t * t];
            let b = row.iter().zip(truth).map(|(a, x)| a * x).sum();
            if k % 2 == 0 { e.add(&row, b) } else { other.add(&row, b) }
        }
        e.merge(&other);
        for (found, truth) in e.solve().unwrap().iter().zip(truth) {
            assert!((found / truth - 1.0).abs() < 1e-11);
        }
    }

    #[test]
    fn refuses_dependent_columns() {
        let mut e = NormalEquations::new(2);
        e.add(&[1.0, 2.0], 1.0);
        e.add(&[2.0, 4.0], 1.0);
        assert!(e.solve().is_none() && NormalEquations::new(1).solve().is_none());
    }
}
