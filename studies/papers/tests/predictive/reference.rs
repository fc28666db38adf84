//! The reference of trip time against the truck that keeps its speed.

use controller::laws::truck::{Reference, Speeds};
use papers::trips::{Cruise, Road, drive};
use truck_model::{Preset, Truck};

/// The baseline of all savings, with the plant's engine, gearbox and shifts.
#[test]
fn it_takes_the_time_of_the_truck_that_keeps_its_speed() {
    let (set_mps, limit_mps) = (75.0 / 3.6, 80.0 / 3.6);
    let speeds = Speeds { set_mps, limit_mps, start_mps: set_mps };
    let climb = [vec![0.0; 20], vec![0.03; 60], vec![-0.03; 60], vec![0.0; 20]].concat();
    for (grades, faster) in [(vec![0.0; 100], 0.001), (climb, 0.08)] {
        for preset in Preset::ALL {
            let truck = Truck::preset(preset);
            let road = Road::new(50.0, grades.clone());
            let mut cruise = Cruise::new(&truck, set_mps, limit_mps);
            let trip = drive(&truck, &road, set_mps, &mut cruise).expect("it gets there");
            let mut reference = Reference::default();
            let mut advance = |&grade| reference.advance(&truck, 50.0, grade, &speeds);
            let time_s: f64 = grades.iter().map(&mut advance).sum();
            let off = time_s / trip.time_s - 1.0;
            assert!(
                (-faster..0.001).contains(&off),
                "{}: {time_s} s, {} s",
                preset.name(),
                trip.time_s
            );
        }
    }
}
