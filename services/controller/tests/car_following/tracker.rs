//! A tracker with the delay and noise of a maneuver-adaptive one. It is a Kalman filter with
//! Singer's model; its noise grows while the range rate departs from its prediction.

use controller::law::Target;

/// Correlation time of the lead's acceleration, s.
const TAU_S: f64 = 2.5;
/// Deviation of the lead's acceleration while it is steady and while it maneuvers, m/s².
const SIGMA_MPS2: [f64; 2] = [0.5, 6.0];
/// Variances of the measurements.
const VARIANCE: [f64; 2] = [0.4 * 0.4, 0.15 * 0.15];
/// Smoothing of the normalised innovation, and the mean at which a maneuver begins and ends.
const SHARE: f64 = 0.4;
const MANEUVER: [f64; 2] = [1.3, 0.7];

#[derive(Clone, Debug, Default)]
pub(crate) struct Tracker {
    state: Option<[f64; 3]>,
    covariance: [[f64; 3]; 3],
    innovation: f64,
    maneuver: bool,
}

impl Tracker {
    pub(crate) fn update(&mut self, measured: Option<[f64; 2]>, ego: f64, dt_s: f64) -> Target {
        let first = measured.unwrap_or_default();
        if self.state.is_none() {
            self.covariance = [[0.16, 0.0, 0.0], [0.0, 0.0225, 0.0], [0.0, 0.0, 0.25]];
        }
        let mut x = *self.state.get_or_insert([first[0], first[1], 0.0]);
        let kept = libm::exp(-dt_s / TAU_S);
        let half = 0.5 * dt_s * dt_s;
        let a = x[2] - ego;
        x = [x[0] + x[1] * dt_s + a * half, x[1] + a * dt_s, kept * x[2]];
        let f = [[1.0, dt_s, half], [0.0, 1.0, dt_s], [0.0, 0.0, kept]];
        let sigma = SIGMA_MPS2[usize::from(self.maneuver)];
        let noise = sigma * sigma * (1.0 - kept * kept);
        let b = [half, dt_s, 1.0];
        let p = self.covariance;
        let mut moved = [[0.0; 3]; 3];
        for (i, row) in moved.iter_mut().enumerate() {
            for (j, cell) in row.iter_mut().enumerate() {
                *cell = noise * b[i] * b[j];
                for k in 0..3 {
                    for l in 0..3 {
                        *cell += f[i][k] * p[k][l] * f[j][l];
                    }
                }
            }
        }
        let mut p = moved;
        for (m, value) in measured.into_iter().flatten().enumerate() {
            let spread = p[m][m] + VARIANCE[m];
            let off = value - x[m];
            if m == 1 {
                self.innovation += SHARE * (off / spread.sqrt() - self.innovation);
            }
            let row = p[m];
            for i in 0..3 {
                let gain = row[i] / spread;
                x[i] += gain * off;
                for j in 0..3 {
                    p[i][j] -= gain * row[j];
                }
            }
        }
        let limit = MANEUVER[usize::from(self.maneuver)];
        self.maneuver = self.innovation.abs() > limit;
        self.covariance = p;
        self.state = Some(x);
        Target {
            track_id: 1,
            gap_m: x[0],
            relative_speed_mps: x[1],
            acceleration_mps2: x[2],
            age_s: 0.0,
        }
    }
}
