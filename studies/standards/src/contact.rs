//! Contact of two rectangles, the end of a case, and positions along an axis.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{STEP_S, VEHICLE_LENGTH_M};

/// End of a case. As a number it is the digit of the published tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// No contact.
    None = 0,
    /// Contact with the other's centre behind the ego's: the other drove into the ego's side.
    Side = 1,
    /// Contact with the other's centre ahead of the ego's.
    RearEnd = 2,
}

impl Outcome {
    pub fn is_collision(self) -> bool {
        self != Outcome::None
    }
}

/// End of a case, and the speed difference at the contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    pub outcome: Outcome,
    /// Speed difference at the contact \[m/s\]; 0 without one.
    pub impact_speed_mps: f64,
}

impl Verdict {
    /// A case without a contact.
    pub const NONE: Verdict = Verdict { outcome: Outcome::None, impact_speed_mps: 0.0 };

    pub fn is_collision(&self) -> bool {
        self.outcome.is_collision()
    }
}

/// The contact of the ego with another vehicle.
///
/// `gap_m` is the distance from the ego's front bumper to the other's rear bumper \[m\]. `clearance_m` is the distance
/// between their sides \[m\]. Both are negative in overlap.
pub fn contact(gap_m: f64, clearance_m: f64) -> Outcome {
    let overlap = clearance_m < 0.0 && gap_m < 0.0 && gap_m > -2.0 * VEHICLE_LENGTH_M;
    match overlap {
        false => Outcome::None,
        true if is_ahead(gap_m) => Outcome::RearEnd,
        true => Outcome::Side,
    }
}

/// True if the other vehicle's centre is ahead of the ego's.
pub(crate) fn is_ahead(gap_m: f64) -> bool {
    gap_m > -VEHICLE_LENGTH_M
}

/// A position along one axis: a start and the way since.
///
/// The way is the sum of the speeds of all steps times the step, not a sum of products. Rounding decides cases in which
/// two sides meet exactly at a step, and the reference rounds this sum.
#[derive(Clone, Debug)]
pub(crate) struct Travel {
    pub start_m: f64,
    pub speeds_mps: f64,
}

impl Travel {
    pub(crate) fn from_m(start_m: f64) -> Travel {
        Travel { start_m, speeds_mps: 0.0 }
    }

    pub(crate) fn step(&mut self, speed_mps: f64) {
        self.speeds_mps += speed_mps;
    }

    pub(crate) fn position_m(&self) -> f64 {
        self.start_m + self.speeds_mps * STEP_S
    }

    /// Distance from the front bumper of a vehicle `behind` to this one's rear bumper \[m\].
    pub(crate) fn gap_to_m(&self, behind: &Travel) -> f64 {
        self.position_m() - behind.position_m() - VEHICLE_LENGTH_M
    }
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
