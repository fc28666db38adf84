//! The storyboard as a list of parts, with the numbers of their conditions.

use crate::model::Script;
use crate::model::condition::{Test, Trigger};
use crate::model::element::ElementKind;
use crate::world::WorldError;

/// A name that no part of the storyboard has, or several.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{reason}, expected {expected}")]
pub struct NotFound {
    /// The fault.
    pub reason: String,
    /// The names that exist.
    pub expected: String,
}

/// The place of an element in the nested lists of the script, as deep as its kind goes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct At {
    pub story: usize,
    pub act: usize,
    pub group: usize,
    pub maneuver: usize,
    pub event: usize,
    pub action: usize,
}

/// A part of the storyboard. Its descendants follow it in the list, up to `end`.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub kind: ElementKind,
    pub path: String,
    pub end: usize,
    pub at: At,
    /// First condition of its start trigger.
    pub start: usize,
    /// First condition of its stop trigger.
    pub stop: usize,
}

#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub elements: Vec<Element>,
    /// Number of all conditions.
    pub conditions: usize,
    /// First condition of the storyboard's stop trigger.
    pub stop: usize,
    /// The element that a condition watches, by the condition's number, if it watches one.
    pub watched: Vec<Option<usize>>,
}

impl Plan {
    /// Lays out a script, and checks its references.
    pub(super) fn of(script: &Script) -> Result<Self, WorldError> {
        let mut plan =
            Self { elements: elements(script), conditions: 0, stop: 0, watched: Vec::new() };
        for index in 0..plan.elements.len() {
            let (start, stop) = triggers(script, &plan.elements[index]);
            let start = plan.number(script, start)?;
            let stop = plan.number(script, stop)?;
            plan.elements[index].start = start;
            plan.elements[index].stop = stop;
        }
        plan.stop = plan.number(script, script.stop.as_ref())?;
        super::check::check(script)?;
        Ok(plan)
    }

    /// Numbers the conditions of a trigger. Returns the first number.
    fn number(&mut self, script: &Script, trigger: Option<&Trigger>) -> Result<usize, WorldError> {
        let first = self.conditions;
        for condition in trigger.iter().flat_map(|trigger| trigger.0.iter().flatten()) {
            self.watched.push(match &condition.test {
                Test::Element { kind, name, .. } => Some(find(&self.elements, *kind, name)?),
                _ => None,
            });
            super::condition::check(script, &condition.test)?;
            self.conditions += 1;
        }
        Ok(first)
    }
}

/// The triggers of an act (start, stop) or of an event (start).
fn triggers<'a>(
    script: &'a Script,
    element: &Element,
) -> (Option<&'a Trigger>, Option<&'a Trigger>) {
    let at = element.at;
    match element.kind {
        ElementKind::Act => {
            let act = &script.stories[at.story].acts[at.act];
            (act.start.as_ref(), act.stop.as_ref())
        }
        ElementKind::Event => {
            let group = &script.stories[at.story].acts[at.act].groups[at.group];
            (group.maneuvers[at.maneuver].events[at.event].start.as_ref(), None)
        }
        _ => (None, None),
    }
}

impl Script {
    /// Finds a part of the storyboard by its name, or by its path from any level with `::`.
    ///
    /// # Errors
    /// When there is none, or more than one.
    pub fn find(&self, kind: ElementKind, name: &str) -> Result<usize, NotFound> {
        find(&elements(self), kind, name)
    }
}

fn find(elements: &[Element], kind: ElementKind, name: &str) -> Result<usize, NotFound> {
    let matches = |element: &Element| {
        element.kind == kind
            && (element.path == name
                || element.path.strip_suffix(name).is_some_and(|rest| rest.ends_with("::")))
    };
    let mut found = elements.iter().enumerate().filter(|(_, element)| matches(element));
    let names = || {
        let of_kind = elements.iter().filter(|element| element.kind == kind);
        crate::error::one_of(of_kind.map(|element| element.path.as_str()))
    };
    match (found.next(), found.next()) {
        (Some((index, _)), None) => Ok(index),
        (None, _) => Err(NotFound {
            reason: format!("the storyboard has no {} `{name}`", words(kind)),
            expected: match elements.iter().any(|element| element.kind == kind) {
                true => names(),
                false => format!("the name of one, and there is no {}", words(kind)),
            },
        }),
        (Some(_), Some(_)) => Err(NotFound {
            reason: format!("the storyboard has several parts called `{name}`"),
            expected: format!("a path: {}", names()),
        }),
    }
}

fn words(kind: ElementKind) -> &'static str {
    match kind {
        ElementKind::Story => "story",
        ElementKind::Act => "act",
        ElementKind::ManeuverGroup => "maneuver group",
        ElementKind::Maneuver => "maneuver",
        ElementKind::Event => "event",
        ElementKind::Action => "action",
    }
}

/// All parts, each before its descendants.
fn elements(script: &Script) -> Vec<Element> {
    let mut list = List::default();
    for (story, s) in script.stories.iter().enumerate() {
        let at = At { story, ..At::default() };
        list.open(ElementKind::Story, &s.name, at, |list| {
            for (act, a) in s.acts.iter().enumerate() {
                let at = At { act, ..at };
                list.open(ElementKind::Act, &a.name, at, |list| {
                    for (group, g) in a.groups.iter().enumerate() {
                        list.group(g, At { group, ..at });
                    }
                });
            }
        });
    }
    list.elements
}

#[derive(Default)]
struct List {
    elements: Vec<Element>,
    path: Vec<String>,
}

impl List {
    fn open(&mut self, kind: ElementKind, name: &str, at: At, inside: impl FnOnce(&mut Self)) {
        self.path.push(name.to_owned());
        let index = self.elements.len();
        let path = self.path.join("::");
        self.elements.push(Element { kind, path, end: 0, at, start: 0, stop: 0 });
        inside(self);
        self.elements[index].end = self.elements.len();
        self.path.pop();
    }

    fn group(&mut self, group: &crate::model::storyboard::ManeuverGroup, at: At) {
        self.open(ElementKind::ManeuverGroup, &group.name, at, |list| {
            for (maneuver, m) in group.maneuvers.iter().enumerate() {
                let at = At { maneuver, ..at };
                list.open(ElementKind::Maneuver, &m.name, at, |list| {
                    for (event, e) in m.events.iter().enumerate() {
                        let at = At { event, ..at };
                        list.open(ElementKind::Event, &e.name, at, |list| {
                            for (action, a) in e.actions.iter().enumerate() {
                                list.open(
                                    ElementKind::Action,
                                    &a.name,
                                    At { action, ..at },
                                    |_| {},
                                );
                            }
                        });
                    }
                });
            }
        });
    }
}
