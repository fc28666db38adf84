//! Whole trips of the truck without processes: roads, drivers, and the fuel that each burns.
//!
//! ```text
//!   Road ──► drive(truck, road, Driver) ──► Trip (time, fuel, energy)
//!               ▲ 10 Hz      │ Demand
//!               └── Seen ◄───┘ truck_model
//! ```
//!
//! Four drivers are compared. They are constant speed ([`Cruise`]), a human ([`Human`]), the law `predictive`
//! ([`Assisted`]), and the optimum of the whole route ([`Bound`]). [`Comparison`] compares them at equal trip time. Everything is plain code in one thread: the same inputs give the same bits.
//!
//! ```
//! use papers::trips::{Cruise, Road, drive};
//! use truck_model::{Preset, Truck};
//!
//! let truck = Truck::preset(Preset::Jh6At25T);
//! let flat = Road::new(50.0, vec![0.0; 40]);
//! let mut cruise = Cruise::new(&truck, 20.0, 25.0);
//! let trip = drive(&truck, &flat, 20.0, &mut cruise).expect("the truck reaches the end");
//! assert!((trip.time_s - 2_000.0 / 20.0).abs() < 1.0);
//! ```

mod assisted;
mod bound;
mod comparison;
mod equal_time;
mod human;
mod road;
mod trip;

pub use assisted::{Assisted, Map};
pub use bound::{Bound, Cruise};
pub use comparison::Comparison;
pub use equal_time::{EQUAL_TIME, at_equal_time};
pub use human::Human;
pub use road::{Road, generated};
pub use trip::{CONTROL_PERIOD_S, Driver, Seen, Trip, drive};
