//! Families of generated roads: 50 m cells, each the sum of a few layers, repeatable from a seed.

use papers::trips::Road;
use rand_core::SeedableRng;
use rand_pcg::Pcg64;
use scenario::grade::{Alignment, generate};

/// Length of a road, m.
const LENGTH_M: f64 = 60_000.0;
/// Length of a cell, m.
const CELL_M: f64 = 50.0;
const CELLS: usize = (LENGTH_M / CELL_M) as usize;
/// Steepest grade of the sum of layers.
const STEEPEST: f64 = 0.07;
/// Waves of a spectrum.
const WAVES: usize = 60;

/// A kind of roads.
pub struct Family {
    pub name: &'static str,
    layers: &'static [Layer],
}

/// Parameters of roads. Lengths in m, grades as rise over run.
enum Layer {
    /// Tangents of constant grade, joined by vertical curves.
    Tangents { sigma: f64, steepest: f64, tangent_m: [f64; 2], curve_m: f64 },
    /// Waves of many lengths with random phases. The amplitude of a wave's grade goes with this power of its length,
    /// and each octave has as many waves.
    Waves { sigma: f64, length_m: [f64; 2], power: f64 },
    /// Up, level, down, level.
    Ramps { grade: [f64; 2], ramp_m: [f64; 2], level_m: [f64; 2], curve_m: f64 },
    /// Errors of the heights of points 50 m apart.
    HeightErrors { sigma_m: f64 },
}

const HILLS: Layer =
    Layer::Tangents { sigma: 0.0138, steepest: 0.03, tangent_m: [300.0, 1500.0], curve_m: 300.0 };

/// Terrain as measured: grades of all lengths.
const TERRAIN: Layer = Layer::Waves { sigma: 0.016, length_m: [400.0, 30_000.0], power: 0.25 };

pub const FAMILIES: [Family; 12] = [
    Family { name: "hills, like the given road", layers: &[HILLS] },
    Family {
        name: "motorway, long mild grades",
        layers: &[Layer::Tangents {
            sigma: 0.009,
            steepest: 0.022,
            tangent_m: [1500.0, 5000.0],
            curve_m: 600.0,
        }],
    },
    Family {
        name: "steep ridges",
        layers: &[Layer::Tangents {
            sigma: 0.028,
            steepest: 0.055,
            tangent_m: [500.0, 2000.0],
            curve_m: 250.0,
        }],
    },
    Family {
        name: "flat with noise",
        layers: &[Layer::Tangents {
            sigma: 0.004,
            steepest: 0.012,
            tangent_m: [100.0, 400.0],
            curve_m: 100.0,
        }],
    },
    Family {
        name: "short hills on long waves",
        layers: &[
            Layer::Tangents {
                sigma: 0.015,
                steepest: 0.035,
                tangent_m: [250.0, 900.0],
                curve_m: 300.0,
            },
            LONG_WAVES,
        ],
    },
    Family { name: "terrain of all lengths", layers: &[TERRAIN] },
    Family {
        name: "mountain terrain",
        layers: &[Layer::Waves { sigma: 0.026, length_m: [400.0, 30_000.0], power: 0.25 }],
    },
    Family {
        name: "passes of 5 to 10 km",
        layers: &[
            Layer::Ramps {
                grade: [0.03, 0.06],
                ramp_m: [5000.0, 10_000.0],
                level_m: [1000.0, 4000.0],
                curve_m: 600.0,
            },
            Layer::Waves { sigma: 0.008, length_m: [400.0, 4000.0], power: 0.25 },
        ],
    },
    Family {
        name: "rolling motorway",
        layers: &[
            Layer::Waves { sigma: 0.014, length_m: [1000.0, 4000.0], power: 0.0 },
            Layer::Waves { sigma: 0.006, length_m: [8000.0, 30_000.0], power: 0.0 },
        ],
    },
    Family {
        name: "valley with short steep ramps",
        layers: &[
            Layer::Ramps {
                grade: [0.03, 0.065],
                ramp_m: [150.0, 600.0],
                level_m: [400.0, 2500.0],
                curve_m: 150.0,
            },
            Layer::Waves { sigma: 0.004, length_m: [400.0, 10_000.0], power: 0.25 },
        ],
    },
    Family {
        name: "hills, heights off by 0.3 m",
        layers: &[HILLS, Layer::HeightErrors { sigma_m: 0.3 }],
    },
    Family {
        name: "terrain, heights off by 1 m",
        layers: &[TERRAIN, Layer::HeightErrors { sigma_m: 1.0 }],
    },
];

const LONG_WAVES: Layer = Layer::Tangents {
    sigma: 0.009,
    steepest: 0.03,
    tangent_m: [4000.0, 15_000.0],
    curve_m: 2000.0,
};

impl Family {
    /// The road of a seed.
    pub fn road(&self, seed: u64) -> Road {
        let mut grades = vec![0.0; CELLS];
        for (index, layer) in self.layers.iter().enumerate() {
            for (grade, added) in grades.iter_mut().zip(layer.grades(seed + 1000 * index as u64)) {
                *grade += added;
            }
        }
        Road::new(CELL_M, grades.iter().map(|grade| grade.clamp(-STEEPEST, STEEPEST)).collect())
    }

    /// The name as that of a file.
    pub fn file_name(&self) -> String {
        let letters = self.name.chars().filter(|letter| *letter != ',');
        letters.map(|letter| if letter.is_alphanumeric() { letter } else { '-' }).collect()
    }
}

impl Layer {
    /// Grades of the cells.
    fn grades(&self, seed: u64) -> Vec<f64> {
        let mut random = Pcg64::seed_from_u64(seed);
        match *self {
            Self::Tangents { sigma, steepest, tangent_m, curve_m } => {
                let alignment = Alignment {
                    length_m: LENGTH_M,
                    grade_sigma: sigma,
                    max_grade: steepest,
                    tangent_m,
                    curve_m,
                    closed: true,
                };
                Road::from_profile(&generate(&alignment, seed)).grades().to_vec()
            }
            Self::Waves { sigma, length_m: [shortest_m, longest_m], power } => {
                let mut grades = vec![0.0; CELLS];
                let mut squares = 0.0;
                for wave in 0..WAVES {
                    let share = (wave as f64 + random::uniform(&mut random)) / WAVES as f64;
                    let wave_m = shortest_m * libm::pow(longest_m / shortest_m, share);
                    let phase = core::f64::consts::TAU * random::uniform(&mut random);
                    let amplitude = libm::pow(wave_m / longest_m, power);
                    squares += 0.5 * amplitude * amplitude;
                    for (cell, grade) in grades.iter_mut().enumerate() {
                        let turns = CELL_M * (cell as f64 + 0.5) / wave_m;
                        *grade += amplitude * libm::cos(core::f64::consts::TAU * turns + phase);
                    }
                }
                let scale = sigma / squares.sqrt();
                grades.iter().map(|grade| scale * grade).collect()
            }
            Self::Ramps { grade, ramp_m, level_m, curve_m } => {
                let mut between =
                    |[low, high]: [f64; 2]| low + (high - low) * random::uniform(&mut random);
                let mut grades = Vec::with_capacity(CELLS);
                let mut side = 1.0;
                while grades.len() < CELLS {
                    let level = (between(level_m) / CELL_M).round() as usize;
                    let ramp = (between(ramp_m) / CELL_M).round() as usize;
                    let steep = side * between(grade);
                    grades.extend(std::iter::repeat_n(0.0, level));
                    grades.extend(std::iter::repeat_n(steep, ramp));
                    side = -side;
                }
                grades.truncate(CELLS);
                smoothed(&grades, (curve_m / CELL_M).round() as usize)
            }
            Self::HeightErrors { sigma_m } => {
                let errors_m: Vec<f64> =
                    (0..=CELLS).map(|_| sigma_m * random::normal(&mut random)).collect();
                errors_m.windows(2).map(|pair| (pair[1] - pair[0]) / CELL_M).collect()
            }
        }
    }
}

/// Means over a window of cells; the ends go on as they are.
fn smoothed(grades: &[f64], window: usize) -> Vec<f64> {
    let half = window / 2;
    let mean = |cell: usize| {
        let places = cell..=cell + 2 * half;
        let at = |place: usize| grades[place.saturating_sub(half).min(grades.len() - 1)];
        places.map(at).sum::<f64>() / (2 * half + 1) as f64
    };
    (0..grades.len()).map(mean).collect()
}
