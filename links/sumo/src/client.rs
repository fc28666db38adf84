//! A client of TraCI: what this crate asks of SUMO.

use std::collections::HashMap;
use std::io::ErrorKind;
use std::net::{Shutdown, TcpStream};
use std::path::Path;
use std::time::{Duration, Instant};

use crate::lights::{Plan, State};
use crate::process::{Network, Process};
use crate::wire::{Answer, Body, Value, read_message, subscription, write_message};
use crate::{ProgramError, RADIUS_M};

/// Least version of TraCI: that of SUMO 1.20.
const VERSION: i32 = 21;

/// Variables of a vehicle that a step brings: each costs SUMO a microsecond a vehicle.
const VEHICLE: [u8; 4] = [0x42, 0x40, 0x43, 0x72];
/// Length and width of a vehicle.
const SIZE: [u8; 2] = [0x44, 0x4d];
/// Variables of a light: state, next switch, phase, time spent in it.
const LIGHT: [u8; 4] = [0x20, 0x2d, 0x28, 0x38];

/// Commands: a step, a subscription to the surroundings of a vehicle, the end.
pub const STEP: u8 = 0x02;
pub const SURROUND: u8 = 0x84;
pub const END: u8 = 0x7f;
/// An ego's station id and acceleration, for the launcher of several egos. It is no command of TraCI.
pub const ANNOUNCE: u8 = 0xf0;
const GET_LIGHT: u8 = 0xa2;
const GET_VEHICLE: u8 = 0xa4;
const GET_SIMULATION: u8 = 0xab;
const SET_VEHICLE: u8 = 0xc4;
/// Answer with a size.
const SIZE_GIVEN: u8 = 0xb4;
const SET_ROUTE: u8 = 0xc6;

/// A vehicle as SUMO has it.
#[derive(Clone, Debug)]
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
    /// Station id of another ego; 0 for a vehicle of SUMO's.
    pub station_id: u32,
}

#[derive(Clone, Debug, Default)]
pub struct Step {
    pub vehicles: Vec<Vehicle>,
    pub states: Vec<State>,
    /// Reason why the ego was not placed.
    pub refusal: Option<String>,
}

#[derive(Debug)]
pub struct Client {
    /// SUMO, unless the launcher of several egos has it.
    process: Option<Process>,
    stream: TcpStream,
    /// Id of the ego once it was added.
    ego: String,
    /// Lengths and widths of vehicles, which do not change, m.
    sizes_m: HashMap<String, [f64; 2]>,
    /// Vehicles whose size the next step asks for: a question of its own would wait for the other egos.
    unknown: Vec<String>,
    deadline_s: f64,
    /// Part of the run, for errors.
    when: &'static str,
    /// Commands that were sent: their names.
    sent: Vec<&'static str>,
    out: Vec<u8>,
    begun: Instant,
}

type Done<T> = Result<T, ProgramError>;

impl Client {
    /// Starts SUMO with a configuration and a seed, and greets it.
    pub fn start(
        (config, seed): (&Path, u64),
        deadline_s: f64,
        network: &mut dyn Network,
    ) -> Done<Self> {
        let (mut process, port) = Process::start((config, seed), |c| network.prepare(c))?;
        let stream = process.connect(port, network)?;
        Self::open(Some(process), stream, deadline_s)
    }

    /// Greets SUMO on a connection, and checks its version.
    pub fn open(process: Option<Process>, stream: TcpStream, deadline_s: f64) -> Done<Self> {
        let mut this = Self {
            process,
            stream,
            ego: String::new(),
            sizes_m: HashMap::new(),
            unknown: Vec::new(),
            deadline_s,
            when: "at its start",
            sent: Vec::new(),
            out: Vec::new(),
            begun: Instant::now(),
        };
        let timeout = Some(Duration::from_secs_f64(deadline_s));
        let set = this.stream.set_nodelay(true);
        let set = set.and_then(|()| this.stream.set_read_timeout(timeout));
        set.and_then(|()| this.stream.set_write_timeout(timeout))
            .map_err(ProgramError::start("a connection"))?;
        let answer = this.ask(0x00, "the greeting", &Body::default())?;
        let (_, mut answer, _) = Answer(&answer).command()?;
        let (version, name) = (answer.whole()?, answer.text()?);
        if version < VERSION || !name.starts_with("SUMO") {
            let name: String = name.chars().filter(|c| !c.is_control()).take(60).collect();
            let expected = format!("{VERSION} or later (SUMO 1.20)");
            let words = format!("{name} speaks version {version} of TraCI, expected {expected}");
            return Err(ProgramError::Unfit(words));
        }
        Ok(this)
    }

    fn put(&mut self, id: u8, name: &'static str, body: &Body) {
        body.write(id, &mut self.out);
        self.sent.push(name);
    }

    fn send(&mut self) -> Done<()> {
        let sent = write_message(&mut self.stream, &std::mem::take(&mut self.out));
        sent.map_err(|error| self.failed(&error))
    }

    fn receive(&mut self) -> Done<Vec<u8>> {
        read_message(&mut self.stream).map_err(|error| self.failed(&error))
    }

    fn failed(&mut self, error: &std::io::Error) -> ProgramError {
        match error.kind() {
            ErrorKind::WouldBlock | ErrorKind::TimedOut => {
                // Nothing waits for the goodbye of a process that hangs.
                self.process.iter_mut().for_each(Process::kill);
                ProgramError::Silent(self.when, self.deadline_s)
            }
            ErrorKind::InvalidData => ProgramError::Nonsense("its length"),
            _ => match &mut self.process {
                Some(process) => process.ended(self.when),
                None => ProgramError::Unfit(format!("ended {}", self.when)),
            },
        }
    }

    /// Hands on a message of commands, as another client wrote it; the answer.
    pub fn forward(&mut self, message: &[u8]) -> Done<Vec<u8>> {
        self.when = "during the run";
        self.out.extend(message);
        self.send()?;
        self.receive()
    }

    /// Sends one command; the answer behind its status.
    fn ask(&mut self, id: u8, name: &'static str, body: &Body) -> Done<Vec<u8>> {
        self.put(id, name, body);
        self.send()?;
        let bytes = self.receive()?;
        let mut answer = Answer(&bytes);
        for command in std::mem::take(&mut self.sent) {
            if let Some(words) = answer.refusal()? {
                return Err(ProgramError::Refused(command, words));
            }
        }
        Ok(answer.0.to_vec())
    }

    fn get(&mut self, id: u8, variable: u8, object: &str) -> Done<Value> {
        let answer = self.ask(id, "a question", &Body::default().byte(variable).text(object))?;
        let (_, mut answer, _) = Answer(&answer).command()?;
        // The variable and the object.
        answer.byte()?;
        answer.text()?;
        answer.value()
    }

    fn set(&mut self, (domain, variable): (u8, u8), object: &str, value: Body) -> Done<()> {
        let mut body = Body::default().byte(variable).text(object);
        body.0.extend(value.0);
        let name = if domain == SET_ROUTE { "the ego's route" } else { "the ego" };
        self.ask(domain, name, &body).map(drop)
    }

    pub fn time_s(&mut self) -> Done<f64> {
        Ok(self.get(GET_SIMULATION, 0x66, "")?.number())
    }

    /// Steps to a time, s, or once for 0.
    pub fn step_to(&mut self, time_s: f64) -> Done<()> {
        self.ask(STEP, "a step", &Body::default().number(time_s)).map(drop)
    }

    pub fn vehicles(&mut self) -> Done<Vec<String>> {
        match self.get(GET_VEHICLE, 0x00, "")? {
            Value::Texts(ids) => Ok(ids),
            _ => Err(ProgramError::Nonsense("a list of vehicles")),
        }
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
        self.unknown = self.vehicles()?;
        self.ask(SURROUND, "a subscription", &around(&self.ego, &VEHICLE)).map(drop)
    }

    /// Takes an ego out of the net. SUMO ends if its subscription is still there.
    pub fn remove(&mut self, ego: &str) -> Done<()> {
        self.ask(SURROUND, "the end of a subscription", &around(ego, &[]))?;
        self.set((SET_VEHICLE, 0x81), ego, Body::default().byte(0x08).byte(3))
    }

    /// Subscribes to a controller of lights; the program that it runs.
    pub fn watch(&mut self, controller: &str) -> Done<Plan> {
        let body = subscription(|body| body.text(controller), &LIGHT);
        self.ask(0xd2, "a subscription", &body)?;
        let present = self.get(GET_LIGHT, 0x29, controller)?;
        Ok(Plan::of(present.text(), &self.get(GET_LIGHT, 0x2b, controller)?))
    }

    /// Places the ego and steps once, without a wait. The other egos get its station id and acceleration, m/s².
    pub fn begin_step(
        &mut self,
        front_m: [f64; 2],
        angle_deg: f64,
        (station_id, acceleration_mps2): (u32, f64),
    ) -> Done<()> {
        for id in std::mem::take(&mut self.unknown) {
            for variable in SIZE {
                self.put(GET_VEHICLE, "a size", &Body::default().byte(variable).text(&id));
            }
        }
        if self.process.is_none() {
            let words = Body::default().text(&self.ego).whole(station_id as i32);
            self.put(ANNOUNCE, "its motion", &words.number(acceleration_mps2));
        }
        let place = Body::default().byte(0xb4).text(&self.ego).byte(0x0f).whole(6);
        let place = place.typed_text("").typed_whole(-1);
        let place = place.typed_number(front_m[0]).typed_number(front_m[1]);
        // On its route, at the nearest place.
        let place = place.typed_number(angle_deg).byte(0x08).byte(1);
        self.put(SET_VEHICLE, "placing the ego", &place);
        self.put(STEP, "a step", &Body::default().number(0.0));
        (self.when, self.begun) = ("during the run", Instant::now());
        self.send()
    }

    /// True if the answer of the step that was begun has come.
    pub fn has_answered(&mut self) -> Done<bool> {
        let peeked = self.stream.set_nonblocking(true).and_then(|()| self.stream.peek(&mut [0]));
        let blocks = self.stream.set_nonblocking(false);
        match peeked.and_then(|count| blocks.map(|()| count)) {
            Ok(0) => Err(self.failed(&ErrorKind::UnexpectedEof.into())),
            Ok(_) => Ok(true),
            Err(error) if error.kind() != ErrorKind::WouldBlock => Err(self.failed(&error)),
            Err(_) if self.begun.elapsed().as_secs_f64() > self.deadline_s => {
                Err(self.failed(&ErrorKind::TimedOut.into()))
            }
            Err(_) => Ok(false),
        }
    }

    /// The outcome of the step that was begun.
    pub fn end_step(&mut self) -> Done<Step> {
        self.sent.clear();
        let bytes = self.receive()?;
        let (mut answer, mut step) = (Answer(&bytes), Step::default());
        loop {
            let (id, mut body, _) = answer.command()?;
            if id == SIZE_GIVEN {
                let (variable, vehicle) = (body.byte()?, body.text()?);
                let size_m = self.sizes_m.entry(vehicle).or_default();
                size_m[usize::from(variable == SIZE[1])] = body.value()?.number();
                continue;
            }
            let (result, words) = (body.byte()?, body.text()?);
            match id {
                STEP if result == 0 => break,
                STEP => return Err(ProgramError::Refused("a step", words)),
                SET_VEHICLE if result != 0 => step.refusal = Some(words),
                // A vehicle that has left has no size.
                _ => {}
            }
        }
        for _ in 0..answer.count()? {
            let (kind, mut answer, _) = answer.command()?;
            let subject = answer.text()?;
            if kind & 0xf0 != 0x90 {
                // The number of the variables.
                answer.byte()?;
                let [letters, next, phase, spent] = answer.variables(LIGHT)?;
                step.states.push(State {
                    controller: subject,
                    letters: letters.text().to_owned(),
                    next_s: next.number(),
                    phase: phase.number().max(0.0) as usize,
                    spent_s: spent.number(),
                });
                continue;
            }
            // The domain, and the number of the variables.
            answer.byte()?;
            answer.byte()?;
            for _ in 0..answer.count()? {
                let id = answer.text()?;
                let [front, speed, angle, acceleration] = answer.variables(VEHICLE)?;
                // Another ego's surroundings come too, and the ego is in its own.
                if subject != self.ego || id == self.ego {
                    continue;
                }
                let Value::Point(front_m) = front else {
                    return Err(ProgramError::Nonsense("a vehicle without a place"));
                };
                let Some(&[length_m, width_m]) = self.sizes_m.get(&id) else {
                    self.unknown.push(id);
                    continue;
                };
                step.vehicles.push(Vehicle {
                    id,
                    front_m,
                    speed_mps: speed.number(),
                    angle_deg: angle.number(),
                    acceleration_mps2: acceleration.number(),
                    length_m,
                    width_m,
                    station_id: 0,
                });
            }
        }
        // The egos' announcements of this step.
        while !answer.0.is_empty() {
            let (_, mut words, _) = answer.command()?;
            let id = words.text()?;
            if let Some(other) = step.vehicles.iter_mut().find(|vehicle| vehicle.id == id) {
                (other.station_id, other.acceleration_mps2) =
                    (words.whole()? as u32, words.number()?);
            }
        }
        Ok(step)
    }
}

/// A subscription to the vehicles around one.
fn around(id: &str, variables: &[u8]) -> Body {
    subscription(|body| body.text(id).byte(GET_VEHICLE).number(RADIUS_M), variables)
}

impl Drop for Client {
    /// Says goodbye, and waits until the process is gone.
    fn drop(&mut self) {
        self.out.clear();
        // A process that hangs does not read it, and is killed.
        let _ = self.stream.set_write_timeout(Some(Duration::from_millis(100)));
        self.put(END, "the end", &Body::default());
        if self.send().is_ok() {
            let _ = self.stream.shutdown(Shutdown::Write);
            self.process.iter_mut().for_each(|process| drop(process.end()));
        }
    }
}
