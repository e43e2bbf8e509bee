//! The example of each component's page runs in virtual time, and its comments are true: `# -> OUTPUT` after a line
//! states its output. `EXAMPLE=NAME` runs one.
#![expect(clippy::print_stdout, reason = "one that is asked for is shown")]

use hal_tests::every::{engine, offers};
use halcmd::{Bytes, Captured, Outcome, Session, Style, manual::man};

const SHOWS: &str = "# ->";

/// Returns the mistakes of an example.
fn wrong(name: &str, script: &str) -> Vec<String> {
    let mut engine = engine();
    let mut out = Vec::new();
    let mut shown = 0;
    let loaded = |l: &str| l.strip_prefix("loadrt ").map(|l| l.split(' ').next() == Some(name));
    let is_load = |l: &str| loaded(l) == Some(true);
    // Some have a second spelling, with the same page.
    let is_second = ["kins", "trsrn", "io", "iov2"].iter().any(|end| name.ends_with(end));
    if !is_second && !script.lines().any(is_load) {
        out.push("it does not load the component".to_owned());
    }
    for line in script.lines() {
        let (command, wanted) = match line.split_once(SHOWS) {
            Some((command, wanted)) => (command, Some(wanted.trim())),
            None => (line, None),
        };
        let mut terminal = Captured::default();
        let mut session = Session::new(&mut engine, &mut terminal, Style::default(), "example");
        let done = session.file(name, Bytes::new(command.as_bytes().to_vec()));
        if done != Outcome::Good {
            out.push(format!("`{line}`: {}", terminal.err.trim()));
        } else if let Some(wanted) = wanted {
            shown += 1;
            let is = terminal.out.trim();
            if is != wanted {
                out.push(format!("`{line}`: it prints {is}"));
            }
        }
    }
    if shown == 0 {
        out.push(format!("it shows nothing: no line with `{SHOWS}`"));
    }
    engine.close();
    out
}

#[test]
fn every_example_shows_what_it_says() {
    let only = std::env::var("EXAMPLE").ok();
    let mut all = Vec::new();
    for offer in offers() {
        let name = offer.component;
        if only.as_ref().is_some_and(|only| *only != name) {
            continue;
        }
        let found = match man::example(&offer.doc) {
            Some(script) => wrong(&name, &script),
            None => vec!["it has no example".to_owned()],
        };
        if only.is_some() {
            println!("{}", man::example(&offer.doc).unwrap_or_default());
        }
        all.extend(found.into_iter().map(|what| format!("{name}: {what}")));
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}
