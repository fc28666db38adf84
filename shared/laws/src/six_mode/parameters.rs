//! Parameters of the law, as the table `[controller.six_mode]` holds them.
//!
//! [`Parameters::published`] names what the paper prints and what is inferred from it. All other defaults are chosen.
//! The origin of a number is its effect on 16 everyday scenes without the emergency brake. These are four cut-ins,
//! stops, braking leads and cut-outs each. "No change" means less than 2 % of each figure, and no collision.
//!
//! ```sh
//! timegap test everyday --effects six_mode --controllers six-mode --seeds 4 --only alone \
//!     --only cut-in,stop,braking-lead,cut-out
//! ```
//!
//! The base: least gap 19.8 m, hardest braking 2.84 m/s², rms jerk 0.554 m/s³ (means of the scenes). There is no
//! collision.

use law::settings::{Settings, below};
use parameters::Table as _;
use scenario::Problem;
use scenario::schema::tables;

/// The paper's acceleration below the set speed and in the accelerate mode, m/s².
const PAPER_ACCELERATION_MPS2: f64 = 1.0;

tables! {
    /// Reading of the paper that drives.
    pub enum Variant {
        /// The paper with its misprints corrected and nothing added: for study, not for driving.
        Literal,
        /// The same modes with every listed trap cured.
        #[default]
        Robust,
    }

    /// Places of R_x and R_j; the literal variant has the paper's in any case.
    pub enum Spacing {
        /// The paper's fits: 4.5 s of time gap in R_x, no regulation of the gap between R_w and R_j.
        Paper,
        /// R_x is a time gap; above R_w the gap is regulated.
        #[default]
        TimeGap,
    }

    /// Division of the decelerate mode; the literal variant has the paper's regions in any case.
    pub enum Parts {
        /// Figure 3: three regions of relative speed and gap, in eight parts.
        Regions,
        /// Eight equal slices of the way from R_w to R_b, whatever the relative speed.
        EqualSlices,
        /// A line through the middles of the equal slices, from 0 at R_w on: no step of the request.
        #[default]
        Smooth,
    }
}

law::settings! {
    /// Parameters of the six-mode law; the default is the road set, which `six-mode` drives.
    ///
    /// Rows from `acceleration_mps2` on act in the robust variant only.
    pub struct Parameters {
        /// a_h: the ego's full braking, m/s² (positive).
        braking_mps2: f64 = 6.0, "m/s²", above 0.0..=12.0,
            "At 3: least gap +5 %, hardest braking -29 %, rms jerk +37 %; at 7.5: hardest braking +10 %, rms jerk \
             -12 %.";
        /// a_p: the hardest braking expected of a target, m/s² (positive, above a_h).
        lead_braking_mps2: f64 = 8.0, "m/s²", above 0.0..=15.0, "At 6.4: rms jerk -8 %; at 10: rms jerk +9 %.";
        /// a: the deceleration behind the warning distance, m/s² (positive).
        warning_deceleration_mps2: f64 = 1.0, "m/s²", above 0.0..=12.0,
            "At 0.5: least gap +2 %; at 2: least gap -2 %, hardest braking -3 %, rms jerk -4 %.";
        /// t1: driver and system reaction time, s.
        reaction_time_s: f64 = 1.1, "s", 0.0..=10.0,
            "At 0.55: least gap -4 %, hardest braking -4 %, rms jerk -14 %. At 2.2: least gap +7 %, hardest braking \
             -9 %, rms jerk +44 %.";
        /// R0: gap left after an emergency stop, m.
        standstill_gap_m: f64 = 4.0, "m", above 0.0..=50.0,
            "At 2: least gap -7 %, rms jerk -2 %; at 8: least gap +14 %, rms jerk -3 %.";
        /// Targets beyond this range are not followed, m.
        sensor_range_m: f64 = 180.0, "m", above 0.0..=1000.0,
            "At 90: least gap -3 %, hardest braking +5 %, rms jerk +5 %; at 360: no change.";
        /// k: closing speed from which steady driving becomes an approach, m/s.
        approach_threshold_mps: f64 = 0.5, "m/s", above 0.0..=20.0, "No change at 0.25 and 1.";
        /// k_c: relative speeds below this are regulated proportionally, m/s.
        steady_band_mps: f64 = 0.15, "m/s", 0.0..=20.0, "No change at 0.075 and 0.3.";
        /// k1: gain of the cruise law, 1/s.
        cruise_gain_per_s: f64 = 1.0, "1/s", above 0.0..=10.0, "No change at 0.5 and 2.";
        /// k3: gain of the steady law, 1/s.
        steady_gain_per_s: f64 = 0.02, "1/s", 0.0..=10.0, "No change at 0.01 and 0.04.";
        /// Request of the accelerate mode and largest request of all, m/s² (literal: the paper's 1).
        acceleration_mps2: f64 = 1.8, "m/s²", 0.2..=5.0, "At 0.9: rms jerk -3 %; at 3.6: no change.";
        /// Time gap in R_x under `spacing = "time-gap"`, s.
        time_gap_s: f64 = 1.5, "s", above 0.0..=10.0,
            "At 0.75: least gap -3 %, rms jerk -3 %; at 3: least gap +16 %, hardest braking -10 %, rms jerk +17 %.";
        /// Gap kept beyond R_w under `spacing = "time-gap"`, m.
        margin_m: f64 = 1.0, "m", 0.0..=50.0, "At 0.5: no change; at 2: rms jerk -3 %.";
        /// Least width of the decelerate band, R_w - R_b, m (trap 1).
        least_band_m: f64 = 2.0, "m", above 0.0..=50.0,
            "At 1: rms jerk -6 %; at 4: least gap +3 %, hardest braking -3 %, rms jerk +3 %.";
        /// Hardest braking of the approach law, m/s² (positive; trap 3).
        approach_limit_mps2: f64 = 1.0, "m/s²", above 0.0..=12.0,
            "At 0.5: least gap -4 %, rms jerk -5 %; at 2: least gap +3 %, hardest braking +6 %, rms jerk +12 %.";
        /// Floor of the approach law's denominator R - R_w, m (trap 3).
        approach_floor_m: f64 = 2.0, "m", above 0.0..=50.0, "At 1: no change; at 4: rms jerk -3 %.";
        /// Distance below R_j to which the gap must fall to end the accelerate mode, m (trap 4).
        following_hysteresis_m: f64 = 3.0, "m", 0.0..=100.0, "No change at 1.5 and 6.";
        /// Relative speed that counts as opening or closing once the other held, m/s (trap 5).
        sign_band_mps: f64 = 0.1, "m/s", 0.0..=5.0, "No change at 0.05 and 0.2.";
        /// Steady driving accelerates less when the gap is within this of R_w, m (trap 6).
        opening_fade_m: f64 = 10.0, "m", above 0.0..=100.0, "At 5: rms jerk +3 %; at 20: no change.";
        /// The avoid mode ends this far above R_b, m (trap 7).
        braking_hysteresis_m: f64 = 3.0, "m", 0.0..=100.0, "At 1.5: rms jerk +3 %; at 6: no change.";
        /// The decelerate mode ends this far above R_w, m (trap 8).
        warning_hysteresis_m: f64 = 1.0, "m", 0.0..=100.0, "At 0.5: rms jerk -3 %; at 2: no change.";
        /// Half width of the hysteresis on k, m/s (trap 8).
        threshold_hysteresis_mps: f64 = 0.15, "m/s", 0.0..=5.0, "No change at 0.075 and 0.3.";
        /// Least time in a mode before it may end, except into 1, 4 and 5, s (trap 8).
        dwell_s: f64 = 0.8, "s", 0.0..=10.0, "No change at 0.4 and 1.6.";
        /// Time constant of the filter on gap and target speed, s; 0 switches it off (trap 8).
        filter_time_s: f64 = 0.3, "s", 0.0..=10.0,
            "At 0.15: hardest braking -2 %, rms jerk +2 %; at 0.6: least gap -5 %, rms jerk -9 %.";
        /// A target is taken up only this far inside the sensor range, m (trap 9).
        range_hysteresis_m: f64 = 2.0, "m", 0.0..=100.0, "No change at 1 and 4.";
        /// Limit on the rate of the request outside the avoid mode, m/s³ (trap 9).
        jerk_limit_mps3: f64 = 5.0, "m/s³", above 0.0..=1000.0, "At 2.5: rms jerk -17 %; at 10: rms jerk +5 %.";
        /// Limit on the rate at which the avoid mode applies the brake, m/s³ (trap 9).
        emergency_jerk_limit_mps3: f64 = 20.0, "m/s³", above 0.0..=1000.0, "No change at 10 and 40.";
        others {
            /// Variant that runs.
            variant: Variant = Variant::Robust;
            /// Division of the decelerate mode into its eight levels.
            deceleration_parts: Parts = Parts::Smooth;
            /// Places of R_x and R_j (trap 6).
            spacing: Spacing = Spacing::TimeGap;
        }
    }
}

impl Parameters {
    /// The keys that the chosen variant and spacing do not use.
    pub(super) fn unused(&self) -> Vec<&'static str> {
        match (self.variant, self.spacing) {
            (Variant::Literal, _) => {
                let rows = Self::ROWS.iter().map(|row| row.name);
                let of_robust = rows.skip_while(|name| *name != "acceleration_mps2");
                of_robust.chain(["deceleration_parts", "spacing"]).collect()
            }
            (Variant::Robust, Spacing::Paper) => vec!["time_gap_s", "margin_m"],
            (Variant::Robust, Spacing::TimeGap) => {
                vec!["steady_band_mps", "steady_gain_per_s", "following_hysteresis_m"]
            }
        }
    }

    /// The literal variant of the paper with the driving default's values.
    pub fn literal() -> Self {
        Self { variant: Variant::Literal, ..Self::default() }
    }

    /// True if the gap is regulated, not only bounded, and braked for as hard as needed, not fully.
    pub(super) fn regulates(&self) -> bool {
        self.variant == Variant::Robust && self.spacing == Spacing::TimeGap
    }

    /// Largest request, m/s²: the literal law has the paper's.
    pub(super) fn largest_mps2(&self) -> f64 {
        match self.variant {
            Variant::Literal => PAPER_ACCELERATION_MPS2,
            Variant::Robust => self.acceleration_mps2,
        }
    }

    /// The values that reproduce the published run.
    ///
    /// The paper prints a, t1, R0, the range, k1 and k3. It does not print a_h, a_p, k, k_c nor any
    /// hysteresis: those are inferred from its switching times. Sensors are ideal there, so the
    /// filter and the dwell are off.
    pub fn published() -> Self {
        Self {
            braking_mps2: 4.0,
            lead_braking_mps2: 6.0,
            approach_threshold_mps: 0.256,
            steady_band_mps: 0.0768,
            braking_hysteresis_m: 2.4,
            threshold_hysteresis_mps: 0.0256,
            sign_band_mps: 0.0128,
            dwell_s: 0.0,
            filter_time_s: 0.0,
            jerk_limit_mps3: 8.0,
            acceleration_mps2: 1.0,
            deceleration_parts: Parts::EqualSlices,
            spacing: Spacing::Paper,
            ..Self::default()
        }
    }
}

impl Settings for Parameters {
    fn check_together(&self) -> Result<(), Problem> {
        let (lead, threshold) = (self.lead_braking_mps2, self.approach_threshold_mps);
        below("braking_mps2", self.braking_mps2, "lead_braking_mps2", lead)?;
        below("steady_band_mps", self.steady_band_mps, "approach_threshold_mps", threshold)?;
        let hysteresis = self.threshold_hysteresis_mps;
        below("threshold_hysteresis_mps", hysteresis, "approach_threshold_mps", threshold)?;
        below("range_hysteresis_m", self.range_hysteresis_m, "sensor_range_m", self.sensor_range_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_sets_are_valid() {
        for p in [Parameters::default(), Parameters::literal(), Parameters::published()] {
            assert_eq!(p.check(), Ok(()));
        }
    }

    #[test]
    fn a_bad_value_names_its_key() {
        let bad = |p: Parameters| p.check().expect_err("must be refused").path;
        let base = Parameters::default();
        assert_eq!(bad(Parameters { braking_mps2: -4.0, ..base.clone() }), "braking_mps2");
        assert_eq!(bad(Parameters { braking_mps2: 9.0, ..base.clone() }), "braking_mps2");
        assert_eq!(bad(Parameters { dwell_s: f64::NAN, ..base.clone() }), "dwell_s");
        assert_eq!(bad(Parameters { sensor_range_m: f64::INFINITY, ..base }), "sensor_range_m");
    }

    #[test]
    fn unknown_keys_are_refused_and_missing_ones_default() {
        let p: Parameters =
            serde_json::from_str(r#"{"variant":"literal","braking_mps2":4.0}"#).expect("valid");
        assert_eq!(p, Parameters { braking_mps2: 4.0, ..Parameters::literal() });
        let e = serde_json::from_str::<Parameters>(r#"{"braking":4.0}"#).expect_err("unknown key");
        assert!(e.to_string().contains("braking"), "{e}");
    }
}
