//! A signal of a corridor with its fixed program.

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Signal {
    /// Position of its stop line, m.
    pub line_m: f64,
    /// Lengths of green, yellow and red, s.
    pub lengths_s: [f64; 3],
    /// Time by which its program is ahead at the start, s.
    pub offset_s: f64,
}

impl Signal {
    /// 0 green, 1 yellow, 2 red.
    pub fn phase_at(&self, time_s: f64) -> usize {
        let [green_s, yellow_s, red_s] = self.lengths_s;
        let into_s = (time_s + self.offset_s) % (green_s + yellow_s + red_s);
        usize::from(into_s >= green_s) + usize::from(into_s >= green_s + yellow_s)
    }
}
