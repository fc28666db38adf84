//! Tasks that take turns in one thread: each runs until it waits, and goes on where it waited.

#![allow(unsafe_code, reason = "a task's yielder cannot be lent for as long as its ports live")]

use crate::RuntimeError;
use corosensei::stack::DefaultStack;
use corosensei::{Coroutine, CoroutineResult, Yielder};
use std::any::Any;
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::NonNull;
use std::rc::Rc;

/// Address space of a task's stack, bytes; only what is touched becomes memory.
const STACK_BYTES: usize = 4 << 20;

thread_local! {
    /// Stacks of tasks that ended, for the next run of this thread.
    static STACKS: RefCell<Vec<DefaultStack>> = const { RefCell::new(Vec::new()) };
}

/// The yielder of the task that runs.
type Slot = Rc<Cell<Option<NonNull<Yielder<(), ()>>>>>;

/// Handle by which the code of a task waits for its next turn.
///
/// It holds the yielder exactly while its task runs: a wait at any other time is a panic.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pause(Slot);

impl Pause {
    /// Lets the other tasks have their turns.
    ///
    /// # Panics
    /// If the caller is not the task that this belongs to.
    pub(crate) fn wait(&self) {
        let yielder = self.0.take().expect("only a running task waits");
        // SAFETY: `Task::new` put the yielder there when the task began and takes it away before it ends. A wait takes
        // it for the time in which the task does not run. So this is the running task's, on its own stack.
        unsafe { yielder.as_ref() }.suspend(());
        self.0.set(Some(yielder));
    }
}

/// Takes the yielder away when the task ends, also by a panic.
struct Running<'a>(&'a Pause);

impl Drop for Running<'_> {
    fn drop(&mut self) {
        self.0.0.set(None);
    }
}

#[derive(Debug)]
pub(crate) enum Turn {
    Waits,
    Done(Result<(), RuntimeError>),
    Panicked(String),
}

pub(crate) struct Task(Option<Coroutine<(), (), Result<(), RuntimeError>>>);

impl std::fmt::Debug for Task {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Task").finish_non_exhaustive()
    }
}

impl Task {
    /// A task that does `body` in its turns.
    pub(crate) fn new(
        pause: Pause,
        body: impl FnOnce() -> Result<(), RuntimeError> + 'static,
    ) -> Result<Self, RuntimeError> {
        let stack = match STACKS.with_borrow_mut(Vec::pop) {
            Some(stack) => stack,
            None => DefaultStack::new(STACK_BYTES)
                .map_err(RuntimeError::setup("a stack for a service"))?,
        };
        // Its content is too big to be handed to the new stack by value.
        let body = Box::new(body);
        Ok(Self(Some(Coroutine::with_stack(stack, move |yielder, ()| {
            pause.0.set(Some(NonNull::from(yielder)));
            let _running = Running(&pause);
            body()
        }))))
    }

    /// Lets it run until it waits or ends; a task that ended is done for good.
    pub(crate) fn resume(&mut self) -> Option<Turn> {
        let coroutine = self.0.as_mut()?;
        let turn = match catch_unwind(AssertUnwindSafe(|| coroutine.resume(()))) {
            Ok(CoroutineResult::Yield(())) => return Some(Turn::Waits),
            Ok(CoroutineResult::Return(result)) => Turn::Done(result),
            Err(payload) => Turn::Panicked(message(&*payload)),
        };
        self.recycle();
        Some(turn)
    }

    /// Ends the task where it is and keeps its stack.
    fn recycle(&mut self) {
        if let Some(mut coroutine) = self.0.take() {
            coroutine.force_unwind();
            STACKS.with_borrow_mut(|stacks| stacks.push(coroutine.into_stack()));
        }
    }
}

impl Drop for Task {
    fn drop(&mut self) {
        self.recycle();
    }
}

fn message(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(ToString::to_string);
    text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tasks_take_turns_and_go_on_where_they_waited() {
        let heard = Rc::new(RefCell::new(Vec::new()));
        let task = |name: char| {
            let (pause, heard) = (Pause::default(), Rc::clone(&heard));
            let own = pause.clone();
            Task::new(pause, move || {
                for turn in 0..3 {
                    heard.borrow_mut().push((name, turn));
                    own.wait();
                }
                Ok(())
            })
        };
        let (mut a, mut b) = (task('a').expect("memory"), task('b').expect("memory"));
        for _ in 0..3 {
            assert!(matches!(a.resume(), Some(Turn::Waits)));
            assert!(matches!(b.resume(), Some(Turn::Waits)));
        }
        assert!(matches!(a.resume(), Some(Turn::Done(Ok(())))));
        assert!(a.resume().is_none());
        let turns = [('a', 0), ('b', 0), ('a', 1), ('b', 1), ('a', 2), ('b', 2)];
        assert_eq!(*heard.borrow(), turns);
    }

    #[test]
    fn a_task_that_is_dropped_while_it_waits_drops_what_it_holds() {
        let (pause, held) = (Pause::default(), Rc::new(()));
        let (own, inside) = (pause.clone(), Rc::clone(&held));
        let mut task = Task::new(pause, move || {
            let _inside = inside;
            own.wait();
            Ok(())
        })
        .expect("memory");
        assert!(matches!(task.resume(), Some(Turn::Waits)));
        assert_eq!(Rc::strong_count(&held), 2);
        drop(task);
        assert_eq!(Rc::strong_count(&held), 1);
    }

    #[test]
    fn a_panic_ends_its_task_alone() {
        let mut task = Task::new(Pause::default(), || panic!("by design")).expect("memory");
        assert!(matches!(task.resume(), Some(Turn::Panicked(why)) if why == "by design"));
        assert!(task.resume().is_none());
    }
}
