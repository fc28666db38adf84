//! The end of a stop: the deceleration fades with the speed, so that nothing jerks at standstill.
//!
//! ```text
//! a = -k v   is reached from any (v, a) by   u = -k v - tau k a,   e = a + k v,  e' = -e / tau
//! distance to rest: (v + tau e) / k
//! ```
//!
//! The law takes the gentlest `k` with which the vehicle comes to rest within its room. It takes the firmest one even
//! if that needs a little more room.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `k` | rate at which speed and deceleration fade | 1/s |
//! | `tau` | lag of the actuator | s |

use super::kinematics::Motion;
use super::parameters::{FOLLOWING, Following};

/// Rates, the gentlest first, 1/s.
const RATES_PER_S: [f64; 5] = [1.0, 1.3, 1.7, 2.2, 2.8];

/// The way that a vehicle has to come to rest, m.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    /// Latest place at which it should stand.
    pub wanted_m: f64,
    /// Further distance after which softness no longer counts.
    pub spare_m: f64,
}

impl Room {
    pub const FREE: Self = Self { wanted_m: f64::INFINITY, spare_m: 0.0 };
}

/// The request at a set speed: at one of 0 a vehicle never accelerates. The driver's model keeps a little more.
pub fn within_set_speed(request_mps2: f64, set_speed_mps: f64) -> f64 {
    if set_speed_mps > 0.0 { request_mps2 } else { request_mps2.min(0.0) }
}

/// The request with a soft end of the stop, if there is one within `room`.
pub fn soften(request_mps2: f64, ego: Motion, tau_s: f64, room: Room) -> f64 {
    let (v, a) = (ego.speed_mps, ego.acceleration_mps2);
    let numbers: &Following = &FOLLOWING;
    if v > numbers.fastest_soft_mps || request_mps2 >= numbers.stays_mps2 {
        return request_mps2;
    }
    if v <= 0.0 {
        return numbers.hold_mps2;
    }
    let needed_m = |k: f64| if v < numbers.last_mps { 0.0 } else { (v + tau_s * (a + k * v)) / k };
    let firmest = RATES_PER_S[RATES_PER_S.len() - 1];
    let k = match RATES_PER_S.into_iter().find(|k| needed_m(*k) <= room.wanted_m) {
        Some(k) => k,
        None if needed_m(firmest) <= room.wanted_m + room.spare_m || v < numbers.last_mps => {
            firmest
        }
        None => return request_mps2,
    };
    let k = if v < numbers.last_mps { RATES_PER_S[0] } else { k };
    let soft = (-k * v - tau_s * k * a - numbers.last_mps2).min(0.0);
    if v < numbers.creeps_mps { soft } else { request_mps2.max(soft) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::following::kinematics::Lag;

    fn room(wanted_m: f64) -> Room {
        Room { wanted_m, spare_m: 0.0 }
    }

    /// Brakes with `request` to a stop within `room_m` from where the deceleration is steady. Returns the largest jerk
    /// and the distance.
    fn stop(request: f64, speed_mps: f64, room_m: f64, period_s: f64) -> (f64, f64) {
        let fine = Lag { tau_s: 0.5 }.discretise(0.01);
        let mut ego = Motion { position_m: 0.0, speed_mps, acceleration_mps2: request };
        let (mut jerk, mut u, mut next_s) = (0.0_f64, request, 0.0);
        for k in 0..4000 {
            let time_s = f64::from(k) * 0.01;
            if time_s >= next_s - 1e-9 {
                u = soften(request, ego, 0.5, room(room_m - ego.position_m));
                next_s += period_s;
            }
            let before = ego.acceleration_mps2;
            ego = fine.advance(ego, u);
            jerk = jerk.max((ego.acceleration_mps2 - before).abs() / 0.01);
        }
        assert_eq!(ego.speed_mps, 0.0);
        (jerk, ego.position_m)
    }

    #[test]
    fn a_stop_ends_without_a_jerk_and_within_its_room() {
        for period_s in [0.05, 0.1] {
            for request in [-1.0, -2.0, -2.5] {
                let (jerk, distance_m) =
                    stop(request, 5.0, 25.0 / (-2.0 * request) + 2.5, period_s);
                assert!(jerk < 5.0, "{jerk} m/s³ at {request} m/s²");
                assert!(distance_m < 25.0 / (-2.0 * request) + 2.5, "{distance_m} m");
            }
        }
    }

    #[test]
    fn without_room_the_braking_is_not_released() {
        let ego = Motion { position_m: 0.0, speed_mps: 2.0, acceleration_mps2: -4.0 };
        assert_eq!(soften(-4.0, ego, 0.5, room(0.3)), -4.0);
    }

    #[test]
    fn a_vehicle_that_stands_is_held_until_it_must_go() {
        let ego = Motion::default();
        assert_eq!(soften(0.0, ego, 0.5, room(10.0)), FOLLOWING.hold_mps2);
        assert_eq!(soften(0.8, ego, 0.5, room(10.0)), 0.8);
    }
}
