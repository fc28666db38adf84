//! The tables of the predictive truck, without processes:
//! `cargo run --release -p papers --example predictive_tables`. `-- families` prints the table of road families
//! alone, and `-- held-back` the same on other roads. `-- export FOLDER` writes these roads as CSV files, which
//! scenarios can drive, too. `-- road FILE` drives one of such a file.
//!
//! Fuel is against constant speed at equal trip time, with the kinetic energy at the end corrected.

mod families;

use controller::laws::truck::PlannerKind::{DynamicProgramming, PaperN2};
use families::FAMILIES;
use papers::trips::{Comparison, Map, Road, Trip, generated as generated_road};
use rand_core::Rng;
use rand_pcg::Pcg64;
use scenario::grade::{GradeProfile, Point};
use scenario::road::HILLS_60KM;
use std::ops::RangeInclusive;
use truck_model::{Preset, Truck};

/// Set speed, m/s.
const SET_MPS: f64 = 75.0 / 3.6;

/// Roads of each family on which the planners were worked on, and roads that were held back.
const FAMILY_SEEDS: RangeInclusive<u64> = 1..=4;
const HELD_BACK_SEEDS: RangeInclusive<u64> = 101..=104;

/// Change of fuel on a road, %, by `paper-n2`, `dynamic-programming` and the full-route plan, and the losses, % of the
/// baseline's fuel.
type Figures = [(f64, [f64; 3]); 3];

fn main() {
    let mut arguments = std::env::args().skip(1);
    let part = arguments.next();
    match (part.as_deref(), arguments.next()) {
        (Some("families"), _) => return all_families(FAMILY_SEEDS),
        (Some("held-back"), _) => return all_families(HELD_BACK_SEEDS),
        (Some("export"), Some(folder)) => return export(&folder),
        (Some("road"), Some(file)) => {
            let text = std::fs::read_to_string(file).expect("a file that can be read");
            return Preset::ALL.into_iter().for_each(|preset| savings(preset, &road(&text)));
        }
        _ => all_families(FAMILY_SEEDS),
    }
    let given = road(HILLS_60KM);
    for preset in Preset::ALL {
        savings(preset, &given);
    }
    println!("\nten generated roads of 60 km, fuel in percent");
    for preset in Preset::ALL {
        generated(preset);
    }
    println!("\nwrongly informed, given road, fuel in percent against constant speed");
    for preset in Preset::ALL {
        robustness(preset, &given);
    }
}

fn all_families(seeds: RangeInclusive<u64>) {
    println!("families of roads of 60 km, fuel in percent against constant speed");
    for preset in Preset::ALL {
        families(preset, seeds.clone());
    }
}

/// Writes every road of the families as a file of distances and heights.
fn export(folder: &str) {
    for family in &FAMILIES {
        for seed in FAMILY_SEEDS.chain(HELD_BACK_SEEDS) {
            let road = family.road(seed);
            let mut text = String::from("distance_m,height_m\n0,0\n");
            let mut height_m = 0.0;
            for (cell, grade) in road.grades().iter().enumerate() {
                height_m += road.cell_m() * grade;
                let distance_m = road.cell_m() * (cell + 1) as f64;
                text += &format!("{distance_m},{height_m:.4}\n");
            }
            let file =
                std::path::Path::new(folder).join(format!("{}-{seed}.csv", family.file_name()));
            std::fs::write(file, text).expect("a folder that can be written to");
        }
    }
}

/// The road of lines of distance and height.
fn road(text: &str) -> Road {
    let numbers = |line: &str| -> Vec<f64> { line.split(',').flat_map(str::parse).collect() };
    let rows = text.lines().map(numbers).filter(|row| row.len() == 2);
    let points = rows.map(|row| Point { distance_m: row[0], height_m: row[1] }).collect();
    Road::from_profile(
        &GradeProfile::new(points).expect("distances that increase, and grades of roads"),
    )
}

fn savings(preset: Preset, road: &Road) {
    let comparison = on(preset, road);
    let litres = comparison.l_per_100_km(&comparison.baseline);
    println!("\n{}: constant speed {litres:.2} L/100 km", preset.name());
    let bound = comparison.bound();
    for (name, trip) in [
        ("paper-n2", comparison.informed(PaperN2)),
        ("dynamic-programming", comparison.informed(DynamicProgramming)),
        ("the whole route", bound),
    ] {
        print_trip(&comparison, name, trip.as_ref());
    }
    for sigma_kmh in [2.5, 4.0] {
        let trips: Vec<Trip> =
            (0..8).filter_map(|seed| comparison.human(sigma_kmh / 3.6, seed)).collect();
        let sum: f64 = trips.iter().map(|trip| comparison.change_percent(trip)).sum();
        let mean = sum / trips.len() as f64;
        println!("  a driver, sigma {sigma_kmh} km/h  {mean:+.2} %  mean of {} seeds", trips.len());
    }
}

fn print_trip(comparison: &Comparison, name: &str, trip: Option<&Trip>) {
    let Some(trip) = trip else {
        println!("  {name:<22} no trip of equal time");
        return;
    };
    let late = 100.0 * (trip.time_s / comparison.baseline.time_s - 1.0);
    let (low, high) = trip.speed_range_mps;
    println!(
        "  {name:<22} {:+.2} %  time {late:+.3} %, {:.1} to {:.1} km/h, {} shifts, service brakes {:.1} MJ",
        comparison.change_percent(trip),
        3.6 * low,
        3.6 * high,
        trip.shifts,
        trip.ledger.service_brake_j / 1e6,
    );
}

fn generated(preset: Preset) {
    println!("{:<10} {:>5} {:>9} {:>9} {:>9} {:>9}", "", "seed", "n2", "dp", "bound", "dp-bound");
    let mut worst = 0.0_f64;
    for seed in 1..=10 {
        let road = generated_road(60_000.0, seed);
        let comparison = on(preset, &road);
        let change = |trip: Option<Trip>| trip.map_or(f64::NAN, |t| comparison.change_percent(&t));
        let n2 = change(comparison.informed(PaperN2));
        let dp = change(comparison.informed(DynamicProgramming));
        let bound = change(comparison.bound());
        println!(
            "{:<10} {seed:>5} {n2:>9.2} {dp:>9.2} {bound:>9.2} {:>9.2}",
            preset.name(),
            dp - bound
        );
        worst = worst.max(dp - bound);
    }
    println!("{:<10} worst distance to the bound {worst:.2}", preset.name());
}

/// Savings on each family: the means, and the largest distance to the full-route plan; then where the means
/// come from.
fn families(preset: Preset, seeds: RangeInclusive<u64>) {
    println!(
        "{:<10} {:<28} {:>5} {:>9} {:>9} {:>9} {:>9} {:>9}   n2: brakes, air, driveline; route: the same",
        "", "", "roads", "n2", "dp", "bound", "n2-bound", "dp-bound"
    );
    for family in &FAMILIES {
        let roads: Vec<[(f64, [f64; 3]); 3]> = seeds
            .clone()
            .filter_map(|seed| {
                let road = family.road(seed);
                let comparison = Comparison::new(&Truck::preset(preset), &road, SET_MPS)?;
                let of = |trip: Option<Trip>| {
                    trip.map(|trip| (comparison.change_percent(&trip), losses(&comparison, &trip)))
                };
                let n2 = of(comparison.informed(PaperN2))?;
                let dp = of(comparison.informed(DynamicProgramming))?;
                Some([n2, dp, of(comparison.bound())?])
            })
            .collect();
        let mean = |value: &dyn Fn(&Figures) -> f64| {
            roads.iter().map(value).sum::<f64>() / roads.len() as f64
        };
        let worst = |k: usize| {
            roads.iter().map(|road| road[k].0 - road[2].0).fold(f64::NEG_INFINITY, f64::max)
        };
        print!("{:<10} {:<28} {:>5}", preset.name(), family.name, roads.len());
        for k in 0..3 {
            print!(" {:>9.2}", mean(&|road| road[k].0));
        }
        print!(" {:>9.2} {:>9.2}  ", worst(0), worst(1));
        for (k, loss) in [(0, 0), (0, 1), (0, 2), (2, 0), (2, 1), (2, 2)] {
            print!(" {:+.2}", mean(&|road| road[k].1[loss]));
        }
        println!();
    }
}

/// Extra losses of brakes, air and driveline against constant speed. They are in percent of the baseline's fuel, at the
/// price of energy.
fn losses(comparison: &Comparison, trip: &Trip) -> [f64; 3] {
    let baseline = &comparison.baseline;
    let of = |trip: &Trip| {
        let ledger = &trip.ledger;
        [ledger.service_brake_j + ledger.engine_brake_j, ledger.air_j, ledger.driveline_j]
    };
    let (ours, theirs) = (of(trip), of(baseline));
    let percent_per_j = 100.0 * comparison.energy_gpj / baseline.fuel_g;
    [0, 1, 2].map(|k| percent_per_j * (ours[k] - theirs[k]))
}

fn robustness(preset: Preset, road: &Road) {
    let comparison = on(preset, road);
    let truck = Truck::preset(preset);
    let mass_kg = truck.parameters().mass_kg;
    let map = Map { road: road.clone(), shift_m: 0.0 };
    let cases = [
        ("nothing wrong", truck, map.clone()),
        ("mass believed 15 % high", truck.with_mass_kg(1.15 * mass_kg), map.clone()),
        ("mass believed 15 % low", truck.with_mass_kg(0.85 * mass_kg), map.clone()),
        ("map 60 m late", truck, Map { shift_m: 60.0, ..map.clone() }),
        ("map 60 m early", truck, Map { shift_m: -60.0, ..map.clone() }),
        ("grade noise 0.25 %", truck, Map { road: noisy(road), shift_m: 0.0 }),
    ];
    println!("{:<10} {:<26} {:>9} {:>9}", "", "", "n2", "dp");
    for (name, believed, map) in cases {
        let change = |planner| {
            let trip = comparison.assisted(planner, &believed, &map);
            trip.map_or(f64::NAN, |trip| comparison.change_percent(&trip))
        };
        let (n2, dp) = (change(PaperN2), change(DynamicProgramming));
        println!("{:<10} {name:<26} {n2:>9.2} {dp:>9.2}", preset.name());
    }
}

/// The road with grades off by 0.25 %, standard deviation.
fn noisy(road: &Road) -> Road {
    let mut rng = Pcg64::new(1, 1);
    let mut uniform = || (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    // Irwin and Hall: the sum of twelve has a variance of one.
    let mut normal = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
    let grades = road.grades().iter().map(|grade| grade + 0.0025 * normal()).collect();
    Road::new(road.cell_m(), grades)
}

fn on(preset: Preset, road: &Road) -> Comparison {
    Comparison::new(&Truck::preset(preset), road, SET_MPS).expect("the truck gets over this road")
}
