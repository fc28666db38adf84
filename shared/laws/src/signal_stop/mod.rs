//! `acc-signal-stop`: an ACC that is blind to countdowns, with a driver's signal stop on top.
//!
//! It is the rival of `cacc-mpc`. He et al. (2024) name "the former ACC with a decision layer" as the simple way
//! through signalised intersections. The follower is `acc-mpc`. The layer sees the colour of the nearest signal from a
//! stated distance, and nothing of the future:
//!
//! ```text
//! seen       the colour, once the line is within sight_m
//! heeded     the colour seen, once it has been the same for reaction_s
//! yellow     stop if  v² / (2 (d - margin - tau v)) <= yellow deceleration,  else go on
//! red        stop, unless it went on through this yellow
//! green      start, as acc-mpc does
//! request    min(acc-mpc, driver in front of a standing obstacle at the line)
//! ```
//!
//! | symbol | field | unit |
//! |---|---|---|
//! | `d` | `SignalAhead::distance_m` | m |
//! | `v` | `Ego::speed_mps` | m/s |
//! | `tau` | `Config::model_time_constant_s` | s |
//! | margin | [`SignalStop::stop_margin_m`] | m |
//!
//! A silent signal counts as red: a colour is not guessed.

mod driver;
mod settings;

pub use driver::FORMULATION;
pub use settings::SignalStop;

use self::driver::StoppingLaw;
use super::cacc::{self, config::Config};
use law::settings::Table;
use law::{Descriptor, GapPolicy};

const TABLE: Table = Table::of::<SignalStop>("signal_stop");

/// The law as data.
pub static ACC_SIGNAL_STOP: Descriptor = Descriptor {
    name: "acc-signal-stop",
    description: "predictive following with a driver's stop for red and yellow, blind to countdowns",
    source: "He et al. 2024 (ACC with a decision layer); ITE 2020 (reaction, yellow)",
    table: Some(TABLE),
    formulations: &[&FORMULATION],
    formulation: |_| &FORMULATION,
    gap: GapPolicy::Scenario(cacc::desired_gap),
    measured_target: false,
    trucks_alone: false,
    // Its modes and figures are its own: the commands are those of `acc-mpc`.
    build: |reader| {
        let settings: SignalStop = reader.table(TABLE.name)?;
        let config = Config::of(reader, cacc::Signals::Ignored)?;
        let acc = cacc::build(cacc::Signals::Ignored, &config)
            .map_err(|error| cacc::in_scenario(error, &reader.scenario().controller))?;
        Ok(Box::new(StoppingLaw::new(acc, settings, &config)))
    },
};
