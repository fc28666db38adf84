//! The vehicles that a ground truth lists.
//!
//! A ground truth lists the vehicles that are on the road, without their names. Their order is that of the scenario's
//! actors.

use messages::AllVehicles;
use scenario::Scenario;

/// The actors of a scenario, with the times at which they are on the road.
#[derive(Clone, Debug)]
pub(crate) struct Present {
    actors: Vec<Actor>,
}

#[derive(Clone, Copy, Debug)]
struct Actor {
    appears_ns: u64,
    leaves_ns: u64,
    length_m: f64,
}

impl Present {
    pub(crate) fn of(scenario: &Scenario) -> Self {
        let actors = scenario.actors.iter().map(|actor| Actor {
            appears_ns: actor.appears_at_s.nanoseconds(),
            leaves_ns: actor.leaves_at_s.map_or(u64::MAX, |time| time.nanoseconds()),
            length_m: actor.length_m.value(),
        });
        Self { actors: actors.collect() }
    }

    /// Place in the scenario of the vehicle at `place` in `truth`. `None` if the truth lists other vehicles than the
    /// scenario's times do, as with a storyboard.
    pub(crate) fn actor(&self, truth: &AllVehicles, place: usize) -> Option<u32> {
        let time_ns = truth.header.acquisition_ns.unsigned_abs();
        let is_present = |actor: &Actor| (actor.appears_ns..actor.leaves_ns).contains(&time_ns);
        let listed = self.actors.iter().enumerate().filter(|(_, actor)| is_present(actor));
        let is_whole = listed.clone().count() == truth.vehicles.len();
        let found = listed.map(|(index, _)| index).nth(place).filter(|_| is_whole)?;
        u32::try_from(found).ok()
    }

    /// Length of the vehicle at `place` in `truth`, m. For an unknown one the shortest, so that no contact is invented.
    pub(crate) fn length_m(&self, truth: &AllVehicles, place: usize) -> f64 {
        let lengths = || self.actors.iter().map(|actor| actor.length_m);
        match self.actor(truth, place) {
            Some(actor) => self.actors[actor as usize].length_m,
            None => lengths().reduce(f64::min).unwrap_or(0.0),
        }
    }
}

/// Place in `truth` of the vehicle in lane whose rear is `gap_m` ahead of `ego_m`.
pub(crate) fn place_at(truth: &AllVehicles, ego_m: f64, gap_m: f64) -> Option<usize> {
    truth
        .vehicles
        .iter()
        .position(|vehicle| vehicle.in_lane != 0 && vehicle.rear_position_m - ego_m == gap_m)
}

/// The item of `step`, or of a time, from a sequence in their order; skips earlier items.
pub(crate) fn take_step<'a, T, K: Ord>(
    items: &mut std::iter::Peekable<std::slice::Iter<'a, T>>,
    step: K,
    step_of: impl Fn(&T) -> K,
) -> Option<&'a T> {
    while items.next_if(|item| step_of(item) < step).is_some() {}
    items.next_if(|item| step_of(item) == step)
}

/// Puts second messages to the first ones of their steps. A second message is sent before the first one: those of later
/// steps stay in `waiting`. `steps` gives the step of a first and of a second message.
pub(crate) fn join<F, M>(
    firsts: &mut [F],
    waiting: &mut Vec<M>,
    steps: (impl Fn(&F) -> u64, impl Fn(&M) -> u64),
    put: impl Fn(&mut F, &M),
) {
    waiting.retain(|second| {
        let step = steps.1(second);
        let waits = firsts.last().is_none_or(|last| steps.0(last) < step);
        let first = firsts.iter_mut().rev().find(|first| steps.0(first) <= step);
        if let Some(first) = first.filter(|first| steps.0(first) == step) {
            put(first, second);
        }
        waits
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::VehicleTruthItem;

    #[test]
    fn a_vehicle_that_left_does_not_shift_the_others() {
        let actor = |name: &str, more: &str| {
            format!("[[actors]]\nname = \"{name}\"\ngap_m = 30\ninitial_speed_mps = 20\n{more}\n")
        };
        let text = format!(
            "schema_version = 1\nname = \"x\"\n{}{}",
            actor("first", "leaves_at_s = 2\nlength_m = 4"),
            actor("second", "length_m = 12")
        );
        let present = Present::of(&Scenario::parse("x", &text).expect("valid"));
        let mut truth = AllVehicles::with_room(2);
        truth.vehicles = vec![VehicleTruthItem::zeroed(); 2];
        truth.header.acquisition_ns = 1_000_000_000;
        assert_eq!((present.actor(&truth, 1), present.length_m(&truth, 1)), (Some(1), 12.0));
        truth.header.acquisition_ns = 3_000_000_000;
        assert_eq!(present.actor(&truth, 0), None, "two are listed, one should be there");
        assert_eq!(present.length_m(&truth, 0), 4.0);
        truth.vehicles.truncate(1);
        assert_eq!((present.actor(&truth, 0), present.length_m(&truth, 0)), (Some(1), 12.0));
    }

    #[test]
    fn items_are_joined_by_step() {
        let items = [(0, 'a'), (5, 'b'), (10, 'c')];
        let mut iter = items.iter().peekable();
        let mut at = |step| take_step(&mut iter, step, |item| item.0).map(|item| item.1);
        assert_eq!([at(0), at(1), at(6), at(10), at(11)], [Some('a'), None, None, Some('c'), None]);
    }
}
