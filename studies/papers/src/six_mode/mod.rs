//! Six-mode switching ACC (Wang et al. 2014). The published drive under the literal and the robust law and under the
//! law's defaults, and the numbers beside the equations.
//!
//! The source's third car keeps 36 km/h, and the source's drive ends at standstill: both cannot be. So the literal and
//! the robust law drive twice, without a stop of that car and with the inferred one. Every set is compared with the
//! printed times; a row outside its tolerance has a note with the reason.

mod plane;
mod releases;

use super::Pictures;
use super::row::{EXACT, Kind, Row, Tolerance, paper, requirement, within};
use super::runner::{Driven, Part, Piece, Runner, printed};
use controller::laws::six_mode::deceleration::LEVELS_MPS2;
use controller::laws::six_mode::{Mode, Parameters};
use scenario::{Setting, Table, Value};
use supervise::Error;
use supervise::report::Outcome;

/// Switches are printed in whole seconds; this is less than rounding alone would excuse.
const PRINTED_S: Tolerance = within(0.3, "printed in whole seconds");

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Drives {
    Literal,
    Robust,
    /// The robust law with the decelerate mode of figure 3.
    Regions,
    /// The law's defaults, `--controller six-mode`.
    Road,
}

/// A law, and whether the third car stops.
#[derive(Clone, Copy, Debug)]
struct Set {
    name: &'static str,
    law: Drives,
    stops: bool,
}

const SETS: [Set; 6] = [
    Set { name: "literal, third car keeps 36 km/h", law: Drives::Literal, stops: false },
    Set { name: "literal, third car stops", law: Drives::Literal, stops: true },
    Set { name: "robust, third car keeps 36 km/h", law: Drives::Robust, stops: false },
    Set { name: "robust, third car stops", law: Drives::Robust, stops: true },
    Set {
        name: "robust with figure 3's regions, third car stops",
        law: Drives::Regions,
        stops: true,
    },
    Set { name: "road set, third car stops", law: Drives::Road, stops: true },
];

/// Instant of the cut-in, s, and the third car's speed, m/s: the paper's.
const CUT_IN_S: f64 = 14.0;
const THIRD_CAR_MPS: f64 = 10.0;
/// Inferred gap at the cut-in, m.
const CUT_IN_GAP_M: f64 = 22.26;

/// The keys of the law's table that the scenario sets.
const INFERRED_KEYS: [&str; 13] = [
    "spacing",
    "acceleration_mps2",
    "deceleration_parts",
    "braking_mps2",
    "lead_braking_mps2",
    "approach_threshold_mps",
    "steady_band_mps",
    "braking_hysteresis_m",
    "threshold_hysteresis_mps",
    "sign_band_mps",
    "dwell_s",
    "filter_time_s",
    "jerk_limit_mps3",
];

impl Set {
    fn drive(self, runner: &Runner<'_>) -> Result<Driven, Error> {
        let of_law =
            |key: &str, value: Value| Setting::new(&format!("controller.six_mode.{key}"), value);
        let mut set = match self.law {
            Drives::Literal => vec![of_law("variant", "literal".into())],
            Drives::Robust => vec![of_law("variant", "robust".into())],
            Drives::Regions => vec![of_law("deceleration_parts", "regions".into())],
            Drives::Road => {
                let defaults = Table::try_from(Parameters::default()).expect("plain data");
                INFERRED_KEYS.iter().map(|key| of_law(key, defaults[*key].clone())).collect()
            }
        };
        if !self.stops {
            set.push(Setting::new("actors.1.profile", "constant"));
        }
        if self.law == Drives::Road {
            // Until the cut-in the third car is beside the lane. It goes to where it cuts in at the same gap.
            let before = runner.drive("six-mode", &set)?;
            let mut steps = before.drive.steps.iter();
            let at_cut_in =
                steps.find(|step| step.time_s >= CUT_IN_S).map_or(0.0, |step| step.position_m);
            let gap_m = at_cut_in + CUT_IN_GAP_M - THIRD_CAR_MPS * CUT_IN_S;
            set.push(Setting::new("actors.1.gap_m", printed(gap_m, 3)));
        }
        runner.drive("six-mode", &set)
    }

    /// True if the paper's plane is drawn: for the paper as printed and for the law that users drive.
    fn is_drawn(self) -> bool {
        matches!((self.law, self.stops), (Drives::Literal, false) | (Drives::Road, _))
    }

    /// Inferred values behind the switch `index` of [`SWITCHES`].
    fn inferred(self, index: usize) -> String {
        if index < CUT_IN {
            return "initial speed, actuator lag".into();
        }
        if index == CUT_IN {
            return "initial speed, gap of the cut-in, a_h, a_p".into();
        }
        let stop = if self.stops { "third car's stop, " } else { "" };
        let of_law = match self.law {
            Drives::Literal => "",
            Drives::Robust => "hysteresis, equal slices, ",
            Drives::Regions => "hysteresis, ",
            Drives::Road => "all defaults of the law, ",
        };
        format!("{stop}{of_law}initial speed, gap of the cut-in, a_h, a_p, k, actuator lag")
    }

    /// Reason why the switch `index` is outside its tolerance, where it is.
    const fn cause(self, index: usize) -> &'static str {
        match (index, self.law, self.stops) {
            (_, Drives::Road, _) => {
                "the road set keeps a time gap in place of the paper's distances, brakes gradually and accelerates \
                 with 1.8 m/s²"
            }
            (0 | 1, ..) => {
                "no initial speed meets the first and the second time; this one meets the second under \
                 the robust law"
            }
            (2 | 3, Drives::Literal, _) => "no hysteresis: avoid ends as soon as R exceeds R_b",
            (4, _, false) => {
                "the ego is slower than the third car when R reaches R_w: V_r > 0 is steady (2)"
            }
            (5, _, false) => "behind a car that keeps 36 km/h the ego settles in steady driving",
            (5, Drives::Literal, true) => {
                "eq (8) keeps R above R_w until R_w falls below R_b near standstill: avoid follows"
            }
            (4 | 5, Drives::Regions, _) => "the inferred values were found with equal slices",
            _ => "the inferred values were found with the third car's stop",
        }
    }
}

/// Switch of the paper: the modes that end and begin, printed time, s, and the sentence, shortened.
type Switch = (u32, u32, f64, &'static str);

const SWITCHES: [Switch; 6] = [
    (
        6,
        1,
        4.0,
        "4 to 8 s: the lead is out of the sensor's range, so the system switches to cruise",
    ),
    (1, 2, 8.0, "at 8 s R > R_w1 and the relative speed is large: approach"),
    (
        2,
        5,
        CUT_IN_S,
        "at 14 s the third car cuts in, the gap falls below the avoid distance: avoid",
    ),
    (5, 4, 16.0, "at 16 s R_b1 < R < R_w1: decelerate"),
    (4, 2, 18.0, "at 18 s R > R_w1 and the relative speed is large: approach"),
    (2, 4, 26.0, "at 26 s R_b1 < R < R_w1: decelerate, braking suitably to a stop"),
];
/// The switch at the cut-in, whose instant the scenario sets.
const CUT_IN: usize = 2;

/// A piece for each set. The first one also has the rows that need no drive.
pub fn pieces() -> Vec<Piece> {
    let piece = |(place, set): (usize, Set)| {
        Piece::new(set.name, move |runner| {
            let driven = set.drive(runner)?;
            let rows = rows(set, &driven).into_iter().map(|row| row.in_set(set.name));
            let releases = if place == 0 { releases::rows() } else { Vec::new() };
            let drawn = if set.is_drawn() { plane::of(set.name, &driven) } else { None };
            let drives = vec![(set.name.to_owned(), driven.picture().1)];
            let pictures = Pictures { drives, galleries: drawn.into_iter().collect() };
            Ok(Part { rows: releases.into_iter().chain(rows).collect(), pictures })
        })
    };
    SETS.into_iter().enumerate().map(piece).collect()
}

/// A change of mode: from, to, s.
type Change = (u32, u32, f64);

fn rows(set: Set, driven: &Driven) -> Vec<Row> {
    let (matched, others) = aligned(&changes(&modes(driven)));
    let switches = SWITCHES.iter().zip(matched).enumerate();
    let mut rows: Vec<_> = switches
        .map(|(index, (&(from, to, at_s, source), ours))| {
            let id = format!("switch.{from}-{to}_s");
            let row = match index {
                CUT_IN => Row::input(&id, "s", paper(at_s), ours),
                _ => Row::near(&id, "s", paper(at_s), ours, PRINTED_S),
            };
            let row = row.with_source(source).depending_on(set.inferred(index));
            if row.ok { row } else { row.with_note(set.cause(index)) }
        })
        .collect();
    let count = Row::near("switch.others", "", paper(0.0), Some(others.len() as f64), EXACT)
        .with_source("figure 6b: six switches")
        .depending_on(set.inferred(5));
    rows.push(if count.ok { count } else { count.with_note("the rows \"seen\" show them") });
    rows.extend(others.iter().map(|(place, (from, to, at_s))| {
        let (id, ours) = (format!("seen.{place}.{from}-{to}_s"), Some(*at_s));
        Row::shown(&id, "s", Kind::Reconstruction, ours, "a switch that the paper does not have")
            .with_source("figure 6b: six switches")
            .depending_on(set.inferred(5))
    }));
    rows.extend(motion(set, driven));
    rows
}

/// Rows of requests, speeds and safety.
fn motion(set: Set, driven: &Driven) -> Vec<Row> {
    let steps = || driven.drive.steps.iter();
    let in_mode = |mode: u32| steps().filter(move |step| step.mode == Some(mode - 1));
    let largest = |mode| in_mode(mode).filter_map(|step| step.request_mps2).reduce(f64::max);
    let hardest = |mode| in_mode(mode).filter_map(|step| step.request_mps2).reduce(f64::min);
    let fastest_kmh = in_mode(1).map(|step| 3.6 * step.speed_mps).reduce(f64::max);
    let end_mps = steps().last().map(|step| step.speed_mps);
    let contact = f64::from(u8::from(driven.summary.outcome == Outcome::Collision));
    let change_mps = change_of_relative_speed(&driven.figure("relative_speed_mps"));
    let standing = within(0.01, "a plot shows this as standing");
    let end = Row::near("end.speed_mps", "m/s", paper(0.0), end_mps, standing)
        .with_source("26 s: decelerate, braking suitably to a stop")
        .depending_on(set.inferred(5));
    let end = if end.ok {
        end
    } else {
        end.with_note("the source contradicts itself: a car behind one at 36 km/h does not stop")
    };
    let input = |id, unit, printed, ours| Row::input(id, unit, paper(printed), ours);
    vec![
        input("accelerate.request_mps2", "m/s²", 1.0, largest(6))
            .with_source("0 to 4 s: accelerate, with 1 m/s²"),
        input("cruise.request_mps2", "m/s²", 1.0, largest(1))
            .with_source("4 to 8 s: V_h < 70 km/h, so with 1 m/s²"),
        input("cruise.fastest_kmh", "km/h", 70.0, fastest_kmh)
            .with_source("4 to 8 s: V_h < 70 km/h (figure 6c)")
            .with_note("the set speed bounds it"),
        input("cut-in.change_of_relative_speed_mps", "m/s", 0.0, change_mps).with_source(
            "at 14 s the third car cuts in at the lead's speed: the relative speed does not change",
        ),
        Row::shown(
            "avoid.hardest_request_mps2",
            "m/s²",
            Kind::Paper,
            hardest(5),
            "the hardest that the vehicle can; the paper prints no a_h",
        )
        .with_source("avoid: comfort is sacrificed for the vehicle's hardest braking")
        .depending_on("a_h"),
        input("decelerate.demands_off_the_levels", "", 0.0, Some(off_levels(driven)))
            .with_source("eight levels, the mean of the present one and the three before"),
        end,
        Row::at_most("collisions", "", requirement(0.0), Some(contact), EXACT)
            .with_source("conclusion: safety is kept"),
    ]
}

/// Control cycles of the decelerate mode with a demand beside the eight levels.
fn off_levels(driven: &Driven) -> f64 {
    let steps = driven.drive.steps.iter().filter(|step| step.figures.is_some());
    let demands = steps.zip(driven.figure("demand_mps2"));
    let decelerates = demands.filter(|(step, _)| step.mode == Some(Mode::Decelerate as u32));
    decelerates.filter(|(_, (_, demand))| !LEVELS_MPS2.contains(demand)).count() as f64
}

/// Change of the relative speed from the last cycle before 14 s to the first from then on, m/s.
fn change_of_relative_speed(relative: &[(f64, f64)]) -> Option<f64> {
    let at = relative.partition_point(|(time_s, _)| *time_s < CUT_IN_S);
    let before = relative.get(at.checked_sub(1)?)?;
    Some(relative.get(at)?.1 - before.1)
}

/// (time, mode in the paper's numbers) at every control cycle.
fn modes(driven: &Driven) -> Vec<(f64, u32)> {
    let steps = driven.drive.steps.iter();
    steps.filter_map(|step| step.mode.map(|mode| (step.time_s, mode + 1))).collect()
}

fn changes(modes: &[(f64, u32)]) -> Vec<Change> {
    let pairs = modes.windows(2).filter(|pair| pair[0].1 != pair[1].1);
    pairs.map(|pair| (pair[0].1, pair[1].1, pair[1].0)).collect()
}

/// The time of each of the paper's switches, in its order, and all other changes with their place in the drive.
fn aligned(changes: &[Change]) -> ([Option<f64>; SWITCHES.len()], Vec<(usize, Change)>) {
    let mut matched = [None; SWITCHES.len()];
    let mut others: Vec<_> = (1..).zip(changes.iter().copied()).collect();
    let mut after = 0;
    for (time_s, &(from, to, ..)) in matched.iter_mut().zip(&SWITCHES) {
        let is_it = |(place, change): &(usize, Change)| {
            *place > after && (change.0, change.1) == (from, to)
        };
        if let Some(index) = others.iter().position(is_it) {
            let (place, change) = others.remove(index);
            (*time_s, after) = (Some(change.2), place);
        }
    }
    (matched, others)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_own_sequence_matches_itself() {
        let own: Vec<Change> = SWITCHES.iter().map(|s| (s.0, s.1, s.2)).collect();
        let (matched, others) = aligned(&own);
        assert_eq!(matched.to_vec(), [4.0, 8.0, 14.0, 16.0, 18.0, 26.0].map(Some));
        assert!(others.is_empty());
    }

    #[test]
    fn a_key_that_the_paper_lacks_is_kept_with_its_place() {
        let changes =
            [(6, 1, 5.0), (1, 2, 7.5), (2, 5, 14.0), (5, 4, 14.9), (4, 2, 17.7), (2, 5, 32.0)];
        let (matched, others) = aligned(&changes);
        assert_eq!(matched[4..], [Some(17.7), None]);
        assert_eq!(others, [(6, (2, 5, 32.0))]);
        // A later pair is not a match for an earlier switch of the paper.
        let (matched, others) = aligned(&[(4, 2, 1.0), (6, 1, 4.0)]);
        assert_eq!((matched[0], matched[4]), (Some(4.0), None));
        assert_eq!(others, [(1, (4, 2, 1.0))]);
    }

    #[test]
    fn changes_are_where_the_mode_is_another() {
        assert_eq!(changes(&[(0.0, 6), (0.1, 6), (0.2, 1), (0.3, 2)]), [(6, 1, 0.2), (1, 2, 0.3)]);
    }

    #[test]
    fn the_relative_speed_is_compared_across_the_cut_in() {
        let relative = [(13.9, -3.0), (13.95, -3.1), (14.0, -3.0), (14.05, -2.0)];
        let change = change_of_relative_speed(&relative).expect("both cycles are there");
        assert!((change - 0.1).abs() < 1e-12);
        assert_eq!(change_of_relative_speed(&relative[2..]), None);
    }
}
