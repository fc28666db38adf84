//! A service's life: join the group, open ports, be released, end.
//!
//! ```text
//! Runtime::join ── publisher / subscriber ── begin ──► next_release ─► update, send ─┐
//!   group file        iceoryx2 ports       ready, start      ▲                       │
//!                                                            └───────────────────────┘ ─► finish
//! ```
//!
//! One code path serves two clocks, and only this module knows which of them is in use:
//!
//! * **realtime**: [`Runtime::next_release`] sleeps until the absolute instant of the next release
//!   and [`Runtime::update`] takes what is there;
//! * **lockstep**: `next_release` returns at once and `update` waits for the samples that are due
//!   in the step. The plant's odometry paces all services, since all wait for it, directly or through
//!   others; no coordinator is needed. Publishers wait when a process of the group lags, so that no
//!   message is lost, and all stamps are simulated time: same scenario, same seed, same bytes. A process
//!   that joined by itself is not waited for.
//!
//! In lockstep a run can also do without processes: [`InProcess`] lets all services of a run take turns
//! in one thread, with the same ports over the memory of one process. No service knows.
//!
//! Messages are written where they will be read: a publisher loans memory in shared memory
//! ([`Publisher::loan`]), protects the message there and hands it over. Readers borrow what is larger than
//! [`SMALL_BYTES`](messages::SMALL_BYTES) and copy what is not before they check it.
//!
//! `unsafe` is allowed in `coroutine`, `scheduling`, `spawn`, `usage` and `words`, for system calls that no
//! crate wraps, and in `transport` (`pooled`, and where loaned bytes become a message) and `probe`.

mod account;
mod background;
mod carried;
mod checkpoint;
mod clock;
mod coroutine;
mod end_word;
mod error;
mod faults;
mod fence;
mod gate;
mod group;
pub mod histogram_log;
mod in_process;
mod kept;
mod kept_buckets;
mod link;
mod members;
mod not_granted;
mod observer;
mod own_file;
mod player;
mod port;
mod prepared;
mod probe;
mod process;
mod program;
mod release;
pub mod report;
mod schedule;
pub mod scheduling;
mod session;
mod spawn;
mod standby;
pub mod statistics;
mod tap;
mod timetable;
mod transport;
mod usage;
mod waking;
mod words;

pub use account::{LastAccount, Progress, take_account};
pub use background::BackgroundWorker;
pub use carried::Carried;
pub use checkpoint::Checkpoint;
pub use clock::{Clock, Mode, monotonic_ns, sleep_until};
pub use error::RuntimeError;
pub use faults::{FaultStatistics, Injected, concerned};
pub use group::Group;
pub use in_process::{Entry, InProcess};
pub use kept::{Count, Figures, RELEASE_JITTER};
pub(crate) use link::End;
pub use link::{FromService, PEER_JOINED, StartOrder, ToService};
pub use members::{enroll, enroll_listener};
pub use observer::{Observed, Observer};
pub use player::{Played, Player};
pub use port::{Publisher, Subscriber};
pub use prepared::{NAME_PREFIX, PREPARED, PREPARED_PREFIX};
pub use probe::{Contents, EventReceiver, EventSender, PayloadReceiver, PayloadSender, Probe};
pub use process::{log_warnings, run_service};
pub use program::{Program, ProgramError, executable};
pub use release::{Overrun, Release};
pub use schedule::{Schedule, ScheduledRelease};
pub use session::{Cycle, Runtime, count_allocations_by};
pub use spawn::{die_with_this_thread, inherit_only};
pub use standby::{ActiveProcess, Cause, TakeOver};
pub use tap::{Tap, Tapped};
pub use timetable::Timetable;
pub use transport::{Carrier, Loan, Sealing, TransportError, domain, shared_memory_bytes};
pub(crate) use transport::{Receiver, Sender, Transport};
pub use usage::Usage;
pub use words::SharedWords;
