//! The storyboard as a list of parts, with the numbers of their conditions.

use crate::model::Script;
use crate::model::action::Action;
use crate::model::condition::{ElementKind, Test, Trigger};
use crate::model::storyboard::{ManeuverGroup, NamedAction, Priority};
use crate::words::Words;
use crate::world::WorldError;

/// A name that no part of the storyboard has, or several.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{reason}, expected {expected}")]
pub struct NotFound {
    pub name: String,
    pub reason: String,
    /// The names that exist.
    pub expected: String,
}

/// A trigger with the number of its first condition.
#[derive(Clone, Debug, Default)]
pub(super) struct Numbered {
    pub trigger: Option<Trigger>,
    pub first: usize,
}

/// A part of the storyboard. Its descendants follow it in the list, up to `end`.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub kind: ElementKind,
    pub path: String,
    pub end: usize,
    /// The triggers of an act or of an event.
    pub start: Numbered,
    pub stop: Numbered,
    /// Number of times that a group or an event runs.
    pub executions: u32,
    pub priority: Priority,
    /// The actors of the group that the part is in.
    pub actors: Vec<usize>,
    pub action: Option<Action>,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Plan {
    pub elements: Vec<Element>,
    pub conditions: usize,
    /// The storyboard's stop trigger.
    pub stop: Numbered,
    /// The element that a condition watches, by the condition's number, if it watches one.
    pub watched: Vec<Option<usize>>,
    /// Names of the parts that are open while the storyboard is laid out, and the actors of the open group.
    open: (Vec<String>, Vec<usize>),
}

impl Plan {
    /// Lays out a script, and checks its references.
    pub(super) fn of(script: &Script) -> Result<Self, WorldError> {
        let mut plan = Self::laid_out(script);
        for index in 0..plan.elements.len() {
            let Element { start, stop, .. } = plan.elements[index].clone();
            let numbered = (plan.number(start, Some(index))?, plan.number(stop, Some(index))?);
            let element = &mut plan.elements[index];
            (element.start, element.stop) = numbered;
        }
        plan.stop = plan.number(Numbered { trigger: script.stop.clone(), first: 0 }, None)?;
        super::check::check(script, &plan)?;
        Ok(plan)
    }

    /// Numbers the conditions of a trigger of a part.
    fn number(&mut self, numbered: Numbered, of: Option<usize>) -> Result<Numbered, WorldError> {
        let first = self.conditions;
        for condition in numbered.trigger.iter().flat_map(|trigger| trigger.0.iter().flatten()) {
            self.watched.push(match &condition.test {
                Test::Element { kind, name, .. } => Some(find(&self.elements, *kind, name, of)?),
                _ => None,
            });
            self.conditions += 1;
        }
        Ok(Numbered { first, ..numbered })
    }

    /// All parts of a storyboard, each before its descendants.
    fn laid_out(script: &Script) -> Self {
        let mut plan = Self::default();
        for story in &script.stories {
            let of_story = plan.open(ElementKind::Story, &story.name);
            for act in &story.acts {
                let of_act = plan.open(ElementKind::Act, &act.name);
                plan.elements[of_act].start.trigger.clone_from(&act.start);
                plan.elements[of_act].stop.trigger.clone_from(&act.stop);
                act.groups.iter().for_each(|group| plan.group(group));
                plan.close(of_act);
            }
            plan.close(of_story);
        }
        plan
    }

    fn group(&mut self, group: &ManeuverGroup) {
        self.open.1.clone_from(&group.actors);
        let of_group = self.open(ElementKind::ManeuverGroup, &group.name);
        self.elements[of_group].executions = group.executions;
        for maneuver in &group.maneuvers {
            let of_maneuver = self.open(ElementKind::Maneuver, &maneuver.name);
            for event in &maneuver.events {
                let of_event = self.open(ElementKind::Event, &event.name);
                let element = &mut self.elements[of_event];
                element.start.trigger.clone_from(&event.start);
                (element.executions, element.priority) = (event.executions, event.priority);
                for NamedAction { name, action } in &event.actions {
                    let of_action = self.open(ElementKind::Action, name);
                    self.elements[of_action].action = Some(action.clone());
                    self.close(of_action);
                }
                self.close(of_event);
            }
            self.close(of_maneuver);
        }
        self.close(of_group);
        self.open.1.clear();
    }

    /// Adds a part inside those that are open. Returns its place in the list.
    fn open(&mut self, kind: ElementKind, name: &str) -> usize {
        self.open.0.push(name.to_owned());
        self.elements.push(Element {
            kind,
            path: self.open.0.join("::"),
            end: 0,
            start: Numbered::default(),
            stop: Numbered::default(),
            executions: 1,
            priority: Priority::default(),
            actors: self.open.1.clone(),
            action: None,
        });
        self.elements.len() - 1
    }

    fn close(&mut self, index: usize) {
        self.elements[index].end = self.elements.len();
        self.open.0.pop();
    }
}

impl Script {
    /// Checks that each condition on the storyboard names one of its parts.
    ///
    /// # Errors
    /// When a name has no part, or several that are equally near.
    pub fn check_names(&self) -> Result<(), NotFound> {
        match Plan::of(self) {
            Err(WorldError::Element(not_found)) => Err(not_found),
            _ => Ok(()),
        }
    }
}

/// The part of a name, or of a path from any level with `::`. If several have it, the nearest to the part that names it counts: a catalog's maneuver that is
/// used several times means its own events.
fn find(
    elements: &[Element],
    kind: ElementKind,
    name: &str,
    from: Option<usize>,
) -> Result<usize, NotFound> {
    let holds = |index: usize, inner: usize| (index..elements[index].end).contains(&inner);
    // Levels that a part has in common with the part that names it.
    let levels = |found: usize| {
        let shared =
            |&index: &usize| from.is_some_and(|from| holds(index, from) && holds(index, found));
        (0..elements.len()).filter(shared).count()
    };
    let matches = |element: &Element| {
        element.kind == kind
            && (element.path == name
                || element.path.strip_suffix(name).is_some_and(|rest| rest.ends_with("::")))
    };
    let mut found: Vec<usize> =
        (0..elements.len()).filter(|index| matches(&elements[*index])).collect();
    found.sort_by_key(|index| std::cmp::Reverse(levels(*index)));
    let names = || {
        let of_kind = elements.iter().filter(|element| element.kind == kind);
        crate::error::one_of(of_kind.map(|element| element.path.as_str()))
    };
    match found[..] {
        [nearest] => Ok(nearest),
        [nearest, next, ..] if levels(nearest) > levels(next) => Ok(nearest),
        [] => Err(NotFound {
            name: name.to_owned(),
            reason: format!("the storyboard has no {} `{name}`", kind.word()),
            expected: match elements.iter().any(|element| element.kind == kind) {
                true => names(),
                false => format!("the name of one, and there is no {}", kind.word()),
            },
        }),
        [..] => Err(NotFound {
            name: name.to_owned(),
            reason: format!("the storyboard has several parts called `{name}`"),
            expected: format!("a path: {}", names()),
        }),
    }
}
