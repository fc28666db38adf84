//! Fewer points for the same picture.
//!
//! Each column of pixels keeps its first, lowest, highest and last point (Jugel et al. 2014, "M4"). So no spike is
//! lost. Then points on the straight line between their neighbours are dropped.

/// Invisible distance from a straight line, px.
const UNSEEN: f64 = 0.5;
/// Most points that one straight line replaces: between them a reader can point at values.
const LONGEST: usize = 64;

/// Indices of the points to keep, in order. Each gap of points that are not finite keeps one of them. With
/// `steps`, where each value holds until the next point, repeated values are dropped.
pub fn kept(px: &[(f64, f64)], steps: bool) -> Vec<usize> {
    let is_point = |point: &(f64, f64)| point.0.is_finite() && point.1.is_finite();
    let (mut kept, mut begin) = (Vec::new(), 0);
    for run in px.chunk_by(|a, b| is_point(a) == is_point(b)) {
        if is_point(&run[0]) {
            straighten(px, &extremes(run, begin), steps, &mut kept);
        } else {
            kept.push(begin);
        }
        begin += run.len();
    }
    kept
}

/// First, lowest, highest and last point of each column, each once, in order of arrival. The run's first point has the
/// index `begin`.
fn extremes(run: &[(f64, f64)], mut begin: usize) -> Vec<usize> {
    let mut kept = Vec::new();
    for column in run.chunk_by(|a, b| a.0.floor() == b.0.floor()) {
        let by_height = |a: &usize, b: &usize| column[*a].1.total_cmp(&column[*b].1);
        let indices = 0..column.len();
        let lowest = indices.clone().min_by(by_height).unwrap_or_default();
        let highest = indices.max_by(by_height).unwrap_or_default();
        kept.extend(
            [0, lowest.min(highest), lowest.max(highest), column.len() - 1].map(|at| begin + at),
        );
        begin += column.len();
    }
    kept.dedup();
    kept
}

/// Drops points within [`UNSEEN`], measured vertically, of the line that replaces them. Ends stay.
fn straighten(px: &[(f64, f64)], run: &[usize], steps: bool, kept: &mut Vec<usize>) {
    kept.extend(run.first());
    let all = (f64::NEG_INFINITY, f64::INFINITY);
    // Slopes of the lines from `from` that pass all points since then unseen.
    let (mut from, (mut least, mut most)) = (0, all);
    for to in 2..run.len() {
        let (a, passed, b) = (px[run[from]], px[run[to - 1]], px[run[to]]);
        let (dx, dy) = (passed.0 - a.0, passed.1 - a.1);
        let (below, above) = ((dy - UNSEEN) / dx, (dy + UNSEEN) / dx);
        if dx > 0.0 {
            (least, most) = (least.max(below), most.min(above));
        } else if dx < 0.0 {
            (least, most) = (least.max(above), most.min(below));
        } else if dy.abs() > UNSEEN {
            least = f64::INFINITY;
        }
        let slope = if steps { 0.0 } else { (b.1 - a.1) / (b.0 - a.0) };
        if to - from > LONGEST || b.0 <= a.0 || !(least..=most).contains(&slope) {
            kept.push(run[to - 1]);
            (from, (least, most)) = (to - 1, all);
        }
    }
    kept.extend(run.last().filter(|_| run.len() > 1));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_survive_and_little_else() {
        let wave = |i: usize| match i {
            5_432 => 100.0,
            7_654 => -100.0,
            _ => (i as f64).sin(),
        };
        let px: Vec<_> = (0..10_000).map(|i| (i as f64 / 100.0, wave(i))).collect();
        let kept = kept(&px, false);
        assert!(kept.len() <= 4 * 100, "{}", kept.len());
        assert!(kept.contains(&5_432) && kept.contains(&7_654));
        assert!(kept.is_sorted() && kept[0] == 0 && kept[kept.len() - 1] == 9_999);
    }

    #[test]
    fn straight_parts_need_few_points() {
        let px: Vec<_> = (0..1000_i32)
            .map(|i| (f64::from(i) / 10.0, f64::from((i - 500).abs()) / 10.0))
            .collect();
        let kept = kept(&px, false);
        assert!(kept.len() < 60 && kept.contains(&500), "the corner stays: {kept:?}");
    }

    #[test]
    fn a_staircase_keeps_the_begin_of_each_step() {
        let px: Vec<_> = (0..100).map(|i| (f64::from(i), f64::from(i / 10))).collect();
        let kept = kept(&px, true);
        assert!((1..10).all(|step| kept.contains(&(10 * step))), "{kept:?}");
    }

    #[test]
    fn few_points_stay_and_a_hole_is_kept_once() {
        let hole = f64::NAN;
        let px = [(0.0, 1.0), (10.0, 2.0), (20.0, hole), (21.0, hole), (30.0, 3.0)];
        assert_eq!(kept(&px, false), [0, 1, 2, 4]);
        assert!(kept(&[], false).is_empty());
    }

    /// As [`straighten`], with each point held against each line.
    fn one_by_one(px: &[(f64, f64)], steps: bool) -> Vec<usize> {
        let mut kept = vec![0];
        let mut from = 0;
        for to in 2..px.len() {
            let (a, b) = (px[from], px[to]);
            let slope = if steps { 0.0 } else { (b.1 - a.1) / (b.0 - a.0) };
            let passes = |p: &(f64, f64)| (a.1 + slope * (p.0 - a.0) - p.1).abs() <= UNSEEN + 1e-12;
            if to - from > LONGEST || b.0 <= a.0 || !px[from + 1..to].iter().all(passes) {
                kept.push(to - 1);
                from = to - 1;
            }
        }
        kept.push(px.len() - 1);
        kept
    }

    #[test]
    fn a_line_passes_each_point_that_it_replaces() {
        let mut random = 1_u64;
        let mut draw = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (random >> 40) as f64 / (1_u64 << 24) as f64
        };
        for number in 0..200 {
            // Some curves go back.
            let back = if number % 2 == 0 { 0.0 } else { 0.4 };
            let (mut x, mut y) = (0.0, 0.0);
            let px: Vec<_> = (0..300)
                .map(|_| {
                    x += draw() - back;
                    y += 0.6 * (draw() - 0.5);
                    (x, y)
                })
                .collect();
            let all: Vec<_> = (0..px.len()).collect();
            for steps in [false, true] {
                let mut kept = Vec::new();
                straighten(&px, &all, steps, &mut kept);
                assert_eq!(kept, one_by_one(&px, steps), "{number}");
            }
        }
    }
}
