//! Control laws: input, output and description.
//!
//! A law is plain code: no clock, no shared memory, no thread, no logging. The control loop samples
//! its inputs, ages them, and calls [`Law::step`] once per release; time is an argument.
//!
//! Frame: x forward along the lane, origin at the ego's start. All quantities in SI units.

mod descriptor;
pub mod following;
mod hosted;
mod input;
mod output;
mod planning;
mod preview;
mod profile;
mod reader;
pub mod settings;

pub use descriptor::{Descriptor, Figure, Formulation, GapPolicy};
pub use hosted::{Hosted, HostedError, ProgramReport};
pub use input::{
    Ego, Input, MAX_PHASES, MAX_SIGNALS, Phase, PhaseInterval, Powertrain, SignalAhead, Target,
};
pub use output::{MAX_FIGURES, MAX_PLAN, ModeMemory, Output, Quality};
pub use planning::{MAX_SEGMENTS, Plan, PlanRequest, Planner, Planning, Segment};
pub use preview::{MAX_CELLS, Preview};
pub use profile::{RESPONSE_S, SpeedProfile};
pub use reader::Reader;

/// A cruise controller.
///
/// Every law passes one conformance suite: its output is finite and within bounds for any input. It copes
/// with a lost target and lost signals. `reset` brings back the initial behaviour exactly. The same inputs
/// give the same bits, and `step` allocates nothing.
///
/// # Example
/// A law that keeps a time headway of two seconds:
///
/// ```
/// use law::{Ego, Input, Law, Output, Target};
///
/// struct TwoSeconds;
///
/// impl Law for TwoSeconds {
///     fn reset(&mut self) {}
///
///     fn step(&mut self, input: &Input, output: &mut Output) {
///         *output = Output::default();
///         let speed_mps = input.ego.speed_mps;
///         let free_mps2 = 0.4 * (input.set_speed_mps - speed_mps);
///         let follow_mps2 = input.target.map_or(free_mps2, |target| {
///             0.2 * (target.gap_m - 5.0 - 2.0 * speed_mps) + 0.7 * target.relative_speed_mps
///         });
///         let (least, most) = self.request_bounds_mps2();
///         // `max` and `min` of a request that is not a number are the bound: never NaN.
///         output.set_request(free_mps2.min(follow_mps2).max(least).min(most));
///     }
///
///     fn request_bounds_mps2(&self) -> (f64, f64) {
///         (-4.0, 2.0)
///     }
/// }
///
/// let input = Input {
///     period_s: 0.1,
///     ego: Ego { speed_mps: 20.0, ..Ego::default() },
///     target: Some(Target { gap_m: 35.0, relative_speed_mps: -1.0, ..Target::default() }),
///     set_speed_mps: 30.0,
///     ..Input::default()
/// };
/// let mut output = Output::default();
/// TwoSeconds.step(&input, &mut output);
/// assert!((output.request_mps2() - -2.7).abs() < 1e-12);
/// ```
pub trait Law {
    /// Clears all history; the next `step` behaves as the first.
    fn reset(&mut self);

    /// Computes the command for one release into `output`, overwriting all of it.
    fn step(&mut self, input: &Input, output: &mut Output);

    /// Smallest and largest request the law ever returns, m/s².
    fn request_bounds_mps2(&self) -> (f64, f64);

    /// The foreign program that computes for the law, if one does.
    fn hosted(&mut self) -> Option<&mut dyn Hosted> {
        None
    }

    /// The law's background planning, if it has any.
    fn planning(&mut self) -> Option<&mut dyn Planning> {
        None
    }
}
