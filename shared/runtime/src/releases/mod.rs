//! The releases of a service: clock, timetable, cycles, a recorded schedule.

pub mod clock;
pub mod cycles;
pub mod schedule;
pub mod timetable;
