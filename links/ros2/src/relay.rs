//! The program between a controller's pipes and the topics.

use crate::node::{Node, NodeError};
use messages::LawInput;
use std::ffi::OsString;
use std::io::{Read, Write, stdin, stdout};
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
fn relay(domain: u16) -> Result<(), NodeError> {
    let mut node = Node::open(domain)?;
    let (mut questions, mut answers) = (stdin().lock(), stdout().lock());
    let mut question = [0; size_of::<LawInput>()];
    let mut is_met = false;
    while questions.read_exact(&mut question).is_ok() {
        node.ask(&question)?;
        let begun = Instant::now();
        let (mut asked, mut is_said) = (begun, false);
        let answer = loop {
            match node.answer()? {
                // Both begin with the question's number.
                Some(answer) if answer[..8] == question[..8] => break answer,
                // A second answer to a question that was asked again.
                Some(_) => continue,
                None => {}
            }
            if !is_met && asked.elapsed() > AGAIN {
                node.ask(&question)?;
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
        if answers.write_all(&answer).and_then(|()| answers.flush()).is_err() {
            return Ok(());
        }
    }
    Ok(())
}
