//! The vehicle ahead as it truly is: for the referee, and for verdicts on what braking could have done.

use crate::numbers::Numbers;

/// The vehicle ahead as it truly is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ahead {
    /// Bumper-to-bumper distance, m.
    pub gap_m: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Acceleration, m/s².
    pub acceleration_mps2: f64,
}

/// Constant deceleration that keeps the ego behind the vehicle ahead, m/s². The vehicle ahead keeps its present
/// acceleration until it stands. 0 without a need to brake.
pub fn required_deceleration(speed_mps: f64, ahead: &Ahead) -> f64 {
    required_with(speed_mps, ahead, &Numbers::DEFAULT)
}

/// The same with other numbers, for studies of their effect.
pub fn required_with(speed_mps: f64, ahead: &Ahead, numbers: &Numbers) -> f64 {
    let room = (ahead.gap_m - numbers.margin_m).max(0.1);
    let braking = (-ahead.acceleration_mps2).max(0.0);
    let closing = speed_mps - ahead.speed_mps;
    let lead_stops_in_s = if braking > 0.0 { ahead.speed_mps / braking } else { f64::INFINITY };
    // Equal speeds are reached after 2 room / closing at the deceleration that just avoids contact.
    let meets_in_s = if closing > 0.0 { 2.0 * room / closing } else { f64::INFINITY };
    if meets_in_s <= lead_stops_in_s && closing > 0.0 {
        braking + closing * closing / (2.0 * room)
    } else if lead_stops_in_s.is_finite() {
        let to_its_stop = 0.5 * ahead.speed_mps * lead_stops_in_s;
        speed_mps * speed_mps / (2.0 * (room + to_its_stop))
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn required_deceleration_by_hand() {
        let ahead =
            |gap_m, speed_mps, acceleration_mps2| Ahead { gap_m, speed_mps, acceleration_mps2 };
        // Standing obstacle: v²/(2 d).
        assert!((required_deceleration(20.0, &ahead(41.0, 0.0, 0.0)) - 5.0).abs() < 1e-12);
        // Constant lead: closing²/(2 d).
        assert!((required_deceleration(20.0, &ahead(26.0, 10.0, 0.0)) - 2.0).abs() < 1e-12);
        // A lead that brakes to a stop from the same speed: its stopping distance is ours too.
        assert!((required_deceleration(20.0, &ahead(11.0, 20.0, -5.0)) - 4.0).abs() < 1e-12);
        // Opening, and a lead that drives on.
        assert_eq!(required_deceleration(10.0, &ahead(5.0, 20.0, 1.0)), 0.0);
    }
}
