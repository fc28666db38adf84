//! A service's life: join the group, open ports, be released, end.
//!
//! ```text
//! Runtime::join ── publisher / subscriber ── begin ──► next_release ─► update, send ─┐
//!   group file        iceoryx2 ports       ready, start      ▲                       │
//!                                                            └───────────────────────┘ ─► finish
//! ```
//!
//! One code path serves two clocks, and only this module depends on which of them is in use:
//!
//! * **realtime**: [`Runtime::next_release`] sleeps until the absolute instant of the next release
//!   and [`Runtime::update`] takes what is there;
//! * **lockstep**: `next_release` returns at once and `update` waits for the samples that are due in the step. The
//!   plant's odometry paces all services, since all wait for it, directly or through others; no coordinator is needed.
//!   Publishers wait when a process of the group lags, so that no message is lost. All stamps are simulated time: same
//!   scenario, same seed, same bytes. A process that joined on its own is not waited for.
//!
//! In lockstep a run can also do without processes. [`InProcess`] lets all services of a run take turns in one thread.
//! They have the same ports over the memory of one process. A service cannot see the difference.
//!
//! Messages are written where they will be read. A publisher loans memory in shared memory ([`Publisher::loan`]),
//! protects the message there and hands it over. Readers borrow what is larger than
//! [`SMALL_BYTES`](messages::SMALL_BYTES) and copy what is not before they check it.
//!
//! `unsafe` is allowed in `coroutine`, `scheduling`, `spawn`, `usage` and `words`, for system calls that no crate wraps.
//! It is also allowed in `transport` (`pooled`, and where loaned bytes become a message). `counts` and `checkpoint` say
//! that a struct in shared memory has atomic numbers alone.

pub mod chain;
mod counts;
mod error;
mod faults;
pub mod hosted;
mod in_process;
mod life;
mod machine;
mod ports;
mod releases;
pub mod report;
mod session;
mod survival;
mod transport;
mod words;

pub use counts::account::LastAccount;
pub use counts::figures::{Count, Figures, Progress, RELEASE_JITTER};
pub use counts::statistics;
pub use counts::statistics::histogram_log;
pub use error::{RuntimeError, TransportError};
pub use faults::{FaultStatistics, Injected, concerned};
pub use in_process::{Entry, InProcess};
pub use life::group::Group;
pub use life::link::{FromService, Link, PEER_JOINED, StartOrder, ToService};
pub use life::process::{NAME_PREFIX, PREPARED, PREPARED_PREFIX};
pub use life::process::{end_of_process, log_warnings, run_service};
pub use machine::background::{BackgroundWorker, WorkerReport};
pub use machine::program::{Program, ProgramError, command_line, executable};
pub use machine::scheduling;
pub use machine::spawn::{OwnNetwork, die_with_this_thread, inherit_only};
pub use machine::usage::Usage;
pub use ports::guest::{Guest, Played, Tapped};
pub use ports::members::{enroll, enroll_listener};
pub use ports::{Publisher, Subscriber};
pub use releases::clock::{Clock, Mode, monotonic_ns, sleep_until};
pub use releases::cycles::{Overrun, Release};
pub use releases::schedule::{Schedule, ScheduledRelease};
pub use releases::timetable::Timetable;
pub use session::{Cycle, Runtime, count_allocations_by};
pub use survival::checkpoint::Checkpoint;
pub use survival::fence as epoch;
pub use survival::standby::{ActiveProcess, Cause, CycleWatch, TakeOver};
pub use transport::waking::{Waker, wait_word, wake_word};
pub use transport::{Carrier, Ipc, Loan, Sealing, Turns, shared_memory_bytes};
pub use words::{Atomics, Shared, SharedWords};
