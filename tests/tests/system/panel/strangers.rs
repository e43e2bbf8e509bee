//! Another user of the computer, who has neither the token nor the rights of the files.

use super::printer::Printer;
use hal_protocol::{Folder, Place};
use hal_tests::{
    scratch::{Scratch, until},
    user::{as_user, is_root},
    web::{self, Socket},
};
use serde_json::json;
use std::{
    fs,
    io::{ErrorKind, Read as _, Write as _},
    net::TcpStream,
    os::unix::{fs::PermissionsExt as _, net::UnixStream},
};

/// A user without rights: `nobody`.
const NOBODY: u32 = 65_534;

#[test]
fn another_user_of_the_computer_reaches_neither_the_machine_nor_a_session() {
    if !is_root() {
        return;
    }
    let printer = Printer::start("integrator");
    let session = printer.sign_in();
    let (host, port) = (printer.host(), printer.port);
    let folder = printer.scratch.path().to_owned();
    let socket = fs::read_dir(folder.join(".run/ferrule")).unwrap();
    let socket = socket.map(|entry| entry.unwrap().path());
    let sockets: Vec<_> =
        socket.filter(|path| path.extension().is_some_and(|e| e == "sock")).collect();
    assert!(!sockets.is_empty(), "the instance has a socket");
    let denied = |what: &str, error: Option<ErrorKind>| {
        assert_eq!(error, Some(ErrorKind::PermissionDenied), "{what}");
    };
    as_user(NOBODY, || {
        for file in ["address", ".private/audit"] {
            denied(file, fs::read(folder.join(file)).err().map(|e| e.kind()));
            denied(file, fs::write(folder.join(file), "x").err().map(|e| e.kind()));
        }
        denied("the folder", fs::read_dir(folder.join(".run/ferrule")).err().map(|e| e.kind()));
        for path in &sockets {
            denied("the socket", UnixStream::connect(path).err().map(|e| e.kind()));
        }
        // The panel's port is open to every user of the computer, and serves only who has signed in.
        for path in ["/info", "/pins", "/programs", "/status", "/graph", "/check"] {
            let answer = web::request(port, "GET", &format!("/api/v1{path}"), &host, b"");
            assert_eq!((answer.status, answer.code()), (401, "no-session".to_owned()), "{path}");
        }
        for token in [String::new(), "0".repeat(64), "f".repeat(64), "é".repeat(64)] {
            let body = json!({ "token": token }).to_string();
            let answer = web::request(port, "POST", "/api/v1/session", &host, body.as_bytes());
            assert_eq!((answer.status, answer.code()), (401, "wrong-login".to_owned()));
        }
        let mut stranger = Socket::open(port, "/api/v1/socket", &host).unwrap();
        stranger.send(&json!({ "type": "hello", "key": "0".repeat(64) }));
        assert_eq!(stranger.last_error(), "no-session");
    });
    // The person who has signed in goes on.
    assert_eq!(session.socket().command("abort", &json!({})), "");
    let save = |what: &str| printer.halcmd(what);
    assert_eq!(save("getp motion.motion-enabled").trim(), "FALSE");
}

/// A user of a system service, and a person.
const SERVICE: u32 = 990;
const PERSON: u32 = 60_001;

#[test]
fn a_folder_of_sockets_is_of_its_user_and_that_of_a_service_of_its_group_too() {
    if !is_root() {
        return;
    }
    let scratch = Scratch::new("service");
    fs::set_permissions(scratch.path(), fs::Permissions::from_mode(0o777)).unwrap();
    for (user, before, after) in [
        (SERVICE, 0o750, 0o750),
        (SERVICE, 0o755, 0o700),
        (SERVICE, 0o751, 0o700),
        (PERSON, 0o750, 0o700),
        (PERSON, 0o755, 0o700),
    ] {
        let path = scratch.path().join(format!("{user}-{before:o}"));
        as_user(user, || {
            fs::create_dir(&path).unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(before)).unwrap();
            drop(Folder::make(&Place::at(&path, "default").unwrap()).unwrap());
        });
        let mode = fs::metadata(&path).unwrap().permissions().mode() & 0o7777;
        assert_eq!(mode, after, "user {user}, {before:o}");
    }
}

/// Connections of one user of this computer.
const MAX_OWN: usize = 512;

#[test]
fn another_user_of_the_computer_takes_no_connection_of_others() {
    if !is_root() {
        return;
    }
    let printer = Printer::start("viewer");
    let (host, port) = (printer.host(), printer.port);
    let ended = as_user(NOBODY, || {
        let connect = || TcpStream::connect(("127.0.0.1", port)).unwrap();
        let mut taken: Vec<_> = (0..MAX_OWN).map(|_| connect()).collect();
        // One more is closed without a word, whatever it asks, as soon as those before it are counted. One that is answered stays in
        // the place of one that the panel gave up because it had asked nothing for long.
        let asked = format!("GET / HTTP/1.1\r\n{host}\r\n");
        until("one more is closed", || {
            let mut more = connect();
            more.write_all(asked.as_bytes()).unwrap_or_default();
            let is_closed = more.read(&mut [0; 1]).unwrap_or(0) == 0;
            taken.push(more);
            is_closed
        });
        taken
    });
    // The person who owns the machine is served meanwhile.
    assert_eq!(printer.sign_in().socket().command("estop", &json!({})), "");
    drop(ended);
}
