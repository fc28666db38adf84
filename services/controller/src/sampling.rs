//! From the newest samples to a law's input: every figure is brought to the time of the release.

use crate::law::{
    self, Ego, Input, MAX_PHASES, MAX_SIGNALS, Phase, PhaseInterval, SignalAhead, Target,
};
use messages::{
    AnnouncedMotion, AnnouncedMotions, Interval, Map, Odometry, PhaseState, Powertrain, Preview,
    RadarTracks, Signal, Spat,
};
use scenario::Scenario;

/// Bounds of an end that differ by no more are one time, s: marks are tenths of a second, rounded apart.
const SAME_END_S: f64 = 0.2;
/// Least confidence in a likely end: the first that is more likely right than wrong (SAE J2735: 56 %).
const LIKELY: u32 = 3;
/// A stop line is dropped when it is this far behind, m.
const PASSED_M: f64 = 50.0;
/// Distance of two rears on one lane from which they are those of two vehicles, m: half of a short car's length.
const SAME_M: f64 = 1.75;
/// Distance from the middle of the ego's lane from which a vehicle is on another one, m: half of a lane.
const BESIDE_M: f64 = 1.75;

/// Part of the input that does not come from samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    pub period_s: f64,
    pub set_speed_mps: f64,
    /// Legal limit, m/s, infinite when unknown.
    pub speed_limit_mps: f64,
    /// True if the law filters the radar itself, and so receives gap and relative speed as measured.
    pub raw_target: bool,
    /// Largest error of an announced end because of the clocks, s.
    pub clock_tolerance_s: f64,
}

impl Setting {
    /// The setting of a scenario; `raw_target` as the law needs it.
    pub fn of(scenario: &Scenario, raw_target: bool) -> Self {
        Self {
            period_s: f64::from(scenario.controller.period_ms.value()) / 1e3,
            set_speed_mps: scenario.set_speed_mps.value(),
            speed_limit_mps: scenario.speed_limit_mps.map_or(f64::INFINITY, |v| v.value()),
            raw_target,
            clock_tolerance_s: match scenario.has_obu() {
                true => f64::from(scenario.v2x.obu.clock_tolerance_ms.value()) / 1e3,
                false => 0.0,
            },
        }
    }
}

/// The newest samples of all inputs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Samples<'a> {
    pub odometry: Option<&'a Odometry>,
    pub radar: Option<&'a RadarTracks>,
    /// Signal timing.
    pub spat: Option<&'a Spat>,
    /// Stop lines.
    pub map: Option<&'a Map>,
    /// Other vehicles, as they announce themselves.
    pub motions: Option<&'a AnnouncedMotions>,
    /// Engine and gears of a truck.
    pub powertrain: Option<&'a Powertrain>,
    pub preview: Option<&'a Preview>,
}

/// Trust in announced signal timing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignalTrust {
    /// All of it: greens and yellows up to their earliest end, reds up to their latest.
    Announced,
    /// The part that holds without another announcement: up to the earliest end of the first interval whose end is not
    /// certain.
    Proven,
    /// Nothing: all phases are unknown.
    None,
}

/// Input of the law at `time_s`. Without odometry the ego is taken to stand at the origin.
pub fn input(setting: &Setting, samples: &Samples<'_>, trust: SignalTrust, time_s: f64) -> Input {
    let ego = samples.odometry.map_or_else(Ego::default, |odometry| {
        let (position_m, speed_mps) = odometry.moved_to(time_s);
        Ego { position_m, speed_mps, acceleration_mps2: odometry.acceleration_mps2 }
    });
    Input {
        time_s,
        period_s: setting.period_s,
        ego,
        target: samples.radar.and_then(|radar| {
            let target = target_at(radar, setting.raw_target, time_s)?;
            Some(eased(announced(target, samples, &ego, time_s), radar.target.doubt_share))
        }),
        signals: signals_ahead(setting, samples, &ego, trust, time_s),
        powertrain: samples.powertrain.map(|powertrain| powertrain_at(powertrain, samples, time_s)),
        preview: samples.preview.map(preview),
        set_speed_mps: setting.set_speed_mps,
        profile: None,
        speed_limit_mps: samples
            .preview
            .map_or(f64::INFINITY, |preview| preview.speed_limit_mps)
            .min(setting.speed_limit_mps),
    }
}

/// The grade is what the accelerometer shows beyond the acceleration: the slope's share of gravity.
fn powertrain_at(powertrain: &Powertrain, samples: &Samples<'_>, time_s: f64) -> law::Powertrain {
    let acceleration_mps2 = samples.odometry.map_or(0.0, |odometry| odometry.acceleration_mps2);
    let slope_mps2 = powertrain.specific_force_mps2 - acceleration_mps2;
    let sine = (slope_mps2 / truck_model::GRAVITY_MPS2).clamp(-0.5, 0.5);
    law::Powertrain {
        gear: (powertrain.gear as usize).saturating_sub(1),
        since_shift_s: powertrain.since_shift_s + age_s(powertrain.header.acquisition_ns, time_s),
        engine_torque_nm: powertrain.engine_torque_nm,
        grade: sine / (1.0 - sine * sine).sqrt(),
    }
}

fn preview(preview: &Preview) -> law::Preview {
    let grades = preview.grades();
    let mut ahead = law::Preview {
        start_m: preview.first_cell_m,
        cell_m: preview.cell_m,
        count: grades.len(),
        ..law::Preview::default()
    };
    ahead.grades[..grades.len()].copy_from_slice(grades);
    ahead
}

fn age_s(acquisition_ns: i64, time_s: f64) -> f64 {
    (time_s - acquisition_ns as f64 / 1e9).max(0.0)
}

/// The target at constant relative speed since the sample. It is as measured if `raw` and the scan has it, else as
/// tracked. Two filters in a row would see a lead brake too late.
fn target_at(radar: &RadarTracks, raw: bool, time_s: f64) -> Option<Target> {
    let target = &radar.target;
    let age_s = age_s(radar.header.acquisition_ns, time_s);
    let measured = radar.tracks().iter().find(|track| raw && track.in_path != 0);
    let (gap_m, relative_speed_mps) = measured
        .map_or((target.gap_m, target.relative_speed_mps), |track| {
            (track.range_m, track.range_rate_mps)
        });
    (target.valid != 0).then_some(Target {
        track_id: target.track_id,
        gap_m: gap_m + relative_speed_mps * age_s,
        relative_speed_mps,
        acceleration_mps2: target.acceleration_mps2,
        age_s,
    })
}

/// The target with the acceleration that it announces, if it brakes harder than the radar has it. A radar needs some
/// scans to see a lead brake. A CAM is not signed and up to a second old, so that it may only make the ego more careful.
fn announced(target: Target, samples: &Samples<'_>, ego: &Ego, time_s: f64) -> Target {
    let motions = samples.motions.map_or(&[][..], AnnouncedMotions::motions);
    let is_it = |motion: &&AnnouncedMotion| {
        let since_s = age_s(motion.made_ns, time_s);
        let gap_m = motion.rear_position_m + motion.speed_mps * since_s - ego.position_m;
        (gap_m - target.gap_m).abs() < SAME_M && motion.lateral_m.abs() < BESIDE_M
    };
    let least_mps2 = motions.iter().filter(is_it).map(|motion| motion.acceleration_mps2);
    let acceleration_mps2 = least_mps2.fold(target.acceleration_mps2, f64::min);
    Target { acceleration_mps2, ..target }
}

/// Braking that is as bad as braking for nothing, m/s²: the most of a cruise control (ISO 15622).
const FOR_NOTHING_MPS2: f64 = 5.0;
/// Braking for a target that may stand beside the way, m/s²: about that of an engine. Those behind need no brakes.
const EASES_MPS2: f64 = 1.0;

/// The target where [`EASES_MPS2`] stops the ego, unless it is worth the braking that it needs. To brake late costs the
/// square of the braking that is then needed, and to brake for nothing costs that of [`FOR_NOTHING_MPS2`].
fn eased(target: Target, doubt_share: f64) -> Target {
    let square = target.relative_speed_mps.min(0.0).powi(2);
    let needed_mps2 = square / (2.0 * target.gap_m.max(1.0));
    let late = (1.0 - doubt_share) * needed_mps2.powi(2);
    if late >= doubt_share * FOR_NOTHING_MPS2.powi(2) {
        return target;
    }
    Target { gap_m: target.gap_m.max(square / (2.0 * EASES_MPS2)), ..target }
}

/// Stop lines of the map with their timing, nearest first.
fn signals_ahead(
    setting: &Setting,
    samples: &Samples<'_>,
    ego: &Ego,
    trust: SignalTrust,
    time_s: f64,
) -> [Option<SignalAhead>; MAX_SIGNALS] {
    let mut ahead = [None; MAX_SIGNALS];
    let Some(map) = samples.map else { return ahead };
    let near = map
        .lanes()
        .iter()
        .filter(|lane| lane.stop_line_m - ego.position_m > -PASSED_M)
        .take(MAX_SIGNALS);
    for (place, lane) in ahead.iter_mut().zip(near) {
        let timing = samples.spat.and_then(|spat| {
            spat.signals().iter().find(|signal| {
                (signal.intersection_id, signal.signal_group)
                    == (lane.intersection_id, lane.signal_group)
            })
        });
        let mut signal = SignalAhead {
            id: lane.intersection_id.wrapping_mul(256).wrapping_add(lane.signal_group),
            distance_m: lane.stop_line_m - ego.position_m,
            ..SignalAhead::default()
        };
        if let Some(timing) = timing {
            announce(setting, timing, trust, time_s, &mut signal);
        }
        *place = Some(signal);
    }
    ahead
}

/// The intervals that have not ended yet. If a phase ends before the known start of its announced successor, the phase
/// is unknown: it is never guessed. A phase other than green or yellow lasts until a message shows another one,
/// whatever was announced. The next release is the soonest time for that.
fn announce(
    setting: &Setting,
    timing: &Signal,
    trust: SignalTrust,
    time_s: f64,
    signal: &mut SignalAhead,
) {
    let known = if trust == SignalTrust::None { &[][..] } else { timing.intervals() };
    let mut certain = true;
    for interval in known {
        if !certain || signal.count == MAX_PHASES {
            break;
        }
        let phase = match PhaseState::from_wire(interval.state) {
            PhaseState::Unavailable => Phase::Unknown,
            PhaseState::StopAndRemain => Phase::Red,
            PhaseState::ProtectedMovementAllowed => Phase::Green,
            PhaseState::ProtectedClearance => Phase::Yellow,
        };
        let end_s = match phase {
            Phase::Green | Phase::Yellow => interval.min_end_s - setting.clock_tolerance_s,
            Phase::Red | Phase::Unknown => {
                let end_s = interval.max_end_s + setting.clock_tolerance_s;
                end_s.max(time_s + setting.period_s)
            }
        };
        if trust == SignalTrust::Proven {
            certain = interval.min_end_s >= interval.max_end_s;
        }
        if end_s <= time_s + 1e-9 {
            continue;
        }
        if signal.count == 0 {
            signal.likely_s = likely_s(setting, phase, interval, end_s, time_s);
        }
        signal.intervals[signal.count] = PhaseInterval { phase, ends_in_s: end_s - time_s };
        signal.count += 1;
    }
}

/// The likely end of a shown phase, as [`SignalAhead::likely_s`], where `end_s` is the certain one.
fn likely_s(setting: &Setting, phase: Phase, interval: &Interval, end_s: f64, time_s: f64) -> f64 {
    let tolerance_s = setting.clock_tolerance_s;
    let is_open = interval.max_end_s - interval.min_end_s > SAME_END_S;
    let is_known = interval.likely_end_s.is_finite() && interval.confidence >= LIKELY;
    match phase {
        _ if !is_open => 0.0,
        Phase::Green if is_known => {
            interval.likely_end_s.max(end_s + tolerance_s) - tolerance_s - time_s
        }
        Phase::Green => f64::INFINITY,
        Phase::Red if is_known => {
            (interval.likely_end_s + tolerance_s).max(time_s + setting.period_s) - time_s
        }
        Phase::Yellow | Phase::Red | Phase::Unknown => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::{Lane, TrackedTarget};

    const SETTING: Setting = Setting {
        period_s: 0.1,
        set_speed_mps: 20.0,
        speed_limit_mps: f64::INFINITY,
        raw_target: false,
        clock_tolerance_s: 0.0,
    };

    #[test]
    fn motion_is_brought_to_the_release_and_braking_ends_at_standstill() {
        let mut odometry = Odometry::zeroed();
        odometry.header.acquisition_ns = 1_000_000_000;
        (odometry.position_m, odometry.speed_mps) = (10.0, 2.0);
        odometry.acceleration_mps2 = -4.0;
        let samples = Samples { odometry: Some(&odometry), ..Samples::default() };
        let soon = input(&SETTING, &samples, SignalTrust::Announced, 1.25).ego;
        assert_eq!((soon.position_m, soon.speed_mps), (10.375, 1.0));
        let late = input(&SETTING, &samples, SignalTrust::Announced, 9.0).ego;
        assert_eq!((late.position_m, late.speed_mps), (10.5, 0.0));
    }

    #[test]
    fn a_doubtful_target_is_given_where_1_mps2_stops_the_ego() {
        let gap_m = |gap_m: f64, closing_mps: f64, doubt_share: f64| {
            let mut radar = RadarTracks::zeroed();
            radar.target = TrackedTarget {
                valid: 1,
                gap_m,
                relative_speed_mps: -closing_mps,
                doubt_share,
                ..TrackedTarget::zeroed()
            };
            let samples = Samples { radar: Some(&radar), ..Samples::default() };
            input(&SETTING, &samples, SignalTrust::Announced, 0.0).target.expect("valid").gap_m
        };
        assert_eq!(gap_m(80.0, 20.0, 0.0), 80.0, "no doubt");
        // 2.5 m/s² are needed: as bad as 5 m/s² for nothing in one of five drives.
        assert_eq!((gap_m(80.0, 20.0, 0.19), gap_m(80.0, 20.0, 0.21)), (80.0, 200.0));
        assert_eq!((gap_m(40.0, 20.0, 0.49), gap_m(40.0, 20.0, 0.51)), (40.0, 200.0));
        assert_eq!(gap_m(300.0, 20.0, 0.9), 300.0, "less than 1 m/s² is needed");
        assert_eq!(gap_m(3.0, 1.0, 0.9), 3.0, "nearly at standstill");
    }

    #[test]
    fn an_old_target_is_extrapolated_and_its_age_reported() {
        let mut radar = RadarTracks::zeroed();
        radar.target.valid = 1;
        (radar.target.gap_m, radar.target.relative_speed_mps) = (40.0, -10.0);
        let samples = Samples { radar: Some(&radar), ..Samples::default() };
        let target = input(&SETTING, &samples, SignalTrust::Announced, 0.2).target.expect("valid");
        assert_eq!((target.gap_m, target.age_s), (38.0, 0.2));
        // As measured, for a law with a filter of its own.
        radar.count = 2;
        radar.tracks[1].in_path = 1;
        (radar.tracks[1].range_m, radar.tracks[1].range_rate_mps) = (41.0, -9.0);
        let samples = Samples { radar: Some(&radar), ..Samples::default() };
        let raw = Setting { raw_target: true, ..SETTING };
        let target = input(&raw, &samples, SignalTrust::Announced, 0.2).target.expect("valid");
        assert_eq!((target.gap_m, target.relative_speed_mps), (39.2, -9.0));
        radar.target.valid = 0;
        let samples = Samples { radar: Some(&radar), ..Samples::default() };
        assert_eq!(input(&raw, &samples, SignalTrust::Announced, 0.2).target, None);
    }

    #[test]
    fn a_target_that_announces_its_braking_brakes_and_a_vehicle_beside_it_does_not() {
        let mut radar = RadarTracks::zeroed();
        (radar.target.valid, radar.target.gap_m, radar.target.acceleration_mps2) = (1, 42.0, -1.0);
        let mut motions = AnnouncedMotions::zeroed();
        motions.count = 1;
        (motions.motions[0].rear_position_m, motions.motions[0].speed_mps) = (40.0, 10.0);
        let at = |motions: &AnnouncedMotions| {
            let samples =
                Samples { radar: Some(&radar), motions: Some(motions), ..Samples::default() };
            input(&SETTING, &samples, SignalTrust::Announced, 0.2).target.expect("valid")
        };
        motions.motions[0].acceleration_mps2 = -6.0;
        assert_eq!(at(&motions).acceleration_mps2, -6.0);
        let announced = motions.motions[0];
        for other in [
            AnnouncedMotion { acceleration_mps2: 2.0, ..announced },
            AnnouncedMotion { rear_position_m: 44.0, ..announced },
            AnnouncedMotion { lateral_m: 3.5, ..announced },
        ] {
            motions.motions[0] = other;
            assert_eq!(at(&motions).acceleration_mps2, -1.0, "{other:?}");
        }
    }

    #[test]
    fn the_grade_is_felt_and_the_map_is_handed_on_up_to_its_end() {
        let mut powertrain = Powertrain::zeroed();
        (powertrain.gear, powertrain.specific_force_mps2) = (6, 0.1 + 9.81 * 0.03);
        let mut odometry = Odometry::zeroed();
        odometry.acceleration_mps2 = 0.1;
        let mut preview = Preview::zeroed();
        (preview.count, preview.cell_m, preview.first_cell_m) = (2, 50.0, 100.0);
        (preview.grades[0], preview.grades[1], preview.speed_limit_mps) = (0.01, 0.02, 25.0);
        let samples = Samples {
            odometry: Some(&odometry),
            powertrain: Some(&powertrain),
            preview: Some(&preview),
            ..Samples::default()
        };
        let input = input(
            &Setting { speed_limit_mps: 30.0, ..SETTING },
            &samples,
            SignalTrust::Announced,
            0.0,
        );
        let felt = input.powertrain.expect("a truck");
        assert_eq!(felt.gear, 5);
        assert!((felt.grade - 0.03 / (1.0_f64 - 0.03 * 0.03).sqrt()).abs() < 1e-12);
        let ahead = input.preview.expect("a map");
        assert_eq!((ahead.grade(160.0), ahead.grade(200.0)), (Some(0.02), None));
        assert_eq!(input.speed_limit_mps, 25.0);
    }

    #[test]
    fn a_phase_that_ended_unannounced_is_unknown_not_green() {
        let mut spat = Spat::zeroed();
        spat.count = 1;
        spat.signals[0].count = 2;
        for (place, (state, end)) in [(6, 5.0), (3, 9.0)].into_iter().enumerate() {
            let (min_end_s, likely_end_s, max_end_s) = (end, end, end);
            let ends = Interval { min_end_s, likely_end_s, max_end_s, ..Interval::zeroed() };
            spat.signals[0].intervals[place] = Interval { state, ..ends };
        }
        let mut map = Map::zeroed();
        map.count = 1;
        map.lanes[0] = Lane { stop_line_m: 80.0, ..Lane::zeroed() };
        let samples = Samples { spat: Some(&spat), map: Some(&map), ..Samples::default() };
        let at = |time_s| {
            let input = input(&SETTING, &samples, SignalTrust::Announced, time_s);
            input.signals[0].expect("in the map")
        };
        assert_eq!((at(1.0).count, at(1.0).intervals[0].phase), (2, Phase::Green));
        assert_eq!(at(1.0).intervals[0].ends_in_s, 4.0);
        assert_eq!((at(5.0).count, at(5.0).intervals[0].phase), (1, Phase::Red));
        assert_eq!((at(9.5).count, at(9.5).intervals[0].phase), (1, Phase::Red), "none is shown");
        spat.signals[0].count = 1;
        let samples = Samples { spat: Some(&spat), map: Some(&map), ..Samples::default() };
        let green = input(&SETTING, &samples, SignalTrust::Announced, 5.0).signals[0];
        assert_eq!(green.map(|signal| signal.count), Some(0), "what follows is unknown");
    }

    #[test]
    fn a_green_counts_when_it_is_shown_and_ends_before_clocks_can_differ() {
        let mut spat = Spat::zeroed();
        spat.count = 1;
        spat.signals[0].count = 3;
        let write = |spat: &mut Spat, phases: [(u32, f64); 3]| {
            for (place, (state, end_s)) in phases.into_iter().enumerate() {
                let (min_end_s, max_end_s) = (end_s - 0.1, end_s + 0.1);
                let ends =
                    Interval { min_end_s, likely_end_s: end_s, max_end_s, ..Interval::zeroed() };
                spat.signals[0].intervals[place] = Interval { state, ..ends };
            }
        };
        let mut map = Map::zeroed();
        map.count = 1;
        map.lanes[0] = Lane { stop_line_m: 80.0, ..Lane::zeroed() };
        let setting = Setting { clock_tolerance_s: 0.2, ..SETTING };
        let at = |spat: &Spat, time_s| {
            let samples = Samples { spat: Some(spat), map: Some(&map), ..Samples::default() };
            let signal = input(&setting, &samples, SignalTrust::Announced, time_s).signals[0];
            let signal = signal.expect("in the map");
            let intervals = &signal.intervals[..signal.count];
            intervals.iter().map(|i| (i.phase, (i.ends_in_s * 10.0).round())).collect::<Vec<_>>()
        };
        write(&mut spat, [(3, 5.0), (6, 9.0), (8, 12.0)]);
        let coming = [(Phase::Red, 13.0), (Phase::Green, 47.0), (Phase::Yellow, 77.0)];
        assert_eq!(at(&spat, 4.0), coming);
        // A tenth of a second is the period.
        let late = [(Phase::Red, 1.0), (Phase::Green, 27.0), (Phase::Yellow, 57.0)];
        assert_eq!(at(&spat, 6.0), late);
        write(&mut spat, [(6, 9.0), (8, 12.0), (3, 40.0)]);
        assert_eq!(at(&spat, 6.0)[0], (Phase::Green, 27.0), "it is shown");
    }

    #[test]
    fn without_renewal_only_what_is_certain_is_believed() {
        let mut spat = Spat::zeroed();
        spat.count = 1;
        spat.signals[0].count = 3;
        let ends = [(6, 5.0, 5.0), (8, 7.0, 9.0), (3, 20.0, 20.0)];
        for (place, (state, min_end_s, max_end_s)) in ends.into_iter().enumerate() {
            let likely_end_s = 0.5 * (min_end_s + max_end_s);
            let interval =
                Interval { state, min_end_s, likely_end_s, max_end_s, ..Interval::zeroed() };
            spat.signals[0].intervals[place] = interval;
        }
        let mut map = Map::zeroed();
        map.count = 1;
        map.lanes[0] = Lane { stop_line_m: 80.0, ..Lane::zeroed() };
        let samples = Samples { spat: Some(&spat), map: Some(&map), ..Samples::default() };
        let at = |trust, time_s| {
            let signal = input(&SETTING, &samples, trust, time_s).signals[0].expect("in the map");
            signal.intervals[..signal.count]
                .iter()
                .map(|i| (i.phase, i.ends_in_s))
                .collect::<Vec<_>>()
        };
        let all = [(Phase::Green, 4.0), (Phase::Yellow, 6.0), (Phase::Red, 19.0)];
        assert_eq!(at(SignalTrust::Announced, 1.0), all);
        assert_eq!(at(SignalTrust::Proven, 1.0), [(Phase::Green, 4.0), (Phase::Yellow, 6.0)]);
        assert_eq!(at(SignalTrust::Proven, 6.0), [(Phase::Yellow, 1.0)]);
        assert_eq!(at(SignalTrust::Proven, 8.0), [], "whether it is red already is not certain");
        assert_eq!(at(SignalTrust::None, 1.0), []);
    }
}
