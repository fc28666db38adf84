//! Programs that wait for the next run of this thread: many short runs start each program once.
//!
//! The next run's first question makes the program clear its history. A program that keeps its
//! history gives another drive than in a process of its own. The runs that studies repeat show
//! this.

use super::record::Program;
use runtime::hosted::Plan;
use std::cell::RefCell;

/// Most programs that wait.
const MOST: usize = 8;

thread_local! {
    /// Oldest first.
    static IDLE: RefCell<Vec<Program>> = const { RefCell::new(Vec::new()) };
}

/// A program of this plan that waits.
pub(super) fn take(plan: &Plan) -> Option<Program> {
    IDLE.with_borrow_mut(|idle| {
        let place = idle.iter().position(|idle| idle.plan == *plan)?;
        let mut program = idle.remove(place);
        program.forget();
        Some(program)
    })
}

/// Lets a program wait that has answered all questions.
pub(super) fn put(program: Program) {
    // A thread that ends keeps none.
    let _ = IDLE.try_with(|idle| {
        let mut idle = idle.borrow_mut();
        idle.push(program);
        if idle.len() > MOST {
            idle.remove(0);
        }
    });
}
