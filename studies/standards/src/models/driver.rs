//! A model with its memory: from what is seen to the ego's next speed.

use super::{Braking, Model, View, fuzzy, rss, un_r157};
use crate::STEP_S;
use crate::contact::is_ahead;

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
