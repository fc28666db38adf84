//! Numbers of the plant beside a scenario's keys, each with its origin.
//!
//! `cargo run --release -p plant --example plant_numbers` prints the effect of each number.
//!
//! ```
//! use plant::numbers::Numbers;
//!
//! // The hold speed is 1 km/h.
//! assert!((3.6 * Numbers::DEFAULT.hold_mps - 1.0).abs() < 1e-12);
//! ```

use parameters::parameters;

parameters! {
    /// Numbers of the vehicles and of the referee.
    pub struct Numbers {
        // The car.

        /// Speed below which the engine's power no longer limits the acceleration further.
        traction_from_mps: f64 = 1.0, "m/s", 0.1..=5.0, "Chosen: keeps the limit of power finite at a stand. At 0.5 and 2 nothing changes.";
        /// Mass of a car without a powertrain, for its energy.
        car_mass_kg: f64 = 1600.0, "kg", 800.0..=3500.0, "Chosen: a compact car with two persons. At 800 energy 11.07 instead of 20.83 kWh/100 km; at 3200 energy 40.38 instead of 20.83 kWh/100 km.";
        /// Coefficient of rolling resistance of a car.
        rolling: f64 = 0.011, "1", 0.006..=0.02, "Source: Mitschke and Wallentowitz, Dynamik der Kraftfahrzeuge, chapter 5. At 0.006 energy 19.09 instead of 20.83 kWh/100 km; at 0.02 energy 24.11 instead of 20.83 kWh/100 km.";
        /// Product of air density, drag coefficient and frontal area of a car: 1.2 kg/m³, 0.29, 2.2 m².
        drag_kgpm: f64 = 0.766, "kg/m", 0.3..=1.5, "Source: Mitschke and Wallentowitz, chapter 5, a saloon car. At 0.383 energy 20.19 instead of 20.83 kWh/100 km; at 1.5 energy 22.09 instead of 20.83 kWh/100 km.";
        /// Distance up to which a consumption is not stated.
        least_way_m: f64 = 100.0, "m", 10.0..=1000.0, "Chosen: on a shorter way a single start decides the figure. The example's drives do not depend on it.";

        // The truck.

        /// Speed below which the brakes hold: 1 km/h.
        hold_mps: f64 = 0.2777777777777778, "m/s", 0.05..=1.0, "Chosen: a pole wheel of 100 teeth (assumed) on a wheel of 0.51 m gives less than one pulse in 100 ms there. At 0.1388888888888889 and 0.5555555555555556 nothing changes.";
        /// Grade on which the brakes hold the truck.
        hold_grade: f64 = 0.18, "1", 0.08..=0.3, "Source: UN R13, the grade of a parking brake's test. At 0.09 and 0.3 nothing changes.";
        /// Growth of the holding force over the truck's mass.
        hold_jerk_mps3: f64 = 0.5, "m/s³", 0.1..=5.0, "Chosen: a standing passenger does not mind it. At 0.25 and 1 nothing changes.";

        // Motion across the road.

        /// Speed from which the single track has dynamics of its own; below, its steady state.
        dynamic_mps: f64 = 5.0, "m/s", 1.0..=10.0, "Chosen: its time constants are below 0.05 s there. At 2.5 and 10 nothing changes.";
        /// Time constant from the desired to the real angle of the wheels.
        steering_lag_s: f64 = 0.15, "s", 0.02..=0.5, "Chosen: a driver's arms and the steering's play (0.1 to 0.2 s in driver models). At 0.075 no change; at 0.3 offset in curves 0.49 instead of 0.46 m, lateral jerk in curves 0.60 instead of 0.63 m/s³, offset before a stand in a curve 0.20 instead of 0.17 m.";
        /// Speed below which a driver corrects an offset on the way of this speed.
        steers_from_mps: f64 = 3.0, "m/s", 0.5..=10.0, "Chosen: keeps corrections finite at a stand. At 1.5 and 6 nothing changes.";
        /// Largest angle of the front wheels.
        most_steering_rad: f64 = 0.6, "rad", 0.3..=1.0, "Chosen: 34 degrees, a car's full lock. At 0.3 and 1 nothing changes.";
        /// Distance of two bodies' middles up to which contact is looked for.
        contact_within_m: f64 = 30.0, "m", 10.0..=100.0, "Chosen: two half lorries of 16.5 m and the way of two periods. The example's drives do not depend on it.";
        /// Time over which the lateral jerk is averaged.
        lateral_jerk_s: f64 = 0.5, "s", 0.1..=2.0, "Source: UN R79, lateral jerk as a mean of 0.5 s (from memory). At 0.25 lateral jerk in curves 0.75 instead of 0.63 m/s³; at 1 lateral jerk in curves 0.55 instead of 0.63 m/s³.";

        // The emergency brake's path.

        /// Periods of the emergency brake without a message after which its last request ends.
        lost_periods: u32 = 3, "periods", 1.0..=20.0, "Chosen: two lost messages are chance. The example's drives do not depend on it.";

        // The referee.

        /// Slowest closing speed for which a time to collision counts: below it the gap is constant.
        closing_mps: f64 = 0.01, "m/s", 0.001..=1.0, "Chosen: rounding of two equal speeds stays far below it. At 0.005 and 0.02 nothing changes.";
        /// Speed above which the ego drives: a slower motion between two stands makes them one.
        drives_mps: f64 = 0.5, "m/s", 0.05..=3.0, "Chosen: creeping in a queue stays below it. At 0.25 stops 7.00 instead of 6.00; at 1 stops 5.00 instead of 6.00.";
        /// Distance that braking keeps from the vehicle ahead at standstill.
        margin_m: f64 = 1.0, "m", 0.0..=5.0, "Chosen: the least gap that drivers leave in a queue. At 0.5 required deceleration 1.80 instead of 1.82 m/s²; at 2 required deceleration 1.86 instead of 1.82 m/s².";

        // Phases of the drive, for faults that wait for them.

        /// Slowest closing speed for which a fault's time to collision exists.
        phase_closing_mps: f64 = 0.1, "m/s", 0.01..=1.0, "Chosen: faults do not wait for a time to collision beyond 1000 s. The example's drives do not depend on it.";
        /// Lateral speed towards the ego's lane from which a vehicle cuts in.
        cut_in_mps: f64 = 0.2, "m/s", 0.05..=1.0, "Chosen: wandering within a lane stays below it. At 0.1 no change; at 0.4 cut-in lasts 6.60 instead of 6.73 s.";
        /// Distance from the lane's middle below which a vehicle has arrived.
        cut_in_arrived_m: f64 = 0.3, "m", 0.05..=1.5, "Chosen: the wandering of a vehicle that keeps its lane. At 0.15 cut-in lasts 7.20 instead of 6.73 s; at 0.6 cut-in lasts 6.06 instead of 6.73 s.";
        /// Distance from the lane's middle from which a vehicle is more than a lane away.
        cut_in_away_m: f64 = 5.5, "m", 3.5..=10.0, "Chosen: a lane of 3.5 m and half of another one. At 3.5 cut-in begins 6.01 instead of 3.68 s, cut-in lasts 4.40 instead of 6.73 s; at 10 cut-in begins 0.85 instead of 3.68 s, cut-in lasts 9.56 instead of 6.73 s.";
        /// Distance ahead up to which a vehicle cuts in on the ego.
        cut_in_ahead_m: f64 = 100.0, "m", 20.0..=300.0, "Chosen: 3 s at 33 m/s. At 50 cut-in lasts 0.00 instead of 6.73 s; at 200 no change.";
    }
}
