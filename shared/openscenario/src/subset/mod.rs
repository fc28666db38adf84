//! The elements of the standard that are read, each declared once.

mod action;
mod body;
mod catalog;
mod condition;
mod entity;
mod environment;
mod file;
mod lateral;
mod longitudinal;
mod position;
mod reference;
mod storyboard;
mod test;
mod trajectory;
mod unused;

pub(crate) use file::{CatalogFile, FileHeader, ScenarioFile, ScenarioParts};
