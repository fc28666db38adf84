//! Figures over the drives of some sources, and their columns.

use group::report::Outcome;
use report::results::{Column, count, number, word};
use report::targets::{Place, Sums};
use serde::Serialize;

use super::judge::Kept;
use super::scene::Scene;

/// Share of a drive, and rate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Often {
    /// Share of the time.
    pub share: f64,
    /// Times per km.
    pub per_km: f64,
}

impl Often {
    fn of(part_s: f64, whole_s: f64, times: u64, km: f64) -> Self {
        let share = if whole_s > 0.0 { part_s / whole_s } else { 0.0 };
        let per_km = if km > 0.0 { times as f64 / km } else { 0.0 };
        Self { share, per_km }
    }

    fn lost(sums: &Sums) -> Self {
        Self::of(sums.lost_s, sums.lead_s, sums.losses, sums.km)
    }

    fn taken(sums: &Sums) -> Self {
        Self::of(sums.taken_s, sums.time_s, sums.takings, sums.km)
    }
}

/// Figures of some sources. Lead and neighbours are those of the random roads.
#[derive(Clone, Debug, Serialize)]
pub struct Figures {
    /// Name of the sources.
    pub sources: &'static str,
    /// Way on the random roads, km.
    pub km: f64,
    /// The lead was not the target: share of the time with a lead within reach.
    pub lead_lost: Often,
    /// A neighbour was the target.
    pub neighbour_taken: Often,
    /// Share of the time with a target that is not a vehicle.
    pub nothing_taken_share: f64,
    /// Interventions on random roads and beside queues.
    pub phantom_interventions: u64,
    /// Drives beside a queue.
    pub beside: usize,
    /// Share of them that the law braked as before a vehicle.
    pub braked_share: f64,
    /// Drives with a queue in the lane.
    pub in_lane: usize,
    /// Collisions of all scenes.
    pub collisions: usize,
    /// Those that braking from sight avoids.
    pub avoidable_collisions: usize,
    /// Queues in the lane that became the target too late.
    pub seen_late: usize,
    /// Time from sight to the target that 99 % of the queues in the lane kept, s.
    pub seen_after_p99_s: Option<f64>,
    /// Largest lateral acceleration, m/s².
    pub largest_lateral_mps2: f64,
}

impl Figures {
    /// The figures over these drives, all of the same sources.
    pub fn of(sources: &'static str, runs: &[&Kept]) -> Self {
        let of_scene = |scene| runs.iter().filter(move |run| run.scene == scene);
        let mut sums = Sums::default();
        of_scene(Scene::Road).for_each(|run| sums.add(&run.sums()));
        let share = |part: usize, whole: usize| part as f64 / whole.max(1) as f64;
        let beside = of_scene(Scene::Beside).count();
        let mut seen: Vec<f64> = of_scene(Scene::InLane)
            .map(|run| run.sight.and_then(|sight| sight.seen_after_s).unwrap_or(f64::INFINITY))
            .collect();
        seen.sort_by(f64::total_cmp);
        let place = ((0.99 * seen.len() as f64).ceil() as usize).saturating_sub(1);
        Self {
            sources,
            km: sums.km,
            lead_lost: Often::lost(&sums),
            neighbour_taken: Often::taken(&sums),
            nothing_taken_share: Often::of(sums.nothing_s, sums.time_s, 0, 0.0).share,
            phantom_interventions: runs.iter().map(|run| run.phantom_interventions()).sum(),
            beside,
            braked_share: share(
                of_scene(Scene::Beside).filter(|run| run.is_braked()).count(),
                beside,
            ),
            in_lane: of_scene(Scene::InLane).count(),
            collisions: runs.iter().filter(|run| run.outcome == Outcome::Collision).count(),
            avoidable_collisions: runs.iter().filter(|run| run.is_avoidable()).count(),
            seen_late: runs.iter().filter(|run| run.is_seen_late()).count(),
            seen_after_p99_s: seen.get(place).copied().filter(|after| after.is_finite()),
            largest_lateral_mps2: runs
                .iter()
                .map(|run| run.largest_lateral_mps2)
                .fold(0.0, f64::max),
        }
    }
}

/// Figures of one part of the curves on the random roads.
#[derive(Clone, Debug, Serialize)]
pub struct PlaceFigures {
    /// Name of the sources.
    pub sources: &'static str,
    /// Part of a curve.
    pub place: Place,
    /// Way in it, km.
    pub km: f64,
    /// As in [`Figures`].
    pub lead_lost: Often,
    /// As in [`Figures`].
    pub neighbour_taken: Often,
}

impl PlaceFigures {
    /// The figures of each part.
    pub fn all(sources: &'static str, runs: &[&Kept]) -> Vec<Self> {
        let parts = Place::ALL.into_iter().enumerate().map(|(index, place)| {
            let mut sums = Sums::default();
            let roads = runs.iter().filter(|run| run.scene == Scene::Road);
            roads.for_each(|run| sums.add(&run.places[index]));
            let (lead_lost, neighbour_taken) = (Often::lost(&sums), Often::taken(&sums));
            Self { sources, place, km: sums.km, lead_lost, neighbour_taken }
        });
        parts.collect()
    }
}

/// A share from 0 to 1.
const fn share<R>(name: &'static str, heading: &'static str, meaning: &'static str) -> Column<R> {
    number(name, heading, "", 4, meaning)
}

/// Columns of a row with sums.
const fn sums<R>() -> [Column<R>; 5] {
    [
        number("km", "way", "km", 1, "Way on the random roads"),
        share(
            "lead_lost.share",
            "lead lost",
            "Share of the time with a lead within 100 m in which the target is not the lead",
        )
        .less(),
        number(
            "lead_lost.per_km",
            "lost per km",
            "",
            3,
            "Number of times per km that the lead was lost",
        )
        .less(),
        share(
            "neighbour_taken.share",
            "neighbour taken",
            "Share of the time in which the target is a vehicle beside the lane",
        )
        .less(),
        number(
            "neighbour_taken.per_km",
            "taken per km",
            "",
            3,
            "Number of times per km that such a vehicle became the target",
        )
        .less(),
    ]
}

/// Columns of [`Figures`].
pub fn columns() -> Vec<Column<Figures>> {
    let rest = [
        share("nothing_taken_share", "nothing taken", "Share of the time in which the target is not a vehicle").less().weight(1),
        count("phantom_interventions", "phantom brakings", "Interventions of the emergency brake on random roads and beside queues").less(),
        count("beside", "", "Drives beside a queue").hidden(),
        share("braked_share", "braked beside", "Share of the drives beside a queue with a request below -1.5 m/s²").less(),
        count("in_lane", "", "Drives with a queue in the lane").hidden(),
        count("collisions", "collisions", "Collisions of all scenes").less(),
        count("avoidable_collisions", "avoidable", "Collisions that 6 m/s² from sight avoids").less(),
        count("seen_late", "seen late", "Queues in the lane that became the target later than 0.5 s after sight, or never").less(),
        number("seen_after_p99_s", "seen after, p99", "s", 2, "Time from sight to the target that 99 % of the queues kept; null where more never became one").less().weight(1),
        number("largest_lateral_mps2", "lateral", "m/s²", 2, "Largest lateral acceleration").weight(2),
    ];
    [word("sources", "course from", "Sources of the course; each row has those above it too")]
        .into_iter()
        .chain(sums())
        .chain(rest)
        .collect()
}

/// Columns of [`PlaceFigures`].
pub fn place_columns() -> Vec<Column<PlaceFigures>> {
    let words = [
        word("sources", "course from", "Sources of the course"),
        word(
            "place",
            "part",
            "Part of a curve between the ego and the lead: straight, entry, arc or exit",
        ),
    ];
    words.into_iter().chain(sums()).collect()
}

#[cfg(test)]
mod tests {
    use super::super::judge::tests::example;
    use super::*;

    #[test]
    fn shares_are_of_the_time_with_a_lead_and_rates_of_the_way() {
        let mut road = example(Scene::Road, "x");
        road.places[0] =
            Sums { lost_s: 1.5, losses: 2, taken_s: 2.0, takings: 1, ..road.places[0] };
        let mut beside = example(Scene::Beside, "x");
        beside.places[0] = Sums { taken_s: 10.0, takings: 9, ..beside.places[0] };
        beside.lowest_request_mps2 = Some(-1.6);
        beside.interventions = 1;
        let in_lane = Kept { interventions: 5, ..example(Scene::InLane, "x") };
        let figures = Figures::of("x", &[&road, &beside, &in_lane]);
        assert_eq!(figures.km, 5.0, "random roads alone");
        assert_eq!(figures.lead_lost, Often { share: 0.01, per_km: 0.4 });
        assert_eq!(figures.neighbour_taken, Often { share: 0.01, per_km: 0.2 });
        assert_eq!((figures.phantom_interventions, figures.braked_share), (1, 1.0));
        assert_eq!((figures.seen_late, figures.seen_after_p99_s), (0, Some(0.4)));
        let parts = PlaceFigures::all("x", &[&road, &beside]);
        assert_eq!((parts[0].km, parts[1].km), (5.0, 0.0));
    }
}
