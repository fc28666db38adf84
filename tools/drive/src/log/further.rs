//! Ground truth of the other vehicles, step by step, and topics of which only the headers matter. A second message has
//! the vehicles for which the first has no room.

use crate::log::kept_steps::KeptSteps;
use crate::log::present::join;
use crate::report::ReceivedTopic;
use messages::{AllVehicles, Header, MAX_TRACKS, Message, MoreVehicles, Topic, VehicleTruth};
use runtime::{Guest, RuntimeError, Subscriber};

/// Steps so far, and room for those to come: a long drive allocates no more than a short one.
#[derive(Debug)]
pub(crate) struct Truths {
    pub(crate) steps: Vec<AllVehicles>,
    spare: Vec<AllVehicles>,
}

impl Truths {
    /// Room for `count` steps of `others` vehicles each.
    pub(crate) fn with_room(count: usize, others: usize) -> Self {
        let spare = (0..count).map(|_| AllVehicles::with_room(others)).collect();
        Self { steps: Vec::with_capacity(count), spare }
    }

    /// Takes the first message of a step. The newest step is always there; the next one replaces it if it is not to be
    /// kept.
    pub(crate) fn take(&mut self, first: &VehicleTruth, kept: &KeptSteps) {
        let is_passing = self.steps.last().is_some_and(|last| !kept.has(last.header.step));
        let room = if is_passing { self.steps.pop() } else { self.spare.pop() };
        let mut step = room.unwrap_or_else(|| AllVehicles::with_room(first.vehicles().len()));
        step.take(first, None);
        self.steps.push(step);
    }

    /// Leaves out what is not to be kept.
    pub(crate) fn thin_out(&mut self, kept: &KeptSteps) {
        self.spare.extend(self.steps.extract_if(.., |step| !kept.has(step.header.step)));
    }
}

/// The topic of a scenario with many vehicles, and its messages that wait for the first ones of their steps.
#[derive(Debug)]
pub(crate) struct Further {
    topic: Subscriber<MoreVehicles>,
    waiting: Vec<MoreVehicles>,
}

impl Further {
    /// Opens the topic; `None` where the first messages have room for all `others`.
    pub(crate) fn listen(observer: &Guest, others: usize) -> Result<Option<Self>, RuntimeError> {
        let has_more = others > MAX_TRACKS;
        let topic = has_more.then(|| observer.subscriber()).transpose()?;
        Ok(topic.map(|topic| Self { topic, waiting: Vec::new() }))
    }

    /// Puts the messages that arrived to the first ones of their steps.
    pub(crate) fn join(&mut self, truths: &mut [AllVehicles]) -> Result<(), RuntimeError> {
        let Self { topic, waiting } = self;
        topic.drain(|message| waiting.push(*message))?;
        let steps =
            (|truth: &AllVehicles| truth.header.step, |more: &MoreVehicles| more.header.step);
        join(truths, waiting, steps, |truth, more| {
            truth.vehicles.extend_from_slice(more.vehicles())
        });
        Ok(())
    }

    /// Count of received messages.
    pub(crate) fn received(&self) -> ReceivedTopic {
        self.topic.received()
    }
}

/// A topic of which only the headers matter.
pub(crate) trait Headers: std::fmt::Debug {
    /// Takes all that arrived.
    fn drain_headers(&mut self, each: &mut dyn FnMut(Topic, &Header)) -> Result<(), RuntimeError>;
}

impl<T: Message> Headers for Subscriber<T> {
    fn drain_headers(&mut self, each: &mut dyn FnMut(Topic, &Header)) -> Result<(), RuntimeError> {
        self.drain(|message| each(T::TOPIC, message.header()))
    }
}

/// Opens a topic by its number.
pub(crate) fn listen_to(observer: &Guest, topic: Topic) -> Result<Box<dyn Headers>, RuntimeError> {
    macro_rules! by_topic {
        ($($message:ty),+) => {
            match topic {
                $(<$message as Message>::TOPIC => Ok(Box::new(observer.subscriber::<$message>()?)),)+
            }
        };
    }
    messages::each_message!(by_topic)
}
