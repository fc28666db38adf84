//! Foxglove's WebSocket protocol: JSON texts, and binary messages for what is large.
//!
//! <https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md>

use recorder::Channel;
use serde::Deserialize;
use serde_json::{Value, json};

/// Names of the protocol that a client may offer, best first.
pub(crate) const SUBPROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];

const MESSAGE_DATA: u8 = 1;
/// First byte of a message that is a time.
pub(crate) const TIME: u8 = 2;
const SERVICE_RESPONSE: u8 = 3;
/// Client's binary message.
const SERVICE_REQUEST: u8 = 2;

/// Number of the only service.
pub(crate) const SERVICE: u32 = 1;

/// Name and value of what viewers may read: a number, a text, a truth value, or a list of them.
pub type Parameter = (String, Value);

/// Answers a request of the service; an error is for the viewer's user.
pub type Answer = Box<dyn Fn(&[u8]) -> Result<Vec<u8>, String> + Send + Sync>;

/// The offer to viewers.
pub struct Subject {
    /// Name of the server.
    pub name: String,
    /// Another one for each run: a viewer that comes back knows whether it sees the same run.
    pub session: String,
    /// Channels, by the numbers that their messages have.
    pub channels: Vec<Channel>,
    /// Values that do not change.
    pub parameters: Vec<Parameter>,
    /// The announcement of a service, and the function that answers.
    pub service: Option<(String, Answer)>,
}

impl Subject {
    /// Texts for a viewer that has connected.
    pub(crate) fn welcome(&self) -> Vec<String> {
        let capabilities = ["time", "parameters", "services"];
        let info = json!({
            "op": "serverInfo",
            "name": self.name,
            "capabilities": capabilities[..2 + usize::from(self.service.is_some())],
            "supportedEncodings": ["json"],
            "metadata": {},
            "sessionId": self.session,
        });
        // Channel numbers are places in the list.
        let one = |(id, channel): (usize, &Channel)| {
            json!({
                "id": id,
                "topic": channel.topic,
                "encoding": "cdr",
                "schemaName": channel.type_name,
                "schema": channel.definition,
                "schemaEncoding": "ros2msg",
            })
        };
        let channels: Vec<Value> = self.channels.iter().enumerate().map(one).collect();
        let channels = json!({ "op": "advertise", "channels": channels });
        let service = self.service.iter().map(|(announcement, _)| announcement.clone());
        [info.to_string(), channels.to_string()].into_iter().chain(service).collect()
    }
}

/// The parameters that a request names, or all without a name.
pub(crate) fn parameter_values(all: &[Parameter], request: &Asked) -> String {
    let names = &request.parameter_names;
    let asked = |(name, _): &&Parameter| names.is_empty() || names.contains(name);
    let one = |(name, value): &Parameter| match value.is_f64() {
        true => json!({ "name": name, "value": value, "type": "float64" }),
        false => json!({ "name": name, "value": value }),
    };
    let parameters: Vec<Value> = all.iter().filter(asked).map(one).collect();
    let mut answer = json!({ "op": "parameterValues", "parameters": parameters });
    request.id.iter().for_each(|id| answer["id"] = id.as_str().into());
    answer.to_string()
}

/// A warning.
pub(crate) fn status(message: &str) -> String {
    json!({ "op": "status", "level": 1, "message": message }).to_string()
}

pub(crate) fn service_response(call: u32, response: &[u8]) -> Vec<u8> {
    const ENCODING: &[u8] = b"json";
    let head = [SERVICE, call, ENCODING.len() as u32].map(u32::to_le_bytes).concat();
    [&[SERVICE_RESPONSE], &head[..], ENCODING, response].concat()
}

pub(crate) fn message_data(subscription: u32, time: u64, payload: &[u8]) -> Vec<u8> {
    [&[MESSAGE_DATA], &subscription.to_le_bytes()[..], &time.to_le_bytes(), payload].concat()
}

/// A client's text. Its operation says which of the other fields it has.
#[derive(Debug, PartialEq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Asked {
    pub(crate) op: String,
    #[serde(default)]
    pub(crate) subscriptions: Vec<Subscription>,
    #[serde(default)]
    pub(crate) subscription_ids: Vec<u32>,
    #[serde(default)]
    pub(crate) parameter_names: Vec<String>,
    pub(crate) id: Option<String>,
}

#[derive(Debug, PartialEq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Subscription {
    pub(crate) id: u32,
    pub(crate) channel_id: u16,
}

/// Reads a client's call of a service: numbers of the service and of the call, encoding, request. `None` if it is none.
pub(crate) fn call(bytes: &[u8]) -> Option<(u32, u32, &[u8], &[u8])> {
    let (head, rest) = bytes.strip_prefix(&[SERVICE_REQUEST])?.split_at_checked(12)?;
    let [service, call, length] = bytemuck::pod_read_unaligned::<[u32; 3]>(head).map(u32::from_le);
    let (encoding, request) = rest.split_at_checked(usize::try_from(length).ok()?)?;
    Some((service, call, encoding, request))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_clients_are_read_and_unknown_ones_are_passed_over() {
        let read = |text: &str| serde_json::from_str::<Asked>(text).ok();
        let text = r#"{"op":"subscribe","subscriptions":[{"id":7,"channelId":2}]}"#;
        let asked = read(text).expect("a text");
        assert_eq!(asked.op, "subscribe");
        assert_eq!(asked.subscriptions, [Subscription { id: 7, channel_id: 2 }]);
        let asked = read(r#"{"op":"unsubscribe","subscriptionIds":[7]}"#).expect("a text");
        assert_eq!((asked.op.as_str(), asked.subscription_ids), ("unsubscribe", vec![7]));
        assert!(read(r#"{"op":"subscribeConnectionGraph","nodes":3}"#).is_some());
        assert_eq!(read(r#"{"subscriptions":[]}"#), None);
        assert_eq!(read(r#"{"op":"subscribe","subscriptions":[{"id":-1,"channelId":2}]}"#), None);
        assert_eq!(read("[]"), None);
    }

    #[test]
    fn a_call_is_read_and_a_short_one_is_none() {
        let mut bytes = vec![2, 1, 0, 0, 0, 9, 0, 0, 0, 4, 0, 0, 0];
        bytes.extend_from_slice(b"json{}");
        assert_eq!(call(&bytes), Some((1, 9, &b"json"[..], &b"{}"[..])));
        for length in 0..17 {
            assert_eq!(call(&bytes[..length]), None, "{length} bytes");
        }
    }
}
