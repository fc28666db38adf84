//! The program between a controller's pipes and the two topics of a ROS 2 node.

use bytes::Bytes;
use messages::{LawAnswer, LawInput};
use rustdds::dds::{CreateError, ReadError, WriteError};
use rustdds::no_key::{DataReaderCdr, DataWriter, SerializerAdapter};
use rustdds::policy::{Durability, History, Reliability};
use rustdds::{DomainParticipant, DomainParticipantBuilder, QosPolicyBuilder};
use rustdds::{RepresentationIdentifier, TopicKind};
use std::convert::Infallible;
use std::ffi::OsString;
use std::io::{Read, Write, stdin, stdout};
use std::net::Ipv4Addr;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Highest domain whose ports exist.
const LAST_DOMAIN: u16 = 232;
/// Time after which a question is asked again, while nothing has ever been answered: the node may not have been there.
const AGAIN: Duration = Duration::from_millis(100);
/// Silence after which a line says what is awaited.
const LONG: Duration = Duration::from_secs(2);
/// Time for which an answer is looked for closely, and the times between two looks then and later.
const CLOSE: Duration = Duration::from_millis(20);
const LOOKS: [Duration; 2] = [Duration::from_micros(50), Duration::from_millis(1)];

/// Reason why the relay does not work.
#[derive(Debug, thiserror::Error)]
enum RelayError {
    #[error("cannot join the domain: {0}")]
    Create(#[from] CreateError),
    #[error("cannot publish /timegap/situation: {0}")]
    Write(#[from] WriteError<Question>),
    #[error("cannot read /timegap/command: {0}")]
    Read(#[from] ReadError),
}

/// Becomes the relay. `arguments` are the domain; an empty one is `ROS_DOMAIN_ID`, or 0.
pub fn run(arguments: &[OsString]) -> ExitCode {
    let given = arguments.first().and_then(|word| word.to_str()).unwrap_or_default();
    let variable = std::env::var("ROS_DOMAIN_ID").unwrap_or_default();
    let word = [given, variable.trim(), "0"].into_iter().find(|word| !word.is_empty());
    let domain = word.and_then(|word| word.parse().ok()).filter(|domain| *domain <= LAST_DOMAIN);
    let Some(domain) = domain else {
        let word = word.unwrap_or_default().escape_debug();
        eprintln!("`{word}` is not a domain of ROS 2, expected a number from 0 to {LAST_DOMAIN}");
        return ExitCode::from(2);
    };
    match relay(domain) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}

/// Hands questions on and answers back until the questions end.
fn relay(domain: u16) -> Result<(), RelayError> {
    // The topics' ends go before the domain.
    let (_domain, situation, mut command) = join(domain)?;
    let (mut questions, mut answers) = (stdin().lock(), stdout().lock());
    let mut question = [0; size_of::<LawInput>()];
    let mut is_met = false;
    while questions.read_exact(&mut question).is_ok() {
        situation.write(question, None)?;
        let begun = Instant::now();
        let (mut asked, mut is_said) = (begun, false);
        let answer = loop {
            match command.take_next_sample()?.map(|sample| sample.into_value()) {
                // Both begin with the question's number.
                Some(answer) if answer[0][0].to_le_bytes() == question[..8] => break answer,
                // A second answer to a question that was asked again.
                Some(_) => continue,
                None => {}
            }
            if !is_met && asked.elapsed() > AGAIN {
                situation.write(question, None)?;
                asked = Instant::now();
            }
            if !is_met && !is_said && begun.elapsed() > LONG {
                is_said = true;
                eprintln!(
                    "waits for a node that reads /timegap/situation and publishes \
                     /timegap/command (domain {domain}, on loopback)"
                );
            }
            std::thread::sleep(LOOKS[usize::from(begun.elapsed() > CLOSE)]);
        };
        is_met = true;
        if answers.write_all(bytemuck::bytes_of(&answer)).and_then(|()| answers.flush()).is_err() {
            return Ok(());
        }
    }
    Ok(())
}

/// A question as it is: without members of less than eight bytes a record is its own CDR.
type Question = [u8; size_of::<LawInput>()];
/// The words of an answer, in lists of a length that serde knows.
type Answer = [[u64; 28]; 4];
const _: () = assert!(size_of::<Answer>() == size_of::<LawAnswer>());

/// A domain, and the ends of the topics in it.
type Ends = (DomainParticipant, DataWriter<Question, Plain>, DataReaderCdr<Answer>);

/// Joins the domain on loopback, with ROS 2's usual quality of service.
fn join(domain: u16) -> Result<Ends, CreateError> {
    let builder = DomainParticipantBuilder::new(domain);
    let participant = builder.with_only_networks([Ipv4Addr::LOCALHOST]).build()?;
    let max_blocking_time = rustdds::Duration::from_millis(100);
    let qos = QosPolicyBuilder::new()
        .reliability(Reliability::Reliable { max_blocking_time })
        .durability(Durability::Volatile)
        .history(History::KeepLast { depth: 10 })
        .build();
    let topic = |name: &str, type_name: &str| {
        let type_name = format!("timegap_msgs::msg::dds_::{type_name}_");
        participant.create_topic(format!("rt/timegap/{name}"), type_name, &qos, TopicKind::NoKey)
    };
    let (situation, command) = (topic("situation", "LawInput")?, topic("command", "LawAnswer")?);
    let situation =
        participant.create_publisher(&qos)?.create_datawriter_no_key(&situation, None)?;
    let command =
        participant.create_subscriber(&qos)?.create_datareader_no_key_cdr(&command, None)?;
    Ok((participant, situation, command))
}

#[derive(Clone)]
struct Plain;

impl SerializerAdapter<Question> for Plain {
    type Error = Infallible;

    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }

    fn to_bytes(question: &Question) -> Result<Bytes, Infallible> {
        Ok(Bytes::copy_from_slice(question))
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
