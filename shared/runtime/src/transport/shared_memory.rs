//! iceoryx2 as timegap uses it: one private node per process and one way to open each topic.

use super::ends::{Arrival, Connect, Input, Receiver, Sender, SenderId, buffer, buffer_of};
use super::error::TransportError;
use super::held::Held;
use super::loan::{Loan, Place};
use crate::counts::file::MOST_BYTES as MOST_COUNTS_BYTES;
use crate::life::link::End;
use crate::ports::members::Members;
use crate::survival::checkpoint::MOST_BYTES as MOST_STATE_BYTES;
use crate::transport::waking::{Waiter, WakeWords, Waker};
use crate::{Group, Mode, RuntimeError, Timetable};
use iceoryx2::config::Config;
use iceoryx2::port::BackpressureAction;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use iceoryx2::service::builder::Builder;
use iceoryx2::service::port_factory::publish_subscribe;
use messages::Service;
use messages::{LAYOUT_VERSION, Message, TOPICS, Topic};
use std::fmt::Debug;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Mutex;

/// The iceoryx2 variant of all topics.
pub use super::pooled::PooledIpc as Ipc;

/// Messages that a receiver borrows at most: the newest one, one of a later step, one that is checked.
const HELD: usize = 3;
/// Messages that a port writes at the same time.
const LOANED: usize = 2;
/// Last messages kept for receivers that come late.
const HISTORY: usize = 1;

/// Processes on one topic: the group, each restarted beside its dead self, and observers.
const MAX_PEERS: usize = 10;
/// Processes that a service with a standby adds to that: the standby, the next one, one that was replaced.
const STANDBY_PEERS: usize = 3;

/// Processes on one topic of a group in which `standbys` services have a standby.
const fn peers(standbys: usize) -> usize {
    MAX_PEERS + STANDBY_PEERS * standbys
}

/// Shared memory that a group with this timetable may come to use, bytes. Every publisher has room for the lag of all
/// its possible subscribers. `standby` are the services with a standby.
#[must_use]
pub fn shared_memory_bytes(timetable: &Timetable, standby: &[Service]) -> u64 {
    /// Management segments of all nodes, services and connections, generously.
    const MANAGEMENT: usize = 1 << 20;
    let each = |topic| buffer_of(topic, buffer(timetable)) + HELD;
    let messages = |topic| peers(standby.len()) * each(topic) + HISTORY + LOANED;
    let of = |service: Service| 1 + usize::from(standby.contains(&service));
    let all = Service::ALL.len() + standby.len();
    let publishers = |topic: Topic| topic.sources().iter().map(|&s| of(s)).max().unwrap_or(all);
    let bytes = |topic: Topic| publishers(topic) * messages(topic) * topic.message_bytes();
    let payload: usize = TOPICS.into_iter().map(bytes).sum();
    (payload + MANAGEMENT + Service::ALL.len() * (MOST_COUNTS_BYTES + MOST_STATE_BYTES)) as u64
}

impl<T: Message> Sender<T> for iceoryx2::port::publisher::Publisher<Ipc, T, ()> {
    #[expect(unsafe_code, reason = "a message is not written twice to please the type")]
    fn loan(&self) -> Result<Loan<T>, TransportError> {
        let sample = self.loan_uninit().map_err(TransportError::iceoryx2)?;
        // SAFETY: the payload is a part of a file in memory that this process has mapped. It holds zeros or an earlier
        // message, and any bytes are a `T`, which is `Pod`.
        Ok(Loan(Place::SharedMemory(unsafe { sample.assume_init() })))
    }

    fn send(&self, message: Loan<T>) -> Result<(), TransportError> {
        match message.0 {
            Place::SharedMemory(sample) => {
                sample.send().map(|_| ()).map_err(TransportError::iceoryx2)
            }
            Place::Memory(_) => Err(TransportError::OtherCarrier),
        }
    }
}

impl<Port: UpdateConnections + Debug> Connect for Port {
    fn connect(&self) -> Result<(), TransportError> {
        self.update_connections().map_err(TransportError::iceoryx2)
    }
}

impl<T: Message> Input for iceoryx2::port::subscriber::Subscriber<Ipc, T, ()> {
    fn has_input(&self) -> bool {
        self.has_samples().unwrap_or(false)
    }
}

impl<T: Message> Receiver<T> for iceoryx2::port::subscriber::Subscriber<Ipc, T, ()> {
    fn receive(&self, held: &mut Held<T>) -> Result<Option<Arrival>, TransportError> {
        let Some(sample) = Self::receive(self).map_err(TransportError::iceoryx2)? else {
            return Ok(None);
        };
        let sender = SenderId::of_port(sample.origin().value());
        Ok(Some(Arrival { sender, copied_bytes: held.take_sample(sample) }))
    }
}

/// A node in the run's private iceoryx2 domain.
#[derive(Debug)]
pub struct SharedMemory {
    node: Node<Ipc>,
    wake_words: WakeWords,
    mode: Mode,
    buffer: usize,
    peers: usize,
    root: PathBuf,
}

impl SharedMemory {
    /// Joins the run's domain.
    ///
    /// # Errors
    /// [`RuntimeError::Node`] if the root is not usable or shared memory is not to be had.
    pub(crate) fn join(group: &Group, name: &str) -> Result<Self, RuntimeError> {
        let error = |reason| RuntimeError::Node { root: group.root.clone(), reason };
        let config = domain(group)?;
        let name = NodeName::new(name).map_err(TransportError::iceoryx2).map_err(error)?;
        let node = NodeBuilder::new()
            .name(&name)
            .config(&config)
            // signal-hook owns the signals.
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Ipc>()
            .map_err(TransportError::iceoryx2)
            .map_err(error)?;
        let system = |what| move |reason| error(TransportError::System { what, reason });
        keep_to_this_user(&group.prefix).map_err(system("shared memory"))?;
        let wake_words = WakeWords::map(&group.prefix).map_err(system("wake words"))?;
        Ok(Self {
            node,
            wake_words,
            mode: group.mode,
            buffer: buffer(&group.timetable),
            peers: peers(group.standby.len()),
            root: group.root.clone(),
        })
    }

    /// Removes what dead processes left on the topics.
    pub(super) fn remove_dead(&self) {
        self.node.try_cleanup_dead_nodes();
    }

    /// Opens the publish-subscribe service of `T`'s topic.
    ///
    /// # Errors
    /// [`RuntimeError::Topic`].
    fn topic<T: Message>(
        &self,
    ) -> Result<publish_subscribe::PortFactory<Ipc, T, ()>, RuntimeError> {
        let key = AttributeKey::try_from("layout").expect("short enough for a key");
        let version = AttributeValue::try_from(LAYOUT_VERSION).expect("short enough for a value");
        let attributes =
            AttributeVerifier::new().require(&key, &version).map_err(refused(T::TOPIC))?;
        self.node
            .service_builder(&service_name(T::TOPIC))
            .publish_subscribe::<T>()
            .max_publishers(self.peers)
            .max_subscribers(self.peers)
            .max_nodes(2 * self.peers)
            .subscriber_max_buffer_size(buffer_of(T::TOPIC, self.buffer))
            .subscriber_max_borrowed_samples(HELD)
            // A restarted receiver begins with it.
            .history_size(HISTORY)
            .enable_safe_overflow(self.mode == Mode::Realtime)
            .open_or_create_with_attributes(&attributes)
            .map_err(refused(T::TOPIC))
    }

    pub(super) fn publisher<T: Message>(
        &self,
        end: End,
    ) -> Result<Rc<dyn Sender<T>>, RuntimeError> {
        let group = Listeners::of(&self.root);
        let port = self
            .topic::<T>()?
            .publisher_builder()
            .max_loaned_samples(LOANED)
            .set_backpressure_handler(move |full| {
                if end.is_now() || !group.waits_for(full.receiver_port_id) {
                    return BackpressureAction::DiscardData;
                }
                std::thread::sleep(std::time::Duration::from_micros(20));
                BackpressureAction::Retry
            })
            .create()
            .map_err(refused(T::TOPIC))?;
        if SenderId::of_port(port.id().value()).pid() != std::process::id() {
            return Err(RuntimeError::Topic { topic: T::TOPIC, reason: TransportError::PortId });
        }
        Ok(Rc::new(port))
    }

    pub(super) fn subscriber<T: Message>(&self) -> Result<Rc<dyn Receiver<T>>, RuntimeError> {
        let port = (self.topic::<T>()?.subscriber_builder()).create().map_err(refused(T::TOPIC))?;
        Ok(Rc::new(port))
    }

    /// Begins to open an iceoryx2 service that is not a topic.
    pub(crate) fn service(&self, name: &ServiceName) -> Builder<Ipc> {
        self.node.service_builder(name)
    }

    pub(crate) fn waker(&self, topic: Topic) -> Waker {
        self.wake_words.waker(topic)
    }

    pub(crate) fn waiter(&self, topic: Topic) -> Waiter {
        self.wake_words.waiter(topic)
    }
}

/// Receiving ports with a full buffer, and whether their process belongs to the group.
///
/// In lockstep each process of the group gets each of its messages: the sender waits for room. A process that joined on
/// its own gets only what it has room for. So it cannot hold up the run.
struct Listeners {
    members: Members,
    /// Listeners that were looked up so far, newest last; few ports ever have a full buffer.
    known: Mutex<[Option<(u128, bool)>; REMEMBERED_LISTENERS]>,
}

/// Receiving ports that a sender keeps.
const REMEMBERED_LISTENERS: usize = 2 * MAX_PEERS;

impl Listeners {
    fn of(root: &std::path::Path) -> Self {
        Self { members: Members::of(root), known: Mutex::new([None; REMEMBERED_LISTENERS]) }
    }

    /// True if the process of receiving port `port` belongs to the group.
    fn waits_for(&self, port: u128) -> bool {
        let mut known = self.known.lock().expect("no holder panics");
        if let Some((_, belongs)) = known.iter().flatten().find(|(id, _)| *id == port) {
            return *belongs;
        }
        let belongs = self.members.is_in_group(SenderId::of_port(port).pid());
        known.rotate_left(1);
        known[REMEMBERED_LISTENERS - 1] = Some((port, belongs));
        belongs
    }
}

/// iceoryx2's configuration for the run's private domain.
///
/// # Errors
/// [`RuntimeError::Node`] if iceoryx2 does not accept the root's path or the prefix.
pub fn domain(group: &Group) -> Result<Config, RuntimeError> {
    let error = |reason| RuntimeError::Node { root: group.root.clone(), reason };
    let mut config = Config::default();
    let root = group.root.to_str().ok_or_else(|| error(TransportError::Path))?;
    config.global.prefix =
        FileName::new(group.prefix.as_bytes()).map_err(TransportError::iceoryx2).map_err(error)?;
    // The launcher cleans up after each death; a service that starts has no time for it.
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    let root = Path::new(root.as_bytes()).map_err(TransportError::iceoryx2).map_err(error)?;
    config.global.set_root_path(&root);
    Ok(config)
}

/// The error of a topic that iceoryx2 does not open.
fn refused<E: std::error::Error + Send + Sync + 'static>(
    topic: Topic,
) -> impl FnOnce(E) -> RuntimeError {
    move |error| RuntimeError::Topic { topic, reason: TransportError::iceoryx2(error) }
}

/// Ending of the name of the one object that iceoryx2 makes for all users.
const NODE_TABLE: &str = ".global_mgmt";

/// Takes from others what iceoryx2 grants them in the run's shared memory. This is a table of the nodes' ids, which all
/// users of one machine would share in a common domain. This domain is one user's own.
fn keep_to_this_user(prefix: &str) -> std::io::Result<()> {
    for entry in std::fs::read_dir("/dev/shm")? {
        let entry = entry?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if !name.starts_with(prefix) || !name.ends_with(NODE_TABLE) {
            continue;
        }
        // A peer may have removed it meanwhile.
        let Ok(metadata) = entry.metadata() else { continue };
        let mode = metadata.permissions().mode();
        if mode & 0o077 != 0 {
            let own = std::fs::Permissions::from_mode(mode & 0o700);
            match std::fs::set_permissions(entry.path(), own) {
                Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(e),
                _ => {}
            }
        }
    }
    Ok(())
}

fn service_name(topic: Topic) -> ServiceName {
    topic.name().try_into().expect("topic names are valid service names")
}
