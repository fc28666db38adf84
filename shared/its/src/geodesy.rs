//! Positions on the Earth and on the plane around a point of it.

/// Semi-major axis of WGS-84, m.
const A_M: f64 = 6_378_137.0;
/// First eccentricity squared of WGS-84.
const E2: f64 = 6.694_379_990_141_33e-3;
/// Degrees in one step of the messages.
const STEP_DEG: f64 = 1e-7;

/// Steps of a half and of a whole turn.
const HALF_TURN: i64 = 1_800_000_000;
const TURN: i64 = 2 * HALF_TURN;

/// A position in the messages' unit: tenths of a microdegree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Position {
    /// Latitude, 1e-7 degrees, north positive.
    pub latitude: i32,
    /// Longitude, 1e-7 degrees, east positive; above -180 and up to 180 degrees.
    pub longitude: i32,
}

/// The tangent plane at a point, with metres along an axis and to its left. By default the axis points east.
///
/// ```
/// use its::geodesy::{Plane, Position};
///
/// let crossing = Position { latitude: 487_000_000, longitude: 91_000_000 };
/// let road = Plane::along(crossing, 0.0);
/// let stop_line = road.position(-25.0, 1.75);
/// assert!(stop_line.latitude < crossing.latitude, "25 m to the south");
/// let (along_m, left_m) = road.point(stop_line);
/// assert!((along_m + 25.0).abs() < 0.02 && (left_m - 1.75).abs() < 0.02);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    origin: Position,
    /// East and north components of the axis.
    axis: (f64, f64),
    east_m_per_step: f64,
    north_m_per_step: f64,
}

impl Plane {
    /// The plane around `origin` with the axes east and north.
    pub fn at(origin: Position) -> Self {
        Self::along(origin, 90.0)
    }

    /// The plane around `origin` with an axis of this heading, degrees clockwise from north.
    pub fn along(origin: Position, heading_deg: f64) -> Self {
        let heading = heading_deg * (core::f64::consts::PI / 180.0);
        let latitude = f64::from(origin.latitude) * STEP_DEG * (core::f64::consts::PI / 180.0);
        let sine = libm::sin(latitude);
        let root = (1.0 - E2 * sine * sine).sqrt();
        // Radii of curvature in the prime vertical and in the meridian.
        let prime_m = A_M / root;
        let meridian_m = A_M * (1.0 - E2) / (root * root * root);
        let radians_per_step = STEP_DEG * (core::f64::consts::PI / 180.0);
        Self {
            origin,
            axis: (libm::sin(heading), libm::cos(heading)),
            east_m_per_step: prime_m * libm::cos(latitude) * radians_per_step,
            north_m_per_step: meridian_m * radians_per_step,
        }
    }

    /// The position nearest to a point of the plane, m.
    pub fn position(&self, along_m: f64, left_m: f64) -> Position {
        let (east_m, north_m) = self.to_earth((along_m, left_m));
        let steps = |m: f64, m_per_step: f64| (m / m_per_step).round() as i64;
        let north = i64::from(self.origin.latitude) + steps(north_m, self.north_m_per_step);
        let east =
            i64::from(self.origin.longitude).saturating_add(steps(east_m, self.east_m_per_step));
        Position {
            latitude: north.clamp(-HALF_TURN / 2, HALF_TURN / 2) as i32,
            longitude: within_half_a_turn(east),
        }
    }

    /// Distance of a position along the axis and to its left, m.
    pub fn point(&self, position: Position) -> (f64, f64) {
        let east = i64::from(position.longitude) - i64::from(self.origin.longitude);
        let north = f64::from(position.latitude) - f64::from(self.origin.latitude);
        self.from_earth((
            f64::from(within_half_a_turn(east)) * self.east_m_per_step,
            north * self.north_m_per_step,
        ))
    }

    /// East and north components of a difference along the axis and to its left.
    pub fn to_earth(&self, (along, left): (f64, f64)) -> (f64, f64) {
        let (east, north) = self.axis;
        (along * east - left * north, along * north + left * east)
    }

    pub fn from_earth(&self, (to_east, to_north): (f64, f64)) -> (f64, f64) {
        let (east, north) = self.axis;
        (to_east * east + to_north * north, to_north * east - to_east * north)
    }
}

/// A longitude, or a difference of two, reduced to above -180 and up to 180 degrees. Source: ETSI TS 102 894-2.
fn within_half_a_turn(steps: i64) -> i32 {
    let turned = steps.rem_euclid(TURN);
    (if turned > HALF_TURN { turned - TURN } else { turned }) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_road_goes_over_the_date_line() {
        for longitude in [1_800_000_000, 1_799_999_000, -1_799_999_000] {
            let plane = Plane::at(Position { latitude: -170_000_000, longitude });
            for east_m in [-500.0, 0.0, 500.0] {
                let position = plane.position(east_m, 3.0);
                assert!((-1_799_999_999..=1_800_000_000).contains(&position.longitude));
                let (east, north) = plane.point(position);
                assert!(
                    (east - east_m).abs() < 0.006 && (north - 3.0).abs() < 0.006,
                    "{position:?}"
                );
            }
        }
        assert_eq!(within_half_a_turn(-HALF_TURN), 1_800_000_000);
        assert_eq!(within_half_a_turn(HALF_TURN + 1), -1_799_999_999);
    }

    #[test]
    fn a_degree_is_as_long_as_the_tables_say() {
        // WGS-84 at 45 degrees north: 111,131.8 m of latitude, 78,846.8 m of longitude.
        let origin = Position { latitude: 450_000_000, longitude: 80_000_000 };
        let plane = Plane::at(origin);
        let north = plane.point(Position { latitude: 460_000_000, ..origin }).1;
        let east = plane.point(Position { longitude: 90_000_000, ..origin }).0;
        assert!((north - 111_131.8).abs() < 1.0, "{north}");
        assert!((east - 78_846.8).abs() < 1.0, "{east}");
    }

    #[test]
    fn points_come_back_to_a_centimetre() {
        let plane = Plane::at(Position { latitude: 487_000_000, longitude: 91_000_000 });
        for (east_m, north_m) in [(0.0, 0.0), (12_345.678, -4.2), (-0.5, 3000.0)] {
            let (east, north) = plane.point(plane.position(east_m, north_m));
            assert!((east - east_m).abs() < 0.006 && (north - north_m).abs() < 0.006);
        }
    }

    #[test]
    fn an_axis_to_the_south_west_has_the_south_east_on_its_left() {
        let origin = Position { latitude: 487_000_000, longitude: 91_000_000 };
        let (east, road) = (Plane::at(origin), Plane::along(origin, 225.0));
        let (to_east_m, to_north_m) = east.point(road.position(100.0, 0.0));
        assert!((to_east_m + 70.71).abs() < 0.01 && (to_north_m + 70.71).abs() < 0.01);
        let (to_east_m, to_north_m) = road.to_earth((0.0, 1.0));
        let half = core::f64::consts::FRAC_1_SQRT_2;
        assert!((to_east_m - half).abs() < 1e-12 && (to_north_m + half).abs() < 1e-12);
        let (along_m, left_m) = road.point(road.position(250.0, -3.5));
        assert!((along_m - 250.0).abs() < 0.01 && (left_m + 3.5).abs() < 0.01);
    }
}
