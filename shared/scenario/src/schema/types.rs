//! The form of types that are no tables.

use super::{Schema, Shape, Variant};
use crate::faults::{Fault, Kind, TopicName, keys_of};
use crate::perception::{CASES, Swerling};
use crate::radio::{RADIOS, Radio};
use crate::storyboard::Storyboard;
use messages::Service;
use openscenario::model::action::Shape as Course;
use openscenario::road::Driven;
use road::LaneLines;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

macro_rules! shapes {
    ($($(#[doc = $about:literal])* $type:ty: $shape:expr $(, $expected:expr)?;)+) => {$(
        $(#[doc = $about])*
        impl Schema for $type {
            fn shape() -> Shape {
                $shape
            }

            $(fn expected() -> Option<String> {
                Some($expected.to_owned())
            })?
        }
    )+};
}

shapes! {
    bool: Shape::Boolean;
    f64: Shape::Number { is_whole: false, range: None, unit: "" };
    u32: Shape::Number { is_whole: true, range: None, unit: "" };
    String: Shape::Text { words: Vec::new() };
    PathBuf: String::shape();
    /// A table that its reader keeps as it is.
    toml::Table: Shape::Free;
    /// A line along a road of a file: reading the file fills it.
    Driven: Shape::Free;
    /// A route in a net of SUMO: reading the net fills it.
    sumo::Route: Shape::Free;
    /// Lines of lanes: a list of stations.
    LaneLines: {
        let number = Shape::Number { is_whole: false, range: None, unit: "m" };
        Shape::List(Box::new(Shape::List(Box::new(number))))
    };
    Service: words(Self::ALL.map(Self::name));
    /// Services with a standby. Their descriptors say whether they can have one: the plant cannot, because there is one
    /// vehicle.
    BTreeSet<Service>: {
        let all = Service::ALL.into_iter().filter(|service| service.descriptor().can_stand_by);
        let words = all.map(|service| service.name().to_owned()).collect();
        Shape::List(Box::new(Shape::Text { words }))
    };
    /// A translation fills it.
    Storyboard: Shape::Free;
    TopicName: {
        Shape::Text { words: Self::all().map(|topic| topic.name().to_owned()).collect() }
    };
    Fault: {
        Shape::Kinds(Kind::ALL.map(|kind| (kind.name().to_owned(), keys_of(kind))).into())
    };
    Radio: String::shape(), RADIOS;
    Swerling: Shape::Number { is_whole: true, range: Some((0.0, 3.0)), unit: "" }, CASES;
    Course: {
        let all = [Self::Linear, Self::Cubic, Self::Sinusoidal, Self::Step];
        let names = all.map(|course| toml::Value::try_from(course).expect("a word"));
        words(names.each_ref().map(|name| name.as_str().unwrap_or_default()))
    };
}

impl<T: Schema> Schema for Option<T> {
    const IS_OPTION: bool = true;

    fn shape() -> Shape {
        T::shape()
    }

    fn expected() -> Option<String> {
        T::expected()
    }
}

impl<T: Schema> Schema for Vec<T> {
    fn shape() -> Shape {
        Shape::List(Box::new(T::shape()))
    }
}

/// A table whose keys are names of the author's.
impl<T: 'static> Schema for BTreeMap<String, T> {
    fn shape() -> Shape {
        Shape::Free
    }
}

fn words<const N: usize>(names: [&str; N]) -> Shape {
    let variant =
        |name: &str| Variant { name: name.to_owned(), meaning: String::new(), shape: None };
    Shape::Choice(names.into_iter().map(variant).collect())
}
