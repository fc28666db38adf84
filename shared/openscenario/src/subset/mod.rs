//! The elements of the standard that are read, each declared once.

mod action;
mod along;
mod catalog;
mod condition;
mod entity;
mod environment;
mod file;
mod motion;
mod position;
mod reference;
mod route;
mod signal;
mod storyboard;
mod trajectory;
mod unused;

pub(crate) use file::{CatalogFile, FileHeader, ScenarioFile};
