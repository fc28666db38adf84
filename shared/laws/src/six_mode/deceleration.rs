//! The eight parts of the decelerate mode, and the level of each (section 2, figure 3).
//!
//! # Printed
//!
//! Three regions in the plane of relative speed and gap. Region 1, metastable, borders both steady areas. Region 2,
//! weak deceleration, borders region 1 and the approach area. Region 3, strong deceleration, borders region 2 and the
//! avoid area. They are divided into eight parts, whose levels run from -0.5 to -3.75 m/s² from right to left.
//! Deceleration at V_r > 0 uses the same levels. The request is the mean of the present level and the three before.
//!
//! # Not printed
//!
//! The drawing of figure 3, and so the borders inside the mode and the number of parts in each region. They are
//! repaired here with the least that the text leaves open:
//!
//! * Region 1 has two parts: its levels alone are 0.25 m/s² apart, all others 0.5. Three parts each remain for the
//!   other regions.
//! * Steady driving and approach meet above R_w at V_r = -k. Region 1 ends there, else it would border the approach.
//! * With s = (R_w - R) / (R_w - R_b), each part has the same share of s at V_r >= 0. Region 1's share w falls to zero
//!   at V_r = -k, and the other six parts divide the rest equally:
//!
//! ```text
//! w = 2/8 min(1, max(0, 1 + V_r / k))
//! borders of s:  0, w/2, w, w + (1 - w) j/6   for j = 1 ... 6
//!
//!        approach   | steady 1 | steady 2
//! R_w ---------------+----------+---------
//!        region 2     `.     region 1
//!                       `.________________
//!     ---------------.          region 2
//!        region 3     `.__________________
//!                               region 3
//! R_b ------------------------------------
//!                     avoid
//!                   -k          0       V_r
//! ```
//!
//! At every gap, a smaller V_r gives the same or a harder level. R_w and R_b grow and w falls from right to left.

use super::boundaries::Boundaries;
use super::modes::Situation;
use super::parameters::{Parameters, Parts, Variant};

pub const PARTS: usize = 8;

/// Levels of the parts from right to left, m/s².
pub const LEVELS_MPS2: [f64; PARTS] = [-0.5, -0.75, -1.25, -1.75, -2.25, -2.75, -3.25, -3.75];

/// Parts of region 1.
const METASTABLE_PARTS: usize = 2;

/// The level of a situation between R_b and R_w, m/s².
pub(super) fn level_mps2(p: &Parameters, s: &Situation, b: &Boundaries) -> f64 {
    if (p.variant, p.deceleration_parts) == (Variant::Robust, Parts::Smooth) {
        return smooth_mps2((b.warning_m - s.gap_m) / (b.warning_m - b.braking_m));
    }
    LEVELS_MPS2[part(p, s, b)]
}

/// Level at a share of the way from R_w to R_b, m/s². It lies on the line through the middles of the equal slices.
fn smooth_mps2(share: f64) -> f64 {
    if share.is_nan() {
        return 0.0;
    }
    let place = (PARTS as f64 * share).clamp(0.0, PARTS as f64) + 0.5;
    let before = (place as usize).min(PARTS);
    let level = |slice: usize| match slice {
        0 => 0.0,
        slice => LEVELS_MPS2[slice.min(PARTS) - 1],
    };
    // The first slice's middle is half a slice from R_w.
    let (from, rest) = if place < 1.0 { (0.5, 0.5) } else { (before as f64, 1.0) };
    level(before) + (level(before + 1) - level(before)) * (place - from) / rest
}

/// The part of a situation between R_b and R_w.
pub fn part(p: &Parameters, s: &Situation, b: &Boundaries) -> usize {
    let share = (b.warning_m - s.gap_m) / (b.warning_m - b.braking_m);
    let metastable = metastable_share(p, s.relative_mps);
    // The casts saturate: NaN and what lies above R_w give the first part.
    let part = if share < metastable {
        (METASTABLE_PARTS as f64 * share / metastable) as usize
    } else {
        let rest = (PARTS - METASTABLE_PARTS) as f64 * (share - metastable) / (1.0 - metastable);
        METASTABLE_PARTS + rest as usize
    };
    part.min(PARTS - 1)
}

/// The gap at which `part` begins below R_w, m; for [`PARTS`], R_b.
pub fn border_m(p: &Parameters, relative_mps: f64, b: &Boundaries, part: usize) -> f64 {
    let metastable = metastable_share(p, relative_mps);
    let share = if part <= METASTABLE_PARTS {
        metastable * part as f64 / METASTABLE_PARTS as f64
    } else {
        let rest = (part - METASTABLE_PARTS) as f64 / (PARTS - METASTABLE_PARTS) as f64;
        metastable + (1.0 - metastable) * rest
    };
    b.warning_m - share * (b.warning_m - b.braking_m)
}

/// Region 1's share of the way from R_w to R_b. Equal slices keep the share at V_r = 0 everywhere.
fn metastable_share(p: &Parameters, relative_mps: f64) -> f64 {
    let full = METASTABLE_PARTS as f64 / PARTS as f64;
    match (p.variant, p.deceleration_parts) {
        (Variant::Robust, Parts::EqualSlices | Parts::Smooth) => full,
        (Variant::Literal, _) | (_, Parts::Regions) => {
            full * (1.0 + relative_mps / p.approach_threshold_mps).clamp(0.0, 1.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::six_mode::modes::{Mode, literal};
    use proptest::prelude::*;

    const SPEED_MPS: f64 = 20.0;

    /// A region of figure 3.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    enum Region {
        /// Region 1: parts 0 and 1.
        Metastable,
        /// Region 2: parts 2, 3 and 4.
        Weak,
        /// Region 3: parts 5, 6 and 7.
        Strong,
    }

    impl Region {
        const fn of_part(part: usize) -> Self {
            match part {
                0 | 1 => Self::Metastable,
                2..=4 => Self::Weak,
                _ => Self::Strong,
            }
        }
    }

    fn seen(gap_m: f64, relative_mps: f64) -> (Situation, Boundaries) {
        let b = Boundaries::literal(&Parameters::literal(), SPEED_MPS, relative_mps);
        (Situation { gap_m, speed_mps: SPEED_MPS, relative_mps }, b)
    }

    /// The literal law's part, if its table says decelerate.
    fn part_at(gap_m: f64, relative_mps: f64) -> Option<usize> {
        let p = Parameters::literal();
        let (s, b) = seen(gap_m, relative_mps);
        let (mode, _) = literal(&p, &s, &b)?;
        (mode == Mode::Decelerate).then(|| part(&p, &s, &b))
    }

    /// The mode or region, from a gap above R_w down to one below R_b.
    fn downwards(relative_mps: f64) -> Vec<String> {
        let p = Parameters::literal();
        let (_, b) = seen(0.0, relative_mps);
        let mut names: Vec<_> = (0..4000)
            .map(|k| b.warning_m + 1.0 - f64::from(k) * 0.001 * (b.warning_m - b.braking_m))
            .filter_map(|gap_m| {
                let (s, b) = seen(gap_m, relative_mps);
                let (mode, _) = literal(&p, &s, &b)?;
                Some(match mode {
                    Mode::Decelerate => format!("{:?}", Region::of_part(part(&p, &s, &b))),
                    mode => format!("{mode:?}"),
                })
            })
            .collect();
        names.dedup();
        names
    }

    /// Figure 3: region 1 borders the steady areas, 2 borders 1 and approach, 3 borders 2 and avoid.
    #[test]
    fn each_region_has_the_neighbours_of_figure_3() {
        let k = Parameters::literal().approach_threshold_mps;
        let steady = ["Steady", "Metastable", "Weak", "Strong", "Avoid"];
        for relative_mps in [5.0, 1.0, 0.01, -0.01, -0.5 * k, -0.9 * k] {
            let down = downwards(relative_mps);
            assert_eq!(down[down.len() - 5..], steady, "at {relative_mps} m/s");
        }
        for relative_mps in [-k, -1.01 * k, -3.0, -10.0, -SPEED_MPS] {
            let approach = ["Approach", "Weak", "Strong", "Avoid"];
            assert_eq!(downwards(relative_mps), approach, "at {relative_mps} m/s");
        }
    }

    /// On a line of constant gap the parts follow each other from right to left.
    #[test]
    fn the_eight_parts_run_from_right_to_left() {
        let to_the_left = || (0..2500).map(|k| 5.0 - f64::from(k) * 0.01);
        let mut met = [false; PARTS];
        for gap_m in (20..300).map(f64::from) {
            let parts: Vec<_> = to_the_left().filter_map(|v_r| part_at(gap_m, v_r)).collect();
            assert!(parts.is_sorted(), "{parts:?} at {gap_m} m");
            parts.iter().for_each(|part| met[*part] = true);
        }
        assert_eq!(met, [true; PARTS]);
        // Shortly below R_x, one line meets all of them.
        let mut parts: Vec<_> = to_the_left().filter_map(|v_r| part_at(85.0, v_r)).collect();
        parts.dedup();
        assert_eq!(parts, [0, 1, 2, 3, 4, 5, 6, 7]);
    }

    #[test]
    fn parts_by_hand() {
        let p = Parameters { approach_threshold_mps: 0.5, ..Parameters::literal() };
        let b = Boundaries { warning_m: 34.0, braking_m: 10.0, ..Boundaries::default() };
        let borders = |relative_mps| [0, 1, 2, 3, 5, 8].map(|k| border_m(&p, relative_mps, &b, k));
        // A quarter, an eighth and nothing of 24 m for region 1.
        assert_eq!(borders(1.0), [34.0, 31.0, 28.0, 25.0, 19.0, 10.0]);
        assert_eq!(borders(-0.25), [34.0, 32.5, 31.0, 27.5, 20.5, 10.0]);
        assert_eq!(borders(-0.5), [34.0, 34.0, 34.0, 30.0, 22.0, 10.0]);
        assert_eq!(LEVELS_MPS2.map(|level| 4.0 * level).iter().sum::<f64>(), -65.0);
    }

    #[test]
    fn equal_slices_are_the_named_choice_of_the_robust_law() {
        let b = Boundaries { warning_m: 18.0, braking_m: 10.0, ..Boundaries::default() };
        let equal = Parameters::default();
        let regions = Parameters { deceleration_parts: Parts::Regions, ..Parameters::default() };
        for k in 0..PARTS {
            let s = Situation { gap_m: 17.9 - k as f64, speed_mps: 10.0, relative_mps: -3.0 };
            assert_eq!(part(&equal, &s, &b), k);
            assert_eq!(part(&Parameters::literal(), &s, &b), part(&regions, &s, &b));
        }
    }

    #[test]
    fn the_smooth_levels_have_no_step_and_meet_each_level_in_the_middle_of_its_slice() {
        assert_eq!((smooth_mps2(0.0), smooth_mps2(-1.0), smooth_mps2(f64::NAN)), (0.0, 0.0, 0.0));
        for (slice, level) in LEVELS_MPS2.into_iter().enumerate() {
            let middle = (slice as f64 + 0.5) / PARTS as f64;
            assert!((smooth_mps2(middle) - level).abs() < 1e-12, "slice {slice}");
        }
        let levels: Vec<f64> = (0..=1000).map(|k| smooth_mps2(f64::from(k) / 1000.0)).collect();
        assert!(levels.windows(2).all(|pair| (0.0..0.01).contains(&(pair[0] - pair[1]))));
        assert_eq!(levels[1000], LEVELS_MPS2[PARTS - 1]);
    }

    proptest! {
        /// Every situation of the mode has one part, and it lies between its borders.
        #[test]
        fn the_partition_is_total(
            speed_mps in 2.0..40.0f64, closing in -1.0..1.0f64, share in 0.0..1.0f64,
        ) {
            for p in [Parameters::literal(), Parameters::default()] {
                let relative_mps = -closing * speed_mps;
                let b = Boundaries::robust(&p, speed_mps, relative_mps);
                let gap_m = b.warning_m - share * (b.warning_m - b.braking_m);
                let s = Situation { gap_m, speed_mps, relative_mps };
                let part = part(&p, &s, &b);
                let border = |k| border_m(&p, relative_mps, &b, k);
                prop_assert!(part < PARTS);
                prop_assert!(gap_m <= border(part) + 1e-9 && gap_m >= border(part + 1) - 1e-9);
            }
        }
    }
}
