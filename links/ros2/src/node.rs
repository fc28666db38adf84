//! The two topics, as a ROS 2 node has them.

use bytes::Bytes;
use messages::{LawAnswer, LawInput};
use rustdds::dds::{CreateError, ReadError, WriteError};
use rustdds::no_key::{DataReader, DataWriter, Decode, DefaultDecoder};
use rustdds::no_key::{DeserializerAdapter, SerializerAdapter};
use rustdds::policy::{Durability, History, Reliability};
use rustdds::{
    DomainParticipant, DomainParticipantBuilder, Duration, QosPolicyBuilder,
    RepresentationIdentifier, TopicKind,
};
use std::convert::Infallible;
use std::net::Ipv4Addr;

/// Reason why the node does not work.
#[derive(Debug, thiserror::Error)]
pub(crate) enum NodeError {
    #[error("cannot join the domain: {0}")]
    Create(CreateError),
    #[error("cannot publish /timegap/situation: {0}")]
    Write(WriteError<Record>),
    #[error("cannot read /timegap/command: {0}")]
    Read(ReadError),
    #[error("a command of {0} bytes, expected the {ANSWER} of timegap_msgs/msg/LawAnswer")]
    Length(usize),
}

const ANSWER: usize = size_of::<LawAnswer>();

/// Bytes of a message without their encapsulation.
pub(crate) type Record = Vec<u8>;

pub(crate) struct Node {
    situation: DataWriter<Record, Plain>,
    command: DataReader<Record, Plain>,
    // The topics' ends before the domain.
    _participant: DomainParticipant,
}

impl Node {
    /// Joins the domain on loopback, with ROS 2's usual quality of service.
    pub(crate) fn open(domain: u16) -> Result<Self, NodeError> {
        let builder = DomainParticipantBuilder::new(domain);
        let participant = builder.with_only_networks([Ipv4Addr::LOCALHOST]).build();
        let participant = participant.map_err(NodeError::Create)?;
        let qos = QosPolicyBuilder::new()
            .reliability(Reliability::Reliable { max_blocking_time: Duration::from_millis(100) })
            .durability(Durability::Volatile)
            .history(History::KeepLast { depth: 10 })
            .build();
        let topic = |name: &str, type_name: &str| {
            let type_name = format!("timegap_msgs::msg::dds_::{type_name}_");
            participant.create_topic(name.to_owned(), type_name, &qos, TopicKind::NoKey)
        };
        let open = || {
            let (situation, command) = (
                topic("rt/timegap/situation", "LawInput")?,
                topic("rt/timegap/command", "LawAnswer")?,
            );
            let publisher = participant.create_publisher(&qos)?;
            let subscriber = participant.create_subscriber(&qos)?;
            Ok((
                publisher.create_datawriter_no_key(&situation, None)?,
                subscriber.create_datareader_no_key(&command, None)?,
            ))
        };
        let (situation, command) = open().map_err(NodeError::Create)?;
        Ok(Self { situation, command, _participant: participant })
    }

    /// Publishes a question.
    pub(crate) fn ask(&self, question: &[u8]) -> Result<(), NodeError> {
        debug_assert_eq!(question.len(), size_of::<LawInput>());
        self.situation.write(question.to_vec(), None).map_err(NodeError::Write)
    }

    /// The next answer, if one is there.
    pub(crate) fn answer(&mut self) -> Result<Option<Record>, NodeError> {
        let sample = self.command.take_next_sample().map_err(NodeError::Read)?;
        let Some(sample) = sample else { return Ok(None) };
        let record = sample.into_value();
        match record.len() == ANSWER {
            true => Ok(Some(record)),
            false => Err(NodeError::Length(record.len())),
        }
    }
}

/// Records as they are.
#[derive(Clone)]
pub(crate) struct Plain;

impl SerializerAdapter<Record> for Plain {
    type Error = Infallible;

    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }

    fn to_bytes(record: &Record) -> Result<Bytes, Infallible> {
        Ok(Bytes::copy_from_slice(record))
    }
}

impl DeserializerAdapter<Record> for Plain {
    type Error = Infallible;
    type Decoded = Record;

    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        // Without members of less than eight bytes all of them are alike.
        &[
            RepresentationIdentifier::CDR_LE,
            RepresentationIdentifier::CDR2_LE,
            RepresentationIdentifier::XCDR2_LE,
        ]
    }

    fn transform_decoded(record: Record) -> Record {
        record
    }
}

impl DefaultDecoder<Record> for Plain {
    type Decoder = Self;

    const DECODER: Self = Self;
}

impl Decode<'_, Record> for Plain {
    type Error = Infallible;

    fn decode_bytes(self, bytes: &[u8], _: RepresentationIdentifier) -> Result<Record, Infallible> {
        Ok(bytes.to_vec())
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_member_of_both_records_has_eight_bytes() {
        for layout in messages::LAW_RECORDS {
            let places = layout.scalars();
            assert!(!places.is_empty() && layout.bytes == 8 * places.len(), "{}", layout.name);
        }
    }
}
