//! The Kalman filter, for states of any small number of elements that are measured one at a time.
//!
//! ```text
//! P+ = F P F' + q b b'                           prediction, noise q along b
//! S = P[m][m] + r,  K = P[.][m] / S              measurement of element m with variance r
//! x+ = x + K (z - x[m]),  P+ = P - K P[m][.]
//! ```
//!
//! The caller moves the state itself, since only it has the known inputs. Source: Bar-Shalom, Li
//! and Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), table 5.2.4-1.
//!
//! ```
//! use kalman::Gaussian;
//! // A position and a speed; the position is measured a second later.
//! let mut state = Gaussian::independent([0.0, 1.0], [1.0, 1.0]);
//! state.mean[0] += state.mean[1];
//! state.spread(&[[1.0, 1.0], [0.0, 1.0]], &[0.0, 1.0], 0.1);
//! let innovation = state.innovation(0, 1.5, 0.5);
//! assert!(innovation.passes(3.0));
//! state.correct(0, &innovation);
//! assert!(state.mean[1] > 1.0);
//! ```

use std::array::from_fn;

/// A state and what is not known of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian<const N: usize> {
    /// Expected state.
    pub mean: [f64; N],
    /// Covariance; symmetric.
    pub covariance: [[f64; N]; N],
}

/// A measurement beside its prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation {
    /// Measured minus predicted value.
    pub residual: f64,
    pub variance: f64,
}

impl Innovation {
    /// It is within `gate` standard deviations. False for a measurement that is not a number.
    pub fn passes(&self, gate: f64) -> bool {
        self.residual * self.residual <= gate * gate * self.variance
    }
}

impl<const N: usize> Gaussian<N> {
    /// A state whose elements are known independently, with the given variances.
    pub fn independent(mean: [f64; N], variances: [f64; N]) -> Self {
        let covariance = from_fn(|i| from_fn(|j| if i == j { variances[i] } else { 0.0 }));
        Self { mean, covariance }
    }

    /// Moves the covariance on by the transition `f`, with noise of variance `q` along `b`.
    pub fn spread(&mut self, f: &[[f64; N]; N], b: &[f64; N], q: f64) {
        let p = self.covariance;
        // Entries of `f` that are 0 cost nothing where the caller's `f` is known.
        let moved: [[f64; N]; N] = from_fn(|i| {
            from_fn(|j| (0..N).filter(|k| f[i][*k] != 0.0).map(|k| f[i][k] * p[k][j]).sum())
        });
        for i in 0..N {
            for j in i..N {
                let along = (0..N).filter(|k| f[j][*k] != 0.0).map(|k| moved[i][k] * f[j][k]);
                let sum = q * b[i] * b[j] + along.sum::<f64>();
                (self.covariance[i][j], self.covariance[j][i]) = (sum, sum);
            }
        }
    }

    /// A measurement of element `m` with a variance, beside its prediction.
    pub fn innovation(&self, m: usize, measured: f64, variance: f64) -> Innovation {
        Innovation { residual: measured - self.mean[m], variance: self.covariance[m][m] + variance }
    }

    /// Takes in the measurement of element `m` that led to `innovation`.
    pub fn correct(&mut self, m: usize, innovation: &Innovation) {
        let p = self.covariance;
        let gain: [f64; N] = from_fn(|i| p[i][m] / innovation.variance);
        for (mean, gain) in self.mean.iter_mut().zip(gain) {
            *mean += gain * innovation.residual;
        }
        // Each pair of elements from the same expression, so that the matrix stays symmetric.
        self.covariance = from_fn(|i| {
            from_fn(|j| {
                let (row, column) = (i.min(j), i.max(j));
                p[row][column] - gain[row] * p[m][column]
            })
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_measurements_of_a_constant_are_averaged_by_their_variances() {
        let mut state = Gaussian::independent([0.0], [1e12]);
        for (measured, variance) in [(2.0, 1.0), (8.0, 2.0)] {
            let innovation = state.innovation(0, measured, variance);
            state.correct(0, &innovation);
        }
        assert!((state.mean[0] - 4.0).abs() < 1e-9);
        assert!((state.covariance[0][0] - 2.0 / 3.0).abs() < 1e-9);
    }

    #[test]
    fn a_measured_position_shows_the_speed_behind_it() {
        let mut state = Gaussian::independent([0.0, 0.0], [0.01, 4.0]);
        state.spread(&[[1.0, 0.5], [0.0, 1.0]], &[0.0, 0.0], 0.0);
        assert_eq!(state.covariance, [[1.01, 2.0], [2.0, 4.0]]);
        let innovation = state.innovation(0, 1.01, 0.0);
        state.correct(0, &innovation);
        assert!((state.mean[1] - 2.0).abs() < 1e-12);
        assert!(state.covariance[0][0].abs() < 1e-12);
    }

    #[test]
    fn a_value_that_is_not_a_number_passes_no_gate() {
        let state = Gaussian::independent([0.0], [1.0]);
        assert!(state.innovation(0, 1.9, 0.0).passes(2.0));
        assert!(!state.innovation(0, -2.1, 0.0).passes(2.0));
        assert!(!state.innovation(0, f64::NAN, 0.0).passes(2.0));
        assert!(!state.innovation(0, f64::INFINITY, 0.0).passes(2.0));
    }
}
