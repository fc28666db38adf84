//! Quality of the tracks by ground truth.
//!
//! * GOSPA (generalised optimal sub-pattern assignment) has c = 10 m, p = 2, alpha = 2. It is taken on the positions
//!   (gap, lateral) of all vehicles whose rear is in range and field of view. Hidden ones are included. A track on the
//!   body of any other vehicle is neither right nor false. At most a part of that vehicle is in view:
//!
//! ```text
//! d² = min over assignments  Σ assigned |x - y|²  +  c²/2 · (missed + false)
//! ```
//!
//! The figures are root mean squares over the scans. So the squares of localisation, missed and false add up to that of
//! the whole.
//! * Time to confirm a cut-in. It lasts from the overlap of the bodies' lanes to the publication of a track of it that
//!   is in the path. It is negative for an earlier recognition.
//! * False targets: selected targets without a vehicle, or with a vehicle that neither overlaps the ego's lane nor
//!   moves towards it.
//!
//! Source: Rahmathullah, García-Fernández and Svensson, Generalized optimal sub-pattern assignment
//! metric (FUSION 2017).

use crate::report::PerceptionReport;
use messages::MAX_TRACKS;
use scenario::Scenario;

use crate::assignment::{Assignment, CUTOFF_M};
use crate::radar::object_list::View;
use crate::radar::scene::Scene;
use crate::tracking::TrackList;
use crate::vehicle::Vehicle;

/// Inward speed from which a vehicle beside the path is a right target, m/s.
const INWARD_MPS: f64 = 0.1;

#[derive(Clone, Debug, Default)]
pub struct Quality {
    view: View,
    scans: u64,
    localisation: f64,
    missed: u64,
    false_tracks: u64,
    left_out: u64,
    targets: Targets,
    cut_ins: Vec<CutIn>,
    /// Room: the vehicles in view.
    in_view: Vec<bool>,
    confirmed: Confirmed,
    last_ns: Option<i64>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Targets {
    episodes: u64,
    false_s: f64,
    is_false: bool,
}

/// A vehicle on its way into the path.
#[derive(Clone, Copy, Debug, Default)]
struct CutIn {
    /// It has been beside the lane.
    outside: bool,
    /// Start of its overlap, if it has not been confirmed since.
    overlaps_ns: Option<i64>,
    /// Start of the time for which a track of it has been in the path.
    in_path_ns: Option<i64>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Confirmed {
    count: u64,
    sum_s: f64,
    worst_s: f64,
}

impl Quality {
    /// Before the first scan.
    pub fn new(scenario: &Scenario) -> Self {
        Self {
            view: View::new(&scenario.perception.radar),
            cut_ins: Vec::with_capacity(scenario.actors.len()),
            in_view: Vec::with_capacity(scenario.actors.len()),
            confirmed: Confirmed { worst_s: f64::NEG_INFINITY, ..Confirmed::default() },
            ..Self::default()
        }
    }

    /// Judges the tracks of the scan of `scene`, published at `published_ns`.
    pub fn observe(&mut self, scene: &Scene, list: &TrackList, published_ns: i64) {
        let vehicles = 0..scene.vehicles.len();
        self.in_view.clear();
        let seen = vehicles.clone().map(|vehicle| self.view.shows(scene, vehicle));
        self.in_view.extend(seen);
        let pairs = Assignment::best(scene, &self.in_view, list);
        let visible = self.in_view.iter().filter(|seen| **seen).count() as u64;
        self.scans += 1;
        self.localisation += pairs.squares;
        self.missed += visible - pairs.count;
        self.false_tracks += list.count as u64 - pairs.count - pairs.partly;
        self.left_out += u64::from(list.left_out);
        self.judge_target(scene, list, &pairs.vehicle_of, published_ns);
        self.cut_ins.resize_with(scene.vehicles.len().max(self.cut_ins.len()), CutIn::default);
        for index in vehicles {
            let in_path = pairs.track_of(index).is_some_and(|track| list.tracks[track].in_path);
            let ahead = self.in_view[index];
            self.judge_cut_in(
                index,
                &scene.vehicles[index],
                ahead,
                in_path,
                scene.time_ns,
                published_ns,
            );
        }
        self.last_ns = Some(published_ns);
    }

    fn judge_target(
        &mut self,
        scene: &Scene,
        list: &TrackList,
        owners: &[Option<u8>; MAX_TRACKS],
        now_ns: i64,
    ) {
        let is_false = list.target.is_some_and(|target| {
            owners[target].is_none_or(|owner| {
                let vehicle = &scene.vehicles[usize::from(owner)];
                let inward_mps = -vehicle.lateral_speed_mps * vehicle.lateral_m.signum();
                !vehicle.in_ego_path() && inward_mps < INWARD_MPS
            })
        });
        if is_false {
            self.targets.episodes += u64::from(!self.targets.is_false);
            let dt_ns = self.last_ns.map_or(0, |last| now_ns - last);
            self.targets.false_s += dt_ns as f64 * 1e-9;
        }
        self.targets.is_false = is_false;
    }

    fn judge_cut_in(
        &mut self,
        index: usize,
        vehicle: &Vehicle,
        in_view: bool,
        in_path: bool,
        time_ns: i64,
        published_ns: i64,
    ) {
        let state = &mut self.cut_ins[index];
        if !vehicle.present || !in_view {
            *state = CutIn::default();
            return;
        }
        state.in_path_ns = in_path.then(|| state.in_path_ns.unwrap_or(published_ns));
        if !vehicle.in_ego_path() {
            state.outside = true;
            state.overlaps_ns = None;
            return;
        }
        if state.outside {
            state.outside = false;
            state.overlaps_ns = Some(time_ns);
        }
        if let (Some(overlaps_ns), Some(confirmed_ns)) = (state.overlaps_ns, state.in_path_ns) {
            let delay_s = (confirmed_ns - overlaps_ns) as f64 * 1e-9;
            self.confirmed.count += 1;
            self.confirmed.sum_s += delay_s;
            self.confirmed.worst_s = self.confirmed.worst_s.max(delay_s);
            state.overlaps_ns = None;
        }
    }

    /// The figures so far, but for what only the radar counts.
    pub fn figures(&self) -> PerceptionReport {
        let scans = (self.scans as f64).max(1.0);
        let rms = |sum: f64| (sum / scans).sqrt();
        let penalty = 0.5 * CUTOFF_M * CUTOFF_M;
        let (missed, false_) = (penalty * self.missed as f64, penalty * self.false_tracks as f64);
        let some = self.confirmed.count > 0;
        PerceptionReport {
            scans: self.scans,
            gospa_m: rms(self.localisation + missed + false_),
            localisation_m: rms(self.localisation),
            missed_m: rms(missed),
            false_m: rms(false_),
            tracks_left_out: self.left_out,
            cut_ins: self.confirmed.count,
            cut_in_mean_s: some.then(|| self.confirmed.sum_s / self.confirmed.count as f64),
            cut_in_worst_s: some.then_some(self.confirmed.worst_s),
            cut_ins_unconfirmed: self.cut_ins.iter().filter(|c| c.overlaps_ns.is_some()).count()
                as u64,
            false_targets: self.targets.episodes,
            false_target_s: self.targets.false_s,
            ..PerceptionReport::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::radar::scene::Ego;
    use crate::tracking::Track;

    fn quality() -> Quality {
        let text = "schema_version = 1\nname = \"x\"\n";
        Quality::new(&Scenario::parse("x.toml", text).expect("it is right"))
    }

    fn car(gap_m: f64, lateral_m: f64) -> Vehicle {
        Vehicle {
            present: true,
            rear_position_m: gap_m,
            lateral_m,
            length_m: 4.5,
            touches_within_m: 1.8,
            ..Vehicle::default()
        }
    }

    fn scene(time_ns: i64, vehicles: &[Vehicle]) -> Scene {
        Scene::new(time_ns, Ego::default(), vehicles)
    }

    fn list(tracks: &[(f64, f64, bool)]) -> TrackList {
        let mut list = TrackList::new(0);
        for &(gap_m, lateral_m, in_path) in tracks {
            list.add(Track { gap_m, lateral_m, in_path, ..Track::default() });
        }
        list.finish();
        list
    }

    #[test]
    fn gospa_is_split_as_published() {
        // Two vehicles, one of them tracked 3 m off; one track of nothing.
        let mut quality = quality();
        let scene = scene(0, &[car(50.0, 0.0), car(90.0, 3.5)]);
        quality.observe(&scene, &list(&[(53.0, 0.0, true), (120.0, 0.0, false)]), 0);
        let figures = quality.figures();
        assert!((figures.localisation_m - 3.0).abs() < 1e-12);
        assert!((figures.missed_m - 50f64.sqrt()).abs() < 1e-12);
        assert!((figures.false_m - 50f64.sqrt()).abs() < 1e-12);
        assert!((figures.gospa_m - (9.0f64 + 100.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn the_assignment_is_the_best_of_all_not_the_first() {
        // The first vehicle is nearest to the track that the second one needs.
        let scene = scene(0, &[car(50.0, 0.0), car(58.0, 0.0)]);
        let tracks = list(&[(43.0, 0.0, true), (53.0, 0.0, true)]);
        let pairs = Assignment::best(&scene, &[true, true], &tracks);
        assert_eq!((pairs.track_of(0), pairs.track_of(1)), (Some(0), Some(1)));
        assert!((pairs.squares - (49.0 + 25.0)).abs() < 1e-12);
    }

    #[test]
    fn a_vehicle_out_of_view_is_not_missed() {
        let mut quality = quality();
        quality.observe(&scene(0, &[car(-20.0, 3.5), car(500.0, 0.0)]), &list(&[]), 0);
        assert_eq!(quality.figures().gospa_m, 0.0);
    }

    #[test]
    fn a_cut_in_is_timed_from_the_overlap() {
        for (confirmed_at, delay_s) in [(3i64, -0.1), (5, 0.0), (9, 0.2)] {
            let mut quality = quality();
            for k in 0..20i64 {
                // It overlaps from the fifth scan on.
                let lateral_m = if k < 5 { 2.0 } else { 1.7 };
                let tracks = list(&[(50.0, lateral_m, k >= confirmed_at)]);
                let time_ns = k * 50_000_000;
                quality.observe(&scene(time_ns, &[car(50.0, lateral_m)]), &tracks, time_ns);
            }
            let figures = quality.figures();
            assert_eq!((figures.cut_ins, figures.cut_ins_unconfirmed), (1, 0));
            assert!((figures.cut_in_mean_s.expect("one") - delay_s).abs() < 1e-12);
        }
    }

    #[test]
    fn a_target_beside_the_lane_or_of_nothing_is_false() {
        let mut quality = quality();
        let inward = Vehicle { lateral_speed_mps: -1.0, ..car(50.0, 2.5) };
        for (k, vehicles, is_false) in
            [(0, [car(50.0, 0.0)], false), (1, [inward], false), (2, [car(50.0, 2.5)], true)]
        {
            let before = quality.figures().false_targets;
            let time_ns = k * 50_000_000;
            let tracks = list(&[(50.0, vehicles[0].lateral_m, true)]);
            quality.observe(&scene(time_ns, &vehicles), &tracks, time_ns);
            assert_eq!(quality.figures().false_targets - before, u64::from(is_false));
        }
        quality.observe(&scene(150_000_000, &[]), &list(&[(30.0, 0.0, true)]), 150_000_000);
        let figures = quality.figures();
        assert_eq!(figures.false_targets, 1, "the episode goes on");
        assert!((figures.false_target_s - 0.1).abs() < 1e-9);
    }
}
