//! Findings as SARIF 2.1.0, which editors and CI systems read.

use crate::{Error, manual::explain};
use hal_protocol::{At, Code, Finding};
use serde_json::{Value, json};

/// Returns the log of one run.
pub(super) fn write(findings: &[Finding]) -> Result<String, Error> {
    let log = json!({
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [{
            "tool": { "driver": {
                "name": "halcmd check",
                "version": env!("CARGO_PKG_VERSION"),
                "rules": Code::ALL.iter().map(|code| rule(*code)).collect::<Vec<_>>(),
            }},
            "columnKind": "unicodeCodePoints",
            "results": findings.iter().map(result).collect::<Vec<_>>(),
        }],
    });
    let text = serde_json::to_string_pretty(&log).map_err(|_| Error::Unexpected)?;
    Ok(text + "\n")
}

fn rule(code: Code) -> Value {
    let row = explain::row(code);
    json!({
        "id": code.id(),
        "name": format!("{code:?}"),
        "shortDescription": { "text": code.title() },
        "fullDescription": { "text": row.map_or("", |row| row.means) },
        "help": { "text": row.map_or("", |row| row.remedy) },
        "defaultConfiguration": { "level": code.level().name() },
    })
}

fn result(f: &Finding) -> Value {
    let text =
        if f.remedy.is_empty() { f.text.clone() } else { format!("{}. {}", f.text, f.remedy) };
    let mut result = json!({
        "ruleId": f.code.id(),
        "ruleIndex": Code::ALL.iter().position(|code| *code == f.code),
        "level": f.level.name(),
        "message": { "text": text },
    });
    let mut location = f.at.as_ref().map_or_else(|| json!({}), physical);
    if !f.subject.is_empty() {
        put(&mut location, "logicalLocations", json!([{ "name": f.subject }]));
    }
    if location.as_object().is_some_and(|map| !map.is_empty()) {
        put(&mut result, "locations", json!([location]));
    }
    if !f.related.is_empty() {
        let related = f.related.iter().map(|r| {
            let mut place = physical(&r.at);
            put(&mut place, "message", json!({ "text": r.text }));
            place
        });
        let related = Value::Array(related.collect());
        put(&mut result, "relatedLocations", related);
    }
    result
}

fn physical(at: &At) -> Value {
    let mut place = json!({ "artifactLocation": { "uri": uri(&at.file) } });
    if at.line > 0 {
        put(&mut place, "region", json!({ "startLine": at.line }));
    }
    json!({ "physicalLocation": place })
}

/// Adds a member to an object.
fn put(object: &mut Value, key: &str, value: Value) {
    if let Some(map) = object.as_object_mut() {
        map.insert(key.to_owned(), value);
    }
}

/// Writes a path as part of a URI.
fn uri(path: &str) -> String {
    let mut out = if path.starts_with('/') { "file://".to_owned() } else { String::new() };
    for b in path.bytes() {
        if b.is_ascii_alphanumeric() || b"-._~/".contains(&b) {
            out.push(char::from(b));
        } else {
            out.push_str(&format!("%{b:02X}"));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_has_what_the_standard_asks_for() {
        let findings = [
            Finding::new(Code::NoReader, "x", "nothing reads it".into())
                .at(Some(At::new("a b.hal", 3)))
                .remedy("link it")
                .related(Some(At::new("/m.hal", 0)), "here"),
            Finding::new(Code::Refused, "", "no".into()),
        ];
        let log: Value = serde_json::from_str(&write(&findings).unwrap()).unwrap();
        let run = &log["runs"][0];
        assert_eq!(log["version"], "2.1.0");
        assert_eq!(run["tool"]["driver"]["rules"].as_array().unwrap().len(), Code::ALL.len());
        let first = &run["results"][0];
        let rule = usize::try_from(first["ruleIndex"].as_u64().unwrap()).unwrap();
        assert_eq!(run["tool"]["driver"]["rules"][rule]["id"], "H306");
        assert_eq!(first["message"]["text"], "nothing reads it. link it");
        let place = &first["locations"][0]["physicalLocation"];
        assert_eq!(place["artifactLocation"]["uri"], "a%20b.hal");
        assert_eq!(place["region"]["startLine"], 3);
        let other = &first["relatedLocations"][0]["physicalLocation"];
        assert_eq!(other["artifactLocation"]["uri"], "file:///m.hal");
        assert_eq!(other["region"], Value::Null);
        assert_eq!(run["results"][1]["locations"], Value::Null);
    }
}
