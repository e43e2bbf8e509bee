//! Samples of the scope over the socket, and the wiring as a picture.

use super::printer::Printer;
use hal_tests::scratch::until;
use serde_json::{Value, json};

#[test]
fn a_capture_that_cannot_be_is_refused_by_name() {
    let mut printer = Printer::start("viewer");
    let capture = |over: Value| {
        let mut capture = json!({ "names": ["axis.0.motor-pos-cmd"], "seconds": 0.1 });
        capture.as_object_mut().unwrap().extend(over.as_object().unwrap().clone());
        json!({ "type": "scope", "capture": capture })
    };
    let reply = printer.sign_in().socket().ask(capture(json!({})));
    assert_eq!(reply["error"]["code"], "role", "{reply}");
    printer.restart("operator", &[]);
    let mut socket = printer.sign_in().socket();
    let names: Vec<_> = (0..17).map(|n| format!("p{n}")).collect();
    let trigger =
        |when: &str, before: f64| json!({ "trigger": { "when": when, "before": before } });
    for (over, code) in [
        (json!({ "names": [] }), "malformed"),
        (json!({ "names": ["axis.*"] }), "malformed"),
        (json!({ "names": names }), "too-large"),
        (json!({ "names": ["n".repeat(257)] }), "too-large"),
        (json!({ "names": ["no.such.pin"] }), "refused"),
        (json!({ "thread": "none" }), "refused"),
        (json!({ "seconds": 0 }), "malformed"),
        (json!({ "seconds": 601 }), "malformed"),
        (json!({ "seconds": 600 }), "too-large"),
        (json!({ "every": 1_000_001 }), "malformed"),
        (json!({ "colour": "red" }), "malformed"),
        (trigger("", 0.0), "malformed"),
        (trigger("axis.0.motor-pos-cmd rises", 0.0), "malformed"),
        (trigger("no.such.pin > 1", 0.0), "refused"),
        (trigger("axis.0.motor-pos-cmd > 1", 0.2), "malformed"),
        (trigger("axis.0.motor-pos-cmd > 1", -0.1), "malformed"),
        (trigger(&"(".repeat(1024), 0.0), "malformed"),
        (trigger(&"x".repeat(1025), 0.0), "too-large"),
    ] {
        let reply = socket.ask(capture(over.clone()));
        assert_eq!(reply["error"]["code"], code, "{over}: {reply}");
    }
    // Eight run, the ninth does not; one that ends leaves its place.
    let mut sockets: Vec<_> = (0..8).map(|_| printer.sign_in().socket()).collect();
    for socket in &mut sockets {
        let reply = socket.ask(capture(json!({})));
        assert_eq!(reply["ok"]["names"], json!(["axis.0.motor-pos-cmd"]), "{reply}");
    }
    assert_eq!(socket.ask(capture(json!({})))["error"]["code"], "too-many");
    drop(sockets.pop());
    until("the scope of a client that has gone ends", || {
        socket.ask(capture(json!({})))["ok"].is_object()
    });
}

#[test]
fn samples_are_those_of_the_engine() {
    let mut printer = Printer::start("operator");
    let mut socket = printer.sign_in().socket();
    let names = json!(["remote.permit", "remote.pulse"]);
    let stream = json!({ "names": names, "seconds": 0.5 });
    let reply = socket.ask(json!({ "type": "scope", "capture": stream }));
    assert_eq!(reply["ok"]["names"], names, "{reply}");
    let period = reply["ok"]["period"].as_f64().unwrap();
    // Each sample of a stream follows the one before by a period, but for those that are lost.
    let mut last = None::<f64>;
    for n in 1..=3 {
        let part = socket.wait(|m| m["type"] == "samples").unwrap();
        assert_eq!(part["capture"], n, "{part}");
        assert_eq!(part["trigger"], Value::Null);
        let times: Vec<f64> =
            part["times"].as_array().unwrap().iter().map(|t| t.as_f64().unwrap()).collect();
        assert!((0.05..0.06).contains(&(times.len() as f64 * period)), "{} samples", times.len());
        let columns = part["columns"].as_array().unwrap();
        assert!(columns.iter().all(|c| c.as_array().unwrap().len() == times.len()));
        let start = part["start"].as_f64().unwrap();
        let lost = part["lost"].as_u64().unwrap() as f64;
        if let Some(last) = last {
            let gap = (start - last) / period;
            assert!((gap - 1.0 - lost).abs() < 0.5, "a gap of {gap} periods, {lost} lost");
        }
        last = Some(start + times.last().unwrap());
    }

    // A trigger: the samples before it do not fulfil its condition, the one at it does.
    let pin = "stepgen.0.maxaccel";
    printer.halcmd(&format!("setp {pin} 1000"));
    let trigger = json!({ "when": format!("{pin} > 1500"), "before": 0.05 });
    let capture = json!({ "names": [pin], "seconds": 0.1, "trigger": trigger });
    assert!(socket.ask(json!({ "type": "scope", "capture": capture }))["ok"].is_object());
    // A capture needs the samples before its trigger.
    let pulse = || printer.number("getp remote.pulse");
    let from = pulse();
    until("200 ms have passed", || from + 200.0 < pulse());
    printer.halcmd(&format!("setp {pin} 2000"));
    let got = socket.wait(|m| m["type"] == "samples" && !m["trigger"].is_null()).unwrap();
    let (times, column) = (got["times"].as_array().unwrap(), got["columns"][0].as_array().unwrap());
    let trigger = got["trigger"].as_f64().unwrap();
    let place = times.iter().position(|t| (t.as_f64().unwrap() - trigger).abs() < 1e-9).unwrap();
    assert!(place > 0, "{trigger} s");
    for (n, value) in column.iter().enumerate() {
        assert_eq!(1500.0 < value.as_f64().unwrap(), place <= n, "sample {n}: {value}");
    }

    // Without a capture the scope ends; the end of a name ends it too.
    assert_eq!(socket.ask(json!({ "type": "scope" }))["ok"], json!({}));
    let reply = socket.ask(json!({ "type": "scope", "capture": stream }));
    assert!(reply["ok"].is_object(), "{reply}");
    socket.wait(|m| m["type"] == "samples").unwrap();
    printer.end_machine();
    let end = socket.wait(|m| m["ended"].is_string()).unwrap();
    assert_ne!(end["ended"], "", "{end}");
}

#[test]
fn the_wiring_is_drawn_as_halcmd_draws_it() {
    let printer = Printer::start("viewer");
    let session = printer.sign_in();
    let picture = |query: &str| {
        let path = format!("/api/v1/graph{query}");
        let answer = printer.request("GET", &path, &session.headers(), b"");
        assert_eq!((answer.status, answer.header("content-type")), (200, Some("image/svg+xml")));
        String::from_utf8(answer.body).unwrap()
    };
    let all = picture("");
    let some = picture("?pattern=xpos*");
    assert!(all.starts_with("<svg") && all.contains(">xpos") && all.contains(">ypos"));
    assert!(some.contains(">xpos") && !some.contains(">ypos"), "{some}");
    // Without its styles the picture has the page's own: nothing else in it is styled or runs.
    let none = ["<script", "<foreignObject", "onload", "href"];
    assert!(none.iter().all(|word| !all.contains(word)));
}
