//! A table with one key for each service.

use std::fmt;
use std::marker::PhantomData;

use messages::{Service, each_service};
use serde::de::{Deserialize, Deserializer, Error, MapAccess, Visitor};
use serde::ser::{Serialize, SerializeStruct, Serializer};

use super::schema::{Key, Presence, Schema, Shape};

/// A value for each service: the file's, else the default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PerService<T>([T; Service::ALL.len()]);

/// Names of the services, in the order of [`Service::ALL`].
const NAMES: [&str; Service::ALL.len()] = {
    let mut names = [""; Service::ALL.len()];
    let mut index = 0;
    while index < names.len() {
        names[index] = Service::ALL[index].name();
        index += 1;
    }
    names
};

macro_rules! meanings {
    ($([$service:ident $krate:ident $about:literal])+) => {
        [$($about),+]
    };
}

/// Documentation of the services, in the same order.
const MEANINGS: [&str; Service::ALL.len()] = each_service!(meanings);

impl<T> PerService<T> {
    /// The value for `service`.
    #[must_use]
    pub const fn of(&self, service: Service) -> &T {
        &self.0[service.index()]
    }
}

impl<T: Serialize> Serialize for PerService<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut table = serializer.serialize_struct("PerService", NAMES.len())?;
        for (name, value) in NAMES.into_iter().zip(&self.0) {
            table.serialize_field(name, value)?;
        }
        table.end()
    }
}

impl<'de, T: Deserialize<'de> + Copy + Default> Deserialize<'de> for PerService<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_struct("PerService", &NAMES, Table(PhantomData))
    }
}

impl<T: Schema + Serialize + Default> Schema for PerService<T> {
    fn shape() -> Shape {
        let keys = NAMES.into_iter().zip(MEANINGS);
        let key = |(name, meaning): (&str, &str)| {
            Key::of::<T>(name, meaning.trim(), Presence::of(&T::default()))
        };
        Shape::Table(keys.map(key).collect())
    }
}

struct Table<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de> + Copy + Default> Visitor<'de> for Table<T> {
    type Value = PerService<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table of services")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> Result<PerService<T>, A::Error> {
        let mut values = PerService::default();
        while let Some(Name(service)) = table.next_key()? {
            values.0[service.index()] = table.next_value()?;
        }
        Ok(values)
    }
}

/// A service as a key.
struct Name(Service);

impl<'de> Deserialize<'de> for Name {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_identifier(Field)
    }
}

struct Field;

impl Visitor<'_> for Field {
    type Value = Name;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the name of a service")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<Name, E> {
        name.parse().map(Name).map_err(|_| E::unknown_field(name, &NAMES))
    }
}
