//! Motion of a truck: the state that the plant integrates, its fuel and its energy.
//!
//! A step holds all forces constant and advances v by dt F / (m d) and s by the mean speed. The
//! change of K is then exactly F ds for any step size, and the balance of the ledger
//!
//! ```text
//! crank work = dK + potential + auxiliaries + driveline + clutch + rolling + air + service brakes
//! ```
//!
//! holds to rounding. Air drag and auxiliaries use the predicted mean speed of the step.

use crate::demand::Demand;
use crate::engine::{IDLE_RPM, RADPS_PER_RPM};
use crate::gearbox::{MIN_BETWEEN_SHIFTS_S, TRACTION_INTERRUPTION_S};
use crate::parameters::GEARS;
use crate::truck::Truck;
use serde::{Deserialize, Serialize};

/// Time constant of the engine's torque \[s\] (equation 6).
const TORQUE_TIME_CONSTANT_S: f64 = 0.3;

/// Energies since the start \[J\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// Work of the crankshaft \[J\]; the engine's drag and brake count negative.
    pub crank_j: f64,
    /// Energy of the auxiliaries \[J\].
    pub auxiliary_j: f64,
    /// Loss in gearbox and axle \[J\].
    pub driveline_j: f64,
    /// Loss in a slipping clutch \[J\].
    pub clutch_j: f64,
    /// Loss to rolling resistance \[J\].
    pub rolling_j: f64,
    /// Loss to air drag \[J\].
    pub air_j: f64,
    /// Loss in the service brakes \[J\].
    pub service_brake_j: f64,
    /// Potential energy gained \[J\].
    pub potential_j: f64,
    /// Part of `crank_j` that the engine brake took beyond the drag \[J\], 0 or more.
    pub engine_brake_j: f64,
}

/// State of a truck in motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// Distance along the road \[m\].
    pub position_m: f64,
    /// Speed \[m/s\], never negative.
    pub speed_mps: f64,
    /// Acceleration of the last step \[m/s²\].
    pub acceleration_mps2: f64,
    /// Gear, counted from 0, the lowest.
    pub gear: usize,
    pub engine_torque_nm: f64,
    /// Time since the last shift began \[s\].
    pub since_shift_s: f64,
    pub shifts: u32,
    pub fuel_g: f64,
    pub ledger: Ledger,
}

impl Motion {
    /// Returns a truck at `speed_mps`, in the highest gear with at least 1000 rpm.
    ///
    /// The engine's torque holds the speed on `grade`; if it cannot, the truck has the remaining
    /// acceleration. A standing truck keeps standing on any grade.
    pub fn new(truck: &Truck, position_m: f64, speed_mps: f64, grade: f64) -> Self {
        let gear =
            (0..GEARS).rev().find(|&g| truck.engine_rpm(speed_mps, g) >= 1000.0).unwrap_or(0);
        let rpm = truck.running_rpm(speed_mps, gear);
        let hold_nm = truck.engine_torque_nm(0.0, speed_mps, gear, grade);
        let engine = truck.engine();
        let engine_torque_nm = hold_nm.clamp(engine.drag_torque_nm(rpm), engine.max_torque_nm(rpm));
        let auxiliary_nm = truck.auxiliary_torque_nm(rpm);
        let force_n = |torque_nm: f64| truck.force_n(torque_nm - auxiliary_nm, gear);
        let lacking_n =
            if speed_mps > 0.0 { force_n(engine_torque_nm) - force_n(hold_nm) } else { 0.0 };
        Self {
            position_m,
            speed_mps,
            acceleration_mps2: lacking_n / truck.inertial_mass_kg(),
            gear,
            engine_torque_nm,
            since_shift_s: MIN_BETWEEN_SHIFTS_S,
            shifts: 0,
            fuel_g: 0.0,
            ledger: Ledger::default(),
        }
    }

    /// Returns whether a shift interrupts the traction.
    pub fn is_shifting(&self) -> bool {
        self.since_shift_s < TRACTION_INTERRUPTION_S
    }

    /// Advances by `dt_s` on a road of `grade` (rise over run). The truck never rolls back.
    pub fn step(&mut self, truck: &Truck, dt_s: f64, demand: &Demand, grade: f64) {
        self.shift(truck, demand);
        let crank = self.crank(truck, dt_s, demand.engine_torque_nm);
        let rolling_n = truck.rolling_resistance_n(grade);
        let slope_n = truck.slope_force_n(grade);
        let brake_n = demand.service_brake_n.max(0.0);
        let mass_kg = truck.inertial_mass_kg();
        let passive_n = rolling_n + brake_n;

        let force_at =
            |speed_mps: f64| crank.tractive_n - slope_n - passive_n - truck.air_drag_n(speed_mps);
        let half_s = 0.5 * dt_s;
        let mean_mps = (self.speed_mps + half_s * force_at(self.speed_mps) / mass_kg).max(0.0);
        let air_n = truck.air_drag_n(mean_mps);
        let acceleration_mps2 = force_at(mean_mps) / mass_kg;

        let end_mps = self.speed_mps + dt_s * acceleration_mps2;
        let distance_m = if end_mps > 0.0 {
            half_s * (self.speed_mps + end_mps)
        } else if acceleration_mps2 < 0.0 {
            // The truck comes to rest within the step.
            -0.5 * self.speed_mps * self.speed_mps / acceleration_mps2
        } else {
            0.0
        };
        self.acceleration_mps2 =
            if end_mps > 0.0 { acceleration_mps2 } else { -self.speed_mps / dt_s };
        self.speed_mps = end_mps.max(0.0);
        self.position_m += distance_m;
        self.since_shift_s += dt_s;

        self.fuel_g += dt_s * truck.engine().fuel_gps(crank.rpm, self.engine_torque_nm);
        let ledger = &mut self.ledger;
        ledger.rolling_j += rolling_n * distance_m;
        ledger.air_j += air_n * distance_m;
        ledger.service_brake_j += brake_n * distance_m;
        ledger.potential_j += slope_n * distance_m;
        self.book(truck, dt_s, &crank, distance_m);
    }

    fn shift(&mut self, truck: &Truck, demand: &Demand) {
        if self.is_shifting() {
            return;
        }
        let rpm = truck.engine_rpm(self.speed_mps, self.gear);
        let asked_nm = demand
            .engine_torque_nm
            .clamp(truck.engine().brake_torque_nm(rpm), truck.engine().max_torque_nm(rpm));
        let net_nm = asked_nm - truck.auxiliary_torque_nm(rpm);
        let rest_is_over = self.since_shift_s >= MIN_BETWEEN_SHIFTS_S;
        let gear = match demand.gear {
            Some(gear) if gear < GEARS && truck.gear_allowed(self.speed_mps, gear) => {
                if rest_is_over {
                    gear
                } else {
                    self.gear
                }
            }
            _ => truck.gear_by_rule(self.speed_mps, self.gear, net_nm, self.since_shift_s),
        };
        if gear != self.gear {
            self.gear = gear;
            self.since_shift_s = 0.0;
            self.shifts += 1;
        }
    }

    /// Moves the engine's torque towards `asked_nm` and couples it to the wheels.
    fn crank(&mut self, truck: &Truck, dt_s: f64, asked_nm: f64) -> Crank {
        let closed_rpm = truck.engine_rpm(self.speed_mps, self.gear);
        let rpm = closed_rpm.max(IDLE_RPM);
        let engine = truck.engine();
        let auxiliary_nm = truck.auxiliary_torque_nm(rpm);
        if self.is_shifting() {
            // The clutch is open: the engine drives itself and the auxiliaries.
            self.engine_torque_nm = auxiliary_nm;
            return Crank { rpm, auxiliary_nm, tractive_n: 0.0, coupling: Coupling::Open };
        }
        let limited_nm = asked_nm.clamp(engine.brake_torque_nm(rpm), engine.max_torque_nm(rpm));
        let share = 1.0 - libm::exp(-dt_s / TORQUE_TIME_CONSTANT_S);
        self.engine_torque_nm += share * (limited_nm - self.engine_torque_nm);
        let net_nm = self.engine_torque_nm - auxiliary_nm;
        if closed_rpm >= IDLE_RPM {
            let tractive_n = truck.force_n(net_nm, self.gear);
            return Crank { rpm, auxiliary_nm, tractive_n, coupling: Coupling::Closed };
        }
        if net_nm > 0.0 {
            let tractive_n = truck.force_n(net_nm, self.gear);
            return Crank { rpm, auxiliary_nm, tractive_n, coupling: Coupling::Slipping };
        }
        self.engine_torque_nm = auxiliary_nm;
        Crank { rpm, auxiliary_nm, tractive_n: 0.0, coupling: Coupling::Open }
    }

    /// Records the energies of the step between crankshaft and wheels.
    fn book(&mut self, truck: &Truck, dt_s: f64, crank: &Crank, distance_m: f64) {
        let turned_rad = match crank.coupling {
            Coupling::Closed => truck.crank_radians_per_m(self.gear) * distance_m,
            Coupling::Slipping | Coupling::Open => crank.rpm * RADPS_PER_RPM * dt_s,
        };
        let crank_j = self.engine_torque_nm * turned_rad;
        let auxiliary_j = crank.auxiliary_nm * turned_rad;
        let lost_j = crank_j - auxiliary_j - crank.tractive_n * distance_m;
        let braked_nm = truck.engine().drag_torque_nm(crank.rpm) - self.engine_torque_nm;
        let ledger = &mut self.ledger;
        ledger.crank_j += crank_j;
        ledger.auxiliary_j += auxiliary_j;
        ledger.engine_brake_j += braked_nm.max(0.0) * turned_rad;
        match crank.coupling {
            Coupling::Closed => ledger.driveline_j += lost_j,
            Coupling::Slipping | Coupling::Open => ledger.clutch_j += lost_j,
        }
    }
}

/// Crankshaft and wheels during one step.
struct Crank {
    rpm: f64,
    auxiliary_nm: f64,
    tractive_n: f64,
    coupling: Coupling,
}

enum Coupling {
    Closed,
    Slipping,
    Open,
}
