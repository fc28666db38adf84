//! The storyboard's parts: standby, running, complete, and the transitions between.
//!
//! In a step, parts whose content ended while the entities moved end, from actions upwards. Then stop triggers and start
//! triggers are evaluated, from the top downwards. This is repeated until no part changes, so that conditions on a part
//! follow each other in one step. A transition lasts to the end of its step. A part starts at most once in a step.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::model::Drive;
use crate::model::condition::{ElementKind, ElementState};
use crate::model::storyboard::Priority;
use crate::world::World;
use crate::world::motion::{Mover, Pace, Part, Path};
use crate::world::plan::{Element, Plan};

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Progress {
    phase: Phase,
    /// Times that it has started or was skipped.
    executions: u32,
    /// Actors for whom an action is still going on.
    pending: u32,
    /// The step in which it started or was skipped last.
    started: u64,
    transition: Option<(ElementState, u64)>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Phase {
    /// It has not started, and of an event its maneuver has not.
    #[default]
    Idle,
    Standby,
    Running,
    Complete,
}

impl Progress {
    /// True if it is in this state, or goes through this transition.
    pub(super) fn is(&self, state: ElementState, step: u64) -> bool {
        match state {
            ElementState::Standby => matches!(self.phase, Phase::Standby | Phase::Idle),
            ElementState::Running => self.phase == Phase::Running,
            ElementState::Complete => self.phase == Phase::Complete,
            transition => self.transition == Some((transition, step)),
        }
    }
}

impl World {
    /// Names of the acts of which no event has started, in the order of the file.
    pub fn unstarted_acts(&self) -> impl Iterator<Item = &str> {
        let elements = &self.plan.elements;
        let has_started = |index: &usize| self.state.progress[*index].executions > 0;
        let is_idle = move |act: &usize| {
            let is_event = |index: &usize| elements[*index].kind == ElementKind::Event;
            let mut events = (*act..elements[*act].end).filter(is_event).peekable();
            match events.peek() {
                None => !has_started(act),
                Some(_) => !events.any(|event| has_started(&event)),
            }
        };
        let acts = (0..elements.len()).filter(|act| elements[*act].kind == ElementKind::Act);
        acts.filter(is_idle).map(|act| elements[act].path.rsplit("::").next().unwrap_or_default())
    }

    /// One step of the storyboard, at the world's present time.
    pub(super) fn storyboard(&mut self) {
        let plan = Arc::clone(&self.plan);
        let is_story = |index: &usize| plan.elements[*index].kind == ElementKind::Story;
        if self.state.step == 1 {
            (0..plan.elements.len()).filter(is_story).for_each(|story| self.run(story));
        }
        // Each part starts and ends at most once.
        for _ in 0..=2 * plan.elements.len() {
            self.state.changed = false;
            self.complete(&plan);
            self.evaluate(&plan);
            if !self.state.changed || self.state.stopped {
                return;
            }
        }
    }

    fn evaluate(&mut self, plan: &Plan) {
        if self.fires(&plan.stop) == Some(true) {
            self.state.stopped = true;
            for index in 0..self.state.progress.len() {
                self.stop(index);
            }
            return;
        }
        for index in 0..self.state.progress.len() {
            match plan.elements[index].kind {
                ElementKind::Act => self.act(plan, index),
                ElementKind::Event => self.event(plan, index),
                _ => {}
            }
        }
    }

    fn act(&mut self, plan: &Plan, index: usize) {
        let Element { start, stop, end, .. } = &plan.elements[index];
        let phase = self.state.progress[index].phase;
        match phase {
            // All stories have started, so that an act stands by from the first step on.
            Phase::Idle if self.fires(start) != Some(false) => {
                self.run(index);
                for inner in index + 1..*end {
                    if plan.elements[inner].kind == ElementKind::ManeuverGroup {
                        self.run_group(plan, inner);
                    }
                }
            }
            Phase::Running if self.fires(stop) == Some(true) => {
                (index..*end).for_each(|inner| self.stop(inner));
            }
            _ => {}
        }
    }

    /// Runs a maneuver group: its maneuvers run, their events stand by.
    fn run_group(&mut self, plan: &Plan, index: usize) {
        self.run(index);
        for inner in index + 1..plan.elements[index].end {
            match plan.elements[inner].kind {
                ElementKind::Maneuver => self.run(inner),
                ElementKind::Event => {
                    self.state.progress[inner].executions = 0;
                    self.stand_by(plan, inner);
                }
                _ => {}
            }
        }
    }

    fn stand_by(&mut self, plan: &Plan, event: usize) {
        self.state.progress[event].phase = Phase::Standby;
        self.forget(&plan.elements[event].start);
    }

    fn event(&mut self, plan: &Plan, index: usize) {
        let event = &plan.elements[index];
        let Progress { phase, started, .. } = self.state.progress[index];
        let stands_by = phase == Phase::Standby && started != self.state.step;
        if !stands_by || self.fires(&event.start) == Some(false) {
            return;
        }
        match (event.priority, self.rival(index)) {
            (Priority::Skip, Some(_)) => {
                let progress = &mut self.state.progress[index];
                progress.executions += 1;
                progress.started = self.state.step;
                if progress.executions >= event.executions {
                    progress.phase = Phase::Complete;
                }
                self.mark(index, ElementState::SkipTransition);
                return;
            }
            (Priority::Override, _) => {
                while let Some(rival) = self.rival(index) {
                    (rival..plan.elements[rival].end).for_each(|inner| self.stop(inner));
                }
            }
            _ => {}
        }
        self.run(index);
        for inner in index + 1..event.end {
            self.run(inner);
            let Element { action, actors, .. } = &plan.elements[inner];
            if let Some(action) = action {
                self.start(action, actors, Some(inner));
            }
        }
    }

    /// Another event of the same maneuver that runs.
    fn rival(&self, event: usize) -> Option<usize> {
        let elements = &self.plan.elements;
        let maneuver = (0..event).rev().find(|i| elements[*i].kind == ElementKind::Maneuver)?;
        (maneuver + 1..elements[maneuver].end).find(|&i| {
            i != event
                && elements[i].kind == ElementKind::Event
                && self.state.progress[i].phase == Phase::Running
        })
    }

    /// Ends parts that have nothing left to do, from the inside outwards.
    fn complete(&mut self, plan: &Plan) {
        for index in (0..self.state.progress.len()).rev() {
            let Element { kind, end, executions, .. } = plan.elements[index];
            let Progress { phase, executions: done, .. } = self.state.progress[index];
            if phase != Phase::Running || kind == ElementKind::Action {
                continue;
            }
            let first = (index + 1 < end).then_some(index + 1);
            let next = |i: &usize| Some(plan.elements[*i].end).filter(|next| *next < end);
            let mut inside = std::iter::successors(first, next);
            if inside.any(|i| self.state.progress[i].phase != Phase::Complete) {
                continue;
            }
            self.mark(index, ElementState::EndTransition);
            self.state.progress[index].phase = Phase::Complete;
            match kind {
                ElementKind::Event if done < executions => self.stand_by(plan, index),
                ElementKind::ManeuverGroup if done < executions => self.run_group(plan, index),
                _ => {}
            }
        }
    }

    fn stop(&mut self, index: usize) {
        let phase = self.state.progress[index].phase;
        if phase == Phase::Complete {
            return;
        }
        // All that an action does for its actors ends with it.
        for actor in 0..self.state.movers.len() {
            for part in [Part::Pace, Part::Steer, Part::Path] {
                if self.state.movers[actor].owners[part as usize] == Some(index) {
                    self.clear(actor, part);
                }
            }
        }
        if phase == Phase::Running {
            self.mark(index, ElementState::StopTransition);
        }
        let progress = &mut self.state.progress[index];
        progress.phase = Phase::Complete;
        progress.pending = 0;
    }

    fn run(&mut self, index: usize) {
        let progress = &mut self.state.progress[index];
        progress.phase = Phase::Running;
        progress.started = self.state.step;
        progress.executions += 1;
        progress.pending = 0;
        self.mark(index, ElementState::StartTransition);
    }

    fn mark(&mut self, index: usize, transition: ElementState) {
        self.state.changed = true;
        self.state.progress[index].transition = Some((transition, self.state.step));
    }

    /// Counts one more actor that is busy with a storyboard's action.
    pub(super) fn hold(&mut self, element: Option<usize>) {
        if let Some(element) = element {
            self.state.progress[element].pending += 1;
        }
    }

    pub(super) fn release(&mut self, element: Option<usize>, how: ElementState) {
        let Some(element) = element else { return };
        let progress = &mut self.state.progress[element];
        progress.pending = progress.pending.saturating_sub(1);
        if progress.pending == 0 && progress.phase == Phase::Running {
            self.finish(Some(element), how);
        }
    }

    /// Number of actors that are busy with it.
    pub(super) fn count(&self, element: Option<usize>) -> u32 {
        element.map_or(0, |element| self.state.progress[element].pending)
    }

    pub(super) fn finish(&mut self, element: Option<usize>, how: ElementState) {
        if let Some(element) = element {
            self.state.progress[element].phase = Phase::Complete;
            self.mark(element, how);
        }
    }

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
}
