//! Changes over time: their shapes, and speeds that follow one.

use serde::{Deserialize, Serialize};

use crate::model::action::{Dimension, Shape, Transition};

/// Largest target speed, m/s: a factor that is applied repeatedly stays finite.
pub(super) const MAX_SPEED_MPS: f64 = 1e4;
/// Shortest duration of a change, s: the clock's own step. A shorter one is done at once, because a time
/// divided by it may overflow.
pub(super) const SHORTEST_S: f64 = 1e-9;

/// A change from one speed to another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct SpeedShape {
    pub from_mps: f64,
    pub to_mps: f64,
    pub start_ns: u64,
    /// Duration, s; infinite for a rate of 0.
    pub duration_s: f64,
    pub shape: Shape,
}

impl Shape {
    /// Progress from 0 to 1 at `x` from 0 to 1.
    pub(super) fn value(self, x: f64) -> f64 {
        let x = x.clamp(0.0, 1.0);
        match self {
            Self::Linear => x,
            Self::Cubic => x * x * (3.0 - 2.0 * x),
            Self::Sinusoidal => 0.5 - 0.5 * libm::cos(std::f64::consts::PI * x),
            Self::Step => 1.0,
        }
    }

    /// The integral of [`Self::value`] from 0 to `x`, at most 1.
    pub(super) fn integral(self, x: f64) -> f64 {
        let pi = std::f64::consts::PI;
        match self {
            Self::Linear => 0.5 * x * x,
            Self::Cubic => x * x * x * (1.0 - 0.5 * x),
            Self::Sinusoidal => 0.5 * x - libm::sin(pi * x) / (2.0 * pi),
            Self::Step => x,
        }
    }

    /// The derivative of [`Self::value`].
    pub(super) fn rate(self, x: f64) -> f64 {
        let pi = std::f64::consts::PI;
        match self {
            _ if !(0.0..1.0).contains(&x) => 0.0,
            Self::Linear => 1.0,
            Self::Cubic => 6.0 * x * (1.0 - x),
            Self::Sinusoidal => 0.5 * pi * libm::sin(pi * x),
            Self::Step => 0.0,
        }
    }

    pub(super) fn largest_rate(self) -> f64 {
        match self {
            Self::Linear => 1.0,
            Self::Cubic => 1.5,
            Self::Sinusoidal => std::f64::consts::FRAC_PI_2,
            Self::Step => f64::INFINITY,
        }
    }

    /// The largest second derivative.
    pub(super) fn largest_curvature(self) -> f64 {
        let pi = std::f64::consts::PI;
        match self {
            Self::Linear | Self::Step => f64::INFINITY,
            Self::Cubic => 6.0,
            Self::Sinusoidal => 0.5 * pi * pi,
        }
    }
}

impl Transition {
    /// The time for a change, s; a distance is covered at a mean speed.
    pub(super) fn duration_s(&self, change: f64, mean_mps: f64) -> f64 {
        match self.dimension {
            _ if self.is_immediate() || change == 0.0 => 0.0,
            Dimension::Time => self.value,
            Dimension::Rate => self.shape.largest_rate() * change / self.value,
            Dimension::Distance => self.value / mean_mps,
        }
    }
}

impl SpeedShape {
    pub(super) fn x(&self, time_ns: u64) -> f64 {
        seconds(time_ns.saturating_sub(self.start_ns)) / self.duration_s
    }

    pub(super) fn is_over(&self, time_ns: u64) -> bool {
        self.x(time_ns) >= 1.0
    }

    pub(super) fn speed(&self, time_ns: u64) -> f64 {
        match self.is_over(time_ns) {
            true => self.to_mps,
            false => {
                self.from_mps + (self.to_mps - self.from_mps) * self.shape.value(self.x(time_ns))
            }
        }
    }

    pub(super) fn acceleration(&self, time_ns: u64) -> f64 {
        (self.to_mps - self.from_mps) / self.duration_s * self.shape.rate(self.x(time_ns))
    }

    /// Distance covered between two times.
    pub(super) fn way(&self, from_ns: u64, to_ns: u64) -> f64 {
        if self.duration_s.is_infinite() {
            return self.from_mps * seconds(to_ns - from_ns);
        }
        let (a, b) = (self.x(from_ns).min(1.0), self.x(to_ns).min(1.0));
        let change = self.shape.integral(b) - self.shape.integral(a);
        let inside = self.from_mps * (b - a) + (self.to_mps - self.from_mps) * change;
        let after = (self.x(to_ns) - b) - (self.x(from_ns) - a);
        self.duration_s * (inside + self.to_mps * after)
    }
}

pub(super) fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 * 1e-9
}
