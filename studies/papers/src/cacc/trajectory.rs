//! Recorded closed loops of the paper's scenarios, and what is read from them.

/// One recorded closed loop; all slices have the same length, in order of time.
#[derive(Clone, Copy, Debug, Default)]
pub struct Trajectory<'a> {
    /// Time, s.
    pub time_s: &'a [f64],
    /// Distance travelled by the ego, m.
    pub position_m: &'a [f64],
    /// Ego speed, m/s.
    pub speed_mps: &'a [f64],
    /// Ego acceleration, m/s².
    pub acceleration_mps2: &'a [f64],
    /// Request that acts from this time on, m/s².
    pub request_mps2: &'a [f64],
    /// Spacing error `d_s - gap`, m.
    pub gap_error_m: &'a [f64],
    /// Speed error, ego minus lead, m/s.
    pub speed_error_mps: &'a [f64],
    /// Gap, m.
    pub gap_m: &'a [f64],
}

impl Trajectory<'_> {
    /// Time at which the ego has travelled `line_m`, interpolated between samples, s.
    #[must_use]
    pub fn crossing_s(&self, line_m: f64) -> Option<f64> {
        let i = self.position_m.iter().position(|&x| x >= line_m)?;
        if i == 0 {
            return self.time_s.first().copied();
        }
        let (x0, x1) = (self.position_m[i - 1], self.position_m[i]);
        let (t0, t1) = (self.time_s[i - 1], self.time_s[i]);
        Some(t0 + (line_m - x0) / (x1 - x0) * (t1 - t0))
    }

    /// Position at `time_s`, interpolated between samples, m.
    #[must_use]
    pub fn position_at_m(&self, time_s: f64) -> Option<f64> {
        let i = self.time_s.iter().position(|&t| t >= time_s - 1e-9)?;
        let (t1, x1) = (self.time_s[i], self.position_m[i]);
        if i == 0 || t1 <= time_s + 1e-9 {
            return (t1 <= time_s + 1e-9).then_some(x1);
        }
        let (t0, x0) = (self.time_s[i - 1], self.position_m[i - 1]);
        Some(x0 + (time_s - t0) / (t1 - t0) * (x1 - x0))
    }

    /// Total time in `[from_s, to_s)` during which the request satisfies `test`, s.
    pub fn request_time_s(&self, from_s: f64, to_s: f64, test: impl Fn(f64) -> bool) -> f64 {
        let mut total = 0.0;
        for (i, pair) in self.time_s.windows(2).enumerate() {
            let inside = pair[0] >= from_s - 1e-9 && pair[0] < to_s - 1e-9;
            if inside && test(self.request_mps2[i]) {
                total += pair[1] - pair[0];
            }
        }
        total
    }

    /// Time from `from_s` on at which `values` first satisfy `test`, s.
    #[must_use]
    pub fn first_s(&self, from_s: f64, values: &[f64], test: impl Fn(f64) -> bool) -> Option<f64> {
        let mut cycles = self.time_s.iter().zip(values);
        cycles.find(|(time, value)| **time >= from_s - 1e-9 && test(**value)).map(|(time, _)| *time)
    }

    /// Value at `time_s`, at which there is a cycle.
    #[must_use]
    pub fn at(&self, time_s: f64, values: &[f64]) -> Option<f64> {
        let i = self.time_s.iter().position(|t| (t - time_s).abs() < 1e-9)?;
        values.get(i).copied()
    }

    /// Time of the first negative request, s.
    #[must_use]
    pub fn first_negative_s(&self) -> Option<f64> {
        self.first_s(0.0, self.request_mps2, |u| u < 0.0)
    }
}

/// The closed loops behind the figures; leave out what was not run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Runs<'a> {
    /// Scenario A under `acc-mpc`.
    pub a_acc: Option<Trajectory<'a>>,
    /// Scenario A under `cacc-mpc`.
    pub a_cacc: Option<Trajectory<'a>>,
    /// Scenario B under `acc-mpc`.
    pub b_acc: Option<Trajectory<'a>>,
    /// Scenario B under `cacc-mpc`.
    pub b_cacc: Option<Trajectory<'a>>,
    /// Scenario C under `acc-mpc`.
    pub c_acc: Option<Trajectory<'a>>,
    /// Scenario C under `cacc-mpc`.
    pub c_cacc: Option<Trajectory<'a>>,
    /// Table 3 under `acc-mpc`.
    pub t3_acc: Option<Trajectory<'a>>,
    /// Table 3 under `cacc-mpc`.
    pub t3_cacc: Option<Trajectory<'a>>,
}

/// Largest value.
#[must_use]
pub fn largest(values: &[f64]) -> Option<f64> {
    values.iter().copied().reduce(f64::max)
}

/// Smallest value.
#[must_use]
pub fn smallest(values: &[f64]) -> Option<f64> {
    values.iter().copied().reduce(f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossing_and_position_interpolate() {
        let t = Trajectory {
            time_s: &[0.0, 1.0, 2.0],
            position_m: &[0.0, 10.0, 30.0],
            ..Trajectory::default()
        };
        assert_eq!(t.crossing_s(20.0), Some(1.5));
        assert_eq!(t.crossing_s(31.0), None);
        assert_eq!(t.position_at_m(1.5), Some(20.0));
        assert_eq!(t.position_at_m(2.5), None);
    }
}
