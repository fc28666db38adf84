//! Parameters of the shipped vehicles.

/// Number of gears: the top six of twelve.
pub const GEARS: usize = 6;

/// Vehicle of the published system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// JH6 tractor with a loaded trailer, 49 t.
    Jh6At49T,
    /// JH6 tractor at 25 t, with an engine 0.68 times as large.
    Jh6At25T,
}

impl Preset {
    pub const ALL: [Self; 2] = [Self::Jh6At49T, Self::Jh6At25T];

    /// Returns the name in scenarios and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Jh6At49T => "jh6-49t",
            Self::Jh6At25T => "jh6-25t",
        }
    }

    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|preset| preset.name() == name)
    }

    pub fn parameters(self) -> Parameters {
        match self {
            Self::Jh6At49T => Parameters {
                mass_kg: 49_000.0,
                drag_area_m2: 5.9,
                rolling_resistance: 0.0058,
                wheel_radius_m: 0.510,
                final_drive: 2.846,
                gear_ratios: RATIOS,
                driveline_efficiency: 0.93,
                auxiliary_power_w: 4000.0,
                engine_scale: 1.0,
                wheel_inertia_kgm2: 22.0 * WHEEL_INERTIA_KGM2,
            },
            Self::Jh6At25T => Parameters {
                mass_kg: 25_000.0,
                drag_area_m2: 5.4,
                rolling_resistance: 0.0062,
                wheel_radius_m: 0.510,
                final_drive: 3.083,
                gear_ratios: RATIOS,
                driveline_efficiency: 0.94,
                auxiliary_power_w: 3500.0,
                engine_scale: 0.68,
                wheel_inertia_kgm2: 10.0 * WHEEL_INERTIA_KGM2,
            },
        }
    }
}

/// Inertia of one wheel \[kg m²\] (VECTO).
const WHEEL_INERTIA_KGM2: f64 = 14.9;

/// Top six of the twelve gears from 14.93 (VECTO).
const RATIOS: [f64; GEARS] = [3.39, 2.65, 2.05, 1.60, 1.28, 1.00];

/// Parameters of a truck.
///
/// VECTO's class 5 tractor and generic engine are the source of every value without another one.
/// The presets' masses are the paper's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// Mass m \[kg\].
    pub mass_kg: f64,
    /// Air drag area CdA \[m²\].
    pub drag_area_m2: f64,
    /// Rolling resistance coefficient f.
    pub rolling_resistance: f64,
    /// Dynamic wheel radius r \[m\].
    pub wheel_radius_m: f64,
    /// Ratio of the axle i_0.
    pub final_drive: f64,
    /// Ratios of the gears i_g, lowest gear first.
    pub gear_ratios: [f64; GEARS],
    /// Efficiency eta of gearbox and axle, in both directions.
    pub driveline_efficiency: f64,
    /// Power of the auxiliaries at the crankshaft \[W\].
    pub auxiliary_power_w: f64,
    /// Torque, drag, fuel and inertia relative to the 12.7 L, 325 kW engine.
    pub engine_scale: f64,
    pub wheel_inertia_kgm2: f64,
}
