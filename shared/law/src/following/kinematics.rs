//! Exact motion of a vehicle whose acceleration follows the request with a first-order lag.
//!
//! ```text
//! tau a' = u - a,  v' = a,  p' = v,  v never negative
//! a(t) = u + (a0 - u) E,                    E = exp(-t / tau)
//! v(t) = v0 + u t + (a0 - u) tau (1 - E)
//! p(t) = p0 + v0 t + u t²/2 + (a0 - u) tau (t - tau (1 - E))
//! ```
//!
//! | symbol | field | unit |
//! |---|---|---|
//! | `p` | [`Motion::position_m`] | m |
//! | `v` | [`Motion::speed_mps`] | m/s |
//! | `a` | [`Motion::acceleration_mps2`] | m/s² |
//! | `tau` | [`Lag::tau_s`] | s |

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    pub position_m: f64,
    pub speed_mps: f64,
    pub acceleration_mps2: f64,
}

/// Time and place at which a braking vehicle stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    pub time_s: f64,
    pub distance_m: f64,
}

/// A first-order lag from request to acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lag {
    /// Time constant, s.
    pub tau_s: f64,
}

/// One step of the lag, discretised exactly for a request held over it:
/// `p+ = p + T v + position[0] a + position[1] u` and likewise for speed and acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LagStep {
    pub step_s: f64,
    /// Coefficients of `a` and `u` in the position's change, s².
    pub position: [f64; 2],
    /// Coefficients of `a` and `u` in the speed's change, s.
    pub speed: [f64; 2],
    /// Coefficients of `a` and `u` in the next acceleration.
    pub acceleration: [f64; 2],
}

impl Lag {
    /// The exact step of length `step_s`.
    pub fn discretise(self, step_s: f64) -> LagStep {
        let (tau, t) = (self.tau_s, step_s);
        let decay = libm::exp(-t / tau);
        let c1 = tau * (1.0 - decay);
        let g1 = tau * (t - c1);
        LagStep {
            step_s,
            position: [g1, 0.5 * t * t - g1],
            speed: [c1, t - c1],
            acceleration: [decay, 1.0 - decay],
        }
    }

    /// Stop under a constant request; `request_mps2` must be negative.
    pub fn stop(self, from: Motion, request_mps2: f64) -> Stop {
        let (v0, u, tau) = (from.speed_mps.max(0.0), request_mps2, self.tau_s);
        let a0 = from.acceleration_mps2;
        if v0 <= 0.0 && a0 <= 0.0 {
            return Stop { time_s: 0.0, distance_m: 0.0 };
        }
        // v(t) is concave for a0 > u and convex else. So Newton's method converges from one side.
        // It starts beyond the root in the first case, and at zero in the second.
        let excess = a0 - u;
        let mut t = if excess > 0.0 { (v0 + excess * tau) / -u } else { 0.0 };
        for _ in 0..30 {
            let decay = libm::exp(-t / tau);
            let v = v0 + u * t + excess * tau * (1.0 - decay);
            let slope = u + excess * decay;
            let change = v / slope;
            t -= change;
            if change.abs() < 1e-9 {
                break;
            }
        }
        let t = t.max(0.0);
        let risen = tau * (1.0 - libm::exp(-t / tau));
        let distance = v0 * t + 0.5 * u * t * t + excess * tau * (t - risen);
        Stop { time_s: t, distance_m: distance.max(0.0) }
    }
}

impl LagStep {
    /// One step on; the vehicle stops rather than reverse.
    pub fn advance(&self, from: Motion, request_mps2: f64) -> Motion {
        let (v, a, u) = (from.speed_mps, from.acceleration_mps2, request_mps2);
        let speed = v + self.speed[0] * a + self.speed[1] * u;
        let travelled = self.step_s * v + self.position[0] * a + self.position[1] * u;
        let acceleration = self.acceleration[0] * a + self.acceleration[1] * u;
        if speed > 0.0 {
            return Motion {
                position_m: from.position_m + travelled.max(0.0),
                speed_mps: speed,
                acceleration_mps2: acceleration,
            };
        }
        // Stopped within the step: the parabola through the speed at both ends gives the distance.
        let mean = (speed - v) / self.step_s;
        let rest = if mean < 0.0 { -0.5 * v * v / mean } else { 0.0 };
        Motion {
            position_m: from.position_m + rest.min(v * self.step_s),
            speed_mps: 0.0,
            acceleration_mps2: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAG: Lag = Lag { tau_s: 0.5 };

    #[test]
    fn a_step_agrees_with_fine_integration() {
        let step = LAG.discretise(0.1);
        let mut m = Motion { position_m: 3.0, speed_mps: 12.0, acceleration_mps2: 1.5 };
        let exact = step.advance(m, -3.0);
        let h = 1e-6;
        for _ in 0..100_000 {
            let a = m.acceleration_mps2;
            m.position_m += h * (m.speed_mps + 0.5 * h * a);
            m.speed_mps += h * (a + 0.5 * h * (-3.0 - a) / 0.5);
            m.acceleration_mps2 += h * (-3.0 - a) / 0.5;
        }
        assert!((m.position_m - exact.position_m).abs() < 1e-6);
        assert!((m.speed_mps - exact.speed_mps).abs() < 1e-6);
        assert!((m.acceleration_mps2 - exact.acceleration_mps2).abs() < 1e-5);
    }

    #[test]
    fn stops_agree_with_small_steps() {
        let fine = LAG.discretise(1e-4);
        for v in [0.0, 0.3, 5.0, 20.0, 40.0] {
            for a in [-6.0, -4.9, -1.0, 0.0, 3.0] {
                for u in [-4.9, -2.0, -0.5] {
                    let start = Motion { position_m: 0.0, speed_mps: v, acceleration_mps2: a };
                    let stop = LAG.stop(start, u);
                    let mut m = start;
                    let mut n = 0;
                    while m.speed_mps > 0.0 || m.acceleration_mps2 > 0.0 {
                        m = fine.advance(m, u);
                        n += 1;
                    }
                    assert!((stop.distance_m - m.position_m).abs() < 5e-3, "{v} {a} {u}");
                    assert!((stop.time_s - f64::from(n) * 1e-4).abs() < 2e-3, "{v} {a} {u}");
                }
            }
        }
    }
}
