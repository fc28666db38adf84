//! The four models, and the driver that each of them makes.

mod braking;
mod careful_driver;
mod driver;
mod fuzzy;
mod regulation;
mod rss;

use std::fmt;
use std::str::FromStr;

pub use driver::Driver;

/// A performance model.
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
    /// All models, in the order of the tables.
    pub const ALL: [Model; 4] = [Model::CarefulDriver, Model::Regulation, Model::Rss, Model::Fuzzy];

    /// The model's name.
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
            Model::CarefulDriver => Some(careful_driver::following_distance_m(speed_mps)),
            Model::Regulation => None,
            Model::Rss => Some(rss::following_distance_m(speed_mps)),
            Model::Fuzzy => Some(fuzzy::following_distance_m(speed_mps)),
        }
    }
}

impl fmt::Display for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that no model has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownModel(pub String);

impl fmt::Display for UnknownModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = Model::ALL.map(Model::name).join(", ");
        write!(f, "no model is called '{}'; the models are {names}", self.0)
    }
}

impl std::error::Error for UnknownModel {}

impl FromStr for Model {
    type Err = UnknownModel;

    fn from_str(name: &str) -> Result<Model, UnknownModel> {
        Model::ALL
            .into_iter()
            .find(|model| model.name() == name)
            .ok_or_else(|| UnknownModel(name.to_owned()))
    }
}

/// A model's view of another vehicle at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Distance from the ego's front bumper to the other's rear bumper \[m\], negative once they
    /// overlap.
    pub gap_m: f64,
    /// Speed of the other \[m/s\].
    pub other_speed_mps: f64,
    /// Between the sides of the two \[m\], negative once they overlap.
    pub clearance_m: f64,
    /// Lateral speed of the other towards the ego's path \[m/s\].
    pub lateral_speed_mps: f64,
}

/// Situation that the model has to recognise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Situation {
    /// Another vehicle comes from the side.
    CutIn,
    /// A vehicle ahead in the ego's lane brakes or stands.
    InLane,
}
