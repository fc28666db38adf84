//! The four models, and the driver that each of them makes.

mod driver;
mod fuzzy;
mod rss;
mod un_r157;

pub use driver::Driver;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Model {
    /// The competent and careful human driver of UN R157, annex 4, appendix 3.
    CarefulDriver,
    /// The system of UN R157, paragraph 5.2.5.2.
    Regulation,
    /// Responsibility-sensitive safety.
    Rss,
    /// The fuzzy safety model of the European Commission's Joint Research Centre.
    Fuzzy,
}

impl Model {
    pub const ALL: [Model; 4] = [Model::CarefulDriver, Model::Regulation, Model::Rss, Model::Fuzzy];

    pub fn name(self) -> &'static str {
        match self {
            Model::CarefulDriver => "careful-driver",
            Model::Regulation => "regulation",
            Model::Rss => "rss",
            Model::Fuzzy => "fuzzy",
        }
    }

    /// Distance that the model keeps at `speed_mps` behind a vehicle of the same speed \[m\].
    /// `None` for `regulation`, which describes cut-ins alone.
    pub fn following_distance_m(self, speed_mps: f64) -> Option<f64> {
        match self {
            Model::CarefulDriver => Some(un_r157::TIME_GAP_S * speed_mps),
            Model::Regulation => None,
            Model::Rss => Some(rss::following_distance_m(speed_mps)),
            Model::Fuzzy => Some(fuzzy::following_distance_m(speed_mps)),
        }
    }
}

/// A model's view of another vehicle at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Distance from the ego's front bumper to the other's rear bumper \[m\], negative once they overlap.
    pub gap_m: f64,
    pub other_speed_mps: f64,
    /// Between the sides of the two \[m\], negative once they overlap.
    pub clearance_m: f64,
    /// Lateral speed of the other towards the ego's path \[m/s\].
    pub lateral_speed_mps: f64,
}

impl View {
    /// The view of a vehicle straight ahead.
    pub(crate) fn in_lane(gap_m: f64, other_speed_mps: f64) -> View {
        let clearance_m = -crate::VEHICLE_WIDTH_M;
        View { gap_m, other_speed_mps, clearance_m, lateral_speed_mps: 0.0 }
    }
}

/// Braking of a model after its reaction time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Braking {
    deceleration_mps2: f64,
    growth_mps3: f64,
}
