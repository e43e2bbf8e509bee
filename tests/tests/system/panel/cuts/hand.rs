//! A client of the panel in a process of its own, which holds a jog button: it can be killed, stopped and cut off.

use super::super::printer::Session;
use hal_tests::{
    programs::own_test,
    scratch::{Running, Scratch, until},
    web::Socket,
};
use serde_json::json;
use std::{env, net::SocketAddr, process::Command};

/// Environment variable with the address of the panel, its own port, the cookie, the key, and the velocity.
const KEY: &str = "FERRULE_HAND";
/// Attempts to begin the jog: a busy computer may answer pulses too late.
const ATTEMPTS: u32 = 500;
/// Word that the client prints once its jog has been accepted.
const JOGS: &str = "the jog was accepted";

/// Starts a client that takes the lease. With a velocity other than 0 it then jogs X, once.
pub(super) fn start(
    scratch: &Scratch,
    before: &[&str],
    at: SocketAddr,
    session: &Session,
    velocity: f64,
) -> Running {
    let test = own_test(module_path!(), "a_hand");
    let exe = env::current_exe().unwrap();
    let mut words: Vec<_> = before.iter().map(std::ffi::OsString::from).collect();
    words.push(exe.into());
    let mut command = Command::new(&words[0]);
    command.args(&words[1..]).args([test.as_str(), "--exact", "--nocapture"]);
    let Session { cookie, key, .. } = session;
    command.env(KEY, format!("{at} {} {cookie} {key} {velocity}", session.port()));
    scratch.start(&mut command)
}

/// Waits until the client's jog has been accepted; returns false if the client has ended.
pub(super) fn jogs(hand: &mut Running) -> bool {
    until("the client jogs or gives up", || hand.said().0.contains(JOGS) || !hand.is_running());
    hand.said().0.contains(JOGS)
}

/// Takes the lease, jogs, and answers pulses until the connection ends.
fn hold(address: SocketAddr, port: u16, cookie: &str, key: &str, velocity: f64) {
    let headers = format!("Host: 127.0.0.1:{port}\r\nCookie: {cookie}\r\n");
    let mut socket = Socket::open_at(address, "/api/v1/socket", &headers).unwrap();
    socket.send(&json!({ "type": "hello", "key": key }));
    socket.wait(|m| m["panel"]["allow_motion"] == true).unwrap();
    // The lease of a panel that was killed lasts a while.
    let takes = (0..ATTEMPTS).any(|_| {
        let taken = socket.ask(json!({ "type": "lease", "do": "take", "force": true }));
        taken["ok"] == json!({}) || socket.wait(|m| m["type"] == "status").is_none()
    });
    assert!(takes, "the lease was not given");
    if velocity != 0.0 {
        let args = json!({ "axis": "X", "velocity": velocity });
        let jogs = (0..ATTEMPTS).any(|_| {
            // The permission needs a beat that has arrived: pulses are answered while a status is awaited.
            socket.wait(|m| m["type"] == "status").unwrap();
            socket.command("jog", &args).is_empty()
        });
        assert!(jogs, "the jog was not accepted");
        println!("{JOGS}");
    }
    socket.wait(|_| false);
}

/// Not a test by itself: `start` runs it in a process of its own, with the variable that says what to do.
#[test]
fn a_hand() {
    let Ok(words) = env::var(KEY) else { return };
    let words: Vec<_> = words.split(' ').collect();
    let [address, port, cookie, key, velocity] = words[..] else { panic!("{words:?}") };
    hold(address.parse().unwrap(), port.parse().unwrap(), cookie, key, velocity.parse().unwrap());
}
