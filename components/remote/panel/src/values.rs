//! Values of pins, parameters and signals that a client watches.

use crate::{engine::Engine, error::Error};
use hal_protocol::{Kind, Reply, Request};
use serde_json::{Map, Value as Json, json};

/// Returns the values of these names; null for those that do not exist.
pub(crate) async fn read(engine: &Engine, names: &[String]) -> Result<Map<String, Json>, Error> {
    let mut values: Map<String, Json> = names.iter().map(|n| (n.clone(), Json::Null)).collect();
    let plain = |name: &&String| !name.starts_with("sig:") && !name.contains(['*', '?', '[']);
    let items: Vec<String> = names.iter().filter(plain).cloned().collect();
    if !items.is_empty() {
        for kind in [Kind::Pins, Kind::Params] {
            let list = Request::List { kind, patterns: items.clone(), ty: None };
            if let Reply::Items(found) = engine.call(list).await? {
                for item in found {
                    put(&mut values, &item.name, &item.value);
                    if let Some(original) = &item.original {
                        put(&mut values, original, &item.value);
                    }
                }
            }
        }
    }
    let signals = names.iter().filter_map(|name| name.strip_prefix("sig:"));
    let signals: Vec<String> =
        signals.filter(|n| !n.contains(['*', '?', '['])).map(str::to_owned).collect();
    if !signals.is_empty() {
        let list = Request::List { kind: Kind::Signals, patterns: signals, ty: None };
        if let Reply::Signals(found) = engine.call(list).await? {
            for signal in found {
                put(&mut values, &format!("sig:{}", signal.name), &signal.value);
            }
        }
    }
    Ok(values)
}

/// Returns whether there is a pin of this name, and it is TRUE.
pub(crate) async fn is_on(engine: &Engine, pin: &str) -> Result<bool, Error> {
    let values = read(engine, &[pin.to_owned()]).await?;
    Ok(values.get(pin) == Some(&json!({ "bit": true })))
}

fn put(values: &mut Map<String, Json>, name: &str, value: &hal_protocol::Value) {
    if let Some(place) = values.get_mut(name) {
        *place = serde_json::to_value(value).unwrap_or_default();
    }
}
