//! A model with its memory: from what is seen to the ego's next speed.

use super::braking::Braking;
use super::{Model, Situation, View, careful_driver, fuzzy, regulation, rss};
use crate::STEP_S;
use crate::contact::is_ahead;

/// A model that drives the ego: its requested speed, step by step.
#[derive(Clone, Debug)]
pub struct Driver {
    model: Model,
    recognition: careful_driver::Recognition,
    acceleration_mps2: f64,
    /// Steps since the trigger first held.
    reacting_steps: Option<u32>,
}

impl Driver {
    /// A driver at constant speed.
    pub fn new(model: Model, situation: Situation) -> Driver {
        Driver {
            model,
            recognition: careful_driver::Recognition::new(situation),
            acceleration_mps2: 0.0,
            reacting_steps: None,
        }
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
        self.acceleration_mps2 = match (braking, self.reacting_steps) {
            (Some(braking), Some(steps)) if steps >= self.reaction_steps() => self.brake(braking),
            (Some(_), _) => -self.pedal_released_mps2(),
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
        self.model == Model::CarefulDriver && self.recognition.needs_no_reaction()
    }

    fn trigger(&mut self, speed_mps: f64, view: &View) -> Option<Braking> {
        match self.model {
            Model::CarefulDriver => self.recognition.trigger(speed_mps, view),
            Model::Regulation => regulation::trigger(speed_mps, view),
            Model::Rss => rss::trigger(speed_mps, view),
            Model::Fuzzy => fuzzy::trigger(speed_mps, self.acceleration_mps2, view),
        }
    }

    /// The reaction time in whole steps.
    fn reaction_steps(&self) -> u32 {
        match self.model {
            Model::Regulation => regulation::REACTION_STEPS,
            Model::CarefulDriver | Model::Rss | Model::Fuzzy => careful_driver::REACTION_STEPS,
        }
    }

    /// Deceleration during the reaction time \[m/s²\].
    fn pedal_released_mps2(&self) -> f64 {
        match self.model {
            Model::CarefulDriver => careful_driver::PEDAL_RELEASED_MPS2,
            Model::Regulation | Model::Rss | Model::Fuzzy => 0.0,
        }
    }

    fn brake(&self, braking: Braking) -> f64 {
        let grown = self.acceleration_mps2.min(0.0) - braking.growth_mps3 * STEP_S;
        grown.max(-braking.deceleration_mps2)
    }
}
