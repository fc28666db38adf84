//! The elements of the standard that are read, each declared once.

mod action;
mod along;
mod body;
mod catalog;
mod condition;
mod curve;
mod entity;
mod environment;
mod file;
mod lateral;
mod longitudinal;
mod position;
mod profile;
mod reference;
mod route;
mod signal;
mod storyboard;
mod synchronize;
mod test;
mod trajectory;
mod unused;

pub(crate) use file::{CatalogFile, FileHeader, ScenarioFile};
