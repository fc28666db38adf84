//! Init, stories, acts, groups, maneuvers, events.

use super::Reader;
use crate::error::ReadError;
use crate::model::InitAction;
use crate::model::action::{Action, Dimension, Shape};
use crate::model::storyboard::{Act, Event, Maneuver, ManeuverGroup, NamedAction, Priority, Story};
use crate::node::Node;

impl Reader<'_> {
    /// The actions of Init: teleports first, then speeds, then the rest, each in the file's order.
    pub(super) fn init(&self, node: Node<'_>) -> Result<Vec<InitAction>, ReadError> {
        let mut init = Vec::new();
        let actions = node.child("Actions")?;
        for global in actions.named("GlobalAction") {
            init.push(InitAction { actor: None, action: self.global(global)? });
        }
        let mut placed = vec![false; self.entities.len()];
        for private in actions.named("Private") {
            let actor = self.entity_ref(private)?;
            for node in private.children() {
                let action = self.private(node)?;
                placed[actor] |= matches!(action, Action::Teleport(_));
                if actor == self.ego {
                    self.check_ego_init(node, &action)?;
                }
                init.push(InitAction { actor: Some(actor), action });
            }
        }
        let added = |entity: usize| {
            init.iter().any(|i| matches!(i.action, Action::Add { entity: e, .. } if e == entity))
        };
        if !placed[self.ego] {
            let name = &self.entities[self.ego].name;
            return Err(
                node.refuse(format!("the ego `{name}` is not placed"), "a `TeleportAction` for it")
            );
        }
        for (entity, placed) in placed.iter().enumerate() {
            if !placed && !added(entity) {
                self.notice(format!(
                    "`{}` has no place in Init: it is not on the road until it is added or teleported",
                    self.entities[entity].name
                ));
            }
        }
        init.sort_by_key(|item| match item.action {
            Action::Add { .. } | Action::Teleport(_) => 0,
            Action::Speed { .. } => 1,
            _ => 2,
        });
        Ok(init)
    }

    /// Of the ego, Init sets place and speed at once; the rest is its stack's affair.
    fn check_ego_init(&self, node: Node<'_>, action: &Action) -> Result<(), ReadError> {
        match action {
            Action::Teleport(_) | Action::Nothing => Ok(()),
            Action::Speed { transition, .. }
                if transition.shape == Shape::Step
                    || (transition.dimension != Dimension::Rate && transition.value == 0.0) =>
            {
                Ok(())
            }
            _ => Err(node.refuse(
                "timegap's stack drives the ego from the start",
                "in Init a teleport, a speed with shape step, or a controller action for it",
            )),
        }
    }

    pub(super) fn stories(&self, storyboard: Node<'_>) -> Result<Vec<Story>, ReadError> {
        let mut stories = Vec::new();
        for (i, node) in storyboard.named("Story").enumerate() {
            let scope = node.scope.with(node.file, node.element, &[])?;
            let inner = Node { scope: &scope, ..node };
            let acts = inner.named("Act").map(|act| self.act(act)).collect::<Result<_, _>>()?;
            let name = node.text_if("name")?.unwrap_or_else(|| format!("story {}", i + 1));
            stories.push(Story { name, acts });
        }
        Ok(stories)
    }

    fn act(&self, node: Node<'_>) -> Result<Act, ReadError> {
        let trigger = |name| node.child_if(name).map(|node| self.trigger(node)).transpose();
        Ok(Act {
            name: node.text("name")?,
            start: trigger("StartTrigger")?,
            stop: trigger("StopTrigger")?,
            groups: node.named("ManeuverGroup").map(|g| self.group(g)).collect::<Result<_, _>>()?,
        })
    }

    fn group(&self, node: Node<'_>) -> Result<ManeuverGroup, ReadError> {
        let list = node.child("Actors")?;
        if list.boolean("selectTriggeringEntities")? {
            let fault = list.fault("selectTriggeringEntities");
            return Err(fault.error("actors chosen by their triggers are not supported", "false"));
        }
        let actors = self.entity_refs(list)?;
        let mut maneuvers = Vec::new();
        for maneuver in node.children() {
            match maneuver.name() {
                "Maneuver" => {
                    let scope = maneuver.scope.with(maneuver.file, maneuver.element, &[])?;
                    maneuvers.push(self.maneuver(Node { scope: &scope, ..maneuver }, &actors)?);
                }
                "CatalogReference" => {
                    let locations = self.root.child_if("CatalogLocations");
                    let found = &mut |entry: Node<'_>| self.maneuver(entry, &actors);
                    maneuvers.push(self.library.entry(
                        maneuver,
                        locations,
                        &["Maneuver"],
                        found,
                    )?);
                }
                _ => {}
            }
        }
        let name = node.text("name")?;
        Ok(ManeuverGroup { name, executions: executions(node)?, actors, maneuvers })
    }

    fn maneuver(&self, node: Node<'_>, actors: &[usize]) -> Result<Maneuver, ReadError> {
        let events = node.named("Event").map(|event| self.event(event, actors));
        Ok(Maneuver { name: node.text("name")?, events: events.collect::<Result<_, _>>()? })
    }

    fn event(&self, node: Node<'_>, actors: &[usize]) -> Result<Event, ReadError> {
        let priorities = [
            ("overwrite", Priority::Override),
            ("override", Priority::Override),
            ("skip", Priority::Skip),
            ("parallel", Priority::Parallel),
        ];
        let mut actions = Vec::new();
        for holder in node.named("Action") {
            let what = holder.children().next().expect("the subset demands one");
            let action = match what.name() {
                "GlobalAction" => self.global(what)?,
                _ if actors.is_empty() => {
                    return Err(what.refuse("the group has no actor for it", "an `EntityRef`"));
                }
                _ => self.private(what)?,
            };
            if actors.contains(&self.ego) && what.name() == "PrivateAction" {
                self.note_ego(&action);
            }
            actions.push(NamedAction { name: holder.text("name")?, action });
        }
        let start = node.child_if("StartTrigger").map(|node| self.trigger(node)).transpose()?;
        Ok(Event {
            name: node.text("name")?,
            priority: node.word("priority", &priorities)?,
            executions: executions(node)?,
            start,
            actions,
        })
    }

    fn note_ego(&self, action: &Action) {
        if *action != Action::Nothing {
            self.notice(
                "actions of the ego take their time in the storyboard and do not move it: timegap's stack drives it"
                    .to_owned(),
            );
        }
    }
}

fn executions(node: Node<'_>) -> Result<u32, ReadError> {
    if node.element.attribute("maximumExecutionCount").is_none() {
        return Ok(1);
    }
    match node.integer("maximumExecutionCount")? {
        count @ 1.. => Ok(count.unsigned_abs()),
        count => Err(node.fault("maximumExecutionCount").error(format!("{count}"), "1 or more")),
    }
}
