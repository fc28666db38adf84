//! The numbers of the carriers, each with its unit, range and origin.
//!
//! An origin ends with the effect of half and double the number in a simulation with one sender (`effect_tests`). Its
//! figures are an uncertainty of 2.99 ms in the first second and of 3.14 ms later, an error of 0.47 ms, 127 questions,
//! and 4 refused new frames.

use parameters::parameters;

parameters! {
    /// Comparison of two hosts' clocks, and numbering of a sender's packets.
    pub struct Numbers {
        /// Largest drift between two hosts' clocks.
        drift_ppm: u32 = 100, "parts per million", 10.0..=500.0, "Chosen: twice the 50 of a usual crystal. At 50 uncertainty later -8 %, error later +5 %; at 200 uncertainty later +10 %, error later +9 %.";
        /// Kept questions with their answers.
        remembered: u32 = 32, "exchanges", 4.0..=256.0, "Chosen: half a minute of questions, in which a drift of 100 parts per million adds 3 ms. At 16 and 64 nothing changes.";
        /// Questions to a new station, for a good estimate soon.
        first_questions: u32 = 8, "questions", 1.0..=32.0, "Chosen: the shortest of eight delays is near the least. At 4 uncertainty in the first second +11 %, questions -4; at 16 uncertainty in the first second -4 %, questions +8.";
        /// Time between the first questions.
        first_period_s: f64 = 0.05, "s", 0.01..=1.0, "Chosen: all first questions are asked within 0.4 s, before the first frame counts. At 0.025 uncertainty in the first second -6 %; at 0.1 uncertainty in the first second +24 %.";
        /// Time between later questions.
        period_s: f64 = 1.0, "s", 0.1..=10.0, "Chosen: the drift in it is 0.1 ms, less than an answer's delay. At 0.5 uncertainty later -8 %, error later -23 %, questions +120; at 2 uncertainty later +10 %, error later +30 %, questions -60.";
        /// Most senders that are distinguished; beyond it, the longest silent one is dropped.
        stations: u32 = 64, "senders", 8.0..=1024.0, "Chosen: twice the units within reach of a vehicle in a town. The simulation does not depend on it.";
        /// Most frames in the queue to the loop.
        queue: u32 = 512, "frames", 64.0..=4096.0, "Chosen: more than a second of 25 roadside units. The simulation does not depend on it.";
        /// Distance from all other numbers beyond which a single number is refused.
        far: u32 = 3000, "numbers", 100.0..=100000.0, "Source: RFC 3550, appendix A.1, MAX_DROPOUT. Otherwise one packet with a wrong number would make all later ones look old. At 1500 and 6000 nothing changes.";
        /// Late numbers in a row, each following the previous one, that replace the sender's numbering.
        agreeing: u32 = 3, "numbers", 2.0..=10.0, "Chosen: one more than the MIN_SEQUENTIAL of RFC 3550, appendix A.1. At 2 new frames refused -1; at 6 new frames refused +3.";
    }
}

/// The values that the carriers use.
pub const NUMBERS: Numbers = Numbers::DEFAULT;
