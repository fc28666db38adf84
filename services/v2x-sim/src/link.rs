//! A carrier instead of simulated roadside units and their air. Frames of another host's units, or of a capture, become
//! `radio/frames`. It also sends the vehicle's own frames.

use crate::report::LinkReport;
use crate::unit_clock::UnitClock;
use messages::{Header, MAX_FRAMES, Origin, RadioFrame, RadioFrames, RadioSent};
use radio::{Carrier, ClockDifference, Frame, Role};
use runtime::{Publisher, Runtime, RuntimeError, Subscriber};
use scenario::carrier::CarrierAddress;
use std::io;

/// The vehicle's end of a carrier.
pub(crate) struct Link {
    carrier: Carrier,
    frames: Publisher<RadioFrames>,
    /// The vehicle's own frames; `None` for a capture.
    sent: Option<Subscriber<RadioSent>>,
    last_sent: Origin,
    batch: Batch,
    /// Wall clock at run time 0, ns: of this host, or of a capture's first frame.
    utc_start_ns: i64,
    clock: Option<ClockDifference>,
    /// The clock of the roadside unit's programs, once known.
    pub(crate) unit: Option<UnitClock>,
    before_start: u64,
    /// Time between two messages without frames, ns: they show that the radio lives.
    period_ns: i64,
    handed_on_ns: Option<i64>,
}

/// Frames of one cycle, each with the rank of its sender. It decides when the room is too small for all.
struct Batch {
    frames: Vec<(Frame, Rank)>,
    left_out: u64,
}

impl Link {
    pub(crate) fn open(
        runtime: &mut Runtime,
        address: &CarrierAddress,
        period_ns: i64,
    ) -> Result<Self, RuntimeError> {
        let carrier = Carrier::open(address, Role::Vehicle)
            .map_err(|error| RuntimeError::Setup("radio".into(), io::Error::other(error)))?;
        Ok(Self {
            carrier,
            frames: runtime.publisher()?,
            sent: address.is_live().then(|| runtime.subscriber()).transpose()?,
            last_sent: Origin::NONE,
            batch: Batch { frames: Vec::with_capacity(MAX_FRAMES), left_out: 0 },
            utc_start_ns: 0,
            clock: (!address.is_live()).then_some(ONE_CLOCK),
            unit: None,
            before_start: 0,
            period_ns,
            handed_on_ns: None,
        })
    }

    pub(crate) fn begin(&mut self, runtime: &Runtime) {
        self.utc_start_ns = match self.carrier.capture() {
            Some(capture) => capture.wall_clock_ns(0),
            None => runtime.utc_start_ns(),
        };
    }

    /// Publishes the arrived frames and sends the vehicle's own. It does not wait.
    pub(crate) fn exchange(
        &mut self,
        runtime: &mut Runtime,
        header: Header,
    ) -> Result<(), RuntimeError> {
        self.collect(header.acquisition_ns);
        if self.is_due(header.acquisition_ns) {
            self.hand_on(header)?;
        }
        if let Some(sent) = &mut self.sent {
            runtime.update(sent)?;
            let origin = sent.origin();
            if let Some(message) = sent.newest().filter(|_| origin != self.last_sent) {
                self.last_sent = origin;
                // The carrier counts frames that it could not send.
                let _ = self.carrier.send(message.frame.data());
            }
        }
        Ok(())
    }

    /// True if there are frames, or if a period has passed without any. A capture's cycles are a period apart, so
    /// that each has its message: receivers wait for it in simulated time.
    fn is_due(&self, now_ns: i64) -> bool {
        let is_overdue = |handed_on_ns: i64| now_ns - handed_on_ns >= self.period_ns;
        !self.batch.frames.is_empty() || self.handed_on_ns.is_none_or(is_overdue)
    }

    fn hand_on(&mut self, header: Header) -> Result<(), RuntimeError> {
        self.handed_on_ns = Some(header.acquisition_ns);
        let Self { frames, batch, utc_start_ns, clock, .. } = self;
        frames.send_with(|message: &mut RadioFrames| {
            message.header = header;
            message.utc_start_ns = *utc_start_ns;
            (message.clock_offset_ns, message.clock_uncertainty_ns) =
                clock.map_or((0, i64::MAX), |clock| (clock.offset_ns, clock.uncertainty_ns));
            for (place, (frame, _)) in message.frames.iter_mut().zip(&batch.frames) {
                write(place, frame, *utc_start_ns);
                message.count += 1;
            }
            message.left_out = batch.left_out;
        })?;
        Ok(())
    }

    fn collect(&mut self, now_ns: i64) {
        self.batch.frames.clear();
        self.batch.left_out = 0;
        while let Some(frame) = self.carrier.receive(now_ns) {
            if frame.received_ns < self.utc_start_ns {
                self.before_start += 1;
                continue;
            }
            let rank = Rank::of(&frame);
            if rank > Rank::Vehicle {
                self.clock = frame.clock.or(self.clock);
            }
            if let Some((start_ns, clock)) = frame.start_ns.zip(frame.clock) {
                self.unit = Some(UnitClock::new(start_ns, clock.offset_ns, self.utc_start_ns));
            }
            self.batch.offer(frame, rank);
        }
    }

    pub(crate) fn report(&self) -> LinkReport {
        LinkReport {
            radio: self.carrier.report(),
            before_start: self.before_start,
            truth_known: self.unit.is_some(),
        }
    }
}

impl Batch {
    fn offer(&mut self, frame: Frame, rank: Rank) {
        if self.frames.len() < MAX_FRAMES {
            self.frames.push((frame, rank));
            return;
        }
        self.left_out += 1;
        // The last frame of the lowest rank leaves.
        let lowest = self.frames.iter().enumerate().rev().min_by_key(|(_, (_, rank))| *rank);
        if let Some((place, _)) = lowest.filter(|(_, (_, lowest))| *lowest < rank) {
            self.frames.remove(place);
            self.frames.push((frame, rank));
        }
    }
}

/// Rank of a sender when the room is too small for all frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Rank {
    /// A vehicle: it has a name and no start.
    Vehicle,
    /// A sender without a name: another maker's unit, or anything else.
    Unnamed,
    /// A roadside unit, with the start of its programs.
    RoadsideUnit,
}

impl Rank {
    fn of(frame: &Frame) -> Self {
        match (frame.start_ns, frame.sender) {
            (Some(_), _) => Self::RoadsideUnit,
            (None, None) => Self::Unnamed,
            (None, Some(_)) => Self::Vehicle,
        }
    }
}

/// A capture's frames and its player have one clock.
const ONE_CLOCK: ClockDifference = ClockDifference { offset_ns: 0, uncertainty_ns: 0 };

fn write(place: &mut RadioFrame, frame: &Frame, utc_start_ns: i64) {
    let offset_ns = frame.clock.map(|clock| clock.offset_ns);
    let sent_ns = frame.sent_ns.zip(offset_ns);
    let sent_ns = sent_ns
        .map_or(RadioFrame::UNKNOWN_NS, |(sent_ns, ahead_ns)| sent_ns - ahead_ns - utc_start_ns);
    place.write(sent_ns, frame.received_ns - utc_start_ns, frame.bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn offer(batch: &mut Batch, number: u8, rank: Rank) {
        batch.offer(Frame::new(&[number], 0).expect("it is short"), rank);
    }

    #[test]
    fn roadside_units_find_room_among_vehicles() {
        let mut batch = Batch { frames: Vec::new(), left_out: 0 };
        let most = MAX_FRAMES as u8;
        let first = |number| if number == 0 { Rank::RoadsideUnit } else { Rank::Vehicle };
        (0..most).for_each(|number| offer(&mut batch, number, first(number)));
        offer(&mut batch, 100, Rank::Vehicle);
        offer(&mut batch, 101, Rank::RoadsideUnit);
        let numbers = |batch: &Batch| -> Vec<u8> {
            batch.frames.iter().map(|(frame, _)| frame.bytes()[0]).collect()
        };
        let kept: Vec<u8> = (0..most - 1).chain([101]).collect();
        assert_eq!((numbers(&batch), batch.left_out), (kept, 2));
        (0..most).for_each(|number| offer(&mut batch, 200 + number, Rank::RoadsideUnit));
        assert!(batch.frames.iter().all(|(_, rank)| *rank == Rank::RoadsideUnit));
        assert_eq!((batch.frames[0].0.bytes(), batch.left_out), (&[0][..], 18));
    }

    #[test]
    fn a_flood_of_unnamed_frames_leaves_room_for_roadside_units() {
        let mut batch = Batch { frames: Vec::new(), left_out: 0 };
        (0..100).for_each(|number| offer(&mut batch, number, Rank::Unnamed));
        (200..203).for_each(|number| offer(&mut batch, number, Rank::RoadsideUnit));
        (0..100).for_each(|number| offer(&mut batch, number, Rank::Unnamed));
        let units = batch.frames.iter().filter(|(_, rank)| *rank == Rank::RoadsideUnit);
        assert_eq!((units.count(), batch.left_out), (3, 203 - MAX_FRAMES as u64));
    }
}
