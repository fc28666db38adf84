//! Contact of two rectangles.

use crate::{Outcome, VEHICLE_LENGTH_M};

/// The contact of the ego with another vehicle.
///
/// `gap_m` is the distance from the ego's front bumper to the other's rear bumper \[m\]. `clearance_m` is the distance
/// between their sides \[m\]. Both are negative in overlap.
pub fn contact(gap_m: f64, clearance_m: f64) -> Outcome {
    let overlap = clearance_m < 0.0 && gap_m < 0.0 && gap_m > -2.0 * VEHICLE_LENGTH_M;
    if !overlap {
        Outcome::None
    } else if gap_m > -VEHICLE_LENGTH_M {
        Outcome::RearEnd
    } else {
        Outcome::Side
    }
}

/// True if the other vehicle's centre is ahead of the ego's.
pub(crate) fn is_ahead(gap_m: f64) -> bool {
    gap_m > -VEHICLE_LENGTH_M
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_contact_is_named_by_where_the_centres_are() {
        assert_eq!(contact(-0.1, -0.1), Outcome::RearEnd);
        assert_eq!(contact(-4.2, -0.1), Outcome::RearEnd);
        assert_eq!(contact(-4.4, -0.1), Outcome::Side);
        assert_eq!(contact(-8.5, -0.1), Outcome::Side);
    }

    #[test]
    fn vehicles_that_are_apart_in_one_direction_do_not_touch() {
        assert_eq!(contact(0.0, -1.0), Outcome::None);
        assert_eq!(contact(-8.6, -1.0), Outcome::None);
        assert_eq!(contact(-4.0, 0.0), Outcome::None);
    }
}
