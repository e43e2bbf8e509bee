//! The table of all components in `components/README.md` is what the plugins themselves say.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_engine::{ClockKind, Engine, Options};
use hal_protocol::Place;
use hal_tests::programs::{programs, root};
use std::fmt::Write;

const BEGIN: &str = "<!-- table:begin -->";
const END: &str = "<!-- table:end -->";

fn table() -> String {
    let options = Options {
        place: Place::find(Some("table")).unwrap(),
        clock: ClockKind::Virtual,
        hold: true,
        simulate: true,
        old_names: false,
        path: vec![programs().to_owned()],
    };
    let mut engine = Engine::without_socket(options).unwrap();
    let mut out = String::from("\n\n| component | library | what it is |\n|---|---|---|\n");
    let catalogue = engine.catalogue();
    assert!(catalogue.len() > 20, "only {} components found", catalogue.len());
    for o in catalogue {
        let summary = o.doc.lines().next().unwrap_or_default();
        assert!(!summary.is_empty(), "{} has no documentation", o.component);
        writeln!(out, "| `{}` | `{}` | {summary} |", o.component, o.library).unwrap();
    }
    out.push('\n');
    out
}

#[test]
fn the_table_of_components_is_true() {
    let path = root().join("components/README.md");
    let text = std::fs::read_to_string(&path).unwrap();
    let (head, rest) = text.split_once(BEGIN).unwrap();
    let (old, tail) = rest.split_once(END).unwrap();
    let new = table();
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        std::fs::write(&path, format!("{head}{BEGIN}{new}{END}{tail}")).unwrap();
        return;
    }
    assert_eq!(old, new, "run this test once with UPDATE_EXPECT=1");
}
