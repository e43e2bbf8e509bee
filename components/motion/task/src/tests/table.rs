//! The tables of `README.md`: commands, and fields of the snapshot.

use crate::{commands, status, status::TaskStatus, worker::Shared};
use hal_bench::{Bench, Described};
use hal_component::Wait;
use hal_component::{Builder, Component, Error, StopEpoch};
use std::fmt::Write;

const BEGIN: &str = "<!-- written by UPDATE_EXPECT=1 cargo test -p task page -->\n";
const END: &str = "<!-- end -->\n";

/// The task without what it needs to run.
struct Page;

impl Component for Page {
    const NAME: &'static str = "page";
    const DOC: &'static str = "Commands and snapshot of the task.";
    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        commands::open(b, &Shared::default(), StopEpoch::default)?;
        b.snapshot::<TaskStatus>("task.status", status::VERSION, "").map(|_| ())
    }
}

fn table() -> String {
    let mut bench = Bench::new();
    bench.load::<Page>(&[]).unwrap();
    let mut out = String::from("\n## Commands\n\n| command | arguments |\n|---|---|\n");
    for name in bench.commands() {
        let args = bench.arguments(&name);
        let names: Vec<_> = args.iter().map(|a| format!("`{}`", a.name)).collect();
        writeln!(out, "| `{name}` | {} |", names.join(" ")).unwrap();
    }
    let version = status::VERSION;
    writeln!(
        out,
        "\n## The snapshot `task.status`\n\nVersion {version}, published at each change; \
         `halcmd snapshot task.status` prints it.\n\n| field | type | description |\n|---|---|---|"
    )
    .unwrap();
    for Described { name, ty, doc } in bench.fields("task.status") {
        writeln!(out, "| `{name}` | {ty} | {} |", doc.replace('\n', " ")).unwrap();
    }
    out.push_str("\n## Waits\n\n| number | name | the object is | who is waited for, and how to go on |\n|---|---|---|---|\n");
    for wait in Wait::ALL {
        let object = match wait {
            Wait::AtSpeed
            | Wait::Index
            | Wait::Orient
            | Wait::SpindleStopped
            | Wait::SpindleSpeed => "a spindle",
            Wait::Tool => "a tool",
            Wait::Input => "an input",
            Wait::Program => "a user code",
            _ => "",
        };
        let (number, name, text) = (wait as u32, wait.name(), wait.text("task", 0));
        writeln!(out, "| {number} | `{name}` | {object} | {text} |").unwrap();
    }
    out.push('\n');
    out
}

#[test]
fn the_names_of_waits_in_python_are_these() {
    let path =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../foreign/python/modules/linuxcnc/_stat.py");
    let text = std::fs::read_to_string(path).unwrap();
    let list = text.split_once("_WAITS = (").unwrap().1.split_once(')').unwrap().0;
    let names: Vec<&str> = list.split(',').map(|name| name.trim().trim_matches('"')).collect();
    assert_eq!(names, Wait::ALL.map(Wait::name));
}

#[test]
fn the_page_has_every_command_and_field() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/README.md");
    hal_golden::check_part(path.as_ref(), BEGIN, END, &table());
}
