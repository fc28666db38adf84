//! Ends of actions.

use crate::model::Drive;
use crate::model::element::ElementState;
use crate::world::World;
use crate::world::motion::{Mover, Pace, Part, Path};

impl World {
    /// Ends a part of an entity's motion at its own end.
    pub(super) fn end(&mut self, actor: usize, part: Part) {
        let mover = &mut self.state.movers[actor];
        let is_scripted = self.script.entities[actor].drive == Drive::Scripted;
        if matches!(part, Part::Pace) && is_scripted {
            mover.motion.acceleration_mps2 = 0.0;
        }
        self.finish_part(actor, part, ElementState::EndTransition);
    }

    /// Ends a part of an entity's motion, because another action replaces it or its event is stopped. A timed trajectory
    /// is longitudinal too.
    pub(super) fn clear(&mut self, actor: usize, part: Part) {
        if matches!(part, Part::Steer) {
            self.state.movers[actor].motion.lateral_mps = 0.0;
        }
        self.finish_part(actor, part, ElementState::StopTransition);
        let timed = |mover: &Mover| mover.path.as_ref().is_some_and(Path::is_timed);
        if matches!(part, Part::Pace) && timed(&self.state.movers[actor]) {
            self.clear(actor, Part::Path);
        }
    }

    fn finish_part(&mut self, actor: usize, part: Part, how: ElementState) {
        let mover = &mut self.state.movers[actor];
        match part {
            Part::Pace => mover.pace = Pace::Free,
            Part::Steer => mover.steer = None,
            Part::Path => mover.path = None,
        }
        let owner = mover.owners[part as usize].take();
        self.release(owner, how);
    }

    /// Ends everything that a storyboard's action does, because its event is stopped.
    pub(super) fn abandon(&mut self, element: usize) {
        for actor in 0..self.state.movers.len() {
            for part in [Part::Pace, Part::Steer, Part::Path] {
                if self.state.movers[actor].owners[part as usize] == Some(element) {
                    self.clear(actor, part);
                }
            }
        }
    }
}
