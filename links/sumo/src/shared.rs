//! One SUMO for several egos, each of which is a run of its own.
//!
//! ```text
//! timegap --egos 3 ── Shared ─┬─ timegap run (a group, or one process), ego 1
//!            │                ├─ timegap run, ego 2       commands at once, in the order of the egos;
//!            └─ sumo          └─ timegap run, ego 3       a step when all have asked for it
//! ```
//!
//! An ego's run finds a SUMO that takes time for a step. With the step it announces its acceleration, which the others get
//! with the answer. An ego enters when the one before it has left room, and its run begins then. An ego whose run ends, or
//! is killed, leaves the net, and the others go on.

use std::io;
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::JoinHandle;

use crate::ProgramError;
use crate::client::{ANNOUNCE, Client, END, STEP, SURROUND};
use crate::process::Network;
use crate::wire::{Answer, Body, read_message, write_message};

/// Environment variable by which a run knows its [`Seat`]: port and number. It is no key of a scenario, since a kept
/// scenario outlives the port.
const SEAT: &str = "TIMEGAP_SUMO";

/// Longest wait of an ego until the one before it has left room, s: it starts from rest.
pub const ROOM_S: f64 = 10.0;
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
    pub fn given() -> Option<Self> {
        let text = std::env::var(SEAT).ok()?;
        let (port, number) = text.split_once(' ')?;
        Some(Self { port: port.parse().ok()?, number: number.parse().ok()? })
    }

    pub(crate) fn take(self, deadline_s: f64) -> Result<Client, ProgramError> {
        let stream = TcpStream::connect((Ipv4Addr::LOCALHOST, self.port));
        let stream = stream.map_err(ProgramError::start("a seat at SUMO"))?;
        Client::open(None, stream, deadline_s + OTHERS_S)
    }
}

struct Ego {
    run: JoinHandle<io::Result<Output>>,
    /// Its run's connection, while it drives.
    stream: Option<TcpStream>,
    /// Id of its vehicle once that is in the net.
    vehicle: Option<String>,
    /// Answers to the commands before a step, and the time to which it asks to step, s.
    waits: Option<(Vec<u8>, f64)>,
    /// Its last announcement to the others.
    announces: Vec<u8>,
}

/// Starts SUMO with a configuration and a seed, and this process's command for each ego with a [`Seat`]. Waits for all
/// runs. Their standard outputs come back in the order of the egos.
///
/// # Errors
/// [`ProgramError`] if a program is missing or cannot start, or if SUMO fails before the runs are over.
pub fn drive_egos(
    program: (&Path, u64),
    deadline_s: f64,
    network: &mut dyn Network,
    egos: u32,
    prepare: impl Fn(&mut Command),
) -> Result<Vec<Output>, ProgramError> {
    let mut sumo = Client::start(program, deadline_s, network)?;
    let refuse = ProgramError::start("the run of an ego");
    let begun = (1..=egos).map(|number| {
        let seat = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
        let place = seat.local_addr()?;
        let mut run = Command::new(std::env::current_exe()?);
        prepare(run.args(std::env::args_os().skip(1)));
        run.env(SEAT, format!("{} {number}", place.port())).stdin(Stdio::null());
        let run = run.stdout(Stdio::piped()).spawn()?;
        let run = std::thread::spawn(move || {
            let output = run.wait_with_output();
            // A run that ends before it takes its seat is not waited for.
            drop(TcpStream::connect(place));
            output
        });
        Ok((seat, run))
    });
    let begun: Vec<_> = begun.collect::<io::Result<_>>().map_err(&refuse)?;
    // All are there before the first step, so that it is the same one for all.
    let seated = begun.into_iter().map(|(seat, run)| {
        let (stream, _) = seat.accept()?;
        stream.set_nodelay(true)?;
        Ok(Ego { run, stream: Some(stream), vehicle: None, waits: None, announces: Vec::new() })
    });
    let mut egos: Vec<_> = seated.collect::<io::Result<_>>().map_err(&refuse)?;
    let driven = steps(&mut sumo, &mut egos);
    // A run whose connection ends here is over.
    egos.iter_mut().for_each(|ego| ego.stream = None);
    let outputs = egos.into_iter().map(|ego| ego.run.join().expect("it does not panic"));
    let outputs = outputs.collect::<io::Result<_>>().map_err(refuse)?;
    driven.map(|()| outputs)
}

/// Steps SUMO until all egos have left.
fn steps(sumo: &mut Client, egos: &mut [Ego]) -> Result<(), ProgramError> {
    loop {
        for ego in &mut *egos {
            while ego.waits.is_none()
                && let Some(stream) = &mut ego.stream
            {
                let message = read_message(stream).unwrap_or_default();
                ego.serve(sumo, &message)?;
            }
        }
        let asked = egos.iter().filter_map(|ego| ego.waits.as_ref()).map(|(_, to_s)| *to_s);
        let Some(to_s) = asked.min_by(f64::total_cmp) else { return Ok(()) };
        let mut step = Vec::new();
        Body::default().number(to_s).write(STEP, &mut step);
        let mut outcome = sumo.forward(&step)?;
        outcome.extend(egos.iter().flat_map(|ego| &ego.announces));
        for ego in &mut *egos {
            if let Some((mut answers, _)) = ego.waits.take_if(|(_, asked_s)| *asked_s == to_s) {
                answers.extend(&outcome);
                ego.answer(&answers);
            }
        }
    }
}

impl Ego {
    /// Executes the commands of a message up to a step. The ego of a message without commands is gone.
    fn serve(&mut self, sumo: &mut Client, message: &[u8]) -> Result<(), ProgramError> {
        let (mut rest, mut commands, mut step) = (Answer(message), Vec::new(), None);
        let mut is_over = message.is_empty();
        while !rest.0.is_empty() && !is_over {
            let (id, mut body, whole) = rest.command()?;
            match id {
                STEP => step = Some(body.number()?),
                END => is_over = true,
                ANNOUNCE => self.announces = whole.to_vec(),
                _ => commands.extend(whole),
            }
            if id == SURROUND {
                // Behind the times between which it lasts.
                body.number().and_then(|_| body.number())?;
                self.vehicle = Some(body.text()?);
            }
        }
        if is_over {
            (self.stream, self.announces) = (None, Vec::new());
            // One that has reached its end is not there any more.
            let _ = self.vehicle.take().map(|vehicle| sumo.remove(&vehicle));
            return Ok(());
        }
        let no_command = commands.is_empty();
        let answers = if no_command { Vec::new() } else { sumo.forward(&commands)? };
        match step {
            Some(to_s) => self.waits = Some((answers, to_s)),
            None => self.answer(&answers),
        }
        Ok(())
    }

    /// Sends an answer. A run that does not take it is found to be gone at the next question.
    fn answer(&mut self, bytes: &[u8]) {
        let _ = self.stream.as_mut().map(|stream| write_message(stream, bytes));
    }
}
