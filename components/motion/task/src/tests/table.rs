//! The tables of `README.md`: commands, and fields of the snapshot.

use crate::{commands, status, status::TaskStatus, worker::Shared};
use hal_bench::{Bench, Described};
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
    out.push('\n');
    out
}

#[test]
fn the_page_has_every_command_and_field() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/README.md");
    hal_golden::check_part(path.as_ref(), BEGIN, END, &table());
}
