//! Longitudinal model of a heavy truck: engine, gearbox, driveline, resistances, fuel.
//!
//! The plant integrates it ([`Motion`]); the predictive controller plans with it ([`Truck`]). With
//! distance s, speed v, kinetic energy K = m d v²/2 and slope angle a (numbers as in the code):
//!
//! ```text
//! (1) dK/ds = F_t - F_b - m g (f cos a + sin a) - c K        c = rho CdA / (m d)
//! (2) F_t = T k eta (T >= 0), T k / eta (T < 0)              T = T_eng - P_aux / w,  k = i_g i_0 / r,  w = k v
//! (3) d = 1 + sum(J_w) / (m r²) + J_e (i_g i_0)² / (m r²)    of the highest gear, so that K knows no gear
//! (4) K(L) = K_inf + (K_0 - K_inf) e^(-c L)                  K_inf = [F_t - m g (f cos a + sin a)] / c
//! (5) fuel per crank radian                                  see `engine`
//! (6) T = (m d a_des + F_res) / (k eta)                      within [T_drag, T_max], first order 0.3 s
//! (7) gear rule                                              see `gearbox`
//! ```
//!
//! Source: the model of Li, Zheng, Wang, Wang (predictive adaptive cruise, FAW Jiefang JH6) as
//! reconstructed from public data: VECTO's generic 325 kW engine, twelve-speed gearbox and class 5
//! tractor. All quantities are in SI units, engine speeds in revolutions per minute as in the maps.

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
