//! The default `cacc-mpc` beside its blind baseline, in seeded variants of the paper's four scenes.
//!
//! The paper's figures belong to its own formulation. These rows hold the road's formulation to the paper's purpose:
//! pass before green turns red if that is possible. A variant has its own speed, line and switch. The line lies where a
//! vehicle that moves as the lead does would arrive at about the switch. So the law decides whether green is used.
//!
//! ```text
//! v       8 to 22 m/s    speed at the start in A to C; set speed in Table 3, whose lead drives 0.75 v
//! switch  4 to 8 s       8 to 12 s in Table 3, which begins at a standstill
//! line    the lead's way until switch + d;  d within 1.5 s         A, B, Table 3
//!         v (switch + d);  d from 0 to 3 s; the lead waits there   C
//! ```
//!
//! A law's gain is the time by which it crosses earlier than its own ACC. It is taken where both forms of `cacc-mpc`
//! cross in green. The set is 250 variants of each scene; `--variants 250` drives all of them.

use super::row::{EXACT, Kind, Row, requirement};
use super::runner::{Part, Piece, Runner, printed};
use rand_core::SeedableRng;
use rand_pcg::Pcg64;
use scenario::Setting;
use supervise::{Error, passed_s};

const SET: &str = "default law, varied";
/// Sentence of the paper behind the rows.
const PURPOSE: &str = "introduction: pass the intersection before green turns red";
/// Takes the scenes' own spacing, which is the paper's, back to the default.
fn spacing() -> [Setting; 2] {
    [
        Setting::new("controller.spacing_policy", "constant-time-headway"),
        Setting::new("controller.standstill_distance_m", 5),
    ]
}
/// Time after the switch within which every drive that does not stop is past its line, s.
const AFTER_S: f64 = 8.0;
/// Time to spare before red with which a pass of the blind law must be matched, s.
const SPARE_S: f64 = 0.1;
/// Share of the printed formulation's median gain that the default law has at least.
const SHARE: f64 = 0.5;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scene {
    A,
    B,
    C,
    Table3,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Variant {
    speed_mps: f64,
    switch_s: f64,
    line_m: f64,
}

impl Scene {
    const ALL: [Self; 4] = [Self::A, Self::B, Self::C, Self::Table3];

    /// Name in rows, and the scenario.
    const fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::A => ("A", "cacc-a"),
            Self::B => ("B", "cacc-b"),
            Self::C => ("C", "cacc-c"),
            Self::Table3 => ("T3", "cacc-table3"),
        }
    }

    /// The variant of a number. All draws are uniform.
    fn variant(self, number: u32) -> Variant {
        let stream = 0x6361_6363 + ((self as u64) << 32);
        let mut generator = Pcg64::seed_from_u64(stream ^ u64::from(number));
        let mut draw = |low, high| low + (high - low) * random::uniform(&mut generator);
        let speed_mps = hundredths(draw(8.0, 22.0));
        let (from_s, to_s) = if self == Self::Table3 { (8.0, 12.0) } else { (4.0, 8.0) };
        let switch_s = hundredths(draw(from_s, to_s));
        let (from_s, to_s) = if self == Self::C { (0.0, 3.0) } else { (-1.5, 1.5) };
        let way_m = self.way_m(speed_mps, switch_s + draw(from_s, to_s));
        Variant { speed_mps, switch_s, line_m: hundredths(way_m) }
    }

    /// Way of the lead until a time, m; in C, whose lead waits, of a vehicle that keeps its speed.
    fn way_m(self, speed_mps: f64, time_s: f64) -> f64 {
        match self {
            Self::A | Self::C => speed_mps * time_s,
            Self::B => {
                let omega = std::f64::consts::TAU / 10.0;
                speed_mps * time_s + 2.0 / omega * (time_s - libm::sin(omega * time_s) / omega)
            }
            Self::Table3 => {
                let (top_mps, acceleration_mps2) = (0.75 * speed_mps, 2.388);
                let gaining_s = time_s.min(top_mps / acceleration_mps2);
                0.5 * acceleration_mps2 * gaining_s * gaining_s + top_mps * (time_s - gaining_s)
            }
        }
    }

    /// Settings that make the scenario this variant.
    fn settings(self, variant: &Variant) -> Vec<Setting> {
        let Variant { speed_mps: v, switch_s, line_m } = *variant;
        let of_scene = match self {
            Self::A | Self::B => vec![
                Setting::new("plant.initial_speed_mps", v),
                Setting::new("actors.0.initial_speed_mps", v),
                // The paper's spacing error, -15 m.
                Setting::new("actors.0.gap_m", printed(1.5 * v + 27.0, 2)),
            ],
            Self::C => vec![
                Setting::new("plant.initial_speed_mps", v),
                Setting::new("actors.0.gap_m", printed(line_m - 0.5, 2)),
                Setting::new("actors.0.profile.steps.0.time_s", switch_s),
                Setting::new("actors.0.profile.steps.0.speed_mps", v),
            ],
            Self::Table3 => vec![
                Setting::new("set_speed_mps", v),
                Setting::new("actors.0.profile.steps.0.speed_mps", printed(0.75 * v, 2)),
            ],
        };
        let of_all = [
            Setting::new("v2x.signals.0.stop_line_m", line_m),
            Setting::new("v2x.signals.0.program.0.duration_s", switch_s),
            Setting::new("duration_s", printed(switch_s + AFTER_S, 2)),
        ];
        of_scene.into_iter().chain(of_all).collect()
    }

    /// True if a crossing is in the light's favour.
    fn in_green(self, crossing_s: f64, variant: &Variant) -> bool {
        (crossing_s >= variant.switch_s) == (self == Self::C)
    }
}

/// Times at which a variant's four drives cross the line, s. `None` where one does not.
#[derive(Clone, Copy, Debug, Default)]
struct Crossings {
    acc: Option<f64>,
    cacc: Option<f64>,
    printed_acc: Option<f64>,
    printed_cacc: Option<f64>,
}

/// A piece for each scene, over `variants` of it.
pub fn pieces(variants: u32) -> Vec<Piece> {
    let piece = |scene: Scene| {
        Piece::new(format!("{SET}, {}", scene.names().0), move |runner| {
            let rows = of_scene(runner, scene, variants)?;
            Ok(Part::of_rows(
                rows.into_iter().map(|row| row.in_set(SET).with_source(PURPOSE)).collect(),
            ))
        })
    };
    Scene::ALL.map(piece).into()
}

/// Drives the variants of a scene and compares.
fn of_scene(runner: &Runner<'_>, scene: Scene, variants: u32) -> Result<Vec<Row>, Error> {
    let mut driven = Vec::new();
    for number in 0..variants {
        let variant = scene.variant(number);
        driven.push((variant, drive(runner, scene, &variant)?));
    }
    let in_green = |crossing: Option<f64>, variant: &Variant| {
        crossing.filter(|&crossing_s| scene.in_green(crossing_s, variant))
    };
    let passes = |of: fn(&Crossings) -> Option<f64>| {
        driven.iter().filter(move |(variant, crossings)| in_green(of(crossings), variant).is_some())
    };
    let red = driven.iter().filter(|(variant, crossings)| {
        crossings.cacc.is_some() && in_green(crossings.cacc, variant).is_none()
    });
    let stops = passes(|crossings| crossings.acc).filter(|(variant, crossings)| {
        let spare_s = (variant.switch_s - crossings.acc.unwrap_or_default()).abs();
        crossings.cacc.is_none() && spare_s >= SPARE_S
    });
    let both = driven.iter().filter_map(|(variant, crossings)| {
        let cacc = in_green(crossings.cacc, variant)?;
        let printed = in_green(crossings.printed_cacc, variant)?;
        Some((crossings.acc? - cacc, crossings.printed_acc? - printed))
    });
    let (gains, printed): (Vec<f64>, Vec<f64>) = both.unzip();
    let (gain, printed) = (median(gains), median(printed));
    // The printed formulation loses time in C.
    let goal = printed.map(|printed| if printed > 0.0 { SHARE * printed } else { printed });
    let id = |figure: &str| format!("{}.varied.{figure}", scene.names().0);
    let shown = |figure: &str, unit, ours, note| {
        Row::shown(&id(figure), unit, Kind::Requirement, ours, note)
    };
    let count = |figure: &str, count: usize, note| shown(figure, "", Some(count as f64), note);
    let never = |figure: &str, count: usize, note| {
        let ours = Some(count as f64);
        Row::at_most(&id(figure), "", requirement(0.0), ours, EXACT).with_note(note)
    };
    let gain = match goal {
        Some(goal) => Row::at_least(&id("gain_s"), "s", requirement(goal), gain, EXACT).with_note(
            "median over its ACC; at least half of the printed formulation's, or its loss",
        ),
        None => shown("gain_s", "s", gain, "no variant in which both formulations pass"),
    };
    Ok(vec![
        count("variants", driven.len(), "the first ones; --variants 250 drives the whole set"),
        count("acc_passes", passes(|c| c.acc).count(), "the blind baseline crosses in green"),
        count("cacc_passes", passes(|c| c.cacc).count(), "the default law crosses in green"),
        count("printed_passes", passes(|c| c.printed_cacc).count(), "the printed formulation"),
        never("red_lights", red.count(), "of the default law"),
        never("stops", stops.count(), "where the blind law passes with 0.1 s to spare"),
        shown("printed_gain_s", "s", printed, "median of the printed formulation over its ACC"),
        gain,
    ])
}

fn drive(runner: &Runner<'_>, scene: Scene, variant: &Variant) -> Result<Crossings, Error> {
    let of_variant = scene.settings(variant);
    let crossing = |law: &str, spacing: &[Setting]| {
        let law = [Setting::new("controller.name", law)];
        let set = [&of_variant[..], &law, spacing].concat();
        let driven = runner.drive(scene.names().1, &set)?;
        Ok::<_, Error>(passed_s(&driven.drive.steps, variant.line_m))
    };
    Ok(Crossings {
        acc: crossing("acc-mpc", &spacing())?,
        cacc: crossing("cacc-mpc", &spacing())?,
        printed_acc: crossing("acc-mpc", &[])?,
        printed_cacc: crossing("cacc-mpc", &[])?,
    })
}

fn hundredths(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() % 2 {
        1 => Some(values[middle]),
        _ => Some(0.5 * (values.get(middle)? + values.get(middle.checked_sub(1)?)?)),
    }
}
