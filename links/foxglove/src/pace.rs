//! A limit on what one client may ask for in a time.

use std::io::{self, Read};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Bytes a second that are read from a client.
const BYTES_PER_S: u32 = 1 << 20;
/// Messages a second that are taken from a client.
const MESSAGES_PER_S: u32 = 200;
/// Time for which a client may be ahead of its rate.
const BURST: Duration = Duration::from_secs(2);

/// Counts units against a rate; who is ahead of it waits. The client notices it as a connection that takes no more.
#[derive(Debug)]
pub(crate) struct Pace {
    per_s: u32,
    /// The rate alone would have reached the present count here.
    level: Instant,
}

impl Pace {
    fn of(per_s: u32) -> Self {
        Self { per_s, level: Instant::now() }
    }

    pub(crate) fn of_messages() -> Self {
        Self::of(MESSAGES_PER_S)
    }

    /// Counts `units`, and waits while they are ahead of the rate by more than a burst. True if it waited.
    pub(crate) fn count(&mut self, units: usize) -> bool {
        let wait = self.due(units, Instant::now());
        std::thread::sleep(wait);
        !wait.is_zero()
    }

    /// Time to wait for `units` that come at `now`.
    fn due(&mut self, units: usize, now: Instant) -> Duration {
        let cost = Duration::from_secs_f64(units as f64 / f64::from(self.per_s));
        self.level = self.level.max(now) + cost;
        self.level.saturating_duration_since(now + BURST)
    }
}

/// The reading half of a connection. Nothing is written: answers go by the writing half.
#[derive(Debug)]
pub(crate) struct Reading {
    stream: TcpStream,
    pace: Pace,
}

impl Reading {
    pub(crate) fn new(stream: TcpStream) -> Self {
        Self { stream, pace: Pace::of(BYTES_PER_S) }
    }
}

impl Read for Reading {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let count = self.stream.read(into)?;
        self.pace.count(count);
        Ok(count)
    }
}

impl io::Write for Reading {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_burst_is_free_and_a_flood_is_slowed_to_the_rate() {
        let mut pace = Pace::of(100);
        let now = Instant::now();
        assert_eq!(pace.due(150, now), Duration::ZERO);
        let wait = pace.due(200, now);
        assert!((1.4..1.6).contains(&wait.as_secs_f64()), "3.5 s of units: {wait:?}");
        assert_eq!(pace.due(1, now + Duration::from_secs(60)), Duration::ZERO, "the debt is over");
    }
}
