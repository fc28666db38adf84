//! The yaw-rate sensor: a lag, an offset for the whole run, noise of each sample.

use scenario::lateral::YawRateSensor as Keys;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YawRateSensor {
    /// Share of the way to the true rate in one period.
    share: f64,
    offset_radps: f64,
    sigma_radps: f64,
    /// Noise of the present sample, rad/s.
    noise_radps: f64,
}

impl YawRateSensor {
    /// The sensor of a run, sampled once in each period; `offset` is a normal deviate.
    pub fn new(keys: &Keys, period_s: f64, offset: f64) -> Self {
        let lag_s = 1e-3 * f64::from(keys.lag_ms.value());
        Self {
            share: if lag_s > 0.0 { 1.0 - libm::exp(-period_s / lag_s) } else { 1.0 },
            offset_radps: offset * keys.offset_sigma_dps.value().to_radians(),
            sigma_radps: keys.noise_dps.value().to_radians(),
            noise_radps: 0.0,
        }
    }

    /// Moves the lagged rate on by one period, and takes the noise of the next sample from a normal deviate.
    pub fn follow(&mut self, sensed_radps: &mut f64, yaw_radps: f64, deviate: f64) {
        *sensed_radps += self.share * (yaw_radps - *sensed_radps);
        self.noise_radps = self.sigma_radps * deviate;
    }

    /// The rate as the sensor gives it, rad/s.
    pub fn measured(&self, sensed_radps: f64) -> f64 {
        sensed_radps + self.offset_radps + self.noise_radps
    }
}
