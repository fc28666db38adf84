//! A client of TraCI: what this crate asks of SUMO.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use crate::process::Process;
use crate::wire::{Answer, Body, MOST_BYTES, Value};
use crate::{ProgramError, RADIUS_M};

/// Least version of TraCI: that of SUMO 1.20.
const VERSION: i32 = 21;
/// A subscription from before this time to this time lasts for the whole run, s.
const ALWAYS_S: f64 = 1_073_741_824.0;

/// Variables of a vehicle that a step brings.
const VEHICLE: [u8; 6] = [0x42, 0x40, 0x43, 0x72, 0x44, 0x4d];
/// Variables of a light: state, next switch, phase, time spent in it.
const LIGHT: [u8; 4] = [0x20, 0x2d, 0x28, 0x38];

const GET_LIGHT: u8 = 0xa2;
const GET_VEHICLE: u8 = 0xa4;
const GET_SIMULATION: u8 = 0xab;
const SET_VEHICLE: u8 = 0xc4;
const SET_ROUTE: u8 = 0xc6;

/// A vehicle as SUMO has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Vehicle {
    pub id: String,
    /// Middle of the front bumper, m.
    pub front_m: [f64; 2],
    pub speed_mps: f64,
    /// Heading, degrees clockwise from north.
    pub angle_deg: f64,
    pub acceleration_mps2: f64,
    pub length_m: f64,
    pub width_m: f64,
}

/// A controller of lights as SUMO has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    pub controller: String,
    /// A letter for each movement.
    pub letters: String,
    /// Next switch, s of SUMO's time.
    pub next_s: f64,
    pub phase: usize,
    /// Time spent in the phase, s.
    pub spent_s: f64,
}

/// The outcome of a step.
#[derive(Clone, Debug, Default)]
pub struct Step {
    pub vehicles: Vec<Vehicle>,
    pub states: Vec<State>,
    /// Reason why the ego was not placed.
    pub refusal: Option<String>,
}

/// The connection.
#[derive(Debug)]
pub struct Client {
    /// SUMO, unless several clients share it.
    process: Option<Process>,
    stream: TcpStream,
    /// Id of the ego once it was added, and whether its surroundings come with each step.
    ego: String,
    is_surrounded: bool,
    /// Messages that were sent and not answered.
    owed: u32,
    deadline_s: f64,
    /// Commands that were sent: their names.
    sent: Vec<&'static str>,
    out: Vec<u8>,
    /// When the step was begun.
    begun: Instant,
}

type Done<T> = Result<T, ProgramError>;

impl Client {
    /// Greets SUMO on a connection, and checks its version.
    pub fn open(process: Option<Process>, stream: TcpStream, deadline_s: f64) -> Done<Self> {
        let (ego, sent, out) = (String::new(), Vec::new(), Vec::new());
        let (is_surrounded, owed, begun) = (false, 0, Instant::now());
        let mut this =
            Self { process, stream, ego, is_surrounded, owed, deadline_s, sent, out, begun };
        let timeout = Some(Duration::from_secs_f64(deadline_s));
        let set = this.stream.set_nodelay(true);
        let set = set.and_then(|()| this.stream.set_read_timeout(timeout));
        set.and_then(|()| this.stream.set_write_timeout(timeout))
            .map_err(ProgramError::start("a connection"))?;
        let answer = this.ask(0x00, "the greeting", Body::default(), "at the greeting")?;
        let mut answer = Answer(&answer);
        answer.length()?;
        answer.byte()?;
        let (version, name) = (answer.whole()?, answer.text()?);
        if version < VERSION || !name.starts_with("SUMO") {
            let name: String = name.chars().filter(|c| !c.is_control()).take(60).collect();
            let expected = format!("{VERSION} or later (SUMO 1.20)");
            let words = format!("{name} speaks version {version} of TraCI, expected {expected}");
            return Err(ProgramError(words));
        }
        Ok(this)
    }

    /// Queues a command.
    fn put(&mut self, id: u8, name: &'static str, body: &Body) {
        body.write(id, &mut self.out);
        self.sent.push(name);
    }

    fn send(&mut self, when: &str) -> Done<()> {
        let mut message = (self.out.len() as i32 + 4).to_be_bytes().to_vec();
        message.append(&mut self.out);
        self.owed += 1;
        self.stream.write_all(&message).map_err(|error| self.failed(&error, when))
    }

    fn receive(&mut self, when: &str) -> Done<Vec<u8>> {
        let mut head = [0; 4];
        self.stream.read_exact(&mut head).map_err(|error| self.failed(&error, when))?;
        let length = usize::try_from(i32::from_be_bytes(head)).ok();
        let length = length.and_then(|length| length.checked_sub(4)).filter(|n| *n <= MOST_BYTES);
        let mut body = vec![0; length.ok_or_else(|| ProgramError::nonsense("its length"))?];
        self.stream.read_exact(&mut body).map_err(|error| self.failed(&error, when))?;
        self.owed -= 1;
        Ok(body)
    }

    fn failed(&mut self, error: &std::io::Error, when: &str) -> ProgramError {
        match error.kind() {
            ErrorKind::WouldBlock | ErrorKind::TimedOut => {
                // Nothing waits for the goodbye of a process that hangs.
                self.process.iter_mut().for_each(Process::kill);
                ProgramError::silent(when, self.deadline_s)
            }
            _ => self.ended(when),
        }
    }

    fn ended(&mut self, when: &str) -> ProgramError {
        match &mut self.process {
            Some(process) => process.ended(when),
            None => ProgramError(format!("ended {when}")),
        }
    }

    /// Takes the statuses of all commands that were sent.
    fn statuses(&mut self, answer: &mut Answer<'_>) -> Done<()> {
        for command in std::mem::take(&mut self.sent) {
            if let (_, Some(words)) = answer.status()? {
                return Err(ProgramError::refused(command, &words));
            }
        }
        Ok(())
    }

    /// Sends one command; the answer behind its status.
    fn ask(&mut self, id: u8, name: &'static str, body: Body, when: &str) -> Done<Vec<u8>> {
        self.put(id, name, &body);
        self.send(when)?;
        let bytes = self.receive(when)?;
        let mut answer = Answer(&bytes);
        self.statuses(&mut answer)?;
        Ok(answer.0.to_vec())
    }

    fn get(&mut self, id: u8, variable: u8, object: &str) -> Done<Value> {
        let body = Body::default().byte(variable).text(object);
        let answer = self.ask(id, "a question", body, "at its start")?;
        let mut answer = Answer(&answer);
        answer.length()?;
        answer.byte()?;
        answer.byte()?;
        answer.text()?;
        answer.value()
    }

    /// Sets a variable of an object of a domain.
    fn set(&mut self, (domain, variable): (u8, u8), object: &str, value: Body) -> Done<()> {
        let mut body = Body::default().byte(variable).text(object);
        body.0.extend(value.0);
        let name = if domain == SET_ROUTE { "the ego's route" } else { "the ego" };
        self.ask(domain, name, body, "at its start").map(|_| ())
    }

    /// Takes a turn among the clients that share SUMO: commands are executed in the order of these numbers.
    pub fn order(&mut self, number: u32) -> Done<()> {
        let body = Body::default().whole(number as i32);
        self.ask(0x03, "the order of the egos", body, "at its start").map(|_| ())
    }

    /// SUMO's time, s.
    pub fn time_s(&mut self) -> Done<f64> {
        Ok(self.get(GET_SIMULATION, 0x66, "")?.number())
    }

    /// Steps to a time, s, or once for 0.
    pub fn step_to(&mut self, time_s: f64) -> Done<()> {
        let body = Body::default().number(time_s);
        self.ask(0x02, "a step", body, "before the run").map(|_| ())
    }

    /// Ids of the vehicles in the net.
    pub fn vehicles(&mut self) -> Done<Vec<String>> {
        match self.get(GET_VEHICLE, 0x00, "")? {
            Value::Texts(ids) => Ok(ids),
            _ => Err(ProgramError::nonsense("a list of vehicles")),
        }
    }

    /// Programs of a controller: the id of each, and its parts.
    pub fn programs(&mut self, controller: &str) -> Done<(String, Value)> {
        let present = self.get(GET_LIGHT, 0x29, controller)?.text().to_owned();
        Ok((present, self.get(GET_LIGHT, 0x2b, controller)?))
    }

    /// Adds the ego on the route of these edges.
    pub fn add(
        &mut self,
        id: &str,
        edges: &[String],
        (lane, front_m, speed_mps): (usize, f64, f64),
        (length_m, width_m): (f64, f64),
    ) -> Done<()> {
        id.clone_into(&mut self.ego);
        let list = Body::default().byte(0x0e).whole(edges.len() as i32);
        let list = edges.iter().fold(list, |list, edge| list.text(edge));
        self.set((SET_ROUTE, 0x80), id, list)?;
        // Route, type, departure and its lane, place and speed; arrival; three words of public transport, all empty.
        let words = format!(
            "{id}|DEFAULT_VEHTYPE|now|{lane}|{front_m:.3}|{speed_mps:.3}|current|max|current|||"
        );
        let body = Body::default().byte(0x0f).whole(14);
        let body = words.split('|').fold(body, Body::typed_text);
        self.set((SET_VEHICLE, 0x85), id, body.typed_whole(4).typed_whole(0))?;
        self.set((SET_VEHICLE, 0x44), id, Body::default().typed_number(length_m))?;
        self.set((SET_VEHICLE, 0x4d), id, Body::default().typed_number(width_m))?;
        // Its own rules of speed and lane changes are off: the run moves it.
        self.set((SET_VEHICLE, 0xb3), id, Body::default().typed_whole(0))?;
        self.set((SET_VEHICLE, 0xb6), id, Body::default().typed_whole(0))
    }

    /// Subscribes to the vehicles around the ego.
    pub fn surround(&mut self) -> Done<()> {
        let body = around(&self.ego, &VEHICLE);
        self.ask(0x84, "a subscription", body, "at its start")?;
        self.is_surrounded = true;
        Ok(())
    }

    /// Subscribes to a controller of lights.
    pub fn watch(&mut self, controller: &str) -> Done<()> {
        let body = subscription(|body| body.text(controller), &LIGHT);
        self.ask(0xd2, "a subscription", body, "at its start").map(|_| ())
    }

    /// Places the ego and steps once, without a wait in between. SUMO mixes up the answers of clients that share it if
    /// one message has both.
    pub fn begin_step(&mut self, front_m: [f64; 2], angle_deg: f64) -> Done<()> {
        let place = Body::default().byte(0xb4).text(&self.ego).byte(0x0f).whole(6);
        let place = place.typed_text("").typed_whole(-1);
        let place = place.typed_number(front_m[0]).typed_number(front_m[1]);
        // On its route, at the nearest place.
        let place = place.typed_number(angle_deg).byte(0x08).byte(1);
        self.put(SET_VEHICLE, "placing the ego", &place);
        self.send("during the run")?;
        self.put(0x02, "a step", &Body::default().number(0.0));
        self.begun = Instant::now();
        self.send("during the run")
    }

    /// True if the answer of the step that was begun has come.
    pub fn has_answered(&mut self) -> Done<bool> {
        let when = "during the run";
        // The answer to the placing comes before it: a status, with words if it is refused.
        let mut begin = [0; 4096];
        let peeked = self.stream.set_nonblocking(true).and_then(|()| self.stream.peek(&mut begin));
        let blocks = self.stream.set_nonblocking(false);
        let has_come = match peeked.and_then(|count| blocks.map(|()| count)) {
            Ok(0) => return Err(self.ended(when)),
            Ok(count) => {
                let first = i32::from_be_bytes([begin[0], begin[1], begin[2], begin[3]]);
                usize::try_from(first).is_ok_and(|first| count > first.max(4))
            }
            Err(error) if error.kind() == ErrorKind::WouldBlock => false,
            Err(error) => return Err(self.failed(&error, when)),
        };
        if !has_come && self.begun.elapsed().as_secs_f64() > self.deadline_s {
            return Err(self.failed(&ErrorKind::TimedOut.into(), when));
        }
        Ok(has_come)
    }

    /// The outcome of the step that was begun.
    pub fn end_step(&mut self) -> Done<Step> {
        self.sent.clear();
        let (_, refusal) = Answer(&self.receive("during the run")?).status()?;
        let bytes = self.receive("during the run")?;
        let mut answer = Answer(&bytes);
        if let (_, Some(words)) = answer.status()? {
            return Err(ProgramError::refused("a step", &words));
        }
        let mut step = Step { refusal, ..Step::default() };
        for _ in 0..answer.count()? {
            answer.length()?;
            let is_context = answer.byte()? & 0xf0 == 0x90;
            let subject = answer.text()?;
            if is_context {
                answer.byte()?;
            }
            let variables = answer.byte()?;
            let objects = if is_context { answer.count()? } else { 1 };
            for _ in 0..objects {
                let id = if is_context { answer.text()? } else { subject.clone() };
                let mut vehicle = Vehicle { id, ..Vehicle::default() };
                let mut state = State { controller: subject.clone(), ..State::default() };
                for _ in 0..variables {
                    let (variable, result, value) =
                        (answer.byte()?, answer.byte()?, answer.value()?);
                    match (variable, &value) {
                        _ if result != 0 => {
                            return Err(ProgramError::refused("a subscription", value.text()));
                        }
                        (0x42, Value::Point(front_m)) => vehicle.front_m = *front_m,
                        (0x40, _) => vehicle.speed_mps = value.number(),
                        (0x43, _) => vehicle.angle_deg = value.number(),
                        (0x72, _) => vehicle.acceleration_mps2 = value.number(),
                        (0x44, _) => vehicle.length_m = value.number(),
                        (0x4d, _) => vehicle.width_m = value.number(),
                        (0x20, Value::Text(letters)) => state.letters.clone_from(letters),
                        (0x2d, _) => state.next_s = value.number(),
                        (0x28, _) => state.phase = value.number().max(0.0) as usize,
                        (0x38, _) => state.spent_s = value.number(),
                        _ => {
                            let fault = "a variable that was not asked for";
                            return Err(ProgramError::nonsense(fault));
                        }
                    }
                }
                match is_context {
                    true if vehicle.id == self.ego => {}
                    true => step.vehicles.push(vehicle),
                    false => step.states.push(state),
                }
            }
        }
        Ok(step)
    }
}

/// A subscription to variables for the whole run; without variables its end.
fn subscription(to: impl Fn(Body) -> Body, variables: &[u8]) -> Body {
    let body = to(Body::default().number(-ALWAYS_S).number(ALWAYS_S));
    let mut body = body.byte(variables.len() as u8);
    body.0.extend(variables);
    body
}

/// A subscription to the vehicles around one.
fn around(id: &str, variables: &[u8]) -> Body {
    subscription(|body| body.text(id).byte(GET_VEHICLE).number(RADIUS_M), variables)
}

impl Drop for Client {
    /// Says goodbye, and waits until the process is gone. Others that share SUMO go on without the ego.
    fn drop(&mut self) {
        self.out.clear();
        // A process that hangs does not read it, and is killed.
        let _ = self.stream.set_write_timeout(Some(Duration::from_millis(100)));
        let mut leaves = || -> Done<()> {
            let (when, is_shared) = ("at the end", self.process.is_none());
            while is_shared && self.owed > 0 {
                self.receive(when)?;
            }
            self.sent.clear();
            if is_shared && self.is_surrounded {
                // SUMO ends if a vehicle with a subscription is taken away.
                self.ask(0x84, "the end of a subscription", around(&self.ego, &[]), when)?;
                let gone = Body::default().byte(0x81).text(&self.ego).byte(0x08).byte(3);
                self.ask(SET_VEHICLE, "the end of the ego", gone, when)?;
            }
            self.put(0x7f, "the end", &Body::default());
            self.send(when)?;
            if is_shared { self.receive(when).map(drop) } else { Ok(()) }
        };
        if leaves().is_ok() {
            let _ = self.stream.shutdown(std::net::Shutdown::Write);
            self.process.iter_mut().for_each(|process| drop(process.end()));
        }
    }
}
