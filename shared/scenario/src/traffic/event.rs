//! `[[actors.events]]`: what an actor does when something happens.
//!
//! ```toml
//! [[actors]]
//! name = "car"
//! gap_m = 60
//! initial_speed_mps = 20
//! lateral_offset_m = -3.5
//! [[actors.events]]
//! name = "cut-in"
//! when = { gap_below_m = 30 }
//! lateral = { to_m = 0, duration_s = 3 }
//! speed = { to_mps = 15, rate_mps2 = 1 }
//! [[actors.events]]
//! when = { completed = "cut-in" }
//! delay_s = 5
//! speed = { to_mps = 0, rate_mps2 = 6 }
//! ```
//!
//! Each event happens once, when its trigger first holds. Events are made into a storyboard, and moved by
//! the same engine as those of OpenSCENARIO files.

use openscenario::model::action::Shape;
use scenario_derive::tables;

use crate::name::Name;
use crate::quantity::{
    AccelerationMagnitude, Distance, Duration, Lateral, Speed, SpeedDifference, Time,
};

/// Most events of an actor.
pub(crate) const MAX_EVENTS: usize = 100;
/// Width of the ego, and of a vehicle whose `width_m` is absent, m.
pub const VEHICLE_WIDTH_M: f64 = 1.8;

tables! {
    /// Something that an actor does once.
    pub struct ActorEvent {
        /// Its name, for events that wait for it; unique among the actor's events.
        pub name: Option<Name>,
        /// Trigger.
        pub when: When,
        /// The actor that a gap, headway or time to collision is to; absent: the ego.
        pub to: Option<Name>,
        /// Time from the trigger to the event, s.
        pub delay_s: Time = 0.0,
        /// A change of speed.
        pub speed: Option<SpeedChange>,
        /// A change of the lateral position.
        pub lateral: Option<LateralChange>,
    }

    /// Trigger of an event.
    #[serde(rename_all = "snake_case")]
    pub enum When {
        /// The run's time has come, s.
        TimeS(Time),
        /// The free space along the road is shorter, m.
        GapBelowM(Distance),
        /// The free space along the road is longer, m.
        GapAboveM(Distance),
        /// The time headway of the one behind is shorter, s.
        HeadwayBelowS(Time),
        /// The time headway of the one behind is longer, s.
        HeadwayAboveS(Time),
        /// The time to collision is shorter, s.
        TtcBelowS(Time),
        /// The time to collision is longer, or they do not come closer, s.
        TtcAboveS(Time),
        /// The actor's speed minus the other's is lower, m/s.
        RelativeSpeedBelowMps(SpeedDifference),
        /// The actor's speed minus the other's is higher, m/s.
        RelativeSpeedAboveMps(SpeedDifference),
        /// The actor's own speed is lower, m/s.
        SpeedBelowMps(Speed),
        /// The actor's own speed is higher, m/s.
        SpeedAboveMps(Speed),
        /// The ego's speed is lower, m/s.
        EgoSpeedBelowMps(Speed),
        /// The ego's speed is higher, m/s.
        EgoSpeedAboveMps(Speed),
        /// The actor has gone this distance since the start, m.
        TraveledM(Distance),
        /// The actor has stood for this time, s.
        StandsForS(Time),
        /// An event of this actor with this name has ended.
        Completed(Name),
    }

    /// A change of speed.
    #[derive(Copy)]
    pub struct SpeedChange {
        /// Speed at its end, m/s.
        pub to_mps: Speed,
        /// Largest rate on the way, m/s².
        pub rate_mps2: AccelerationMagnitude,
        /// Its shape.
        pub shape: Shape = Linear,
    }

    /// A change of the lateral position.
    #[derive(Copy)]
    pub struct LateralChange {
        /// Lateral position at its end, m, left positive.
        pub to_m: Lateral,
        /// Time that it takes, s.
        pub duration_s: Duration,
        /// Its shape.
        pub shape: Shape = Sinusoidal,
    }
}

impl When {
    /// True if it measures to the ego or another actor.
    pub(crate) fn measures(&self) -> bool {
        !matches!(
            self,
            Self::TimeS(_)
                | Self::SpeedBelowMps(_)
                | Self::SpeedAboveMps(_)
                | Self::EgoSpeedBelowMps(_)
                | Self::EgoSpeedAboveMps(_)
                | Self::TraveledM(_)
                | Self::StandsForS(_)
                | Self::Completed(_)
        )
    }
}
