//! Numbers of the plant beside a scenario's keys, each with its origin. One whose half and double change nothing is a
//! constant beside its use.
//!
//! `cargo run --release -p plant --example plant_numbers` prints the effect of each number.
//!
//! ```
//! use plant::numbers::Numbers;
//!
//! // The lateral jerk of UN R79 is a mean of half a second.
//! assert_eq!(Numbers::DEFAULT.lateral_jerk_s, 0.5);
//! ```

use parameters::parameters;

parameters! {
    /// Numbers of the vehicles and of the referee.
    pub struct Numbers {
        // The car.

        /// Mass of a car without a powertrain, for its energy.
        car_mass_kg: f64 = 1600.0, "kg", 800.0..=3500.0, "Chosen: a compact car with two persons. At 800 energy 11.07 instead of 20.83 kWh/100 km; at 3200 energy 40.38 instead of 20.83 kWh/100 km.";
        /// Coefficient of rolling resistance of a car.
        rolling: f64 = 0.011, "1", 0.006..=0.02, "Source: Mitschke and Wallentowitz, Dynamik der Kraftfahrzeuge, chapter 5. At 0.006 energy 19.09 instead of 20.83 kWh/100 km; at 0.02 energy 24.11 instead of 20.83 kWh/100 km.";
        /// Product of air density, drag coefficient and frontal area of a car: 1.2 kg/m³, 0.29, 2.2 m².
        drag_kgpm: f64 = 0.766, "kg/m", 0.3..=1.5, "Source: Mitschke and Wallentowitz, chapter 5, a saloon car. At 0.383 energy 20.19 instead of 20.83 kWh/100 km; at 1.5 energy 22.09 instead of 20.83 kWh/100 km.";

        // Motion across the road.

        /// Time constant from the desired to the real angle of the wheels.
        steering_lag_s: f64 = 0.15, "s", 0.02..=0.5, "Chosen: a driver's arms and the steering's play (0.1 to 0.2 s in driver models). At 0.075 no change; at 0.3 offset in curves 0.49 instead of 0.46 m, lateral jerk in curves 0.60 instead of 0.63 m/s³, offset before a stand in a curve 0.20 instead of 0.17 m.";
        /// Time over which the lateral jerk is averaged.
        lateral_jerk_s: f64 = 0.5, "s", 0.1..=2.0, "Source: UN R79, lateral jerk as a mean of 0.5 s (from memory). At 0.25 lateral jerk in curves 0.75 instead of 0.63 m/s³; at 1 lateral jerk in curves 0.55 instead of 0.63 m/s³.";

        // The referee.

        /// Speed above which the ego drives: a slower motion between two stands makes them one.
        drives_mps: f64 = 0.5, "m/s", 0.05..=3.0, "Chosen: creeping in a queue stays below it. At 0.25 stops 7.00 instead of 6.00; at 1 stops 5.00 instead of 6.00.";
        /// Distance that braking keeps from the vehicle ahead at standstill.
        margin_m: f64 = 1.0, "m", 0.0..=5.0, "Chosen: the least gap that drivers leave in a queue. At 0.5 required deceleration 1.80 instead of 1.82 m/s²; at 2 required deceleration 1.86 instead of 1.82 m/s².";

        // Phases of the drive, for faults that wait for them.

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
