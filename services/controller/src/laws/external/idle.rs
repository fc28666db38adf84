//! Programs that wait for the next run of this thread: many short runs start each program once.
//!
//! The next run's first question makes the program clear its history. A program that keeps its
//! history gives another drive than in a process of its own. The runs that studies repeat show
//! this.

use super::channel::Channel;
use super::host::Host;
use super::process::Plan;
use std::cell::RefCell;

/// Most programs that wait.
const MOST: usize = 8;

thread_local! {
    /// Oldest first.
    static IDLE: RefCell<Vec<Idle>> = const { RefCell::new(Vec::new()) };
}

struct Idle {
    plan: Plan,
    // The channel before the host: a program goes when its input ends.
    channel: Box<Channel>,
    host: Host,
}

/// A program of this plan that waits.
pub(super) fn take(plan: &Plan) -> Option<(Box<Channel>, Host)> {
    IDLE.with_borrow_mut(|idle| {
        let place = idle.iter().position(|idle| idle.plan == *plan)?;
        let Idle { channel, host, .. } = idle.remove(place);
        Some((channel, host))
    })
}

/// Lets a program wait that has answered all questions.
pub(super) fn put(plan: Plan, channel: Box<Channel>, host: Host) {
    // A thread that ends keeps none.
    let _ = IDLE.try_with(|idle| {
        let mut idle = idle.borrow_mut();
        idle.push(Idle { plan, channel, host });
        if idle.len() > MOST {
            idle.remove(0);
        }
    });
}
