//! An intersection from its frames: its map, and the timing of its signals from each sender.

use crate::clock::Moment;
use crate::known_map::{KnownMap, Told};
use crate::lanes::StopLine;
use crate::numbers::{Numbers, nanoseconds};
use crate::timing::{Timing, every_group};
use crate::verdict::Verdict;
use its::spatem::IntersectionState;

const MOST_SENDERS: usize = 4;
/// Distance from the assumed line to the unit, m: half of a large intersection. A stop too early is safe.
const LINE_BEFORE_UNIT_M: f64 = 30.0;
/// Signal group of the assumed line: no real group.
const NO_GROUP: u8 = 0;

/// An intersection, as its frames describe it.
#[derive(Clone, Debug, Default)]
pub struct Intersection {
    numbers: Numbers,
    pub id: u16,
    frames: u64,
    first_ns: i64,
    /// Instant of its last frame, ns of run time.
    pub(crate) heard_ns: i64,
    pub(crate) map: Option<KnownMap>,
    /// Its maps without a lane of the vehicle.
    elsewhere: u64,
    /// Position of its unit on the vehicle's path, m; `None` if it is not beside the path.
    unit_m: Option<f64>,
    senders: Vec<Sender>,
    /// Instant of its last timing without a contradiction, ns of run time.
    pub(crate) certain_ns: Option<i64>,
}

/// One sender's timing of an intersection's signals.
#[derive(Clone, Debug)]
struct Sender {
    station: u32,
    /// Instant of the timing, ns of run time.
    made_ns: i64,
    /// Accepted messages.
    words: u64,
    revision: u8,
    timings: Vec<Timing>,
    /// Last message, if it was inconsistent.
    candidate: Option<Vec<Timing>>,
}

impl Intersection {
    pub fn new(id: u16, now_ns: i64, numbers: Numbers) -> Self {
        Self { numbers, id, first_ns: now_ns, heard_ns: now_ns, ..Self::default() }
    }

    /// Notes any frame about it, from a unit at `unit_m` on the vehicle's path.
    pub fn note(&mut self, now_ns: i64, unit_m: Option<f64>) {
        self.frames += 1;
        self.heard_ns = now_ns;
        self.unit_m = unit_m;
    }

    /// True after two frames: a single one can have a falsified id.
    pub fn is_confirmed(&self) -> bool {
        self.frames >= 2
    }

    /// The stop lines for a vehicle at `ego_m`, including those just passed.
    pub fn lines(&self, now_ns: i64, ego_m: f64) -> impl Iterator<Item = StopLine> + use<'_> {
        let passed_m = self.numbers.passed_m;
        let told = self.map.iter().flat_map(move |map| map.in_force(ego_m));
        let lines = told.chain(self.assumed_line(now_ns));
        lines.filter(move |line| line.position_m - ego_m > -passed_m)
    }

    /// The assumed line of an intersection without a map.
    fn assumed_line(&self, now_ns: i64) -> Option<StopLine> {
        let is_due = now_ns - self.first_ns > nanoseconds(self.numbers.map_due_s);
        let is_missing = self.map.is_none() && self.elsewhere < 2 && is_due;
        let position_m = self.unit_m.filter(|_| is_missing)? - LINE_BEFORE_UNIT_M;
        Some(StopLine { signal_group: NO_GROUP, position_m })
    }

    pub fn take_timing(
        &mut self,
        station: u32,
        state: &IntersectionState,
        made_ns: i64,
        moment: &Moment,
    ) -> Verdict {
        let now_s = moment.now_ns as f64 / 1e9;
        let timings: Vec<Timing> =
            state.movements.iter().map(|m| Timing::of(m, made_ns, moment)).collect();
        match self.senders.iter_mut().find(|sender| sender.station == station) {
            Some(sender) => {
                if made_ns <= sender.made_ns {
                    return Verdict::OutOfOrder;
                }
                let shows = |a: &Timing, b: &Timing| a.shows_as(b, now_s);
                let agrees = |a: &Timing, b: &Timing| a.agrees_with(b, now_s);
                let again = (sender.candidate.as_ref())
                    .is_some_and(|candidate| every_group(candidate, &timings, shows));
                if !again && !every_group(&sender.timings, &timings, agrees) {
                    // Other ends do not contradict the phase that both show.
                    if every_group(&sender.timings, &timings, shows) {
                        sender.made_ns = made_ns;
                    }
                    sender.candidate = Some(timings);
                    self.renew(moment.now_ns);
                    return Verdict::Contradicting;
                }
                sender.candidate = None;
                sender.words += 1;
                (sender.made_ns, sender.revision) = (made_ns, state.revision);
                sender.timings = timings;
            }
            None => {
                if self.senders.len() == MOST_SENDERS {
                    // Replace the sender with the fewest messages; among equals, the one silent for longest.
                    self.senders.sort_by_key(|sender| (sender.words.min(2), sender.made_ns));
                    self.senders.remove(0);
                }
                let (revision, words, candidate) = (state.revision, 1, None);
                self.senders.push(Sender { station, made_ns, words, revision, timings, candidate });
            }
        }
        if self.disagree(moment.now_ns) {
            return Verdict::Contradicting;
        }
        let Some(map) = &self.map else { return Verdict::UnknownIntersection };
        if map.revision() != state.revision {
            return Verdict::Contradicting;
        }
        let told = |line: &StopLine| {
            state.movements.iter().any(|movement| movement.signal_group == line.signal_group)
        };
        let is_whole = map.accepted.lines.iter().all(told);
        self.renew(moment.now_ns);
        if is_whole { Verdict::Accepted } else { Verdict::MissingLane }
    }

    pub fn take_map(&mut self, told: Told, now_ns: i64) -> Verdict {
        if told.lines.is_empty() {
            self.elsewhere += 1;
            return Verdict::MissingLane;
        }
        let (station, revision) = (told.station, told.geometry.revision);
        let is_announced = (self.senders.iter())
            .any(|sender| sender.station == station && sender.revision == revision);
        let is_taken = match &mut self.map {
            Some(map) => map.take(told, now_ns, is_announced),
            None => {
                self.map = Some(KnownMap::new(told, now_ns));
                true
            }
        };
        self.renew(now_ns);
        if is_taken { Verdict::Accepted } else { Verdict::Contradicting }
    }

    /// The newest timing of a signal group; `None` if senders differ. One of them is false, and so may be its green.
    pub fn timing(&self, signal_group: u8, now_ns: i64) -> Option<&Timing> {
        let timings = &self.accepted(now_ns)?.timings;
        timings.iter().find(|timing| timing.signal_group == signal_group)
    }

    fn renew(&mut self, now_ns: i64) {
        let made_ns = self.accepted(now_ns).map(|sender| sender.made_ns);
        self.certain_ns = self.certain_ns.max(made_ns);
    }

    /// The sender of the newest timing that fits the map, unless another sender contradicts. A sender of a
    /// single message counts only if it is alone.
    fn accepted(&self, now_ns: i64) -> Option<&Sender> {
        let revision = self.map.as_ref()?.revision();
        if self.disagree(now_ns) {
            return None;
        }
        let fitting = self.senders.iter().filter(|sender| sender.revision == revision);
        fitting.max_by_key(|sender| (sender.words.min(2), sender.made_ns))
    }

    /// True if two senders with standing timing contradict each other. The silence of one does not confirm the other.
    fn disagree(&self, now_ns: i64) -> bool {
        let once_ns = nanoseconds(self.numbers.once_stands_s);
        let fits = |a: &Timing, b: &Timing| a.agrees_with(b, now_ns as f64 / 1e9);
        let stands = |sender: &&Sender| sender.words >= 2 || now_ns - sender.made_ns <= once_ns;
        let standing: Vec<&Sender> = self.senders.iter().filter(stands).collect();
        standing.iter().enumerate().any(|(place, one)| {
            standing[place + 1..]
                .iter()
                .any(|other| !every_group(&one.timings, &other.timings, fits))
        })
    }
}
