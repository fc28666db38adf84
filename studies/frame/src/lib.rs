//! What all studies have in common. A study drives many runs and judges them.
//!
//! [`batch`] does runs with all workers and repeats a sample of them in process groups, [`parts`] splits a study into
//! parts, keeps a journal of it and puts the parts together, and [`param`] reads lists and ranges of values.

pub mod batch;
pub mod param;
pub mod parts;
