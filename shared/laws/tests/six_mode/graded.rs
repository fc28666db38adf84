//! Behind a lead that brakes gently mode 5 brakes gently.

use super::plant::{Actor, DT, advance_ego, ask, input};
use law::Ego;
use laws::six_mode::{Mode, Parameters, SixMode};

const PERIOD: f64 = 0.1;
const LAG: f64 = 0.5;

/// Behind a lead that brakes from 20 m/s to standstill with `braking`: modes, requests and speeds, and the last gap.
fn stop_behind(braking: f64) -> (Vec<(Mode, f64, f64)>, f64) {
    let mut law = SixMode::new(Parameters::default()).expect("the built-in set is valid");
    let mut ego = Ego { speed_mps: 20.0, ..Ego::default() };
    let mut lead = Actor { id: 1, position: 39.0, speed: 20.0 };
    let (mut rows, mut request, mut lead_mps2) = (Vec::new(), 0.0, 0.0);
    for step in 0..4000_u32 {
        let time = f64::from(step) * DT;
        if step % 10 == 0 {
            let mut target = lead.seen_from(&ego);
            target.acceleration_mps2 = lead_mps2;
            request = ask(&mut law, &input(time, PERIOD, 25.0, ego, Some(target))).request_mps2();
            rows.push((law.mode.expect("it has decided"), request, ego.speed_mps));
        }
        advance_ego(&mut ego, request, LAG);
        lead_mps2 = if time > 10.0 && lead.speed > 0.0 { -braking } else { 0.0 };
        lead.advance(lead_mps2);
        assert!(lead.position > ego.position_m, "contact at {time} s");
    }
    (rows, lead.position - ego.position_m)
}

/// ISO 15622's limits: 3.5 m/s² over 2 s and 2.5 m/s³ over 1 s from 20 m/s on; 5 and 5 up to 5 m/s.
#[test]
fn a_lead_that_brakes_with_2_5_is_followed_comfortably() {
    let (rows, gap_m) = stop_behind(2.5);
    assert!(rows.iter().any(|row| row.0 == Mode::Avoid), "mode 5 is needed");
    let share = |speed: f64| ((speed - 5.0) / 15.0).clamp(0.0, 1.0);
    for window in rows.windows(21) {
        let mean = (window[0].2 - window[20].2) / 2.0;
        assert!(mean <= 5.0 - 1.5 * share(window[0].2), "{mean} m/s² at {} m/s", window[0].2);
    }
    for window in rows.windows(11) {
        let fall = window[0].1 - window[10].1;
        assert!(fall <= 5.0 - 2.5 * share(window[0].2), "{fall} m/s³ at {} m/s", window[0].2);
    }
    assert!((4.0..10.0).contains(&gap_m), "it stands {gap_m} m behind");
}

#[test]
fn a_lead_that_brakes_as_hard_as_assumed_is_not_reached() {
    let (rows, _) = stop_behind(Parameters::default().lead_braking_mps2);
    let hardest = rows.iter().fold(0.0_f64, |least, row| least.min(row.1));
    assert_eq!(hardest, -Parameters::default().braking_mps2);
}
