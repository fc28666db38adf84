//! Fewer points for the same picture.
//!
//! Each column of pixels keeps its first, lowest, highest and last point (Jugel et al. 2014, "M4"). So no spike is
//! lost. Then points on the straight line between their neighbours are dropped.

/// Invisible distance from a straight line, px.
const UNSEEN: f64 = 0.5;
/// Most points that one straight line replaces; it bounds the work.
const LONGEST: usize = 64;

/// Indices of the points to keep, in order. Each gap of points that are not finite keeps one of them. With
/// `steps`, where each value holds until the next point, repeated values are dropped.
pub fn kept(px: &[(f64, f64)], steps: bool) -> Vec<usize> {
    let is_point = |index: usize| px[index].0.is_finite() && px[index].1.is_finite();
    let all: Vec<usize> = (0..px.len()).collect();
    let mut kept = Vec::new();
    for run in all.chunk_by(|a, b| is_point(*a) == is_point(*b)) {
        if is_point(run[0]) {
            let columns = run.chunk_by(|a, b| px[*a].0.floor() == px[*b].0.floor());
            let extremes: Vec<usize> = columns.flat_map(|column| extremes(px, column)).collect();
            kept.extend(straighten(px, &extremes, steps));
        } else {
            kept.push(run[0]);
        }
    }
    kept
}

/// First, lowest, highest and last point of a column, each once, in order of arrival.
fn extremes(px: &[(f64, f64)], column: &[usize]) -> Vec<usize> {
    let by_height = |a: &&usize, b: &&usize| px[**a].1.total_cmp(&px[**b].1);
    let ends = [column.first(), column.last()];
    let heights = [column.iter().min_by(by_height), column.iter().max_by(by_height)];
    let mut kept: Vec<usize> = ends.into_iter().chain(heights).flatten().copied().collect();
    kept.sort_unstable();
    kept.dedup();
    kept
}

/// Drops points within [`UNSEEN`], measured vertically, of the line that replaces them. Ends stay.
fn straighten(px: &[(f64, f64)], run: &[usize], steps: bool) -> Vec<usize> {
    let mut kept: Vec<usize> = run.first().copied().into_iter().collect();
    let mut from = 0;
    for to in 2..run.len() {
        let (a, b) = (px[run[from]], px[run[to]]);
        let on_the_line = |index: &usize| {
            let point = px[*index];
            let slope = if steps { 0.0 } else { (b.1 - a.1) / (b.0 - a.0) };
            (a.1 + slope * (point.0 - a.0) - point.1).abs() <= UNSEEN
        };
        if to - from > LONGEST || b.0 <= a.0 || !run[from + 1..to].iter().all(on_the_line) {
            kept.push(run[to - 1]);
            from = to - 1;
        }
    }
    kept.extend(run.last().filter(|_| run.len() > 1));
    kept
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
}
