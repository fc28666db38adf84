//! The quadratic-bounded law: its design file, its promise, the published scenarios.

mod design;
mod plant;
mod promise;
mod published;
mod scenario;
