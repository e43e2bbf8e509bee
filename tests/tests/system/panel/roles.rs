//! Every command by every role, as the table of the API's document says.

use super::printer::Printer;
use hal_tests::programs::root;
use serde_json::json;
use std::fs;

/// Roles, each with the rights of those before it.
const ROLES: [&str; 3] = ["viewer", "operator", "integrator"];

/// A command of the table.
struct Row {
    name: String,
    /// Least role, as a place in `ROLES`.
    role: usize,
    lease: bool,
}

/// Reads the table of commands in the document.
fn table() -> Vec<Row> {
    let text = fs::read_to_string(root().join("components/remote/panel/API.md")).unwrap();
    let (_, table) = text.split_once("| command | arguments | role | lease |").unwrap();
    let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
    let rows = rows.flat_map(|line| {
        let cells: Vec<_> = line.split('|').map(str::trim).collect();
        let role = ROLES.iter().position(|role| *role == cells[3]).unwrap();
        let lease = ["no", "yes"].iter().position(|word| *word == cells[4]).unwrap() == 1;
        let names = cells[1].split('`').skip(1).step_by(2);
        names.map(|name| Row { name: name.to_owned(), role, lease }).collect::<Vec<_>>()
    });
    rows.collect()
}

#[test]
fn every_command_has_the_role_and_the_lease_of_the_document() {
    let rows = table();
    assert!(rows.len() > 30, "the document has {} commands", rows.len());
    let mut printer = Printer::start(ROLES[0]);
    for (n, role) in ROLES.iter().enumerate() {
        if n != 0 {
            printer.restart(role, &[]);
        }
        let session = printer.sign_in();
        let mut socket = session.socket();
        for row in &rows {
            // Without arguments most commands are malformed: that is found after the rights.
            let code = socket.command(&row.name, &json!({ "none": 0 }));
            let wanted = match (n < row.role, row.lease) {
                (true, _) => "role",
                (false, true) => "lease",
                (false, false) => "malformed",
            };
            assert_eq!(code, wanted, "{role}: {} without lease", row.name);
        }
        let taken = socket.ask(json!({ "type": "lease", "do": "take" }));
        let refused = taken["error"]["code"].as_str().unwrap_or_default();
        assert_eq!(refused, if n == 0 { "role" } else { "" }, "{role}: {taken}");
        for row in rows.iter().filter(|row| n != 0 && row.lease) {
            let code = socket.command(&row.name, &json!({ "none": 0 }));
            let wanted = if n < row.role { "role" } else { "malformed" };
            // A button that answers nothing, whatever its arguments.
            let wanted = if row.name == "tool-changed" { "conflict" } else { wanted };
            assert_eq!(code, wanted, "{role}: {} with lease", row.name);
        }
        // Abort is everybody's, without lease.
        assert_eq!(session.socket().command("abort", &json!({})), "", "{role}");
        let put = printer.request("PUT", "/api/v1/programs/a.ngc", &session.headers(), b"M2\n");
        assert_eq!(put.status, if n == 0 { 403 } else { 200 }, "{role}");
    }
    // The log names who did what, and how it ended.
    let audit = printer.scratch.read(&printer.scratch.private("audit"));
    let has = |text: &str| audit.lines().any(|line| line.contains(text));
    assert!(has(r#""end":"ok""#) && has(r#""command":"abort""#) && has(r#""end":"role""#));
    assert!(!audit.contains(&printer.token()));
}
