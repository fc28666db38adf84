//! The storyboard's parts: standby, running, complete, and the transitions between.
//!
//! A step has two phases. First, parts whose content ended while the entities moved end, from actions upwards. Then
//! stop triggers and start triggers are evaluated, from the top downwards. Conditions see a transition of the first
//! phase in the same step. They see one of the second phase in the next step.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::model::Script;
use crate::model::condition::Trigger;
use crate::model::element::{ElementKind, ElementState};
use crate::model::storyboard::{Act, Event, ManeuverGroup, Priority};
use crate::world::World;
use crate::world::plan::At;

/// Progress of a part of the storyboard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Progress {
    phase: Phase,
    /// Times that it has started or was skipped.
    executions: u32,
    /// Actors for whom an action is still going on.
    pending: u32,
    /// The last transition, with the step in which conditions see it.
    transition: Option<(ElementState, u64)>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Phase {
    /// Its parent has not started.
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
    /// Names of the acts that have not started, in the order of the file.
    pub fn unstarted_acts(&self) -> impl Iterator<Item = &str> {
        let acts = self.plan.elements.iter().zip(&self.state.progress);
        acts.filter(|(element, progress)| {
            element.kind == ElementKind::Act && progress.executions == 0
        })
        .map(|(element, _)| act_at(&self.script, element.at).name.as_str())
    }

    /// One step of the storyboard, at the world's present time.
    pub(super) fn storyboard(&mut self) {
        let script = Arc::clone(&self.script);
        if self.state.step == 1 {
            self.start_stories();
        }
        self.complete(&script);
        self.state.evaluating = true;
        self.evaluate(&script);
        self.state.evaluating = false;
    }

    fn evaluate(&mut self, script: &Script) {
        if let Some(stop) = &script.stop
            && self.fires(stop, self.plan.stop)
        {
            self.state.stopped = true;
            for index in 0..self.state.progress.len() {
                self.stop(index);
            }
            return;
        }
        for index in 0..self.state.progress.len() {
            match self.plan.elements[index].kind {
                ElementKind::Act => self.act(script, index),
                ElementKind::Event => self.event(script, index),
                _ => {}
            }
        }
    }

    fn start_stories(&mut self) {
        for index in 0..self.state.progress.len() {
            match self.plan.elements[index].kind {
                ElementKind::Story => self.run(index),
                ElementKind::Act => self.state.progress[index].phase = Phase::Standby,
                _ => {}
            }
        }
    }

    fn act(&mut self, script: &Script, index: usize) {
        let element = &self.plan.elements[index];
        let (at, start, stop, end) = (element.at, element.start, element.stop, element.end);
        let act = act_at(script, at);
        match self.state.progress[index].phase {
            Phase::Standby => {
                let starts = act.start.as_ref().is_none_or(|trigger| self.fires(trigger, start));
                if starts {
                    self.run(index);
                    self.each(index + 1, end, ElementKind::ManeuverGroup, |world, group| {
                        world.run_group(script, group);
                    });
                }
            }
            Phase::Running => {
                if act.stop.as_ref().is_some_and(|trigger| self.fires(trigger, stop)) {
                    for inner in index..end {
                        self.stop(inner);
                    }
                }
            }
            Phase::Idle | Phase::Complete => {}
        }
    }

    /// Runs a maneuver group: its maneuvers run, their events stand by.
    fn run_group(&mut self, script: &Script, index: usize) {
        self.run(index);
        let end = self.plan.elements[index].end;
        for inner in index + 1..end {
            match self.plan.elements[inner].kind {
                ElementKind::Maneuver => self.run(inner),
                ElementKind::Event => {
                    self.state.progress[inner].executions = 0;
                    self.stand_by(script, inner);
                }
                _ => {}
            }
        }
    }

    fn stand_by(&mut self, script: &Script, event: usize) {
        self.state.progress[event].phase = Phase::Standby;
        let element = &self.plan.elements[event];
        let start = element.start;
        if let Some(trigger) = &event_at(script, element.at).start {
            self.forget(trigger, start);
        }
    }

    fn event(&mut self, script: &Script, index: usize) {
        if self.state.progress[index].phase != Phase::Standby {
            return;
        }
        let element = &self.plan.elements[index];
        let (at, start, end) = (element.at, element.start, element.end);
        let event = event_at(script, at);
        let fires = |world: &mut Self, trigger: &Trigger| world.fires(trigger, start);
        if !event.start.as_ref().is_none_or(|trigger| fires(self, trigger)) {
            return;
        }
        let rival = self.rival(index);
        match (event.priority, rival) {
            (Priority::Skip, Some(_)) => {
                let progress = &mut self.state.progress[index];
                progress.executions += 1;
                if progress.executions >= event.executions {
                    progress.phase = Phase::Complete;
                }
                self.mark(index, ElementState::SkipTransition);
                return;
            }
            (Priority::Override, _) => {
                while let Some(rival) = self.rival(index) {
                    for inner in rival..self.plan.elements[rival].end {
                        self.stop(inner);
                    }
                }
            }
            _ => {}
        }
        self.run(index);
        let group = group_at(script, at);
        for inner in index + 1..end {
            self.run(inner);
            let action = &event.actions[self.plan.elements[inner].at.action].action;
            self.start(action, &group.actors, Some(inner));
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
    fn complete(&mut self, script: &Script) {
        for index in (0..self.state.progress.len()).rev() {
            if self.state.progress[index].phase != Phase::Running {
                continue;
            }
            let element = &self.plan.elements[index];
            let (kind, at, end) = (element.kind, element.at, element.end);
            let inner = match kind {
                ElementKind::Story => ElementKind::Act,
                ElementKind::Act => ElementKind::ManeuverGroup,
                ElementKind::ManeuverGroup => ElementKind::Maneuver,
                ElementKind::Maneuver => ElementKind::Event,
                ElementKind::Event => ElementKind::Action,
                ElementKind::Action => continue,
            };
            let busy = (index + 1..end).any(|i| {
                self.plan.elements[i].kind == inner
                    && self.state.progress[i].phase != Phase::Complete
            });
            if busy {
                continue;
            }
            let executions = self.state.progress[index].executions;
            self.mark(index, ElementState::EndTransition);
            self.state.progress[index].phase = Phase::Complete;
            match kind {
                ElementKind::Event if executions < event_at(script, at).executions => {
                    self.stand_by(script, index);
                }
                ElementKind::ManeuverGroup if executions < group_at(script, at).executions => {
                    self.run_group(script, index);
                }
                _ => {}
            }
        }
    }

    /// Ends a part from outside.
    fn stop(&mut self, index: usize) {
        let phase = self.state.progress[index].phase;
        if phase == Phase::Complete {
            return;
        }
        if self.plan.elements[index].kind == ElementKind::Action {
            self.abandon(index);
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
        progress.executions += 1;
        progress.pending = 0;
        self.mark(index, ElementState::StartTransition);
    }

    fn each(
        &mut self,
        from: usize,
        end: usize,
        kind: ElementKind,
        mut act: impl FnMut(&mut Self, usize),
    ) {
        for index in from..end {
            if self.plan.elements[index].kind == kind {
                act(self, index);
            }
        }
    }

    /// Records a transition. Conditions see a transition of the second phase in the next step.
    fn mark(&mut self, index: usize, transition: ElementState) {
        let step = self.state.step + u64::from(self.state.evaluating);
        self.state.progress[index].transition = Some((transition, step));
    }

    /// Counts one more actor that is busy with a storyboard's action.
    pub(super) fn hold(&mut self, element: Option<usize>) {
        if let Some(element) = element {
            self.state.progress[element].pending += 1;
        }
    }

    /// Counts one actor less.
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

    /// Completes a storyboard's action.
    pub(super) fn finish(&mut self, element: Option<usize>, how: ElementState) {
        if let Some(element) = element {
            self.state.progress[element].phase = Phase::Complete;
            self.mark(element, how);
        }
    }
}

fn act_at(script: &Script, at: At) -> &Act {
    &script.stories[at.story].acts[at.act]
}

fn group_at(script: &Script, at: At) -> &ManeuverGroup {
    &act_at(script, at).groups[at.group]
}

fn event_at(script: &Script, at: At) -> &Event {
    &group_at(script, at).maneuvers[at.maneuver].events[at.event]
}
