//! One step of perception: traffic, radar, tracks, target.
//!
//! The radar has been on before the run begins: the scans that its latency holds back at the start
//! are those of the time before, in which everybody kept the speed of the start.

use messages::MAX_TRACKS;
use scenario::Scenario;
use scenario::perception::MAX_LATENCY_SCANS;

use crate::radar::{Detection, Ego, Radar, Scan};
use crate::target_selection::{Membership, PathLimits};
use crate::tracker::{Estimate, Model};
use crate::traffic::{Traffic, Vehicle};

/// Scans held back at most, and the newest one.
const HELD: usize = MAX_LATENCY_SCANS as usize + 1;

/// Time constant of the smoothing of lateral positions, s: a lane change takes some seconds.
const LATERAL_SMOOTHING_S: f64 = 0.3;

/// A track is given up, and begun anew, after this many scans in a row outside its gate.
const MISFITS: u32 = 3;

/// What a scan has led to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrackList {
    /// When the scan was taken, ns since the start of the run; before it: negative.
    pub acquisition_ns: i64,
    /// The tracks, nearest first; `count` are valid.
    pub tracks: [Track; MAX_TRACKS],
    /// Valid entries of `tracks`.
    pub count: usize,
    /// Index of the target among the tracks: the nearest one in the path.
    pub target: Option<usize>,
}

/// One vehicle as it is tracked, at the time of the scan.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Track {
    /// Identity: a new number means a new vehicle, or the same one found again.
    pub id: u32,
    /// The last measurement.
    pub detection: Detection,
    /// It was measured in this scan; otherwise the estimates are predictions.
    pub measured: bool,
    /// Bumper-to-bumper distance, m.
    pub gap_m: f64,
    /// Its speed minus the ego's, m/s.
    pub relative_speed_mps: f64,
    /// Its acceleration, m/s².
    pub acceleration_mps2: f64,
    /// Lateral position of its centre, m, left positive.
    pub lateral_m: f64,
    /// It is in the ego's path.
    pub in_path: bool,
}

/// The other vehicles and all that the ego perceives of them.
#[derive(Clone, Debug)]
pub struct Perception {
    traffic: Traffic,
    radar: Radar,
    model: Model,
    limits: PathLimits,
    ideal: bool,
    period_ns: u64,
    latency_scans: usize,
    coast_s: f64,
    held: Box<[Held; HELD]>,
    taken: usize,
    filters: [Option<Filter>; MAX_TRACKS],
    last_processed_ns: Option<i64>,
    next_id: u32,
    list: TrackList,
}

/// A scan and what else was true at its time.
#[derive(Clone, Copy, Debug, Default)]
struct Held {
    time_ns: i64,
    scan: Scan,
    ego: Ego,
    vehicles: [Vehicle; MAX_TRACKS],
}

/// What is known of one vehicle.
#[derive(Clone, Copy, Debug)]
struct Filter {
    id: u32,
    estimate: Estimate,
    lateral_m: f64,
    membership: Membership,
    detection: Detection,
    measured: bool,
    unseen_s: f64,
    misfits: u32,
}

impl Perception {
    /// The perception of a scenario, before the start.
    #[must_use]
    pub fn new(scenario: &Scenario) -> Self {
        let perception = &scenario.perception;
        let ideal = perception.ideal;
        let latency = perception.radar.latency_ms.value() / perception.period_ms.value();
        Self {
            traffic: Traffic::new(scenario),
            radar: Radar::new(scenario),
            model: Model::new(perception),
            limits: PathLimits::new(&perception.target_selection, ideal),
            ideal,
            period_ns: perception.period_ms.nanoseconds(),
            latency_scans: if ideal { 0 } else { latency.min(MAX_LATENCY_SCANS) as usize },
            coast_s: perception.tracker.coast_s.value(),
            held: Box::new([Held::default(); HELD]),
            taken: 0,
            filters: [None; MAX_TRACKS],
            last_processed_ns: None,
            next_id: 1,
            list: TrackList::default(),
        }
    }

    /// Takes the scan of `time_ns` with the ego as it truly is then, and returns the tracks of the
    /// scan that the radar's latency lets out now. Called once in each period; a period that was
    /// missed may be left out.
    pub fn step(&mut self, time_ns: u64, ego: &Ego) -> &TrackList {
        self.traffic.advance(time_ns, ego.position_m);
        if self.taken == 0 {
            self.warm_up(time_ns, ego);
        }
        let time_ns = i64::try_from(time_ns).unwrap_or(i64::MAX);
        self.take(time_ns, ego, &self.vehicles_array());
        let out = self.held[(self.taken - 1 - self.latency_scans) % HELD];
        self.process(&out);
        &self.list
    }

    /// The traffic, for what of it outlives the process.
    pub fn traffic(&mut self) -> &mut Traffic {
        &mut self.traffic
    }

    /// The other vehicles as they truly are, in the scenario's order.
    #[must_use]
    pub fn vehicles(&self) -> &[Vehicle] {
        self.traffic.vehicles()
    }

    /// Takes the scans that lie before the first one by less than the latency.
    fn warm_up(&mut self, time_ns: u64, ego: &Ego) {
        let now = self.vehicles_array();
        for back in (1..=self.latency_scans as u64).rev() {
            let back_ns = back * self.period_ns;
            let back_s = back_ns as f64 * 1e-9;
            let past = Ego {
                position_m: ego.position_m - ego.speed_mps * back_s,
                acceleration_mps2: 0.0,
                ..*ego
            };
            let vehicles = now.map(|vehicle| Vehicle {
                rear_position_m: vehicle.rear_position_m - vehicle.speed_mps * back_s,
                acceleration_mps2: 0.0,
                ..vehicle
            });
            let time_ns = i64::try_from(time_ns).unwrap_or(i64::MAX) - back_ns as i64;
            self.take(time_ns, &past, &vehicles);
        }
    }

    fn vehicles_array(&self) -> [Vehicle; MAX_TRACKS] {
        let mut vehicles = [Vehicle::default(); MAX_TRACKS];
        for (slot, vehicle) in vehicles.iter_mut().zip(self.traffic.vehicles()) {
            *slot = *vehicle;
        }
        vehicles
    }

    fn take(&mut self, time_ns: i64, ego: &Ego, vehicles: &[Vehicle; MAX_TRACKS]) {
        let count = self.traffic.vehicles().len();
        let scan = self.radar.scan(ego, &vehicles[..count]);
        self.held[self.taken % HELD] = Held { time_ns, scan, ego: *ego, vehicles: *vehicles };
        self.taken += 1;
    }

    fn process(&mut self, held: &Held) {
        let first = self.last_processed_ns.is_none();
        let dt_s = self.last_processed_ns.map_or(0.0, |last| (held.time_ns - last) as f64 * 1e-9);
        self.last_processed_ns = Some(held.time_ns);
        for i in 0..MAX_TRACKS {
            let mut filter = self.filters[i].take();
            if let Some(known) = &mut filter {
                self.model.predict(&mut known.estimate, dt_s, held.ego.acceleration_mps2);
                known.unseen_s += dt_s;
                known.measured = false;
            }
            if let Some(detection) = held.scan[i] {
                filter = Some(match filter {
                    known if self.ideal => {
                        let known = known.unwrap_or_else(|| self.begin(detection, true));
                        self.exactly(known, detection, &held.ego, &held.vehicles[i], dt_s)
                    }
                    Some(known) => self.correct(known, detection, dt_s),
                    None => self.begin(detection, first),
                });
            }
            let coast_s = if self.ideal { 0.0 } else { self.coast_s };
            self.filters[i] = filter.filter(|known| known.unseen_s <= coast_s + 1e-9);
        }
        self.report(held.time_ns);
    }

    fn begin(&mut self, detection: Detection, long_known: bool) -> Filter {
        let (gap_m, lateral_m) = along_and_across(&detection);
        let mut membership = Membership::default();
        if long_known {
            membership = self.limits.long_known(lateral_m);
        } else {
            self.limits.observe(&mut membership, lateral_m, 0.0);
        }
        let id = self.next_id;
        self.next_id = self.next_id.wrapping_add(1).max(1);
        Filter {
            id,
            estimate: self.model.start(gap_m, detection.range_rate_mps),
            lateral_m,
            membership,
            detection,
            measured: true,
            unseen_s: 0.0,
            misfits: 0,
        }
    }

    /// A known track with a new measurement; a track that the measurements keep contradicting is
    /// begun anew.
    fn correct(&mut self, mut known: Filter, detection: Detection, dt_s: f64) -> Filter {
        let (gap_m, lateral_m) = along_and_across(&detection);
        if self.model.update(&mut known.estimate, gap_m, detection.range_rate_mps) {
            known.misfits = 0;
        } else {
            known.misfits += 1;
            if known.misfits >= MISFITS {
                return self.begin(detection, false);
            }
        }
        let weight = known.unseen_s / (LATERAL_SMOOTHING_S + known.unseen_s);
        known.lateral_m += weight * (lateral_m - known.lateral_m);
        self.limits.observe(&mut known.membership, known.lateral_m, dt_s);
        Filter { detection, measured: true, unseen_s: 0.0, ..known }
    }

    /// A track that is the truth.
    fn exactly(
        &self,
        mut filter: Filter,
        detection: Detection,
        ego: &Ego,
        vehicle: &Vehicle,
        dt_s: f64,
    ) -> Filter {
        filter.estimate.gap_m = vehicle.rear_position_m - ego.position_m;
        filter.estimate.relative_speed_mps = vehicle.speed_mps - ego.speed_mps;
        filter.estimate.acceleration_mps2 = vehicle.acceleration_mps2;
        self.limits.observe(&mut filter.membership, vehicle.lateral_m, dt_s);
        Filter { lateral_m: vehicle.lateral_m, detection, measured: true, unseen_s: 0.0, ..filter }
    }

    fn report(&mut self, time_ns: i64) {
        let mut list = TrackList { acquisition_ns: time_ns, ..TrackList::default() };
        for filter in self.filters.iter().flatten() {
            list.tracks[list.count] = Track {
                id: filter.id,
                detection: filter.detection,
                measured: filter.measured,
                gap_m: filter.estimate.gap_m.max(0.0),
                relative_speed_mps: filter.estimate.relative_speed_mps,
                acceleration_mps2: filter.estimate.acceleration_mps2,
                lateral_m: filter.lateral_m,
                in_path: filter.membership.in_path(),
            };
            list.count += 1;
        }
        list.tracks[..list.count].sort_unstable_by(|a, b| a.gap_m.total_cmp(&b.gap_m));
        list.target = list.tracks[..list.count].iter().position(|track| track.in_path);
        self.list = list;
    }
}

/// Gap and lateral position of a measurement, m.
fn along_and_across(detection: &Detection) -> (f64, f64) {
    let (range, azimuth) = (detection.range_m, detection.azimuth_rad);
    (range * libm::cos(azimuth), range * libm::sin(azimuth))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use scenario::Overrides;

    use super::*;

    const PERIOD_NS: u64 = 50_000_000;

    fn scenario(name: &str, keys: &[&str]) -> Scenario {
        let mut overrides = Overrides::new();
        for key in keys {
            overrides.set(key).unwrap_or_else(|error| panic!("{error}"));
        }
        Scenario::open(name, &overrides, &|_| Ok(())).unwrap_or_else(|error| panic!("{error}"))
    }

    const EXACT: [&str; 5] = [
        "perception.radar.range_sigma_m=0",
        "perception.radar.range_rate_sigma_mps=0",
        "perception.radar.azimuth_sigma_deg=0",
        "perception.radar.dropout_probability=0",
        "perception.radar.latency_ms=0",
    ];

    /// The ego at constant speed.
    fn ego(time_ns: u64, speed_mps: f64) -> Ego {
        Ego { position_m: speed_mps * time_ns as f64 * 1e-9, speed_mps, acceleration_mps2: 0.0 }
    }

    fn target(list: &TrackList) -> Option<Track> {
        list.target.map(|index| list.tracks[index])
    }

    #[test]
    fn ideal_tracks_are_the_truth_from_the_first_scan_on() {
        let mut perception = Perception::new(&scenario("cacc-b", &[]));
        for k in 0..200 {
            let ego = ego(k * PERIOD_NS, 15.0);
            let list = *perception.step(k * PERIOD_NS, &ego);
            let truth = perception.vehicles()[0];
            let track = target(&list).expect("the lead is in the path");
            assert_eq!(list.acquisition_ns, (k * PERIOD_NS) as i64);
            assert_eq!(track.id, 1);
            assert_eq!(track.gap_m, truth.rear_position_m - ego.position_m);
            assert_eq!(track.relative_speed_mps, truth.speed_mps - 15.0);
            assert_eq!(track.acceleration_mps2, truth.acceleration_mps2);
        }
    }

    #[test]
    fn a_noisy_lead_is_tracked_within_its_filters_errors() {
        let mut perception = Perception::new(&scenario("following", &[]));
        let (mut gap, mut speed, mut count) = (0.0, 0.0, 0.0);
        for k in 0..600 {
            let list = *perception.step(k * PERIOD_NS, &ego(k * PERIOD_NS, 22.0));
            if k < 20 {
                continue;
            }
            let track = target(&list).expect("the lead is in the path");
            // The truth has moved on by the latency of one scan.
            let truth = perception.vehicles()[0];
            let relative = truth.speed_mps - 22.0;
            let then =
                truth.rear_position_m - 22.0 * (k * PERIOD_NS) as f64 * 1e-9 - relative * 0.05;
            gap += (track.gap_m - then).powi(2);
            speed += (track.relative_speed_mps - relative).powi(2);
            count += 1.0;
        }
        let (gap, speed): (f64, f64) = ((gap / count).sqrt(), (speed / count).sqrt());
        assert!(gap > 0.02 && gap < 0.15, "gap off by {gap}");
        assert!(speed > 0.02 && speed < 0.15, "speed off by {speed}");
    }

    #[test]
    fn a_cut_in_and_a_cut_out_change_the_target_once_each() {
        for seed in 1..=20 {
            let seed = format!("seed={seed}");
            let mut perception = Perception::new(&scenario("cut-in", &[&seed]));
            let mut targets: Vec<(f64, Option<u32>)> = Vec::new();
            for k in 0..800 {
                let list = *perception.step(k * PERIOD_NS, &ego(k * PERIOD_NS, 22.0));
                let id = target(&list).map(|track| track.id);
                if targets.last().is_none_or(|last| last.1 != id) {
                    targets.push((k as f64 * 0.05, id));
                }
            }
            // No target, the car, perhaps a moment of none, the lorry.
            let seen: Vec<_> = targets.iter().filter_map(|(_, id)| *id).collect();
            assert_eq!(seen.len(), 2, "{seed}: {targets:?}");
            assert_eq!(targets[0].1, None);
            // The car crosses 1.6 m at 8.4 s and is smoothed and confirmed soon after; it crosses
            // 2.2 m again at 26.9 s.
            assert!((8.0..9.3).contains(&targets[1].0), "{seed}: {targets:?}");
            let lorry = targets.last().expect("there are some").0;
            assert!((26.5..29.0).contains(&lorry), "{seed}: {targets:?}");
        }
    }

    #[test]
    fn latency_delays_the_scan_and_nothing_else() {
        let mut keys = EXACT.to_vec();
        keys[4] = "perception.radar.latency_ms=150";
        let mut late = Perception::new(&scenario("following", &keys));
        let mut prompt = Perception::new(&scenario("following", &EXACT));
        let mut history = Vec::new();
        for k in 0..100u64 {
            let ego = ego(k * PERIOD_NS, 22.0);
            history.push(*prompt.step(k * PERIOD_NS, &ego));
            let list = *late.step(k * PERIOD_NS, &ego);
            assert_eq!(list.acquisition_ns, (k * PERIOD_NS) as i64 - 150_000_000);
            let track = target(&list).expect("the lead is in the path");
            if k < 3 {
                // Before the start both kept their speed.
                assert!((track.gap_m - 50.0).abs() < 1e-9);
            } else {
                let then = target(&history[k as usize - 3]).expect("it was in the path");
                assert!((track.gap_m - then.gap_m).abs() < 1e-6);
                assert!((track.acceleration_mps2 - then.acceleration_mps2).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn a_track_out_of_range_coasts_and_then_ends() {
        let mut keys = EXACT.to_vec();
        keys.push("perception.radar.max_range_m=60.2");
        let mut perception = Perception::new(&scenario("following", &keys));
        // The lead at 22 m/s leaves the range of an ego at 12 m/s after one second.
        let mut last = None;
        for k in 0..40 {
            let list = *perception.step(k * PERIOD_NS, &ego(k * PERIOD_NS, 12.0));
            if let Some(track) = target(&list) {
                assert_eq!(track.measured, track.gap_m <= 60.2, "{track:?}");
                last = Some(k);
            }
        }
        assert_eq!(last, Some(20 + 10));
    }

    #[test]
    fn a_jump_outside_the_gate_begins_a_new_track() {
        let mut keys = EXACT.to_vec();
        keys.push(
            "actors.0={ name = \"lead\", gap_m = 60, profile.speeds = [[2, 20], [2.01, 2]] }",
        );
        let mut perception = Perception::new(&scenario("following", &keys));
        let ids: Vec<u32> = (0..60)
            .map(|k| {
                let list = *perception.step(k * PERIOD_NS, &ego(k * PERIOD_NS, 20.0));
                list.tracks[0].id
            })
            .collect();
        // The jump is over at 2.01 s: the scans of 2.05, 2.10 and 2.15 s do not fit.
        assert_eq!(ids[42], 1);
        assert_eq!(ids[43], 2);
        assert_eq!(ids[59], 2);
    }

    #[test]
    fn no_actors_no_tracks() {
        let text = "schema_version = 1\nname = \"empty\"\n";
        let mut perception = Perception::new(&Scenario::parse("x", text).expect("it is right"));
        let list = *perception.step(0, &Ego::default());
        assert_eq!(list, TrackList::default());
    }

    proptest! {
        #[test]
        fn equal_inputs_give_equal_bits_and_an_ordered_list(
            seed in 0u64..1000, periods in prop::collection::vec(1u64..5, 1..100),
            speed_mps in 0.0..40.0f64,
        ) {
            let seed = format!("seed={seed}");
            let scenario = scenario("cut-in", &[&seed]);
            let (mut one, mut two) = (Perception::new(&scenario), Perception::new(&scenario));
            let mut now_ns = 0;
            for skip in periods {
                let ego = ego(now_ns, speed_mps);
                let list = *one.step(now_ns, &ego);
                prop_assert_eq!(&list, two.step(now_ns, &ego));
                let tracks = &list.tracks[..list.count];
                prop_assert!(tracks.windows(2).all(|pair| pair[0].gap_m <= pair[1].gap_m));
                prop_assert!(tracks.iter().all(|track| track.gap_m.is_finite()
                    && track.relative_speed_mps.is_finite() && track.acceleration_mps2.is_finite()));
                prop_assert_eq!(list.target, tracks.iter().position(|track| track.in_path));
                now_ns += skip * PERIOD_NS;
            }
        }
    }
}
