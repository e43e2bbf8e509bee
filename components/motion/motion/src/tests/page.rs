//! The tables of `README.md`: commands of the service `motion`, and fields of its status.

use super::Rig;
use hal_bench::Described;
use hal_component::{motion_kind, motion_setting};
use std::fmt::Write;

const BEGIN: &str = "<!-- written by UPDATE_EXPECT=1 cargo test -p motion page -->\n";
const END: &str = "<!-- end -->\n";

fn table() -> String {
    let rig = Rig::off(&[]);
    let mut out =
        String::from("\n## Commands\n\n| kind | text command | arguments |\n|---|---|---|\n");
    for (n, name) in motion_kind::NAMES.iter().enumerate().skip(1) {
        let name = format!("motion.{name}");
        let args = rig.bench.arguments(&name);
        let names: Vec<_> = args.iter().map(|a| format!("`{}`", a.name)).collect();
        writeln!(out, "| {n} | `{name}` | {} |", names.join(" ")).unwrap();
    }
    out.push_str(
        "\n## Settings of `motion.configure`\n\n| code | setting | description |\n|---|---|---|\n",
    );
    let settings = rig.bench.arguments("motion.configure");
    for (n, name) in motion_setting::NAMES.iter().enumerate() {
        let doc = &settings.iter().find(|a| a.name == *name).unwrap().doc;
        writeln!(out, "| {n} | `{name}` | {doc} |").unwrap();
    }
    out.push_str("\n## Status\n\n| field | type | description |\n|---|---|---|\n");
    for Described { name, ty, doc } in rig.bench.fields("motion.status") {
        writeln!(out, "| `{name}` | {ty} | {} |", doc.replace('\n', " ")).unwrap();
    }
    out.push('\n');
    out
}

/// Each command, setting and field is in the tables.
#[test]
fn the_page_has_every_command_and_field() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/README.md");
    hal_golden::check_part(path.as_ref(), BEGIN, END, &table());
}
