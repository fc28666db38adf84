//! End of a case.

/// End of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Outcome {
    /// No contact.
    None,
    /// Contact with the other's centre behind the ego's: the other drove into the ego's side.
    Side,
    /// Contact with the other's centre ahead of the ego's.
    RearEnd,
}

impl Outcome {
    /// The digit of the tables: 0 none, 1 side, 2 rear-end.
    pub fn digit(self) -> u8 {
        match self {
            Outcome::None => 0,
            Outcome::Side => 1,
            Outcome::RearEnd => 2,
        }
    }

    /// The outcome that `digit` stands for, if it stands for one.
    pub fn from_digit(digit: u8) -> Option<Outcome> {
        match digit {
            0 => Some(Outcome::None),
            1 => Some(Outcome::Side),
            2 => Some(Outcome::RearEnd),
            _ => None,
        }
    }

    /// True if the vehicles touched.
    pub fn is_collision(self) -> bool {
        self != Outcome::None
    }
}

/// End of a case, and the speed difference at the contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// Kind of contact.
    pub outcome: Outcome,
    /// Speed difference at the contact \[m/s\]; 0 without one.
    pub impact_speed_mps: f64,
}

impl Verdict {
    /// A case without a contact.
    pub const NONE: Verdict = Verdict { outcome: Outcome::None, impact_speed_mps: 0.0 };
}
