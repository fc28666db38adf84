//! Behind a stopped lead every own law stands, on any grade, and drives when the lead drives.

use system_tests::{Corner, csv};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");
const LAWS: [&str; 5] = ["acc-mpc", "cacc-mpc", "six-mode", "quadratic-bounded", "predictive"];

/// A lead that brakes to standstill at 6 m/s², stands for 160 s and drives off. `grade_percent` is a truck's.
fn scenario(vehicle: &str, grade_percent: f64) -> String {
    let road = match vehicle {
        "car" => String::new(),
        _ => format!("[road]\npoints = [[0, 500], [500, {}]]\n", 500.0 + 5.0 * grade_percent),
    };
    format!(
        "schema_version = 1\nname = \"stand\"\nduration_s = 210\nset_speed_mps = 22\n\
         [aebs]\nenabled = false\n\
         [plant]\nvehicle = \"{vehicle}\"\nperiod_ms = 20\nintegration_step_ms = 20\n\
         initial_speed_mps = 20\nactuator_time_constant_s = 0.4\nmin_acceleration_mps2 = -6.5\n\
         {road}\
         [perception]\nperiod_ms = 100\nradar = {{ model = \"object-list\", max_range_m = 200 }}\n\
         [[actors]]\nname = \"lead\"\ngap_m = 50\ninitial_speed_mps = 20\nprofile.steps = [\n\
         {{ time_s = 5, speed_mps = 0, acceleration_mps2 = 6 }},\n\
         {{ time_s = 180, speed_mps = 5, acceleration_mps2 = 0.5 }}]\n"
    )
}

/// Every law stands from 60 s until the lead drives off at 180 s; `goes` states whether it can follow.
fn stands(vehicle: &str, grade_percent: f64, goes: bool) {
    let corner = Corner::new(PROGRAM);
    let file = corner.path().join("stand.toml");
    std::fs::write(&file, scenario(vehicle, grade_percent)).expect("a directory of its own");
    let file = file.to_str().expect("a plain path");
    let drives = |law: &&str| vehicle != "car" || *law != "predictive";
    for law in LAWS.into_iter().filter(drives) {
        let options = ["--controller", law, "--mode", "lockstep", "--in-process", "--out", law];
        let arguments: Vec<_> = ["run", file].into_iter().chain(options).collect();
        let summary = corner.json(&arguments);
        let place = format!("{law}, {vehicle} on {grade_percent} %");
        assert_eq!(summary["outcome"], "completed", "{place}");
        let table = corner.path().join(law).join("trajectory.csv");
        let table = std::fs::read_to_string(table).expect("written");
        let rows = csv(&table, &["time_s", "position_m", "speed_mps"]);
        let waiting = rows.iter().filter(|row| (60.0..180.0).contains(&row[0]));
        let places: Vec<_> = waiting.map(|row| row[1]).collect();
        // A car's law may correct its gap by a millimetre; a creeping vehicle moves metres.
        let moved_m = places.last().expect("rows") - places[0];
        assert!(moved_m < 0.01, "{place}: creeps {moved_m} m");
        let last = rows.last().expect("rows")[2];
        assert_eq!(last > 2.0, goes, "{place}: {last} m/s thirty seconds after the lead began");
    }
}

#[test]
fn a_car_stands_and_goes() {
    stands("car", 0.0, true);
}

#[test]
fn a_truck_stands_and_goes_on_the_level_and_downhill() {
    for grade_percent in [0.0, -1.0, -8.0] {
        stands("jh6-49t", grade_percent, true);
    }
    stands("jh6-25t", -10.0, true);
}

/// The model has the top six of twelve gears. Its greatest force balances 49 t on 3.7 %, and 25 t on 5.7 %.
#[test]
fn a_truck_stands_uphill_and_goes_where_its_lowest_gear_can() {
    stands("jh6-49t", 2.0, true);
    stands("jh6-25t", 3.0, true);
    stands("jh6-49t", 8.0, false);
}

#[test]
fn the_truck_that_brakes_downhill_stands_long_after_the_scene() {
    let corner = Corner::new(PROGRAM);
    for law in LAWS {
        for seed in ["1", "9"] {
            let options = ["--seed", seed, "--duration", "120", "--mode", "lockstep"];
            let arguments: Vec<_> =
                ["run", "truck-brake", "--controller", law].into_iter().chain(options).collect();
            let summary = corner.json(&[&arguments[..], &["--in-process"]].concat());
            assert_eq!(summary["outcome"], "completed", "{law}, seed {seed}");
        }
    }
}
