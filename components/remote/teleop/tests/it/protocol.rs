//! The tables of `PROTOCOL.md`: requests, codes and states, from the server itself; and limits that need many bytes.
#![expect(clippy::unwrap_used, reason = "tests")]

use std::{
    net::{IpAddr, Ipv4Addr},
    path::Path,
};
use teleop::{
    Action, Answer, CODES, Code, LIVENESS_MS, MAX_LINE, MAX_PROGRAM, Machine, REQUESTS, Reason,
    Server, Word,
};

const BEGIN: &str = "<!-- written by UPDATE_EXPECT=1 cargo test -p teleop protocol -->\n";
const END: &str = "<!-- end -->\n";
/// Address of the clients' computer.
const PEER: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);
/// States of a session; in the last two, another session's job runs.
const STATES: &[&str] = &["NEW", "READY", "LOADED", "RUNNING", "LOADED, another's job"];

/// Returns a server with the session in a state.
fn server(state: &str) -> (Server, u64) {
    let mut server = Server::default();
    let own = server.connect(PEER, 0).unwrap();
    if state == "NEW" {
        return (server, own);
    }
    let other = server.connect(PEER, 0).unwrap();
    for (id, user) in [(own, "ana"), (other, "eva")] {
        server.receive(id, format!("INGRESAR {user}:clave\n").as_bytes(), 0);
        assert!(matches!(server.action(), Some(Action::SignIn { .. })));
        server.signed_in(id, Ok(true), 0);
        if state != "READY" {
            server.receive(id, b"ENVIAR_NUEVO G00 X1\n", 0);
        }
    }
    let runs = match state {
        "RUNNING" => Some(own),
        "LOADED, another's job" => Some(other),
        _ => None,
    };
    if let Some(id) = runs {
        server.receive(id, b"EJECUTAR\n", 0);
        assert!(matches!(server.action(), Some(Action::Start { .. })));
        server.started(Ok(()), 0);
        server.machine(Machine { busy: None, progress: Some(42) });
    }
    drop(server.output(own));
    (server, own)
}

/// Returns the answers of a server to a request in a state, and the state after it where it is another.
fn cell(state: &str, word: Word) -> String {
    let (mut server, id) = server(state);
    let line = match word {
        Word::Ingresar => "INGRESAR ana:clave".to_owned(),
        Word::EnviarNuevo | Word::EnviarAgregar => format!("{}\nG00 X1\n.", word.text()),
        _ => word.text().to_owned(),
    };
    server.receive(id, format!("{line}\n").as_bytes(), 0);
    let mut after = state;
    while let Some(action) = server.action() {
        match action {
            Action::SignIn { id, .. } => {
                server.signed_in(id, Ok(true), 0);
                after = "READY";
            }
            Action::Start { .. } => {
                server.started(Ok(()), 0);
                after = "RUNNING";
            }
            Action::Cancel => {
                assert_eq!(server.output(id), b"", "the machine moves");
                server.ended(Err(Reason::new(Code::Falla, "aborted")), 0);
                after = "LOADED";
            }
            Action::Lose => after = "lost",
            Action::Close(_) => after = "closed",
        }
    }
    let output = String::from_utf8(server.output(id)).unwrap();
    let words: Vec<String> = output
        .lines()
        .map(|line| {
            let code =
                matches!(Answer::parse(line), Some(Answer::Avance(_))) || line.contains("ERROR");
            line.split(' ').take(1 + usize::from(code)).collect::<Vec<_>>().join(" ")
        })
        .collect();
    if words == ["RECIBIDO"] && state == "READY" {
        after = "LOADED";
    }
    let arrow = if after == state { String::new() } else { format!("→ {after}") };
    let text = [words.join(", "), arrow].join(" ");
    text.trim().to_owned()
}

fn tables() -> String {
    let mut text = "\n| request | answers | effect |\n|---|---|---|\n".to_owned();
    for row in REQUESTS {
        let argument =
            if row.argument.is_empty() { String::new() } else { format!(" {}", row.argument) };
        text += &format!("| `{}{argument}` | {} | {} |\n", row.text, row.answers, row.doc);
    }
    text += "\n| code | meaning |\n|---|---|\n";
    for row in CODES {
        text += &format!("| `{}` | {} |\n", row.text, row.doc);
    }
    text += &format!("\n| | {} |\n|---|{}\n", STATES.join(" | "), "---|".repeat(STATES.len()));
    for row in REQUESTS {
        let cells: Vec<String> = STATES.iter().map(|state| cell(state, row.word)).collect();
        text += &format!("| `{}` | {} |\n", row.text, cells.join(" | "));
    }
    text + "\n"
}

#[test]
fn protocol() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("PROTOCOL.md");
    hal_golden::check_part(&path, BEGIN, END, &tables());
}

#[test]
fn a_program_that_is_too_long_is_refused_and_the_one_before_stays() {
    let (mut server, id) = server("READY");
    let line = format!("{}\n", "x".repeat(MAX_LINE));
    let most = MAX_PROGRAM / line.len();
    let mut send = |word: &str, lines: usize| {
        server.receive(id, format!("{word}\n").as_bytes(), 0);
        for _ in 0..lines {
            server.receive(id, line.as_bytes(), 0);
        }
        server.receive(id, b".\n", 0);
        String::from_utf8(server.output(id)).unwrap()
    };
    let refused = |word: &str| format!("{word} LARGO the program has more than 16 MiB\r\n");
    assert_eq!(send("ENVIAR_NUEVO", most), "RECIBIDO\r\n");
    assert_eq!(send("ENVIAR_AGREGAR", 1), refused("ERROR_AGREGAR"));
    assert_eq!(send("ENVIAR_NUEVO", most + 1), refused("ERROR_NUEVO"));
    assert_eq!(send("ENVIAR_AGREGAR", 0), "RECIBIDO\r\n");
    server.receive(id, b"EJECUTAR\n", 0);
    let Some(Action::Start { program, .. }) = server.action() else { panic!("no start") };
    assert_eq!(program.len(), most * line.len());
}

#[test]
fn a_client_that_sends_while_its_request_is_executed_is_read_no_further() {
    let (mut server, id) = server("LOADED");
    server.receive(id, b"EJECUTAR\n", 0);
    assert!(!server.is_full(id));
    server.receive(id, "AVANCE\n".repeat(10_000).as_bytes(), 0);
    assert!(server.is_full(id));
    assert_eq!(server.output(id), b"", "the start comes first");
    server.started(Ok(()), 0);
    assert!(!server.is_full(id));
    assert_eq!(server.output(id).len(), 10_000 * "AVANCE 0\r\n".len());
}

#[test]
fn a_client_that_waits_for_the_end_of_its_job_is_there_as_long_as_its_connection() {
    let (mut server, id) = server("RUNNING");
    assert_eq!(
        server.answers_until(9_000),
        LIVENESS_MS,
        "it has said nothing since it was started"
    );
    server.receive(id, b"CANCELAR\n", 9_000);
    assert_eq!(server.answers_until(50_000), 50_000 + LIVENESS_MS);
    server.poll(50_000);
    assert!(server.is_linked(), "a client that waits is not silent");
    server.gone(id);
    assert_eq!(server.answers_until(50_000), 49_999);
}

#[test]
fn an_answer_is_one_line_whatever_its_text() {
    let (mut server, id) = server("RUNNING");
    let text = format!("one\r\ntwo\u{1b}[2J {}", "é".repeat(2000));
    server.ended(Err(Reason::new(Code::Falla, text)), 0);
    let line = String::from_utf8(server.output(id)).unwrap();
    assert!(line.starts_with("ERROR_EJECUTAR FALLA one  two [2J é"), "{line}");
    assert!(line.len() <= MAX_LINE + 2 && line.lines().count() == 1, "{line}");
    let shown = Answer::parse(line.trim_end());
    assert!(
        matches!(shown, Some(Answer::ErrorEjecutar(Reason { code: Some(_), .. }))),
        "{shown:?}"
    );
}

/// Returns the next number of a sequence without a pattern.
fn next(seed: &mut u64) -> usize {
    *seed ^= *seed << 13;
    *seed ^= *seed >> 7;
    *seed ^= *seed << 17;
    usize::try_from(*seed >> 33).unwrap()
}

#[test]
fn bytes_and_events_in_any_order_leave_one_job_and_whole_answers() {
    let long = "x".repeat(2000);
    let pieces: &[&[u8]] = &[
        b"INGRESAR ana:clave\n",
        b"INGRESAR eva:clave\r\n",
        b"INGRESAR ana:",
        b"ENVIAR_NUEVO\n",
        b"ENVIAR_NUEVO G0\n",
        b"ENVIAR_AGREGAR\n",
        b"G01 X1\n",
        b".\n",
        b"..\n",
        b"EJECUTAR\n",
        b"ejecutar\r\n",
        b"AVANCE\n",
        b"CANCELAR\n",
        b"SALIR\n",
        b"\xff\xfe\n",
        b"\0",
        b"\r",
        b"\n",
        b"AVAN",
        b"TERMINADO\n",
        b" \t\n",
        long.as_bytes(),
    ];
    let mut seed = 1905;
    let (mut jobs, mut ends, mut answers) = (0, 0, 0);
    for _ in 0..300 {
        let (mut server, mut ids, mut now) = (Server::default(), Vec::new(), 0);
        // Number of jobs that the machine would have.
        let (mut starting, mut running) = (0_u32, 0_u32);
        let mut cancels = 0;
        for _ in 0..400 {
            let pick = next(&mut seed) % 100;
            match (pick, ids.is_empty()) {
                (0..4, _) | (_, true) => ids.extend(server.connect(PEER, now)),
                (4..6, _) => {
                    let id = ids.swap_remove(next(&mut seed) % ids.len());
                    server.gone(id);
                }
                (6..10, _) => {
                    now += next(&mut seed) as u64 % 8000;
                    server.poll(now);
                }
                (10..14, _) if starting > 0 => {
                    starting -= 1;
                    running += u32::from(pick < 13);
                    let refused = Reason::new(Code::Sintaxis, "1 odd");
                    server.started(if pick < 13 { Ok(()) } else { Err(refused) }, now);
                }
                (14..18, _) if running > 0 => {
                    running -= 1;
                    ends += 1;
                    server.ended(Ok(()), now);
                }
                (18, _) if next(&mut seed).is_multiple_of(20) => server.stop(now),
                _ => {
                    let id = ids[next(&mut seed) % ids.len()];
                    server.receive(id, pieces[next(&mut seed) % pieces.len()], now);
                }
            }
            while let Some(action) = server.action() {
                match action {
                    Action::SignIn { id, secret, .. } => {
                        server.signed_in(id, Ok(secret == "clave"), now);
                    }
                    Action::Start { .. } => {
                        (starting, jobs, cancels) = (starting + 1, jobs + 1, 0);
                        assert_eq!((starting, running), (1, 0), "one job at a time");
                    }
                    Action::Cancel => {
                        cancels += 1;
                        assert_eq!((starting + running, cancels), (1, 1), "once for a job");
                    }
                    Action::Lose => assert_eq!(running, 1),
                    Action::Close(id) => assert!(ids.contains(&id)),
                }
            }
            for id in &ids {
                let output = String::from_utf8(server.output(*id)).unwrap();
                assert!(output.is_empty() || output.ends_with("\r\n"));
                for line in output.split_terminator("\r\n") {
                    answers += 1;
                    assert!(Answer::parse(line).is_some(), "{line:?}");
                }
            }
        }
    }
    assert!(jobs > 100 && ends > 30 && answers > 5000, "{jobs} {ends} {answers}");
}
