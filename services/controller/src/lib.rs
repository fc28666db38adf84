//! The control loop, and the registry of the laws that it can ask.
//!
//! ```text
//! topics ─ sampling ─► plausibility ─► ladder ─► law ─► curve speed ─► control/command, control/diagnostics
//! ```
//!
//! A law is plain code behind one trait ([`law::Law`]). The registry ([`laws::ALL`]) has a descriptor of each
//! ([`law::Descriptor`]). The loop samples the topics ([`sampling`]) and finds inputs that contradict each other
//! ([`plausibility`]). It chooses the degradation level ([`ladder`]), asks the law, and publishes.
//!
//! [`run`] takes the law that the scenario names. [`run_law`] takes one that you bring along, and [`serve`] makes it a
//! program. [`run_asked`] takes one that the caller of a run in one process computes.
//!
//! A law can also be asked alone:
//!
//! ```
//! use controller::law::{Ego, Input, Output, Target};
//! use scenario::Scenario;
//!
//! let text = "schema_version = 1\nname = \"a\"\n[controller]\nname = \"acc-mpc\"";
//! let scenario = Scenario::parse("a.toml", text)?;
//! let mut law = controller::laws::build(&scenario)?;
//!
//! // 20 m behind a vehicle that is 5 m/s slower.
//! let input = Input {
//!     period_s: 0.1,
//!     ego: Ego { speed_mps: 20.0, ..Ego::default() },
//!     target: Some(Target { gap_m: 20.0, relative_speed_mps: -5.0, ..Target::default() }),
//!     set_speed_mps: 25.0,
//!     ..Input::default()
//! };
//! let mut output = Output::default();
//! law.step(&input, &mut output);
//! assert!(output.request_mps2() < -1.0, "it brakes");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod curve_speed;
pub mod ladder;
pub mod laws;
mod planning_thread;
pub mod plausibility;
pub mod report;
pub mod sampling;
mod service;

pub use ::law;
pub use service::{last_law_times, run, run_asked, run_law, serve};
