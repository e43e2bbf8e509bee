//! The description of the API is what the panel serves: paths, methods, answers, messages and commands.

use super::printer::Printer;
use hal_tests::{
    programs::{cargo, root, target},
    schema::Document,
    scratch::until,
};
use serde_json::{Value, json};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    process::Command,
};

/// Folder of the panel.
const PANEL: &str = "components/remote/panel";
/// Methods that a path may have.
const METHODS: [&str; 4] = ["get", "post", "put", "delete"];

fn text(path: &str) -> String {
    fs::read_to_string(root().join(PANEL).join(path)).unwrap()
}

fn document() -> Document {
    Document(serde_json::from_str(&text("openapi.json")).unwrap())
}

/// Returns the paths of the document, with their methods.
fn paths(document: &Document) -> BTreeMap<String, BTreeSet<String>> {
    let methods = |path: &Value| {
        METHODS.iter().filter(|m| path.get(m).is_some()).map(|m| (*m).to_owned()).collect()
    };
    let all = document.0["paths"].as_object().unwrap().iter();
    all.map(|(path, about)| (path.clone(), methods(about))).collect()
}

#[test]
fn the_document_has_the_paths_of_the_source() {
    let source = text("src/http/mod.rs");
    let routes: BTreeSet<_> = source
        .split(".route(\"")
        .skip(1)
        .map(|rest| rest.split_once('"').unwrap().0.to_owned())
        .collect();
    let document = document();
    assert_eq!(paths(&document).into_keys().collect::<BTreeSet<_>>(), routes);
    // The lists that one route serves.
    let kinds: BTreeSet<_> = text("src/http/lists.rs")
        .split("const KINDS")
        .nth(1)
        .unwrap()
        .split("];")
        .next()
        .unwrap()
        .split("(\"")
        .skip(1)
        .map(|rest| rest.split_once('"').unwrap().0.to_owned())
        .collect();
    let listed = &document.0["paths"]["/{kind}"]["get"]["parameters"][0]["schema"]["enum"];
    let listed: BTreeSet<_> =
        listed.as_array().unwrap().iter().map(|k| k.as_str().unwrap().to_owned()).collect();
    assert_eq!(listed, kinds);
}

#[test]
fn the_document_has_the_commands_codes_and_paths_of_the_texts() {
    let (document, api) = (document(), text("API.md"));
    let commands = document.0["x-commands"].as_array().unwrap();
    let schema = &document.schema("Command")["properties"]["name"]["enum"];
    let mut names = Vec::new();
    for command in commands {
        let (name, role) = (command["name"].as_str().unwrap(), command["role"].as_str().unwrap());
        let lease = if command["lease"] == true { "yes" } else { "no" };
        let end = format!("| {role} | {lease} |");
        let row = api.lines().find(|l| {
            l.starts_with('|')
                && l.split('|').nth(1).is_some_and(|cell| cell.contains(&format!("`{name}`")))
                && l.ends_with(&end)
        });
        assert!(row.is_some(), "API.md has no command {name} {end}");
        names.push(name);
    }
    assert_eq!(*schema, json!(names));
    // The table of the source has these rows, and no other.
    let source = text("src/commands.rs");
    let (_, table) = source.split_once("const ROWS").unwrap();
    let rows = table.split_once("\n];").unwrap().0.matches("row(").count();
    assert_eq!(rows, names.len(), "rows of commands.rs");
    // Codes: those of the document, of the table in API.md and of the source are the same.
    let codes = document.schema("Refusal")["properties"]["code"]["enum"].as_array().unwrap();
    let codes: BTreeSet<_> = codes.iter().map(|c| c.as_str().unwrap().to_owned()).collect();
    let source = text("src/error.rs");
    let (_, variants) = source.split_once("pub(crate) enum Code {").unwrap();
    let variants = variants.split_once("\n}").unwrap().0.lines().map(str::trim);
    let variants = variants.filter(|l| l.starts_with(char::is_uppercase));
    let kebab = |name: &str| {
        let words = name.trim_end_matches(',').chars().map(|c| match c {
            'A'..='Z' => format!("-{}", c.to_ascii_lowercase()),
            c => c.to_string(),
        });
        words.collect::<String>().trim_start_matches('-').to_owned()
    };
    assert_eq!(codes, variants.map(kebab).collect(), "codes of openapi.json and error.rs");
    let (_, table) = api.split_once("| code |").unwrap();
    let rows = table.lines().skip(2).take_while(|l| l.starts_with('|'));
    let listed = rows.flat_map(|l| l.split('|').nth(1).unwrap().split('`').skip(1).step_by(2));
    assert_eq!(codes, listed.map(str::to_owned).collect(), "codes of openapi.json and API.md");
    for path in paths(&document).keys().filter(|path| **path != "/{kind}") {
        let path = path.replace("{name}", "NAME");
        assert!(api.contains(&path), "API.md has no {path}");
    }
}

#[test]
fn answers_are_those_of_the_document() {
    let printer = Printer::start("integrator");
    let document = document();
    let good = printer.sign_in().headers();
    printer.scratch.write("programs/a.ngc", "G21\nG1 X1 F100\nM2\n");
    fs::create_dir(printer.scratch.path().join("output")).unwrap();
    printer.scratch.write("output/a.ngc", "1 2 3\n");
    for (path, methods) in paths(&document) {
        let real = path.replace("{name}", "a.ngc");
        let kinds = ["pins", "params", "signals", "functs", "threads", "commands", "components"];
        let real: Vec<_> = if path == "/{kind}" {
            kinds.map(|kind| format!("/{kind}")).to_vec()
        } else {
            vec![real]
        };
        for real in &real {
            let whole = format!("/api/v1{real}");
            for method in METHODS {
                let name = method.to_uppercase();
                if method != "get" && methods.contains(method) {
                    // Those that change something have tests of their own.
                    continue;
                }
                let answer = printer.request(&name, &whole, &good, b"");
                if !methods.contains(method) {
                    // The socket's path takes any method and wants an upgrade.
                    let refused = [400, 405].contains(&answer.status);
                    assert!(refused, "{name} {real} is not in the document: {}", answer.status);
                    continue;
                }
                let about = &document.0["paths"][&path][method];
                if real == "/socket" {
                    continue;
                }
                if answer.status != 200 {
                    let fits = document.check(document.schema("Error"), &answer.json());
                    assert_eq!(fits, Ok(()), "{name} {real}");
                    assert!(
                        ["/start", "/flight", "/align", "/align/picture"].contains(&real.as_str()),
                        "{name} {real}: {answer:?}"
                    );
                    continue;
                }
                let content = about["responses"]["200"]["content"].as_object().unwrap();
                let (kind, body) = content.iter().next().unwrap();
                let served = answer.header("content-type").unwrap();
                assert!(served.starts_with(kind.as_str()), "{real}: {served}, not {kind}");
                if kind == "application/json" {
                    let fits = document.check(&body["schema"], &answer.json());
                    assert_eq!(fits, Ok(()), "{name} {real}");
                }
                // Without a session only what the document says so of.
                let open = about["security"] == json!([]);
                let bare = printer.request(&name, &whole, &printer.host(), b"");
                assert_eq!(bare.status, if open { 200 } else { 401 }, "{real} without a session");
            }
        }
    }
    let served = printer.request("GET", "/api/v1/openapi.json", &printer.host(), b"");
    assert_eq!(served.json(), document.0);
}

#[test]
fn messages_of_the_socket_are_those_of_the_document() {
    let printer = Printer::start("integrator");
    let document = document();
    let (from_client, from_server) =
        (document.schema("ClientMessage"), document.schema("ServerMessage"));
    let mut socket = printer.sign_in().socket();
    let mut seen = BTreeSet::new();
    for mut message in [
        json!({ "type": "lease", "do": "take" }),
        json!({ "type": "command", "name": "optional-stop", "args": { "on": true } }),
        json!({ "type": "command", "name": "home", "args": { "joint": "all" } }),
        json!({ "type": "command", "name": "jog" }),
        json!({ "type": "watch", "names": ["remote.pulse", "no.such.pin"] }),
        json!({ "type": "scope", "capture": { "names": ["remote.pulse"], "seconds": 0.2 } }),
        json!({ "type": "scope" }),
    ] {
        let is_asked = message["type"] != "watch";
        if is_asked {
            message["id"] = 7.into();
        }
        assert_eq!(document.check(from_client, &message), Ok(()));
        socket.send(&message);
        let last = match (message["type"].as_str().unwrap(), message["name"].as_str()) {
            ("watch", _) => "values",
            ("scope", _) if message.get("capture").is_some() => "samples",
            (_, Some("home")) => "done",
            _ => "reply",
        };
        loop {
            let got = socket.receive().unwrap();
            assert_eq!(document.check(from_server, &got), Ok(()), "after {message}");
            let kind = got["type"].as_str().unwrap().to_owned();
            if kind == "pulse" {
                let beat = json!({ "type": "beat", "n": got["n"] });
                assert_eq!(document.check(from_client, &beat), Ok(()));
                socket.send(&beat);
            }
            seen.insert(kind.clone());
            if kind == last {
                break;
            }
        }
    }
    let mut broken = printer.sign_in().socket();
    broken.frame(1, b"{");
    let error = broken.wait(|m| m["type"] == "error").unwrap();
    assert_eq!(document.check(from_server, &error), Ok(()));
    let all = ["done", "pulse", "reply", "samples", "status", "values"].map(str::to_owned);
    assert_eq!(seen, all.into());
}

#[test]
fn the_example_of_a_client_reads_the_state_of_the_machine() {
    let (folder, profile) = target();
    // The crates that `programs` builds too, whose dependencies are there; of one crate alone they would have other features.
    let mut build = cargo("build");
    build.args(["--workspace", "--exclude", "hal-tests", "--example", "client", "--quiet"]);
    build.args(["--profile", if profile == "debug" { "dev" } else { &profile }]);
    assert!(build.arg("--target-dir").arg(&folder).status().unwrap().success());
    let printer = Printer::start("viewer");
    let mut client = Command::new(folder.join(profile).join("examples/client"));
    let mut client = printer.scratch.start(client.arg(printer.address()));
    until("the client ends", || !client.is_running());
    let (out, err) = client.said();
    assert!(out.lines().count() > 2, "{out} {err}");
    assert!(out.lines().all(|line| line.starts_with("local at Some(")), "{out}");
}
