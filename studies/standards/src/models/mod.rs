//! The four models, and the driver that each of them makes: from what is seen to the ego's next speed.

mod fuzzy;
mod rss;
mod un_r157;

use crate::STEP_S;
use crate::contact::is_ahead;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Model {
    /// The competent and careful human driver of UN R157, annex 4, appendix 3.
    CarefulDriver,
    /// The system of UN R157, paragraph 5.2.5.2.
    Regulation,
    /// Responsibility-sensitive safety.
    Rss,
    /// The fuzzy safety model of the European Commission's Joint Research Centre.
    Fuzzy,
}

impl Model {
    pub const ALL: [Model; 4] = [Model::CarefulDriver, Model::Regulation, Model::Rss, Model::Fuzzy];

    pub fn name(self) -> &'static str {
        match self {
            Model::CarefulDriver => "careful-driver",
            Model::Regulation => "regulation",
            Model::Rss => "rss",
            Model::Fuzzy => "fuzzy",
        }
    }

    /// Distance that the model keeps at `speed_mps` behind a vehicle of the same speed \[m\].
    /// `None` for `regulation`, which describes cut-ins alone.
    pub fn following_distance_m(self, speed_mps: f64) -> Option<f64> {
        match self {
            Model::CarefulDriver => Some(un_r157::TIME_GAP_S * speed_mps),
            Model::Regulation => None,
            Model::Rss => Some(rss::following_distance_m(speed_mps)),
            Model::Fuzzy => Some(fuzzy::following_distance_m(speed_mps)),
        }
    }
}

/// A model's view of another vehicle at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Distance from the ego's front bumper to the other's rear bumper \[m\], negative once they overlap.
    pub gap_m: f64,
    pub other_speed_mps: f64,
    /// Between the sides of the two \[m\], negative once they overlap.
    pub clearance_m: f64,
    /// Lateral speed of the other towards the ego's path \[m/s\].
    pub lateral_speed_mps: f64,
}

impl View {
    /// The view of a vehicle straight ahead.
    pub(crate) fn in_lane(gap_m: f64, other_speed_mps: f64) -> View {
        let clearance_m = -crate::VEHICLE_WIDTH_M;
        View { gap_m, other_speed_mps, clearance_m, lateral_speed_mps: 0.0 }
    }
}

/// Braking of a model after its reaction time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Braking {
    deceleration_mps2: f64,
    growth_mps3: f64,
}

/// A model that drives the ego: its requested speed, step by step.
#[derive(Clone, Debug)]
pub struct Driver {
    model: Model,
    recognition: un_r157::Recognition,
    acceleration_mps2: f64,
    reacting_steps: Option<u32>,
}

impl Driver {
    /// A driver at constant speed that another vehicle is beside, which may come in.
    pub fn beside(model: Model) -> Driver {
        let recognition = un_r157::Recognition::Waiting;
        Driver { model, recognition, acceleration_mps2: 0.0, reacting_steps: None }
    }

    /// A driver at constant speed behind a vehicle in its lane, which brakes or stands.
    pub fn in_lane(model: Model) -> Driver {
        Driver { recognition: un_r157::Recognition::Risk, ..Driver::beside(model) }
    }

    /// The ego's speed \[m/s\] after one step of [`STEP_S`]. The step begins at `speed_mps`; `view` is of the relevant
    /// vehicle, if there is one.
    ///
    /// A vehicle whose centre is behind the ego's is not a reason to brake.
    pub fn step(&mut self, speed_mps: f64, view: Option<&View>) -> f64 {
        let braking =
            view.filter(|view| is_ahead(view.gap_m)).and_then(|view| self.trigger(speed_mps, view));
        self.reacting_steps = match self.reacting_steps {
            Some(steps) => Some(steps + 1),
            None => braking.map(|_| 0),
        };
        // The deceleration during the reaction time is that of the pedal.
        let (reaction_steps, pedal_mps2) = match self.model {
            Model::CarefulDriver => (un_r157::DRIVER_STEPS, un_r157::PEDAL_RELEASED_MPS2),
            Model::Regulation => (un_r157::SYSTEM_STEPS, 0.0),
            Model::Rss | Model::Fuzzy => (un_r157::DRIVER_STEPS, 0.0),
        };
        self.acceleration_mps2 = match (braking, self.reacting_steps) {
            (Some(braking), Some(steps)) if steps >= reaction_steps => self.brake(braking),
            (Some(_), _) => -pedal_mps2,
            (None, _) => 0.0,
        };
        let next_mps = (speed_mps + self.acceleration_mps2 * STEP_S).max(0.0);
        if next_mps == 0.0 {
            self.acceleration_mps2 = 0.0;
        }
        next_mps
    }

    /// True if the model has found that no reaction is needed: the case then counts as no collision.
    pub fn needs_no_reaction(&self) -> bool {
        self.model == Model::CarefulDriver && self.recognition == un_r157::Recognition::NotNeeded
    }

    fn trigger(&mut self, speed_mps: f64, view: &View) -> Option<Braking> {
        match self.model {
            Model::CarefulDriver => self.recognition.trigger(speed_mps, view),
            Model::Regulation => un_r157::trigger(speed_mps, view),
            Model::Rss => rss::trigger(speed_mps, view),
            Model::Fuzzy => fuzzy::trigger(speed_mps, self.acceleration_mps2, view),
        }
    }

    fn brake(&self, braking: Braking) -> f64 {
        let grown = self.acceleration_mps2.min(0.0) - braking.growth_mps3 * STEP_S;
        grown.max(-braking.deceleration_mps2)
    }
}
