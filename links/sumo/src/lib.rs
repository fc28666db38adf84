//! SUMO's nets as roads, and SUMO as the traffic around the ego.
//!
//! ```text
//! NET.sumocfg ─► net, demand ─► path: the ego's lanes ─► smooth ─► Route: axis, limits, stop lines
//!                                                                             │ at the opening of a scenario
//! ────────────────────────────────────────────────────────────────────────────┼─────────────────────────────
//!                                                                             ▼ in each run
//! sumo (a process of its own) ◄─ wire, client: TraCI ─► World: bodies along the axis, lights at the stop lines
//! ```
//!
//! [`read_route`] needs no SUMO. [`World`] starts the program, adds the ego, and steps it each 100 ms of the run. The ego
//! is placed together with the step. SUMO answers with the vehicles around it and with the states of the lights. Between
//! two steps the vehicles go on at constant acceleration. Several egos have one SUMO: [`drive_egos`].
//!
//! ```no_run
//! use std::path::Path;
//!
//! let route = sumo::read_route(Path::new("grid.sumocfg"), "from=A0B0,to=C2D2", 4.5)?;
//! let (axis, _) = route.axis()?;
//! println!("{} edges, {:.0} m, {} lights", route.edges.len(), axis.length_m(), route.lights.len());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod client;
mod demand;
mod lights;
mod line;
mod net;
mod path;
mod process;
mod route;
mod shared;
mod smooth;
mod wire;
mod world;

pub use lights::Interval;
pub use openscenario::ReadError;
pub use path::Light;
pub use process::{Network, ProgramError};
pub use route::{Limit, Route, read_route};
pub use shared::{ROOM_S, Seat, drive_egos};
pub use world::{Body, Ego, Settings, World};

/// Time between two steps of SUMO, ms.
pub const STEP_MS: u64 = 100;
/// Distance from the ego up to which vehicles take part, m.
pub const RADIUS_M: f64 = 250.0;
