//! The four distances that divide the plane of gap and relative speed.

use super::parameters::{Parameters, Spacing, Variant};

/// Closing speed per metre of gap beyond the one that is kept, 1/s, and its bounds, m/s.
const CLOSING_PER_S: f64 = 0.1;
const CLOSING_MPS: (f64, f64) = (-1.0, 3.0);

/// Boundary distances at one instant, all in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Boundaries {
    /// R_x: the gap drivers keep at this speed (the paper's table 1).
    pub desired_m: f64,
    /// R_w: below it the ego decelerates, eqs (1) and (5).
    pub warning_m: f64,
    /// R_b: below it the ego brakes fully, eqs (2), (3) and (4).
    pub braking_m: f64,
    /// R_j: above it the ego accelerates to catch up behind a lead that runs away, eq (6).
    pub following_m: f64,
}

impl Boundaries {
    pub fn of(p: &Parameters, speed: f64, relative: f64) -> Self {
        match p.variant {
            Variant::Literal => Self::literal(p, speed, relative),
            Variant::Robust => Self::robust(p, speed, relative),
        }
    }

    /// The paper's boundaries, corrected only where the print is impossible.
    ///
    /// `speed` is V_h and `relative` is V_r = V_p - V_h, m/s.
    pub fn literal(p: &Parameters, speed: f64, relative: f64) -> Self {
        let desired_m = desired(speed);
        Self {
            desired_m,
            warning_m: desired_m + closing_allowance(p, relative),
            braking_m: braking(p, speed, relative),
            following_m: following(p, speed, relative),
        }
    }

    /// The boundaries of the robust law: R_b is never below R0 (trap 2), R_w always above R_b (trap 1). R_j
    /// is without its pole and its drop at small relative speeds (trap 4).
    pub fn robust(p: &Parameters, speed: f64, relative: f64) -> Self {
        let desired_m = match p.spacing {
            Spacing::Paper => desired(speed),
            Spacing::TimeGap => p.standstill_gap_m + p.time_gap_s * speed,
        };
        let braking_m = braking(p, speed, relative).max(p.standstill_gap_m);
        let warning_m =
            (desired_m + closing_allowance(p, relative)).max(braking_m + p.least_band_m);
        let following_m = match p.spacing {
            Spacing::Paper => following(p, speed, relative.max(0.0)),
            Spacing::TimeGap => warning_m + p.margin_m + p.opening_fade_m,
        };
        Self { desired_m, warning_m, braking_m, following_m }
    }

    /// The closing speed at which the gap beyond R_w is used up, m/s; negative below it.
    pub(super) fn closing_mps(&self, p: &Parameters, gap_m: f64) -> f64 {
        let (low, high) = CLOSING_MPS;
        (CLOSING_PER_S * (gap_m - self.warning_m - p.margin_m)).clamp(low, high)
    }
}

/// R_x, the paper's fit of its table 1 over speed in km/h; continuous at 80 km/h. The table has 70 m at 60 km/h, the
/// printed fit gives 75 m. Eq (5) lost its sign of comparison above 80 km/h.
fn desired(speed: f64) -> f64 {
    let kmh = 3.6 * speed;
    if kmh < 80.0 { 1.25 * kmh } else { 2.5 * kmh - 100.0 }
}

/// Part that eq (1) adds to R_x while closing; nothing while opening, eq (5). The paper prints `t1 V_a`, a speed that
/// it does not define. |V_r| is the way closed in t1, and only it is continuous with eq (5) at V_r = 0.
fn closing_allowance(p: &Parameters, relative: f64) -> f64 {
    let closing = (-relative).max(0.0);
    closing * closing / (2.0 * p.warning_deceleration_mps2) + p.reaction_time_s * closing
}

/// R_b: both brake to a stop, eqs (2) and (3); or the ego has stopped first, eq (4). Eq (3) lost the square of its
/// third term, which is that of eq (2). Eq (4) adds `a_p t_h²/2` to the way of a target that brakes: it is subtracted.
fn braking(p: &Parameters, speed: f64, relative: f64) -> f64 {
    let lead = (speed + relative).max(0.0);
    let ego_stop_s = speed / p.braking_mps2 + p.reaction_time_s;
    let lead_stop_s = lead / p.lead_braking_mps2;
    let ego_way = speed * p.reaction_time_s + speed * speed / (2.0 * p.braking_mps2);
    let lead_way = if relative > 0.0 && ego_stop_s < lead_stop_s {
        lead * ego_stop_s - 0.5 * p.lead_braking_mps2 * ego_stop_s * ego_stop_s
    } else {
        lead * lead / (2.0 * p.lead_braking_mps2)
    };
    ego_way - lead_way + p.standstill_gap_m
}

/// R_j, eq (6) as printed: empirical, with a pole at V_r = -2 m/s. V_r/18 × 90 is 5 V_r, V_h/21 × 90 is 30/7 V_h.
fn following(p: &Parameters, speed: f64, relative: f64) -> f64 {
    5.0 * relative
        + 30.0 / 7.0 * speed
        + (speed + relative)
        + 8.0 * (18.0 - relative) / (relative + 2.0)
        - relative * relative / (2.0 * p.braking_mps2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn near(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-9 * (1.0 + b.abs()), "{a} != {b}");
    }

    #[test]
    fn values_by_hand() {
        let p = Parameters::published();
        // 20 m/s = 72 km/h, closing at 5 m/s.
        let b = Boundaries::literal(&p, 20.0, -5.0);
        near(b.desired_m, 90.0);
        near(b.warning_m, 90.0 + 12.5 + 5.5);
        near(b.braking_m, 22.0 + 50.0 - 225.0 / 12.0 + 4.0);
        near(Boundaries::literal(&p, 30.0, 0.0).desired_m, 170.0);
        // Printed: V_r/18*90 + V_h/21*90 + (V_h + V_r) + (18 - V_r)/(V_r + 2)*8 - V_r^2/(2 a_h).
        near(
            Boundaries::literal(&p, 14.0, 3.0).following_m,
            3.0 / 18.0 * 90.0 + 14.0 / 21.0 * 90.0 + 17.0 + 15.0 / 5.0 * 8.0 - 9.0 / 8.0,
        );
    }

    #[test]
    fn the_ego_that_stops_first_uses_equation_4() {
        let p = Parameters::published();
        // V_h = 4, V_p = 20: t_h = 1 + 1.1 = 2.1 s < t_p = 20/6 s.
        let b = Boundaries::literal(&p, 4.0, 16.0);
        near(b.braking_m, 4.4 + 2.0 + 4.0 - (20.0 * 2.1 - 3.0 * 2.1 * 2.1));
        assert!(b.braking_m < 0.0);
        near(Boundaries::robust(&p, 4.0, 16.0).braking_m, 4.0);
    }

    #[test]
    fn the_warning_distance_is_continuous_at_equal_speeds() {
        let p = Parameters::default();
        let at = |v_r| Boundaries::literal(&p, 20.0, v_r).warning_m;
        assert!((at(-1e-9) - at(1e-9)).abs() < 1e-6);
    }

    proptest! {
        /// Order, finiteness and the floors over everything a road can show.
        #[test]
        fn robust_boundaries_are_ordered(v_h in 0.0..70.0f64, v_r in -70.0..70.0f64) {
            let p = Parameters::default();
            let b = Boundaries::robust(&p, v_h, v_r);
            prop_assert!(b.braking_m >= p.standstill_gap_m);
            prop_assert!(b.warning_m >= b.braking_m + p.least_band_m);
            prop_assert!(b.following_m.is_finite());
        }

        /// The point of R_b: at that gap the target brakes at a_p, and the ego answers with a_h after t1. They do not
        /// touch.
        #[test]
        fn braking_at_the_boundary_avoids_contact(v_h in 0.0..40.0f64, v_p in 0.0..40.0f64) {
            let p = Parameters::default();
            let (mut gap, mut ego, mut lead) =
                (Boundaries::robust(&p, v_h, v_p - v_h).braking_m, v_h, v_p);
            let dt = 1e-3;
            let mut t = 0.0;
            while ego > 0.0 {
                if t >= p.reaction_time_s { ego = (ego - p.braking_mps2 * dt).max(0.0); }
                lead = (lead - p.lead_braking_mps2 * dt).max(0.0);
                gap += (lead - ego) * dt;
                prop_assert!(gap > p.standstill_gap_m - 0.1, "gap {gap} at {t}");
                t += dt;
            }
        }
    }
}
