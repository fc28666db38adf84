//! The tables of the process group: how services run, are supervised and judged.

pub mod per_service;
pub mod referee;
pub mod require;
pub mod runtime;
pub mod supervision;
