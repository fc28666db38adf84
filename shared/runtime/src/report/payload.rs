//! Figures of one service on their way to the launcher.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

/// Figures that a service can report: plain data of its own crate.
pub trait Reported: Serialize + DeserializeOwned + Clone + Debug + Send + Sync + 'static {}

impl<T: Serialize + DeserializeOwned + Clone + Debug + Send + Sync + 'static> Reported for T {}

/// Figures of one service, whose type only the service and the reader use.
///
/// In one process they stay the value that they are. Between processes they travel as JSON.
///
/// ```
/// use runtime::report::Payload;
///
/// let payload = Payload::of((7_u64, "late".to_owned()));
/// let line = serde_json::to_string(&payload)?;
/// let received: Payload = serde_json::from_str(&line)?;
/// for payload in [payload, received] {
///     assert_eq!(payload.read::<(u64, String)>(), Some((7, "late".to_owned())));
///     assert_eq!(payload.read::<bool>(), None);
/// }
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Payload(Form);

#[derive(Clone, Debug)]
enum Form {
    Value(Arc<dyn Carried>),
    Json(serde_json::Value),
}

/// [`Reported`] of any type.
trait Carried: Any + Debug + Send + Sync {
    fn json(&self) -> serde_json::Value;
    fn any(&self) -> &dyn Any;
}

impl<T: Reported> Carried for T {
    fn json(&self) -> serde_json::Value {
        serde_json::to_value(self).expect("figures are plain data")
    }

    fn any(&self) -> &dyn Any {
        self
    }
}

impl Payload {
    /// A payload of these figures.
    pub fn of(figures: impl Reported) -> Self {
        Self(Form::Value(Arc::new(figures)))
    }

    /// The figures, if they are of type `T`.
    #[must_use]
    pub fn read<T: Reported>(&self) -> Option<T> {
        match &self.0 {
            Form::Value(value) => (**value).any().downcast_ref::<T>().cloned(),
            Form::Json(json) => T::deserialize(json).ok(),
        }
    }

    fn json(&self) -> serde_json::Value {
        match &self.0 {
            Form::Value(value) => (**value).json(),
            Form::Json(json) => json.clone(),
        }
    }
}

impl PartialEq for Payload {
    fn eq(&self, other: &Self) -> bool {
        self.json() == other.json()
    }
}

impl Serialize for Payload {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.json().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Payload {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        serde_json::Value::deserialize(deserializer).map(|json| Self(Form::Json(json)))
    }
}
