//! Target selection on random roads: by the straight path, and by a course from more and more sources.
//!
//! ```sh
//! cargo run --release -p perception-sim --example course -- [ROADS [KILOMETRES [ROW]]] [NUMBER=VALUE]...
//! cargo run --release -p perception-sim --example course -- effects [ROADS [KILOMETRES [NUMBERS]]]
//! cargo run --release -p perception-sim --example course -- empty [ROADS [KILOMETRES]]
//! cargo run --release -p perception-sim --example course -- queues [SCENES [HYPOTHESES]]
//! ```
//!
//! A lead drives at a constant gap in the ego's lane. Each neighbouring lane has one vehicle, at 0.5 to 1.3 of that
//! gap. All have the same speed and wander in their lanes. The radar has all of its imperfections. Module `ego` is the
//! ego. Every figure is of seeded roads and the same on every machine.
//!
//! A lead is lost while no track on it is in the path. A neighbour is taken while a track on it is in the path. Both
//! count from 8 s on. "Unseen" is the share of time in which the lead has no track at all, so that no selection helps.
//! `ROW` is a part of a row's name; a number is one of the tracker's `Numbers`. The third table is a
//! straight road: what the radar's imperfections alone cost. `effects` halves and doubles each number that `NUMBERS`
//! lists. `empty` drives roads without vehicles, by radius. `queues` compares the belief with an oracle before queues in
//! curves.

use bytemuck::Zeroable;
use messages::{Detection, MAX_DETECTIONS};
use parameters::effect::{Figure, line};
use parameters::{Row, Table};
use perception_sim::perception::Perception;
use perception_sim::random::Random;
use perception_sim::tracking::Track;
use perception_sim::tracking::numbers::Numbers;
use perception_sim::tracking::sources::Sources;
use road::random::{Recipe, pieces};
use road::{Axis, Piece};
use scenario::Scenario;
use std::sync::Arc;

mod ego;
mod empty;
mod oracle;
mod queue;

use ego::{CELL_M, Scan};

/// Time that does not count, s.
const SETTLES_S: f64 = 8.0;
/// Distance within which a track is on a vehicle, m.
const NEAR_M: f64 = 6.0;

/// A row: its name and the sources.
const ROWS: [(&str, Sources); 5] = [
    ("straight", Sources { yaw_rate: false, standing: false, trails: false, map: false }),
    ("yaw rate", Sources { yaw_rate: true, standing: false, trails: false, map: false }),
    ("+ standing", Sources { yaw_rate: true, standing: true, trails: false, map: false }),
    ("+ trails", Sources { yaw_rate: true, standing: true, trails: true, map: false }),
    ("+ map", Sources { yaw_rate: true, standing: true, trails: true, map: true }),
];

/// Radii, m, and speed, m/s. The last one is a straight road, for comparison.
const ROADS: [(f64, f64, f64); 3] =
    [(250.0, 2000.0, 22.4), (500.0, 2000.0, 30.0), (f64::INFINITY, f64::INFINITY, 30.0)];

/// Counts over some way.
#[derive(Default)]
struct Sums {
    scans: f64,
    km: f64,
    lost: f64,
    losses: f64,
    unseen: f64,
    taken: f64,
    takes: f64,
    squares: f64,
    seen: f64,
    /// Largest lack of the seen share.
    missing_share: f64,
}

impl Sums {
    fn print(&self, name: &str, gap_m: f64) {
        let share = |count: f64| 100.0 * count / self.scans;
        println!(
            "| {name:10} | {gap_m:4} | {:6.2} | {:6.2} | {:6.2} | {:6.2} | {:6.2} | {:6.2} | {:6.2} |",
            share(self.lost),
            self.losses / self.km,
            share(self.unseen),
            share(self.taken),
            self.takes / self.km,
            (self.squares / self.seen.max(1.0)).sqrt(),
            1.0 - self.missing_share,
        );
    }
}

/// The scenario of a seeded scene.
fn scene(seed: u64, gap_m: f64, speed_mps: f64, duration_s: f64) -> Scenario {
    let mut random = Random::of_run(seed, 5);
    let mut text = format!(
        "schema_version = 1\nname = \"scene\"\nseed = {seed}\n\
         [plant]\ninitial_speed_mps = {speed_mps}\n"
    );
    for (name, gap_m, lane_m) in [
        ("lead", gap_m, 0.0),
        ("left", gap_m * random.between(0.5, 1.3), 3.5),
        ("right", gap_m * random.between(0.5, 1.3), -3.5),
    ] {
        // Each goes to another place in its lane every few seconds.
        let (mut at_s, mut wander) = (random.between(0.5, 3.0), Vec::new());
        while at_s < duration_s {
            let to_m = lane_m + 0.2 * random.normal().clamp(-2.5, 2.5);
            let takes_s = random.between(2.0, 4.0);
            wander.push(format!(
                "{{ time_s = {at_s:.2}, to_m = {to_m:.3}, duration_s = {takes_s:.2} }}"
            ));
            at_s += takes_s + random.between(0.0, 2.0);
        }
        text += &format!(
            "[[actors]]\nname = \"{name}\"\ngap_m = {gap_m:.2}\ninitial_speed_mps = {speed_mps}\n\
             lateral_offset_m = {lane_m}\nlateral = [{}]\n",
            wander.join(", ")
        );
    }
    Scenario::parse("course", &text).unwrap_or_else(|error| panic!("{error}"))
}

/// Place of a track in the ego's axes.
fn place(track: &Track) -> (f64, f64) {
    let (sine, cosine) = track.azimuth_rad.sin_cos();
    (track.range_m * cosine, track.range_m * sine)
}

/// The vehicle on which a track is.
fn owner(perception: &Perception, track: &Track) -> Option<usize> {
    let scene = perception.scanned();
    let plane = scene.plane.as_ref()?;
    let (x, y) = place(track);
    let off_m = |index: &usize| {
        let body = &plane.bodies[*index];
        let (dx, dy) = (x - body.rear_m.0, y - body.rear_m.1);
        // Along the body an echo may come from any place of it.
        let (along, across) =
            (dx * body.cosine + dy * body.sine, dy * body.cosine - dx * body.sine);
        let beyond = (-along).max(along - scene.vehicles[*index].length_m).max(0.0);
        beyond.hypot(2.0 * across)
    };
    let nearest = (0..3).min_by(|a, b| off_m(a).total_cmp(&off_m(b)))?;
    (off_m(&nearest) < NEAR_M).then_some(nearest)
}

fn drive(
    road: &Arc<Axis>,
    sources: Sources,
    numbers: &Numbers,
    (seed, gap_m, speed_mps): (u64, f64, f64),
    detections: &mut [Detection; MAX_DETECTIONS],
    sums: &mut Sums,
) {
    let duration_s = (road.length_m() - 1.6 * gap_m - 200.0) / speed_mps;
    let scenario = scene(seed, gap_m, speed_mps, duration_s);
    let mut perception = Perception::with(&scenario, numbers).on_road(Arc::clone(road), sources);
    let cells: Vec<f64> = (0..(road.length_m() / CELL_M) as usize)
        .map(|cell| road.curvature_perm((cell as f64 + 0.5) * CELL_M))
        .collect();
    let (mut was_lost, mut was_taken, mut last_way_m) = (true, [false; 3], 0.0);
    ego::drive(&mut perception, road, (seed, speed_mps), &cells, detections, |scan| {
        let Scan { perception, tracks, .. } = scan;
        let goes_on = scan.time_s < duration_s;
        if scan.time_s < SETTLES_S {
            last_way_m = scan.position_m;
            return goes_on;
        }
        let (mut seen, mut in_path) = (false, [false; 3]);
        for track in tracks.tracks() {
            let Some(vehicle) = owner(perception, track) else { continue };
            in_path[vehicle] |= track.in_path;
            if vehicle == 0 {
                seen = true;
                let off_m = track.lateral_m - perception.scanned().vehicles[0].lateral_m;
                sums.squares += off_m * off_m;
                sums.seen += 1.0;
            }
        }
        sums.scans += 1.0;
        sums.missing_share = sums.missing_share.max(1.0 - perception.seen_share());
        sums.km += (scan.position_m - last_way_m) * 1e-3;
        last_way_m = scan.position_m;
        sums.lost += f64::from(u8::from(!in_path[0]));
        sums.losses += f64::from(u8::from(!in_path[0] && !was_lost));
        was_lost = !in_path[0];
        sums.unseen += f64::from(u8::from(!seen));
        for (taken, was) in in_path.iter().zip(&mut was_taken).skip(1) {
            sums.taken += f64::from(u8::from(*taken));
            sums.takes += f64::from(u8::from(*taken && !*was));
            *was = *taken;
        }
        goes_on
    });
}

/// Sets a number of a table, if it has one of the name.
fn set<T: Table>(table: &mut T, name: &str, value: &str) -> bool {
    let row = T::ROWS.iter().position(|row| row.name == name);
    row.inspect(|row| *table = table.with(*row, number(value))).is_some()
}

fn number(word: &str) -> f64 {
    word.parse().unwrap_or_else(|_| panic!("`{word}` is not a number"))
}

/// The roads of a row: radii, m, and speed, m/s; their number and length, km.
#[derive(Clone, Copy)]
struct Roads {
    kind: (f64, f64, f64),
    count: u64,
    kilometres: f64,
}

impl Roads {
    /// Drives all roads with one gap.
    fn drive(
        &self,
        sources: Sources,
        numbers: &Numbers,
        gap_m: f64,
        detections: &mut [Detection; MAX_DETECTIONS],
    ) -> Sums {
        let (min_radius_m, max_radius_m, speed_mps) = self.kind;
        let length_m = 1e3 * self.kilometres;
        let recipe = Recipe { length_m, min_radius_m, max_radius_m, spiral_m: [30.0, 200.0] };
        let mut sums = Sums::default();
        for seed in 0..self.count {
            let pieces = match min_radius_m.is_finite() {
                true => pieces(&recipe, seed),
                false => vec![Piece::Line { length_m }],
            };
            let road = Arc::new(Axis::new(&pieces).expect("a road"));
            drive(&road, sources, numbers, (seed, gap_m, speed_mps), detections, &mut sums);
        }
        sums
    }
}

/// Figures by which the effect of a number is judged, over both kinds of roads with curves and two gaps.
static FIGURES: [Figure; 5] = [
    Figure::percent("lead lost", "% of the time", 10.0),
    Figure::percent("neighbour taken", "% of the time", 10.0),
    Figure::percent("lead's offset", "m", 2.0),
    Figure::percent("lead lost with the map", "% of the time", 10.0),
    Figure::percent("neighbour taken with the map", "% of the time", 10.0),
];

fn figures(
    numbers: &Numbers,
    (count, kilometres): (u64, f64),
    detections: &mut [Detection; MAX_DETECTIONS],
) -> Vec<f64> {
    let mut found = Vec::new();
    for (_, sources) in &ROWS[3..] {
        let (mut scans, mut lost, mut taken, mut squares, mut seen) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for kind in &ROADS[..2] {
            for gap_m in [60.0, 100.0] {
                let roads = Roads { kind: *kind, count, kilometres };
                let sums = roads.drive(*sources, numbers, gap_m, detections);
                scans += sums.scans;
                lost += sums.lost;
                taken += sums.taken;
                squares += sums.squares;
                seen += sums.seen;
            }
        }
        found.extend([100.0 * lost / scans, 100.0 * taken / scans]);
        if !sources.map {
            found.push((squares / seen).sqrt());
        }
    }
    found
}

/// Prints the effect of each number that `names` lists.
fn print_effects(numbers: Numbers, roads: (u64, f64), names: &str) {
    let mut detections = Box::new([Detection::zeroed(); MAX_DETECTIONS]);
    let base = figures(&numbers, roads, &mut detections);
    for (figure, value) in FIGURES.iter().zip(&base) {
        println!("{}", figure.text(*value));
    }
    for (row, Row { name, .. }) in Numbers::ROWS.iter().enumerate() {
        if names.split(',').any(|asked| asked == *name) {
            let tried = [0.5, 2.0].map(|factor| {
                let numbers = numbers.scaled(row, factor);
                (numbers.value(row), figures(&numbers, roads, &mut detections))
            });
            println!("{}", line(name, &FIGURES, &base, &tried));
        }
    }
}

fn main() {
    let (changes, mut words): (Vec<String>, Vec<String>) =
        std::env::args().skip(1).partition(|word| word.contains('='));
    let mut numbers = Numbers::DEFAULT;
    for change in &changes {
        let (name, value) = change.split_once('=').expect("it has one");
        assert!(set(&mut numbers, name, value), "`{name}` is not a number of the tracker");
    }
    if words.first().is_some_and(|word| word == "queues") {
        let number =
            |index: usize, other: u64| words.get(index).map_or(other, |word| number(word) as u64);
        let mut detections = Box::new([Detection::zeroed(); MAX_DETECTIONS]);
        queue::print(number(1, 12), number(2, 1_000) as usize, &mut detections);
        return;
    }
    let of_effects = words.first().is_some_and(|word| word == "effects");
    let of_empty = words.first().is_some_and(|word| word == "empty");
    words.drain(..usize::from(of_effects || of_empty));
    let count = words.first().map_or(100.0, |word| number(word)) as u64;
    let kilometres = words.get(1).map_or(5.0, |word| number(word));
    let only = words.get(2);
    if of_effects {
        print_effects(numbers, (count, kilometres), only.map_or("", String::as_str));
        return;
    }
    let mut detections = Box::new([Detection::zeroed(); MAX_DETECTIONS]);
    if of_empty {
        empty::print(count, kilometres, &numbers, &ROWS[1..4], &mut detections);
        return;
    }
    for kind in ROADS {
        let (min_radius_m, max_radius_m, speed_mps) = kind;
        println!(
            "\n{count} roads of {kilometres} km, radii {min_radius_m} to {max_radius_m} m, {speed_mps} m/s\n"
        );
        println!(
            "| sources | gap, m | lead lost, % | per km | unseen, % | neighbour taken, % | per km \
             | lead's offset, rms m | least seen share |"
        );
        println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
        for (name, sources) in ROWS {
            if only.is_some_and(|only| !name.contains(only.as_str())) {
                continue;
            }
            for gap_m in [40.0, 60.0, 80.0, 100.0] {
                let roads = Roads { kind, count, kilometres };
                roads.drive(sources, &numbers, gap_m, &mut detections).print(name, gap_m);
            }
        }
    }
}
