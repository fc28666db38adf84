//! The quantities that a law or a vehicle exchanges with timegap, and the names by which a unit's variables are found.

use crate::measure::{ACCELERATION, Dimension, FORCE, LENGTH, NUMBER, SPEED, TIME, TORQUE};
use bytemuck::{Pod, Zeroable};
use messages::{LawAnswer, LawInput};

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
    pub period_s: f64,
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

/// A quantity of questions `Q` and answers `A`.
pub struct Quantity<Q, A> {
    /// Name in `[laws.NAME.map]` and in errors.
    pub key: &'static str,
    pub dimension: Dimension,
    pub flow: Flow<Q, A>,
    /// Names of variables that have it: lower-case letters and digits alone, the likeliest first.
    pub names: &'static [&'static str],
}

pub enum Flow<Q, A> {
    /// To the unit before each step.
    Input(fn(&Q) -> f64),
    /// To the unit once, before it initialises.
    Start(fn(&Q) -> f64),
    /// From the unit after each step.
    Output(fn(&mut A, f64)),
}

impl<Q, A> Flow<Q, A> {
    pub fn word(&self) -> &'static str {
        match self {
            Self::Input(_) => "an input",
            Self::Start(_) => "a parameter, or a variable with a start of its own",
            Self::Output(_) => "an output",
        }
    }
}

/// Gap to a target that is not there, m: farther than any sensor sees.
const NO_TARGET_M: f64 = 1000.0;
/// Distance to a signal that is not there, m.
const NO_SIGNAL_M: f64 = 10_000.0;
/// Speed limit of a road without one, m/s.
const NO_LIMIT_MPS: f64 = 100.0;

fn has_target(question: &LawInput) -> bool {
    question.has_target != 0
}

fn signal(question: &LawInput) -> Option<&messages::LawSignal> {
    question.signals.first().filter(|_| question.signal_count > 0)
}

macro_rules! quantities {
    ($($flow:ident $key:literal $dimension:ident $value:expr, [$($name:literal)*];)*) => {
        &[$(Quantity { key: $key, dimension: $dimension, flow: Flow::$flow($value), names: &[$($name),*] }),*]
    };
}

pub static LAW: &[Quantity<LawInput, LawAnswer>] = quantities! {
    Input "speed_mps" SPEED |q| q.speed_mps, ["speed" "velocity" "egospeed" "egovelocity" "speedego" "velocityego"
        "vego" "vehiclespeed" "hostspeed" "ownspeed" "longitudinalvelocity" "longitudinalspeed" "vx" "v"];
    Input "acceleration_mps2" ACCELERATION |q| q.acceleration_mps2, ["acceleration" "egoacceleration"
        "accelerationego" "aego" "vehicleacceleration" "longitudinalacceleration" "ax" "accel" "a"];
    Input "position_m" LENGTH |q| q.position_m, ["position" "egoposition" "xego" "s" "x"];
    Input "set_speed_mps" SPEED |q| q.set_speed_mps, ["setspeed" "setvelocity" "vset" "desiredspeed" "desiredvelocity"
        "cruisespeed" "referencespeed" "vref" "vdes" "v0"];
    Input "speed_limit_mps" SPEED |q| q.speed_limit_mps.min(NO_LIMIT_MPS), ["speedlimit" "vlimit" "vmax"];
    Input "has_target" NUMBER |q| has_target(q).into(), ["hastarget" "targetpresent" "targetvalid" "targetdetected"
        "haslead" "leadpresent" "leadvalid" "leaddetected"];
    Input "gap_m" LENGTH |q| if has_target(q) { q.gap_m } else { NO_TARGET_M }, ["gap" "distance" "relativedistance"
        "spacing" "clearance" "range" "targetdistance" "leaddistance" "distancetotarget" "distancetolead" "headway"
        "drel" "dx" "d"];
    Input "relative_speed_mps" SPEED |q| q.relative_speed_mps, ["relativespeed" "relativevelocity" "rangerate"
        "speeddifference" "vrel" "deltav" "dv"];
    Input "target_speed_mps" SPEED |q| q.speed_mps + q.relative_speed_mps, ["leadspeed" "leadvelocity" "vlead"
        "targetvelocity" "targetspeed" "precedingspeed" "vtarget" "vl"];
    Input "target_acceleration_mps2" ACCELERATION |q| q.target_acceleration_mps2, ["targetacceleration"
        "leadacceleration" "alead" "atarget"];
    Input "target_age_s" TIME |q| q.target_age_s, ["targetage"];
    Input "signal_distance_m" LENGTH |q| signal(q).map_or(NO_SIGNAL_M, |signal| signal.distance_m),
        ["signaldistance" "distancetosignal" "stoplinedistance" "distancetostopline"];
    Input "signal_phase" NUMBER |q| signal(q).map_or(0.0, |signal| signal.intervals[0].phase as f64),
        ["signalphase" "signalstate"];
    Input "signal_ends_in_s" TIME |q| signal(q).map_or(0.0, |signal| signal.intervals[0].ends_in_s),
        ["signalendsin" "timetochange"];
    Input "grade" NUMBER |q| q.grade, ["slope" "roadgrade"];
    Input "time_s" TIME |q| q.time_s, ["time" "t"];
    Input "period_s" TIME |q| q.period_s, ["period" "dt" "ts"];
    Output "request_mps2" ACCELERATION |a, value| a.request_mps2 = value, ["request" "accelerationrequest"
        "requestedacceleration" "accelerationcommand" "commandedacceleration" "accelerationcmd" "accelcmd" "acccmd"
        "desiredacceleration" "acceleration" "longitudinalacceleration" "areq" "acmd" "ades" "aref" "accel" "acc" "ax"
        "command" "control" "output" "a" "u" "y"];
    Output "mode" NUMBER |a, value| a.mode = value as u64, ["mode"];
    Output "figure_0" NUMBER |a, value| a.figures[0] = value, [];
    Output "figure_1" NUMBER |a, value| a.figures[1] = value, [];
    Output "engine_torque_nm" TORQUE |a, value| (a.has_torque, a.engine_torque_nm) = (1, value), ["enginetorque"];
    Output "service_brake_n" FORCE |a, value| a.service_brake_n = value, ["servicebrake"];
};

pub static VEHICLE: &[Quantity<Request, Motion>] = quantities! {
    Input "request_mps2" ACCELERATION |q| q.request_mps2, ["request" "accelerationrequest" "requestedacceleration"
        "accelerationcommand" "commandedacceleration" "accelerationcmd" "accelcmd" "desiredacceleration" "acceleration"
        "areq" "acmd" "ades" "aref" "ax" "accel" "acc" "command" "a" "u"];
    Input "throttle" NUMBER |q| q.throttle, ["throttlepedal" "throttleposition" "acceleratorpedal" "accelerator"
        "accelpedal" "gaspedal" "gas"];
    Input "brake" NUMBER |q| q.brake, ["brakepedal" "brakeposition" "brakecommand" "braking"];
    Output "speed_mps" SPEED |a, value| a.speed_mps = value, ["speed" "velocity" "vehiclespeed" "longitudinalvelocity"
        "longitudinalspeed" "egospeed" "vego" "vx" "v"];
    Output "position_m" LENGTH |a, value| (a.has_position, a.position_m) = (1, value), ["position" "distance"
        "travelleddistance" "distancetravelled" "odometer" "egoposition" "sx" "s" "x"];
    Output "acceleration_mps2" ACCELERATION |a, value| (a.has_acceleration, a.acceleration_mps2) = (1, value),
        ["acceleration" "vehicleacceleration" "longitudinalacceleration" "egoacceleration" "aego" "ax" "accel" "a"];
    // Last: an output with a start of its own has the speed, and takes its start.
    Start "initial_speed_mps" SPEED |q| q.speed_mps, ["initialspeed" "initialvelocity" "startspeed" "speedinit"
        "vinit" "vstart" "speed0" "v0" "speed" "velocity" "vehiclespeed" "vx" "v"];
};
