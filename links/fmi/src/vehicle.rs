//! Messages between the plant and a vehicle's unit: one question and one answer each period.

use bytemuck::{Pod, Zeroable};

/// Beginning of every question. The answer begins with the same number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Head {
    pub sequence: u64,
    /// 1 if the law or the vehicle begins anew.
    pub reset: u64,
    /// Time since the start of the run, s.
    pub time_s: f64,
    /// Period, s.
    pub period_s: f64,
}

/// Question: a period of the plant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Request {
    /// Number of the question; the answer carries it back.
    pub sequence: u64,
    /// 1 if the vehicle begins anew, at `speed_mps`.
    pub reset: u64,
    /// Time since the start of the run, s.
    pub time_s: f64,
    /// Period, s.
    pub period_s: f64,
    /// Requested acceleration, m/s².
    pub request_mps2: f64,
    /// Pedals, 0 to 1, for a unit that has no acceleration as input.
    pub throttle: f64,
    pub brake: f64,
    /// Speed at the start, m/s.
    pub speed_mps: f64,
}

/// Answer: the motion at the end of the period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Motion {
    pub sequence: u64,
    /// 1 if the unit has a position and an acceleration; they follow from the speed otherwise.
    pub has_position: u64,
    pub has_acceleration: u64,
    /// Way since the unit's start, m.
    pub position_m: f64,
    pub speed_mps: f64,
    pub acceleration_mps2: f64,
}
