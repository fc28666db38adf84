//! The tables of the process group: how services run, are supervised and judged.

pub mod referee;
pub mod runtime;
pub mod supervision;

use messages::{Service, each_service};
use serde::{Deserialize, Serialize};

use crate::schema::{self, Key, Schema, Shape};

/// A table with one key for each service.
macro_rules! per_service {
    ($([$service:ident $krate:ident $about:literal])+) => {
        /// A value for each service: the file's, else the default.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case", deny_unknown_fields, default)]
        #[serde(bound(deserialize = "T: Default + Deserialize<'de>"))]
        pub struct PerService<T> {
            $(pub(crate) $krate: T,)+
        }

        impl<T> PerService<T> {
            pub const fn of(&self, service: Service) -> &T {
                match service {
                    $(Service::$service => &self.$krate,)+
                }
            }
        }

        impl<T: Schema + Serialize + Default> Schema for PerService<T> {
            fn shape() -> Shape {
                let key = |service: Service, meaning: &str| {
                    Key::of::<T>(service.name(), meaning.trim(), Some(schema::written(&T::default())))
                };
                Shape::Table(vec![$(key(Service::$service, $about)),+])
            }
        }
    };
}

each_service!(per_service);
