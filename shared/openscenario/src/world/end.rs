//! Ends of actions.

use crate::model::element::ElementState;
use crate::world::World;
use crate::world::motion::{Pace, Steer};

impl World {
    /// Ends the longitudinal action, because another one replaces it. A timed trajectory is longitudinal too.
    pub(super) fn clear_pace(&mut self, actor: usize) {
        let mover = &mut self.state.movers[actor];
        mover.pace = Pace::Free;
        let owner = mover.pace_owner.take();
        self.release(owner, ElementState::StopTransition);
        if self.state.movers[actor].path.as_ref().is_some_and(|path| path.by_way_from_m.is_none()) {
            self.clear_path(actor);
        }
    }

    pub(super) fn clear_steer(&mut self, actor: usize) {
        let mover = &mut self.state.movers[actor];
        mover.steer = Steer::Hold;
        mover.motion.lateral_mps = 0.0;
        let owner = mover.steer_owner.take();
        self.release(owner, ElementState::StopTransition);
    }

    pub(super) fn clear_path(&mut self, actor: usize) {
        let mover = &mut self.state.movers[actor];
        mover.path = None;
        let owner = mover.path_owner.take();
        self.release(owner, ElementState::StopTransition);
    }

    /// Ends the longitudinal action at its own end.
    pub(super) fn end_pace(&mut self, actor: usize) {
        let mover = &mut self.state.movers[actor];
        mover.pace = Pace::Free;
        mover.motion.acceleration_mps2 = match self.script.entities[actor].drive {
            crate::model::Drive::Scripted => 0.0,
            crate::model::Drive::External => mover.motion.acceleration_mps2,
        };
        let owner = mover.pace_owner.take();
        self.release(owner, ElementState::EndTransition);
    }

    pub(super) fn end_steer(&mut self, actor: usize) {
        let mover = &mut self.state.movers[actor];
        mover.steer = Steer::Hold;
        let owner = mover.steer_owner.take();
        self.release(owner, ElementState::EndTransition);
    }

    pub(super) fn end_path(&mut self, actor: usize) {
        let mover = &mut self.state.movers[actor];
        mover.path = None;
        let owner = mover.path_owner.take();
        self.release(owner, ElementState::EndTransition);
    }

    /// Ends everything that a storyboard's action does, because its event is stopped.
    pub(super) fn abandon(&mut self, element: usize) {
        for actor in 0..self.state.movers.len() {
            let mover = &self.state.movers[actor];
            let owns = |owner: Option<usize>| owner == Some(element);
            let (pace, steer, path) =
                (owns(mover.pace_owner), owns(mover.steer_owner), owns(mover.path_owner));
            if pace {
                self.clear_pace(actor);
            }
            if steer {
                self.clear_steer(actor);
            }
            if path {
                self.clear_path(actor);
            }
        }
    }
}
