//! Speeds from recorded positions.

use crate::smooth::slopes;

/// Semi-major axis, m, and square of the eccentricity of the WGS 84 ellipsoid (NGA.STND.0036, table 3.1).
const EQUATOR_M: f64 = 6_378_137.0;
const ECCENTRICITY_2: f64 = 6.694_379_990_141e-3;

/// The columns that give a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Speed, m/s.
    Speed,
    /// Distance along the road, m.
    Distance,
    /// Position in a plane, m.
    Plane,
    /// Latitude and longitude, rad.
    Geodetic,
}

/// Speeds, m/s, of the columns of a motion at times `t`, s. Along a road they keep their sign.
///
/// Positions become speeds by the slope of the line that the filter fits ([`slopes`]). Without a filter, central
/// differences are used. Latitude and longitude become metres on the ellipsoid's plane at the first row. 20 km from
/// there, the speed is 0.3 % wrong. The longitude may jump by a turn (at 180°).
pub fn speeds(t: &[f64], motion: Motion, columns: &[Vec<f64>], half_s: Option<f64>) -> Vec<f64> {
    let rate = |values: &[f64]| match half_s {
        Some(half_s) => slopes(t, values, half_s),
        None => differences(t, values),
    };
    match motion {
        Motion::Speed => columns[0].clone(),
        Motion::Distance => rate(&columns[0]),
        Motion::Plane => lengths(&rate(&columns[0]), &rate(&columns[1])),
        Motion::Geodetic => {
            let (north_m, east_m) = radii(columns[0][0]);
            let [north, east] = [(0, north_m), (1, east_m)].map(|(index, scale)| {
                // Relative to the first row, so that no digits are lost.
                let first: f64 = columns[index][0];
                let turned = |angle: &f64| libm::remainder(angle - first, std::f64::consts::TAU);
                columns[index].iter().map(|angle| scale * turned(angle)).collect::<Vec<_>>()
            });
            lengths(&rate(&north), &rate(&east))
        }
    }
}

/// Metres of a radian to the north and to the east at a latitude, rad.
fn radii(latitude: f64) -> (f64, f64) {
    let square = 1.0 - ECCENTRICITY_2 * libm::sin(latitude).powi(2);
    let meridian = EQUATOR_M * (1.0 - ECCENTRICITY_2) / (square * square.sqrt());
    (meridian, EQUATOR_M / square.sqrt() * libm::cos(latitude))
}

fn lengths(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| (a * a + b * b).sqrt()).collect()
}

/// Central differences, one-sided at the ends; zero for a single row.
fn differences(t: &[f64], values: &[f64]) -> Vec<f64> {
    let last = t.len() - 1;
    let rate = |i: usize| {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
        if a == b { 0.0 } else { (values[b] - values[a]) / (t[b] - t[a]) }
    };
    (0..=last).map(rate).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steady_drive_has_one_speed_in_every_form() {
        let t: Vec<f64> = (0..50).map(|k| 0.1 * f64::from(k)).collect();
        let along = |rate: f64| t.iter().map(|t| rate * t).collect::<Vec<f64>>();
        let latitude = 48.0_f64.to_radians();
        let (north_m, east_m) = radii(latitude);
        // The usual series for the lengths of a degree on WGS 84.
        let cos = |times: f64| libm::cos(times * latitude);
        let series_north_m = 111_132.954 - 559.822 * cos(2.0) + 1.175 * cos(4.0);
        let series_east_m = 111_412.84 * cos(1.0) - 93.5 * cos(3.0) + 0.118 * cos(5.0);
        assert!((north_m.to_radians() - series_north_m).abs() < 0.5, "{}", north_m.to_radians());
        assert!((east_m.to_radians() - series_east_m).abs() < 0.5, "{}", east_m.to_radians());
        let shifted: Vec<f64> = along(9.0 / north_m).iter().map(|x| latitude + x).collect();
        for half_s in [None, Some(0.5)] {
            for (motion, columns) in [
                (Motion::Distance, vec![along(15.0)]),
                (Motion::Plane, vec![along(9.0), along(-12.0)]),
                (Motion::Geodetic, vec![shifted.clone(), along(12.0 / east_m)]),
            ] {
                for speed in speeds(&t, motion, &columns, half_s) {
                    assert!((speed - 15.0).abs() < 1e-6, "{motion:?} {speed}");
                }
            }
        }
    }
}
