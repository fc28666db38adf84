//! iceoryx2 as timegap uses it: one private node per process and one way to open each topic.

use super::{buffer, buffer_of};
use crate::counts::MOST_BYTES as MOST_COUNTS_BYTES;
use crate::life::link::End;
use crate::survival::checkpoint::MOST_BYTES as MOST_STATE_BYTES;
use crate::survival::fence::Peers;
use crate::{Group, Mode, RuntimeError, Timetable, TransportError};
use iceoryx2::config::Config;
use iceoryx2::port::BackpressureAction;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;
use iceoryx2::sample_mut::SampleMut;
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use iceoryx2::service::builder::Builder;
use iceoryx2::service::marker::{CustomHeaderMarker, CustomPayloadMarker};
use iceoryx2::service::port_factory::publish_subscribe;
use iceoryx2::service::static_config::message_type_details::{TypeDetail, TypeVariant};
use messages::{LAYOUT_VERSION, Layout, Service, TOPICS, Topic};
use std::fmt::Debug;
use std::os::unix::fs::PermissionsExt;
use std::sync::Arc;
use std::time::Duration;

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
const fn most_processes(standbys: usize) -> usize {
    MAX_PEERS + STANDBY_PEERS * standbys
}

/// Shared memory that a group with this timetable may come to use, bytes. Every publisher has room for the lag of all
/// its possible subscribers. `standby` are the services with a standby.
pub fn shared_memory_bytes(timetable: &Timetable, standby: &[Service]) -> u64 {
    /// Management segments of all nodes, services and connections, generously.
    const MANAGEMENT: usize = 1 << 20;
    let each = |topic| buffer_of(topic, buffer(timetable)) + HELD;
    let messages = |topic| most_processes(standby.len()) * each(topic) + HISTORY + LOANED;
    let of = |service: Service| 1 + usize::from(standby.contains(&service));
    let all = Service::ALL.len() + standby.len();
    let publishers = |topic: Topic| topic.sources().iter().map(|&s| of(s)).max().unwrap_or(all);
    let bytes = |topic: Topic| publishers(topic) * messages(topic) * topic.message_bytes();
    let payload: usize = TOPICS.into_iter().map(bytes).sum();
    // A service's own state, and the accounts of three processes.
    let kept = Service::ALL.len() * (MOST_COUNTS_BYTES + 4 * MOST_STATE_BYTES);
    (payload + MANAGEMENT + kept) as u64
}

/// A payload: the bytes of one message. iceoryx2 compiles its ports once for all types, and gets size, alignment and
/// name of the type of each topic when it is opened. A program that uses the types themselves meets ours.
pub(crate) type Payload = [CustomPayloadMarker];
pub(crate) type LoanedSample = SampleMut<Ipc, Payload, CustomHeaderMarker>;
pub(crate) type ReceivedSample = Sample<Ipc, Payload, CustomHeaderMarker>;
pub(crate) type SendingPort = Publisher<Ipc, Payload, CustomHeaderMarker>;
pub(crate) type ReceivingPort = Subscriber<Ipc, Payload, CustomHeaderMarker>;

type Factory = publish_subscribe::PortFactory<Ipc, Payload, CustomHeaderMarker>;

#[expect(unsafe_code, reason = "a message is not written twice to please the type")]
pub(super) fn loan(port: &SendingPort) -> Result<LoanedSample, TransportError> {
    // SAFETY: a topic has one payload a message.
    let sample = unsafe { port.loan_custom_payload(1) }.map_err(TransportError::iceoryx2)?;
    // SAFETY: the payload is a part of a file in memory that this process has mapped. It holds zeros or an earlier
    // message.
    Ok(unsafe { sample.assume_init() })
}

/// The process that made port `id` of iceoryx2. From the lowest bits on, ids are seconds, nanoseconds, process, counter.
pub(super) fn pid_of(id: u128) -> u32 {
    (id >> 64) as u32
}

/// A node in the run's private iceoryx2 domain.
#[derive(Debug)]
pub(crate) struct SharedMemory {
    node: Node<Ipc>,
    pub(crate) peers: Peers,
    mode: Mode,
    buffer: usize,
    most_processes: usize,
}

impl SharedMemory {
    pub(crate) fn join(group: &Group, name: &str) -> Result<Self, RuntimeError> {
        let error = |reason| RuntimeError::Node(group.root.clone(), reason);
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
        let system = |what| move |reason| error(TransportError::System(what, reason));
        keep_to_this_user(&group.prefix).map_err(system("shared memory"))?;
        Ok(Self {
            node,
            peers: Peers::of(group).map_err(system("words of the run"))?,
            mode: group.mode,
            buffer: buffer(&group.timetable),
            most_processes: most_processes(group.standby.len()),
        })
    }

    /// Removes what dead processes left on the topics.
    pub(crate) fn remove_dead(&self) {
        self.node.try_cleanup_dead_nodes();
    }

    /// Opens the publish-subscribe service of a topic.
    #[expect(unsafe_code, reason = "the layout stands for the type")]
    fn topic(&self, topic: Topic) -> Result<Factory, RuntimeError> {
        let key = AttributeKey::try_from("layout").expect("short enough for a key");
        let version = AttributeValue::try_from(LAYOUT_VERSION).expect("short enough for a value");
        let attributes =
            AttributeVerifier::new().require(&key, &version).map_err(refused(topic))?;
        let layout = topic.layout();
        let fixed = TypeVariant::FixedSize;
        let (name, bytes) = (layout.type_name, layout.bytes);
        let payload = TypeDetail::__internal_new_from_parts(fixed, name, bytes, Layout::ALIGNMENT)
            .map_err(refused(topic))?;
        let builder = self
            .node
            .service_builder(&topic.name().try_into().expect("topic names are valid service names"))
            .publish_subscribe::<Payload>()
            .user_header::<CustomHeaderMarker>();
        // SAFETY: the payload has the layout of the topic's message, and there is no header of ours.
        let builder = unsafe {
            builder
                .__internal_set_payload_type_details(&payload)
                .__internal_set_user_header_type_details(&TypeDetail::new::<()>(fixed))
        };
        builder
            .max_publishers(self.most_processes)
            .max_subscribers(self.most_processes)
            .max_nodes(2 * self.most_processes)
            .subscriber_max_buffer_size(buffer_of(topic, self.buffer))
            .subscriber_max_borrowed_samples(HELD)
            // A restarted receiver begins with it.
            .history_size(HISTORY)
            .enable_safe_overflow(self.mode == Mode::Realtime)
            .open_or_create_with_attributes(&attributes)
            .map_err(refused(topic))
    }

    /// Creates the sending end of `topic`.
    ///
    /// In lockstep each process of the group gets each of its messages: the sender waits for room. A process that
    /// joined on its own gets only what it has room for. So it cannot hold up the run.
    pub(crate) fn sender(&self, topic: Topic, end: End) -> Result<SendingPort, RuntimeError> {
        let words = Arc::clone(&self.peers.words);
        let port = self
            .topic(topic)?
            .publisher_builder()
            .max_loaned_samples(LOANED)
            .set_backpressure_handler(move |full| {
                if end.is_now() || !words.is_in_group(pid_of(full.receiver_port_id)) {
                    return BackpressureAction::DiscardData;
                }
                std::thread::sleep(Duration::from_micros(20));
                BackpressureAction::Retry
            })
            .create()
            .map_err(refused(topic))?;
        if pid_of(port.id().value()) != std::process::id() {
            let reason = TransportError::Refused("iceoryx2's port ids do not name the process");
            return Err(RuntimeError::Topic("open", topic, reason));
        }
        Ok(port)
    }

    pub(crate) fn receiver(&self, topic: Topic) -> Result<ReceivingPort, RuntimeError> {
        self.topic(topic)?.subscriber_builder().create().map_err(refused(topic))
    }

    /// Begins to open an iceoryx2 service that is not a topic.
    pub(crate) fn service(&self, name: &ServiceName) -> Builder<Ipc> {
        self.node.service_builder(name)
    }
}

/// iceoryx2's configuration for the run's private domain.
fn domain(group: &Group) -> Result<Config, RuntimeError> {
    let error = |reason| RuntimeError::Node(group.root.clone(), reason);
    let mut config = Config::default();
    let root = group
        .root
        .to_str()
        .ok_or_else(|| error(TransportError::Refused("the path is not UTF-8")))?;
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
    move |error| RuntimeError::Topic("open", topic, TransportError::iceoryx2(error))
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
