//! Behind a lead in town and on a country road, with many stops. There is no collision, stops are
//! soft, and traffic accepts the time gap.

use controller::law::Quality;
use controller::laws;
use scenario::Scenario;

use crate::world::{Perception, STEP_S, Vehicle, World};

/// The end of a stop is what happens below this speed, m/s.
const STOPPING_MPS: f64 = 1.0;
/// Slowest speed at which a time gap is counted, m/s.
const MOVING_MPS: f64 = 2.0;
/// Figures of each of the lead's trips from stop to stop: top speed, m/s; acceleration and
/// deceleration, m/s²; time at the top and at standstill, s.
const TRIPS: [(f64, f64, f64, f64, f64); 8] = [
    (8.0, 1.2, 1.0, 6.0, 12.0),
    (14.0, 1.5, 1.5, 20.0, 15.0),
    (5.0, 1.0, 1.6, 2.0, 9.0),
    (25.0, 1.8, 1.3, 60.0, 10.0),
    (11.0, 1.4, 1.9, 8.0, 12.0),
    (16.0, 1.6, 1.7, 15.0, 12.0),
    (3.0, 0.8, 0.7, 3.0, 12.0),
    (33.0, 2.0, 1.8, 70.0, 20.0),
];

/// Course of a drive.
#[derive(Debug, Default)]
struct Drive {
    collision_s: Option<f64>,
    /// Largest jerk of the ego while it comes to a stop, m/s³.
    stop_jerk_mps3: f64,
    /// Stops of the ego.
    stops: u32,
    /// Mean of gap over speed while the ego moves, s.
    mean_time_gap_s: f64,
    /// Share of the time in which the law's fall-back drove.
    fall_back_share: f64,
}

/// The lead's acceleration over time, in steps of [`STEP_S`].
fn lead() -> impl Iterator<Item = f64> {
    TRIPS.into_iter().flat_map(|(top_mps, up_mps2, down_mps2, cruise_s, rest_s)| {
        let phases = [
            (up_mps2, top_mps / up_mps2),
            (0.0, cruise_s),
            (-down_mps2, top_mps / down_mps2 + STEP_S),
            (0.0, rest_s),
        ];
        phases
            .into_iter()
            .flat_map(|(mps2, for_s)| std::iter::repeat_n(mps2, (for_s / STEP_S).round() as usize))
    })
}

fn drive(law: &str, perception: Perception) -> Drive {
    let text = format!("schema_version = 1\nname = \"town\"\n[controller]\nname = \"{law}\"\n");
    let scenario = Scenario::parse("town", &text).expect("the keys are right");
    let built = laws::build(&scenario).unwrap_or_else(|problem| panic!("{law}: {problem:?}"));
    let ahead = Vehicle { position_m: 8.0, ..Vehicle::default() };
    let mut world = World::new(built, perception, 0.1, (Vehicle::default(), ahead), 1);
    let mut seen = Drive::default();
    let (mut gaps_s, mut moving, mut steps) = (0.0, 0.0, 0.0);
    for lead_mps2 in lead() {
        let before = world.ego;
        world.advance(lead_mps2);
        let after = world.ego;
        if before.speed_mps < STOPPING_MPS && before.acceleration_mps2 < 0.0 {
            let jerk = (after.acceleration_mps2 - before.acceleration_mps2).abs() / STEP_S;
            seen.stop_jerk_mps3 = seen.stop_jerk_mps3.max(jerk);
        }
        seen.stops += u32::from(before.speed_mps > 0.0 && after.speed_mps == 0.0);
        if world.gap_m() <= 0.0 {
            seen.collision_s = Some(world.time_s());
            break;
        }
        if after.speed_mps > MOVING_MPS {
            gaps_s += world.gap_m() / after.speed_mps;
            moving += 1.0;
        }
        steps += 1.0;
        seen.fall_back_share += f64::from(u8::from(world.output.quality == Quality::FallBack));
    }
    seen.mean_time_gap_s = gaps_s / moving;
    seen.fall_back_share /= steps;
    seen
}

/// No collision and soft stops, with ideal perception and with the radar.
fn stops_softly(law: &str) -> [Drive; 2] {
    [Perception::Ideal, Perception::Tracked].map(|perception| {
        let drive = drive(law, perception);
        println!("{law} {perception:?}: {drive:?}");
        assert_eq!(drive.collision_s, None, "{law}");
        assert!(drive.stop_jerk_mps3 <= 5.0, "{law}: {} m/s³", drive.stop_jerk_mps3);
        drive
    })
}

#[test]
fn acc_mpc() {
    for drive in stops_softly("acc-mpc") {
        assert!(drive.stops >= 4 && drive.mean_time_gap_s < 3.0, "{drive:?}");
    }
}

#[test]
fn six_mode() {
    for drive in stops_softly("six-mode") {
        assert!(drive.stops >= 4 && drive.mean_time_gap_s < 3.0, "{drive:?}");
    }
}

#[test]
fn quadratic_bounded_says_where_its_fall_back_drives() {
    for drive in stops_softly("quadratic-bounded") {
        assert!(drive.stops >= 4, "{drive:?}");
        let share = drive.fall_back_share;
        assert!(share > 0.1 && share < 0.9, "both drive, each in its range: {share}");
    }
}
