//! Processes that keep a core busy.

use super::outcome::Outcome;
use super::setup::Load;
use group::Error;
use std::hint::black_box;

/// Size of the copied buffers: larger than caches.
const BUFFER_BYTES: usize = 64 << 20;

/// Keeps the core busy until the process is killed.
pub fn run(load: Load) -> Result<Outcome, Error> {
    match load {
        Load::Idle => loop {
            std::thread::park();
        },
        Load::Cpu => {
            let mut state = 1_u64;
            loop {
                // Each multiplication depends on the previous one: the core never waits for memory.
                state = black_box(state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1));
            }
        }
        Load::Memory => {
            let (mut from, mut to) = (vec![1_u8; BUFFER_BYTES], vec![0_u8; BUFFER_BYTES]);
            loop {
                to.copy_from_slice(black_box(&from));
                from.copy_from_slice(black_box(&to));
            }
        }
    }
}
