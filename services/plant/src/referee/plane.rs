//! Figures of the drive across the road.

use scenario::Scenario;
use scenario::event::VEHICLE_WIDTH_M;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

use super::larger;
use crate::numbers::Numbers;
use crate::report::ControlFigures;

/// The ego across the road at one instant, by the ground truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InPlane {
    /// Distance of the front bumper's middle from the axis, m.
    pub lateral_m: f64,
    pub lateral_acceleration_mps2: f64,
    /// Closing speed of a body that the ego touches, m/s; `None` without contact.
    pub closing_at_contact_mps: Option<f64>,
}

/// Most samples of the window of the jerk.
const WINDOW: usize = 50;

/// Sums behind the figures across the road.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct PlaneFigures {
    /// Offset from which a part of the bumper is outside the lane, m.
    outside_from_m: f64,
    window_s: f64,
    /// Time between two samples of the window, s.
    spacing_s: f64,
    /// Lateral accelerations of the last `window_s`, m/s², up to this number.
    window: VecDeque<f64>,
    samples: usize,
    since_s: f64,
}

impl PlaneFigures {
    /// `None` without a plan of the road.
    pub(super) fn of(scenario: &Scenario, numbers: &Numbers) -> Option<Self> {
        let lanes = &scenario.road.plan()?.lanes;
        let (period_s, window_s) =
            (1e-3 * f64::from(scenario.plant.period_ms.value()), numbers.lateral_jerk_s);
        // A whole number of periods that leaves at most `WINDOW` samples.
        let periods = (window_s / WINDOW as f64 / period_s - 1e-9).ceil().max(1.0);
        let spacing_s = periods * period_s;
        let samples = ((window_s / spacing_s).round() as usize).clamp(1, WINDOW);
        Some(Self {
            outside_from_m: 0.5 * (lanes.width_m.value() - VEHICLE_WIDTH_M),
            window_s: samples as f64 * spacing_s,
            spacing_s,
            window: VecDeque::with_capacity(samples),
            samples,
            since_s: 0.0,
        })
    }

    /// Counts a sample that comes `period_s` after the one before.
    pub(super) fn add(&mut self, sample: &InPlane, period_s: f64, figures: &mut ControlFigures) {
        let acceleration = sample.lateral_acceleration_mps2;
        larger(&mut figures.max_abs_lateral_accel_mps2, acceleration.abs());
        let outside = sample.lateral_m.abs() > self.outside_from_m;
        let outside_s = figures.outside_lane_s.unwrap_or(0.0);
        figures.outside_lane_s = Some(outside_s + if outside { period_s } else { 0.0 });
        self.since_s += period_s;
        if !self.window.is_empty() && self.since_s < self.spacing_s - 1e-9 {
            return;
        }
        self.since_s = 0.0;
        if self.window.len() == self.samples
            && let Some(first) = self.window.pop_front()
        {
            let jerk = (acceleration - first) / self.window_s;
            larger(&mut figures.max_abs_lateral_jerk_mps3, jerk.abs());
        }
        self.window.push_back(acceleration);
    }
}
