//! Effect of each number of the sensor model and of the tracker.
//!
//! ```sh
//! cargo run --release -p perception-sim --example perception_numbers -- [SCENES [NAMES]]
//! ```
//!
//! Each number is halved and doubled, within its range, while all others keep their values. `NAMES` lists some of them,
//! as `a,b`. The scenes are those of the example `quality`. A quarter each has a sound radar, fast odometry, and a
//! blind radar. The last quarter has a radar that misses three vehicles and posts of ten. Odometry is 1.5 m/s fast from
//! 8 s on; the radar is blind for 1.5 s.

use bytemuck::Zeroable;
use messages::{Detection, MAX_DETECTIONS};
use parameters::effect::{Figure, line};
use parameters::{Row, Table};
use perception_sim::quality::Quality;
use perception_sim::radar::Scan;
use perception_sim::radar::detections::DetectionRadar;
use perception_sim::radar::numbers::Numbers as RadarNumbers;
use perception_sim::radar::receiver::Receiver;
use perception_sim::radar::scene::{Ego, Scene};
use perception_sim::tracking::TrackList;
use perception_sim::tracking::course::Course;
use perception_sim::tracking::ego_speed::EgoSpeed;
use perception_sim::tracking::numbers::Numbers as TrackerNumbers;
use perception_sim::tracking::tracker::Tracker;
use perception_sim::traffic::Traffic;
use scenario::Scenario;

mod scenes;

use scenes::{PERIOD_NS, SCANS, follow, scene};

/// Scans before the figures begin: the tracker finds the traffic.
const SETTLING: usize = 20;

/// Fault in a scene.
#[derive(Clone, Copy, PartialEq)]
enum Condition {
    Sound,
    Misses,
    FastOdometry,
    Blind,
}

const CONDITIONS: [Condition; 4] =
    [Condition::Sound, Condition::Misses, Condition::FastOdometry, Condition::Blind];

/// Share of vehicles and posts that a radar with misses does not show in a scan.
const MISSED: f64 = 0.3;

/// Sums over the scenes.
#[derive(Clone, Copy, Default)]
struct Sums {
    scenes: f64,
    gospa_m2: f64,
    cut_ins: f64,
    cut_in_s: f64,
    false_s: f64,
    acceleration: (f64, f64),
    share: (f64, f64),
    speed: (f64, f64),
}

static FIGURES: [Figure; 6] = [
    Figure::percent("GOSPA", "m", 1.0),
    Figure::difference("cut-in delay", "s", 0.02),
    Figure::percent("time with a false target", "s", 10.0),
    Figure::percent("error of the target's acceleration", "m/s²", 2.0),
    Figure::percent("error of the seen share", "", 5.0),
    Figure::percent("error of the ego's speed", "m/s", 5.0),
];

impl Sums {
    /// The figures, in the order of [`FIGURES`].
    fn figures(&self) -> Vec<f64> {
        let mean_square = |(sum, count): (f64, f64)| (sum / count).sqrt();
        vec![
            (self.gospa_m2 / self.scenes).sqrt(),
            self.cut_in_s / self.cut_ins,
            self.false_s,
            mean_square(self.acceleration),
            self.share.0 / self.share.1,
            mean_square(self.speed),
        ]
    }
}

/// The truth of a scene, and how it is seen.
struct Drive {
    scenario: Scenario,
    condition: Condition,
    truth: Vec<Scene>,
}

impl Drive {
    fn new(seed: u32) -> Self {
        let condition = CONDITIONS[(seed / 4) as usize % CONDITIONS.len()];
        let missed = format!("/perception.radar.dropout_probability={MISSED}");
        let keys: &[&str] = if condition == Condition::Misses { &[&missed] } else { &[] };
        let scenario = scene(seed, keys);
        let mut traffic = Traffic::new(&scenario);
        let mut ego = Ego { speed_mps: scenario.plant.initial_speed_mps.value(), ..Ego::default() };
        let mut truth = Vec::new();
        for time_ns in (0..SCANS).map(|k| k * PERIOD_NS) {
            traffic.advance(time_ns, &ego);
            let mut scene = Scene::new(time_ns as i64, ego, traffic.vehicles());
            if condition == Condition::FastOdometry && time_ns >= 8_000_000_000 {
                scene.told = Some(Ego { speed_mps: ego.speed_mps + 1.5, ..ego });
            }
            truth.push(scene);
            ego = follow(ego, scenario.set_speed_mps.value(), traffic.vehicles());
        }
        Self { scenario, condition, truth }
    }

    /// The detections of all scans.
    fn scan(&self, numbers: &RadarNumbers) -> (Receiver, Vec<Vec<Detection>>) {
        let mut radar = DetectionRadar::with(&self.scenario, numbers);
        let mut room = Box::new([Detection::zeroed(); MAX_DETECTIONS]);
        let scans = self.truth.iter().map(|scene| {
            let count = radar.scan(None, scene, &mut room).count;
            let blind = self.condition == Condition::Blind
                && (10_000_000_000..11_500_000_000).contains(&scene.time_ns);
            room[..if blind { 0 } else { count }].to_vec()
        });
        let scans = scans.collect();
        (*radar.receiver(), scans)
    }

    fn track(
        &self,
        (receiver, scans): &(Receiver, Vec<Vec<Detection>>),
        numbers: &TrackerNumbers,
        sums: &mut Sums,
    ) {
        let mut tracker = Tracker::new(&self.scenario, receiver, numbers);
        let mut ego_speed = EgoSpeed::new(numbers);
        let mut quality = Quality::new(&self.scenario);
        for (k, (scene, detections)) in self.truth.iter().zip(scans).enumerate() {
            let known =
                ego_speed.take_scan(&Course::STRAIGHT, scene.time_ns, scene.told, detections);
            let list = tracker.step(scene.time_ns, &known, None, None, Scan::of_echoes(detections));
            if k < SETTLING {
                continue;
            }
            quality.observe(scene, &list, scene.time_ns);
            add_acceleration(scene, &list, &mut sums.acceleration);
            if self.condition != Condition::Blind {
                let truly = if self.condition == Condition::Misses { 1.0 - MISSED } else { 1.0 };
                sums.share.0 += (tracker.sight.share() - truly).abs();
                sums.share.1 += 1.0;
            }
            if scene.told != Some(scene.ego) {
                sums.speed.0 += (known.speed_mps - scene.ego.speed_mps).powi(2);
                sums.speed.1 += 1.0;
            }
        }
        let figures = quality.figures();
        sums.scenes += 1.0;
        sums.gospa_m2 += figures.gospa_m * figures.gospa_m;
        sums.cut_ins += figures.cut_ins as f64;
        sums.cut_in_s += figures.cut_in_mean_s.unwrap_or(0.0) * figures.cut_ins as f64;
        sums.false_s += figures.false_target_s;
    }
}

/// Adds the squared error of the target's acceleration, if the target is the vehicle ahead.
fn add_acceleration(scene: &Scene, list: &TrackList, sum: &mut (f64, f64)) {
    let gap_m = |rear_m: f64| rear_m - scene.ego.position_m;
    let ahead = scene.vehicles.iter().filter(|vehicle| vehicle.in_ego_path());
    let ahead = ahead.filter(|vehicle| gap_m(vehicle.rear_position_m) > 0.0);
    let ahead = ahead.min_by(|a, b| a.rear_position_m.total_cmp(&b.rear_position_m));
    if let (Some(ahead), Some(target)) = (ahead, list.target())
        && (gap_m(ahead.rear_position_m) - target.gap_m).abs() < 5.0
    {
        sum.0 += (target.acceleration_mps2 - ahead.acceleration_mps2).powi(2);
        sum.1 += 1.0;
    }
}

/// Rows of a table that `names` lists, or all of them.
fn rows<T: Table>(names: Option<&str>) -> impl Iterator<Item = usize> {
    (0..T::ROWS.len()).filter(move |row| {
        names.is_none_or(|names| names.split(',').any(|name| name == T::ROWS[*row].name))
    })
}

/// The sums with each row of a table halved and doubled.
fn vary<T: Table>(
    default: T,
    names: Option<&str>,
    mut run: impl FnMut(&T, &mut Sums),
    sums: &mut [[Sums; 2]],
) {
    for row in rows::<T>(names) {
        let sums = &mut sums[row];
        for (factor, sums) in [0.5, 2.0].into_iter().zip(sums) {
            run(&default.scaled(row, factor), sums);
        }
    }
}

fn print<T: Table>(default: T, names: Option<&str>, base: &Sums, sums: &[[Sums; 2]]) {
    for row in rows::<T>(names) {
        let Row { name, .. } = &T::ROWS[row];
        let values = [0.5, 2.0].map(|factor| default.scaled(row, factor).value(row));
        let tried = [0, 1].map(|k| (values[k], sums[row][k].figures()));
        println!("{}", line(name, &FIGURES, &base.figures(), &tried));
    }
}

fn main() {
    let scenes = std::env::args().nth(1).map_or(160, |argument| {
        argument.parse().unwrap_or_else(|_| panic!("`{argument}` is not a number of scenes"))
    });
    let names = std::env::args().nth(2);
    let names = names.as_deref();
    let mut base = Sums::default();
    let mut radar = vec![[Sums::default(); 2]; RadarNumbers::ROWS.len()];
    let mut tracker = vec![[Sums::default(); 2]; TrackerNumbers::ROWS.len()];
    for seed in 0..scenes {
        let drive = Drive::new(seed);
        let seen = drive.scan(&RadarNumbers::DEFAULT);
        drive.track(&seen, &TrackerNumbers::DEFAULT, &mut base);
        let with_radar = |numbers: &RadarNumbers, sums: &mut Sums| {
            drive.track(&drive.scan(numbers), &TrackerNumbers::DEFAULT, sums);
        };
        vary(RadarNumbers::DEFAULT, names, with_radar, &mut radar);
        let with_tracker =
            |numbers: &TrackerNumbers, sums: &mut Sums| drive.track(&seen, numbers, sums);
        vary(TrackerNumbers::DEFAULT, names, with_tracker, &mut tracker);
    }
    println!("{scenes} scenes of {} s", SCANS / 20);
    for (figure, value) in FIGURES.iter().zip(base.figures()) {
        println!("{}", figure.text(value));
    }
    println!("\nSensor model");
    print(RadarNumbers::DEFAULT, names, &base, &radar);
    println!("\nTracker");
    print(TrackerNumbers::DEFAULT, names, &base, &tracker);
}
