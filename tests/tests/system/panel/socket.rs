//! Messages of the socket that are refused by name, and the lease.

use super::printer::{Printer, Session};
use hal_tests::web::Socket;
use serde_json::{Value, json};

/// Opens the socket, and sends this as the first message; returns the code of the refusal.
fn greeting(session: &Session, cookie: &str, first: &Value) -> String {
    let headers = format!("Host: 127.0.0.1:{}\r\nCookie: {cookie}\r\n", session.port());
    let mut socket = Socket::open(session.port(), "/api/v1/socket", &headers).unwrap();
    socket.send(first);
    socket.last_error()
}

#[test]
fn a_message_that_is_not_right_is_refused_by_name() {
    let printer = Printer::start("integrator");
    let session = printer.sign_in();
    let other = printer.sign_in();
    // The first message is the key of this cookie's session.
    for (cookie, first) in [
        (&session.cookie, json!({ "type": "hello", "key": "" })),
        (&session.cookie, json!({ "type": "hello", "key": other.key })),
        (&String::new(), json!({ "type": "hello", "key": session.key })),
        (&session.cookie, json!({ "type": "command", "id": 1, "name": "abort" })),
        (&session.cookie, json!([])),
    ] {
        assert_eq!(greeting(&session, cookie, &first), "no-session", "{first}");
    }

    // With an id there is an answer, and the connection lasts.
    let mut socket = session.socket();
    for (message, code) in [
        (json!({ "type": "samples" }), "malformed"),
        (json!({ "type": "lease", "do": "steal" }), "malformed"),
        (json!({ "type": "command", "name": "mode", "args": [] }), "malformed"),
        (json!({ "type": "command", "name": "explode" }), "not-found"),
        (json!({ "type": "command", "name": "abort", "args": { "joint": 0 } }), "malformed"),
        (json!({ "type": "command", "name": "run" }), "lease"),
        (json!({ "type": "lease", "do": "hand", "to": 99 }), "lease"),
    ] {
        let reply = socket.ask(message.clone());
        assert_eq!(reply["error"]["code"], code, "{message}: {reply}");
    }

    // Under the lease.
    assert_eq!(socket.ask(json!({ "type": "lease", "do": "take" }))["ok"], json!({}));
    let guarded =
        ["remote.beat", "remote.allow-motion", "halpanel.beat", "motion.jog-stop", "task.abort"];
    for pin in guarded {
        for (command, args) in [
            ("setp", json!({ "name": pin, "value": "1" })),
            ("net", json!({ "signal": "a", "pins": pin })),
            ("linkp", json!({ "pin": pin, "signal": "a" })),
            ("unlink", json!({ "pin": pin })),
        ] {
            assert_eq!(socket.command(command, &args), "remote", "{command} {pin}");
        }
    }
    for (command, args, code) in [
        ("open", json!({ "program": "../printer.ini" }), "malformed"),
        ("mode", json!({ "mode": "x\ntask.on" }), "malformed"),
        ("mdi", json!({ "text": "G".repeat(5000) }), "too-large"),
        ("touch-off", json!({ "axis": "X", "value": "inf" }), "malformed"),
        ("touch-off", json!({ "axis": "X", "value": 0, "system": 10 }), "malformed"),
        ("setp", json!({ "name": "no.such.pin", "value": "1" }), "refused"),
        ("tool-changed", json!({}), "conflict"),
    ] {
        assert_eq!(socket.command(command, &args), code, "{command} {args}");
    }

    // Without an id the connection ends, with the reason where the message has been read.
    let long = format!(r#"{{"type": "watch", "names": ["{}"]}}"#, "n".repeat(65_536));
    let names: Vec<_> = (0..1001).map(|n| n.to_string()).collect();
    let watch = json!({ "type": "watch", "names": names }).to_string();
    for (opcode, bytes, code) in [
        (1, &b"{"[..], "malformed"),
        (1, br#"{"type": "scope"}"#, "malformed"),
        (1, br#"{"type": "beat", "n": -1}"#, "malformed"),
        (1, br#"{"type": "hello", "key": ""}"#, "malformed"),
        (1, watch.as_bytes(), "too-large"),
        (2, b"abc", "malformed"),
        (1, long.as_bytes(), ""),
        (3, b"abc", ""),
    ] {
        let mut socket = session.socket();
        socket.frame(opcode, bytes);
        let text = String::from_utf8_lossy(&bytes[..bytes.len().min(60)]);
        assert_eq!(socket.last_error(), code, "{text}");
    }
    let mut hasty = session.socket();
    for n in 0..5000 {
        hasty.send(&json!({ "type": "beat", "n": n }));
    }
    assert_eq!(hasty.last_error(), "too-many");
}

#[test]
fn the_lease_is_of_one_client_and_an_old_one_counts_no_more() {
    let printer = Printer::start("operator");
    let session = printer.sign_in();
    let (mut ana, mut eva) = (session.socket(), printer.sign_in().socket());
    let lease = |what: &str| json!({ "type": "lease", "do": what });
    let on = json!({ "on": true });
    assert_eq!(ana.ask(lease("take"))["ok"], json!({}));
    assert_eq!(eva.ask(lease("take"))["error"]["code"], "conflict");
    assert_eq!(eva.command("optional-stop", &on), "lease");
    assert_eq!(ana.command("optional-stop", &on), "");
    // What takes time has a reply at once, and its end later: here a refusal, because the machine is off.
    let home = json!({ "type": "command", "name": "home", "args": { "joint": "all" } });
    let begun = ana.ask(home);
    assert_eq!(begun["pending"], true, "{begun}");
    let done = ana.wait(|m| m["type"] == "done" && m["id"] == begun["id"]).unwrap();
    assert_eq!(done["error"]["code"], "refused", "{done}");

    // Given back: the former holder has nothing more to say, until it takes the lease again.
    assert_eq!(ana.ask(lease("give"))["ok"], json!({}));
    assert_eq!(eva.ask(lease("take"))["ok"], json!({}));
    assert_eq!(ana.command("optional-stop", &on), "lease");
    assert_eq!(eva.command("optional-stop", &on), "");

    // A connection that ends gives it back; a new one of the same session does not have it.
    drop(eva);
    ana.wait(|m| m["type"] == "status" && m["panel"]["lease"].is_null()).unwrap();
    assert_eq!(session.socket().command("optional-stop", &on), "lease");
    assert_eq!(ana.ask(lease("take"))["ok"], json!({}));

    // The end of the session ends its sockets.
    let ended = printer.request("DELETE", "/api/v1/session", &session.headers(), b"");
    assert_eq!(ended.status, 200);
    assert_eq!(ana.last_error(), "no-session");
    let first = json!({ "type": "hello", "key": session.key });
    assert_eq!(greeting(&session, &session.cookie, &first), "no-session");
}
