//! The quadratic-bounded law: its design file, its guarantee, the published scenarios.

mod design;
mod plant;
mod promise;
mod published;
mod scenario;
