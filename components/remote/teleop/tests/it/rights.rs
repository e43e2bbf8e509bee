//! The table of rights: every request of the protocol by strangers, users who look on, and users who work.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_golden::rights::RightsTable;
use std::{net::Ipv4Addr, path::Path};
use teleop::{Action, Machine, REQUESTS, Server, Word};

const WHO: [&str; 4] = ["stranger", "watcher", "worker", "owner"];
const STATES: [&str; 3] = ["ready", "leased", "job"];

/// Returns a server with a connection of these circumstances.
fn server(who: &str, state: &str) -> (Server, u64) {
    let mut server = Server::default();
    let peer = Ipv4Addr::LOCALHOST.into();
    let (own, other) = (server.connect(peer, 0).unwrap(), server.connect(peer, 0).unwrap());
    let mut enter = |id: u64, user: &str, works: bool| {
        server.receive(id, format!("INGRESAR {user}:clave\n").as_bytes(), 0);
        assert!(matches!(server.action(), Some(Action::SignIn { .. })));
        server.signed_in(id, Ok(works), 0);
        if works {
            server.receive(id, b"ENVIAR_NUEVO\nG00 X1\n.\n", 0);
        }
    };
    if who != "stranger" {
        enter(own, "ana", who != "watcher");
    }
    enter(other, "eva", true);
    let runs = match (who, state) {
        ("owner", _) => Some(own),
        (_, "job") => Some(other),
        _ => None,
    };
    if let Some(id) = runs {
        server.receive(id, b"EJECUTAR\n", 0);
        assert!(matches!(server.action(), Some(Action::Start { .. })));
        server.started(Ok(()), 0);
    }
    if state == "leased" {
        server.machine(Machine { busy: Some("ida has the lease".to_owned()), progress: None });
    }
    drop((server.output(own), server.output(other)));
    (server, own)
}

/// Returns what comes of a request: the code of its refusal, or what the server does.
fn end(who: &str, state: &str, word: Word) -> String {
    let (mut server, id) = server(who, state);
    let line = match word {
        Word::Ingresar => "INGRESAR ana:clave\n".to_owned(),
        Word::EnviarNuevo | Word::EnviarAgregar => format!("{}\nG00 X1\n.\n", word.text()),
        _ => format!("{}\n", word.text()),
    };
    server.receive(id, line.as_bytes(), 0);
    let said = String::from_utf8(server.output(id)).unwrap();
    let refused =
        said.lines().find(|line| line.starts_with("ERROR") || line.starts_with("DENEGADO"));
    match (refused, server.action()) {
        (Some(line), _) => line.split_whitespace().nth(1).unwrap().to_lowercase(),
        (None, Some(Action::SignIn { .. })) => "asks for the password".to_owned(),
        (None, _) => "ok".to_owned(),
    }
}

#[test]
fn every_request_has_the_rights_of_its_rule() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tests/rights");
    let mut table = RightsTable::of(&folder.join("teleoperation.rules"));
    for who in WHO {
        for state in STATES {
            for row in REQUESTS {
                table.row(row.text, &[who, state], &end(who, state, row.word));
            }
        }
    }
    table.finish(&folder.join("teleoperation.md"));
}
