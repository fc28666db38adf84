//! When a service's cycles begin: the clock, the timetable, a recorded schedule.

pub mod clock;
pub mod release;
pub mod schedule;
pub mod timetable;
