//! Longitudinal model of a heavy truck: engine, gearbox, driveline, resistances, fuel.
//!
//! The plant integrates it ([`Motion`]); the predictive controller plans with it ([`Truck`]). With
//! distance s, speed v, kinetic energy K = m d v²/2 and slope angle a (numbers as in the code):
//!
//! ```text
//! (1) dK/ds = F_t - F_b - m g (f cos a + sin a) - c K        c = rho CdA / (m d)
//! (2) F_t = T k eta (T >= 0), T k / eta (T < 0)              T = T_eng - P_aux / w,  k = i_g i_0 / r,  w = k v
//! (3) d = 1 + sum(J_w) / (m r²) + J_e (i_g i_0)² / (m r²)    in the highest gear: K does not depend on the gear
//! (4) K(L) = K_inf + (K_0 - K_inf) e^(-c L)                  K_inf = [F_t - m g (f cos a + sin a)] / c
//! (5) fuel per crank radian                                  see `engine`
//! (6) T = (m d a_des + F_res) / (k eta)                      within [T_drag, T_max], first order 0.3 s
//! (7) gear rule                                              see `gearbox`
//! ```
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | m, r, f, CdA, i_0, i_g, eta, P_aux, J_w | [`Parameters`] | kg, m, -, m², -, -, -, W, kg m² |
//! | s, v | [`Motion::position_m`], [`Motion::speed_mps`] | m, m/s |
//! | K | [`Truck::kinetic_energy_j`] | J |
//! | c, m d, k | [`Truck::drag_per_m`], [`Truck::inertial_mass_kg`], [`Truck::crank_radians_per_m`] | 1/m, kg, 1/m |
//! | T_eng, F_b | [`Demand::engine_torque_nm`], [`Demand::service_brake_n`] | N m, N |
//! | rho, g, J_e | [`AIR_DENSITY_KGPM3`], [`GRAVITY_MPS2`], 5.15 | kg/m³, m/s², kg m² |
//!
//! ```
//! use truck_model::{Demand, Motion, Preset, Truck};
//!
//! // One minute at 18 m/s on a climb of 1 %.
//! let truck = Truck::preset(Preset::Jh6At49T);
//! let (dt_s, grade) = (0.01, 0.01);
//! let mut motion = Motion::new(&truck, 0.0, 18.0, grade);
//! for _ in 0..6000 {
//!     let (speed_mps, gear) = (motion.speed_mps, motion.gear);
//!     let demand = Demand::for_acceleration(&truck, 0.0, speed_mps, gear, grade);
//!     motion.step(&truck, dt_s, &demand, grade);
//! }
//! assert!(motion.fuel_g > 0.0 && motion.ledger.potential_j > 0.0);
//! ```
//!
//! Source: the model of Li, Zheng, Wang, Wang (predictive adaptive cruise, FAW Jiefang JH6). It is reconstructed from
//! public data: VECTO's generic 325 kW engine, twelve-speed gearbox and class 5 tractor. All quantities are in SI
//! units; engine speeds are in revolutions per minute, as in the maps.

mod demand;
mod engine;
mod gearbox;
mod motion;
mod parameters;
mod truck;

pub use demand::Demand;
pub use engine::Engine;
pub use gearbox::{MIN_BETWEEN_SHIFTS_S, TRACTION_INTERRUPTION_S};
pub use motion::{Ledger, Motion};
pub use parameters::{GEARS, Parameters, Preset};
pub use truck::{AIR_DENSITY_KGPM3, FUEL_DENSITY_GPL, GRAVITY_MPS2, Truck};
