//! One SUMO for several egos, each of which is a run of its own.
//!
//! ```text
//! timegap --egos 3 ── Shared ─┬─ timegap run (a group, or one process), ego 1
//!            │                ├─ timegap run, ego 2       commands at once, in the order of the egos;
//!            └─ sumo          └─ timegap run, ego 3       a step when all have asked for it
//! ```
//!
//! An ego's run knows nothing of the others: it finds a SUMO that takes time for a step. An ego enters when the one before
//! it has left room, and its run begins then. An ego whose run ends, or is killed, leaves the net, and the others go on.

use std::io;
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::ProgramError;
use crate::client::{Client, END, STEP, SURROUND};
use crate::process::Network;
use crate::wire::{Answer, Body, read_message, write_message};

/// Environment variable by which a run knows its [`Seat`]: port and number. It is no key of a scenario, since a kept
/// scenario outlives the port.
const SEAT: &str = "TIMEGAP_SUMO";

/// Longest wait of an ego until the one before it has left room, s: it starts from rest.
pub const ROOM_S: f64 = 10.0;
/// Time between two looks for the connections of the runs.
const LOOK: Duration = Duration::from_millis(5);
/// Wait of a run beyond SUMO's deadline, s: the runs begin together, and some take longer to start.
const OTHERS_S: f64 = 60.0;

/// A place at a SUMO that several egos share.
#[derive(Clone, Copy, Debug)]
pub struct Seat {
    port: u16,
    /// The ego's number, from 1 on.
    pub number: u32,
}

impl Seat {
    /// The seat that this process was given.
    pub fn given() -> Option<Self> {
        let text = std::env::var(SEAT).ok()?;
        let (port, number) = text.split_once(' ')?;
        Some(Self { port: port.parse().ok()?, number: number.parse().ok()? })
    }
}

impl Seat {
    /// Connects the run to it.
    pub(crate) fn take(self, deadline_s: f64) -> Result<Client, ProgramError> {
        let stream = TcpStream::connect((Ipv4Addr::LOCALHOST, self.port));
        let stream = stream.map_err(ProgramError::start("a seat at SUMO"))?;
        Client::open(None, stream, deadline_s + OTHERS_S)
    }
}

/// The command of this process without some options, each `--NAME VALUE` or `--NAME=VALUE`.
///
/// # Errors
/// If the system does not know this program's file.
pub fn this_command(without: &[&str]) -> io::Result<Command> {
    let mut command = Command::new(std::env::current_exe()?);
    let mut words = std::env::args_os().skip(1);
    while let Some(word) = words.next() {
        let text = word.to_string_lossy();
        match without.contains(&text.split('=').next().unwrap_or_default()) {
            true if !text.contains('=') => drop(words.next()),
            true => {}
            false => drop(command.arg(&word)),
        }
    }
    Ok(command)
}

/// SUMO for several egos.
#[derive(Debug)]
pub struct Shared(Client);

/// An ego at the table.
struct Ego {
    number: u32,
    run: JoinHandle<io::Result<Output>>,
    /// Its run's connection, while it drives.
    stream: Option<TcpStream>,
    /// Id of its vehicle once that is in the net.
    vehicle: Option<String>,
    /// Answers to the commands before a step, and the time to which it asks to step, s.
    waits: Option<(Vec<u8>, f64)>,
}

impl Shared {
    /// Starts SUMO with a configuration and a seed.
    ///
    /// # Errors
    /// [`ProgramError`] if the program is missing or cannot start.
    pub fn start(
        program: (&Path, u64),
        deadline_s: f64,
        network: &mut dyn Network,
    ) -> Result<Self, ProgramError> {
        Client::start(program, deadline_s, network).map(Self)
    }

    /// Runs a program for each ego, and waits for all. Their standard outputs come back in the order of the egos.
    ///
    /// # Errors
    /// [`ProgramError`] if a run cannot start, or SUMO fails before they are over.
    pub fn drive(
        mut self,
        runs: impl IntoIterator<Item = io::Result<Command>>,
    ) -> Result<Vec<Output>, ProgramError> {
        let refuse = ProgramError::start("the run of an ego");
        let begun = runs.into_iter().zip(1..).map(|(run, number)| {
            let seat = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
            seat.set_nonblocking(true)?;
            let mut run = run?;
            run.env(SEAT, format!("{} {number}", seat.local_addr()?.port())).stdin(Stdio::null());
            let run = run.stdout(Stdio::piped()).spawn()?;
            let run = std::thread::spawn(move || run.wait_with_output());
            Ok((seat, Ego { number, run, stream: None, vehicle: None, waits: None }))
        });
        let begun: Vec<_> = begun.collect::<io::Result<_>>().map_err(&refuse)?;
        // All are there before the first step, so that it is the same one for all.
        let seated = begun.into_iter().map(|(seat, mut ego)| {
            while ego.stream.is_none() && !ego.run.is_finished() {
                ego.stream = seat.accept().ok().map(|(stream, _)| stream);
                std::thread::sleep(LOOK);
            }
            let set = ego.stream.as_ref().map_or(Ok(()), |stream| {
                stream.set_nonblocking(false).and_then(|()| stream.set_nodelay(true))
            });
            set.map(|()| ego)
        });
        let mut egos: Vec<_> = seated.collect::<io::Result<_>>().map_err(&refuse)?;
        let driven = self.steps(&mut egos);
        // A run whose connection ends here is over.
        egos.iter_mut().for_each(|ego| ego.stream = None);
        let outputs = egos.into_iter().map(|ego| ego.run.join().expect("it does not panic"));
        let outputs = outputs.collect::<io::Result<_>>().map_err(refuse)?;
        driven.map(|()| outputs)
    }

    /// Steps SUMO until all egos have left.
    fn steps(&mut self, egos: &mut [Ego]) -> Result<(), ProgramError> {
        loop {
            for ego in &mut *egos {
                while ego.waits.is_none()
                    && let Some(stream) = &mut ego.stream
                {
                    let message = read_message(stream).unwrap_or_default();
                    self.serve(ego, &message)?;
                }
            }
            let asked = egos.iter().filter_map(|ego| ego.waits.as_ref()).map(|(_, to_s)| *to_s);
            let Some(to_s) = asked.min_by(f64::total_cmp) else { return Ok(()) };
            let mut step = Vec::new();
            Body::default().number(to_s).write(STEP, &mut step);
            let outcome = self.0.forward(&step)?;
            for ego in &mut *egos {
                if let Some((mut answers, _)) = ego.waits.take_if(|(_, asked_s)| *asked_s == to_s) {
                    answers.extend(&outcome);
                    ego.answer(&answers);
                }
            }
        }
    }

    /// Executes the commands of an ego's message up to a step. The ego of a message without commands is gone.
    fn serve(&mut self, ego: &mut Ego, message: &[u8]) -> Result<(), ProgramError> {
        let (mut rest, mut commands, mut step) = (Answer(message), Vec::new(), None);
        let mut is_over = message.is_empty();
        while !rest.0.is_empty() && !is_over {
            let (id, mut body, whole) = rest.next_command()?;
            match id {
                STEP => step = Some(body.number()?),
                END => is_over = true,
                _ => commands.extend(whole),
            }
            if id == SURROUND {
                // Behind the times between which it lasts.
                body.number().and_then(|_| body.number())?;
                ego.vehicle = Some(body.text()?);
            }
        }
        if is_over {
            if message.is_empty() {
                eprintln!("note: the run of ego {} has broken off: the others go on", ego.number);
            }
            ego.stream = None;
            // One that has reached its end is not there any more.
            let _ = ego.vehicle.take().map(|vehicle| self.0.remove(&vehicle));
            return Ok(());
        }
        let no_command = commands.is_empty();
        let answers = if no_command { Vec::new() } else { self.0.forward(&commands)? };
        match step {
            Some(to_s) => ego.waits = Some((answers, to_s)),
            None => ego.answer(&answers),
        }
        Ok(())
    }
}

impl Ego {
    /// Sends an answer. A run that does not take it is found to be gone at the next question.
    fn answer(&mut self, bytes: &[u8]) {
        let _ = self.stream.as_mut().map(|stream| write_message(stream, bytes));
    }
}
