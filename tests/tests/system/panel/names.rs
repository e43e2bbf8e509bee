//! Every path that a name from afar reaches, with each attack on it: the table `tests/names.md`.

use super::printer::{Printer, Session};
use hal_golden::check;
use hal_protocol::{Answer, Client, Link as _, Reply, Request, TicketInfo};
use hal_tests::{
    programs::root,
    scratch::Scratch,
    web::{Socket, encoded},
};
use serde_json::{Value, json};
use std::{
    fmt::Write as _,
    fs,
    os::unix::fs::{PermissionsExt as _, symlink},
};

/// Text that no attack may change or show.
const KEPT: &str = "kept\n";

/// A way for a name to come in.
#[derive(Clone, Copy)]
enum Door {
    /// A request with this method; the name is in the path.
    Request(&'static str, &'static str, &'static str),
    /// A command of the socket, with the name as its program.
    Command(&'static str),
    /// A line of G-code, before and behind the name.
    Code(&'static str, &'static str),
    /// The engine's command that opens a program, of a client that speaks from afar, with a file of the uploads.
    Afar(&'static str),
    /// An entry of a section of the INI file, with the name as its value.
    Entry(&'static str, &'static str),
}

/// The doors: what they are called in the table, and what a good name is there.
const DOORS: &[(&str, Door, &str)] = &[
    ("`GET /programs/NAME`", Door::Request("GET", "/programs/", ""), "good.ngc"),
    ("`PUT /programs/NAME`", Door::Request("PUT", "/programs/", ""), "good.ngc"),
    ("`DELETE /programs/NAME`", Door::Request("DELETE", "/programs/", ""), "good.ngc"),
    ("`GET /programs/NAME/path`", Door::Request("GET", "/programs/", "/path"), "good.ngc"),
    ("`POST /programs/NAME/align`", Door::Request("POST", "/programs/", "/align"), "good.ngc"),
    ("`GET /output/NAME`", Door::Request("GET", "/output/", ""), "good.ngc"),
    ("command `open`", Door::Command("open"), "good.ngc"),
    ("command `robot-load`", Door::Command("robot-load"), "good.ngc"),
    ("`(LOGOPEN,NAME)`", Door::Code("(LOGOPEN,", ")"), "good.ngc"),
    ("`(LOGAPPEND,NAME)`", Door::Code("(LOGAPPEND,", ")"), "good.ngc"),
    ("`(PROBEOPEN NAME)`", Door::Code("(PROBEOPEN ", ")"), "good.ngc"),
    ("`o<NAME> call`", Door::Code("o<", "> call"), "good"),
    ("`set open NAME` of linuxcncrsh", Door::Afar("task.open"), "good.ngc"),
    ("`[RS274NGC]OUTPUT_DIR`", Door::Entry("RS274NGC", "OUTPUT_DIR"), "good"),
    ("`[RS274NGC]SUBROUTINE_PATH`", Door::Entry("RS274NGC", "SUBROUTINE_PATH"), "good"),
    ("`[RS274NGC]USER_M_PATH`", Door::Entry("RS274NGC", "USER_M_PATH"), "good"),
    ("`[DISPLAY]PROGRAM_PREFIX`", Door::Entry("DISPLAY", "PROGRAM_PREFIX"), "good"),
    ("`[PYTHON]TOPLEVEL`", Door::Entry("PYTHON", "TOPLEVEL"), "good"),
    ("`[PYTHON]PATH_APPEND`", Door::Entry("PYTHON", "PATH_APPEND"), "good"),
    ("`[PYTHON]PATH_PREPEND`", Door::Entry("PYTHON", "PATH_PREPEND"), "good"),
];

/// The attacks: what they are called in the table, and the name.
const ATTACKS: &[(&str, &str)] = &[
    ("good", ""),
    ("link", "link.ngc"),
    ("linked folder", "folder/secret.ngc"),
    ("hard link", "hard.ngc"),
    ("executable", "run.ngc"),
    ("pipe", "pipe.ngc"),
    ("`..`", "../secret.ngc"),
    ("`..` within", "a/../../secret.ngc"),
    ("absolute", "/secret.ngc"),
    ("hidden", ".secret.ngc"),
    ("NUL", "a\0.ngc"),
    ("256 bytes", ""),
    ("two characters for one", "e\u{301}.ngc"),
    ("another form", "\u{ff47}ood.ngc"),
    ("leader of two dots", "\u{2025}.ngc"),
];

/// Returns the name of an attack at a door.
fn name(attack: usize, good: &str) -> String {
    match ATTACKS[attack] {
        ("good", _) => good.to_owned(),
        ("256 bytes", _) => format!("{}.ngc", "a".repeat(252)),
        // A subroutine's file has this ending, whatever its name.
        (_, name) if !good.contains('.') => name.trim_end_matches(".ngc").to_owned(),
        (_, name) => name.to_owned(),
    }
}

/// Lays the traps of a folder.
fn lay(scratch: &Scratch, folder: &str) {
    let at = scratch.path().join(folder);
    drop(fs::remove_dir_all(&at));
    fs::create_dir_all(&at).unwrap();
    let secret = scratch.path().join("secret.ngc");
    fs::write(at.join("good.ngc"), "G21\nM2\n").unwrap();
    fs::write(at.join("run.ngc"), KEPT).unwrap();
    fs::set_permissions(at.join("run.ngc"), fs::Permissions::from_mode(0o755)).unwrap();
    symlink(&secret, at.join("link.ngc")).unwrap();
    symlink(scratch.path(), at.join("folder")).unwrap();
    fs::hard_link(&secret, at.join("hard.ngc")).unwrap();
    rustix::fs::mknodat(
        rustix::fs::CWD,
        at.join("pipe.ngc"),
        rustix::fs::FileType::Fifo,
        rustix::fs::Mode::from_raw_mode(0o666),
        0,
    )
    .unwrap();
}

struct Stage {
    printer: Printer,
    session: Session,
    socket: Socket,
}

impl Stage {
    fn start() -> Self {
        let edit = |ini: &str| {
            let lines = ini.lines().map(|line| match line.split_once('=') {
                Some((name, _)) if name.trim() == "PROGRAM_PREFIX" => "PROGRAM_PREFIX = programs",
                _ if line == "[RS274NGC]" => "[RS274NGC]\nSUBROUTINE_PATH = subs",
                _ if line == "[TRAJ]" => "[TRAJ]\nNO_FORCE_HOMING = 1",
                _ => line,
            });
            lines.map(|line| format!("{line}\n")).collect()
        };
        let prepare = |scratch: &Scratch| {
            scratch.write("secret.ngc", KEPT);
            fs::create_dir(scratch.path().join("programs")).unwrap();
            lay(scratch, "subs");
            scratch.write("subs/good.ngc", "o<good> sub\no<good> endsub\n");
        };
        let printer = Printer::edited("operator", &["--virtual", "--hold"], edit, prepare);
        printer.halcmd("run 1s");
        let session = printer.sign_in();
        let mut socket = session.socket();
        assert_eq!(socket.ask(json!({ "type": "lease", "do": "take" }))["ok"], json!({}));
        let mut stage = Self { printer, session, socket };
        for (name, args) in
            [("estop-reset", json!({})), ("on", json!({})), ("mode", json!({ "mode": "mdi" }))]
        {
            assert_eq!(stage.order(name, &args), "", "{name}");
        }
        stage
    }

    /// Gives a command, and returns the code of its refusal, or nothing.
    fn order(&mut self, name: &str, args: &Value) -> String {
        let code = |answer: &Value| answer["error"]["code"].as_str().unwrap_or_default().to_owned();
        let reply = self.socket.ask(json!({ "type": "command", "name": name, "args": args }));
        if reply["pending"] == true {
            self.printer.halcmd("run 1s");
            let done = self.socket.wait(|m| m["type"] == "done" && m["id"] == reply["id"]);
            return code(&done.unwrap());
        }
        code(&reply)
    }

    /// Opens a program as linuxcncrsh does; returns `refused`, or nothing.
    fn open_from_afar(&self, command: &str, name: &str) -> String {
        let scratch = &self.printer.scratch;
        let mut client = Client::connect_from_afar(&scratch.place("default")).unwrap();
        let file = scratch.path().join("programs/uploads").join(name);
        let args = vec![format!("file={}", file.display())];
        let asked = client.call(Request::Command { name: command.to_owned(), args });
        let Ok(Reply::Answer(Answer { ticket: Some(id), .. })) = asked else {
            return if asked.is_ok() { String::new() } else { "refused".to_owned() };
        };
        self.printer.halcmd("run 1s");
        match client.call(Request::Ticket { id, wait: false }).unwrap() {
            Reply::Ticket(TicketInfo::Done) => String::new(),
            Reply::Ticket(TicketInfo::Failed(_)) => "refused".to_owned(),
            other => panic!("{name}: {other:?}"),
        }
    }

    /// Tries a name at a door, and returns what became of it.
    fn knock(&mut self, door: Door, name: &str) -> String {
        for folder in ["programs/uploads", "output"] {
            lay(&self.printer.scratch, folder);
        }
        let said = match door {
            Door::Request(method, before, behind) => {
                let path = format!("/api/v1{before}{}{behind}", encoded(name).replace('/', "%2F"));
                let body = if method == "POST" { "{}" } else { "M2\n" };
                let kind = if method == "POST" { "Content-Type: application/json\r\n" } else { "" };
                let headers = format!("{}{kind}", self.session.headers());
                let answer = self.printer.request(method, &path, &headers, body.as_bytes());
                let shows = answer.body.windows(KEPT.len()).any(|part| part == KEPT.as_bytes());
                match answer.status {
                    200 if shows && !name.contains("run") => "SHOWN".to_owned(),
                    200 => String::new(),
                    status => format!("{status} {}", answer.code()),
                }
            }
            Door::Command(command) => self.order(command, &json!({ "program": name })),
            Door::Code(before, behind) => {
                let said = self.order("mdi", &json!({ "text": format!("{before}{name}{behind}") }));
                self.order("mdi", &json!({ "text": "(LOG,mischief)" }));
                self.order("mdi", &json!({ "text": "(LOGCLOSE)" }));
                said
            }
            Door::Afar(command) => self.open_from_afar(command, name),
            Door::Entry(..) => unreachable!("another table"),
        };
        let scratch = &self.printer.scratch;
        let kept = ["secret.ngc", "programs/uploads/run.ngc", "output/run.ngc"];
        let changed = kept.iter().any(|file| {
            fs::read_to_string(scratch.path().join(file)).ok().as_deref() != Some(KEPT)
        });
        if changed {
            scratch.write("secret.ngc", KEPT);
            return "CHANGED".to_owned();
        }
        if said.is_empty() { "ok".to_owned() } else { said }
    }
}

/// Starts a machine with an entry, and returns whether it starts.
fn start(scratch: &Scratch, ini: &str, section: &str, entry: &str, place: &str) -> String {
    let (head, line) = (format!("[{section}]\n"), format!("{entry} = {place}\n"));
    let others = ini.lines().filter(|line| !line.starts_with(&format!("{entry} =")));
    let others: String = others.map(|line| format!("{line}\n")).collect();
    let text = match others.contains(&head) {
        true => others.replace(&head, &format!("{head}{line}")),
        false => format!("{others}{head}{line}"),
    };
    scratch.write("machine.ini", text);
    let output = scratch.halrun(&["--virtual", "--for", "1ms", "--headless", "machine.ini"]);
    let is_named = output.stderr.contains("machine.ini:");
    match output.status {
        Some(0) => "ok".to_owned(),
        _ if is_named => "refused with its line".to_owned(),
        _ => format!("refused: {}", output.stderr.lines().next().unwrap_or_default()),
    }
}

#[test]
fn each_attack_on_a_name_is_refused_at_each_door() {
    let mut stage = Stage::start();
    let mut table = "\
# Names

Every path that a name from a request, a program or an INI file reaches, with each attack on the name: what answers. The test
`panel::names` of `tests/tests/system` writes this table, and `tests/tests/system/panel/attacks.rs` has the attacks that combine several steps.

`link` to a file outside, `linked folder` on the way, `hard link` to a file outside, `executable` file and `pipe` under a good name; the other columns are the names themselves.
A race of check and use is a test of `hal/beneath`, for each operation. `ok` means that the file was opened, written or removed where it may be; numbers are the status of HTTP.
Without the components `align` and `robot`, what the name does not refuse is `refused` for that.

"
    .to_owned();
    let titles: Vec<_> = ATTACKS.iter().map(|(title, _)| *title).collect();
    writeln!(table, "| path | {} |\n|---|{}", titles.join(" | "), "---|".repeat(titles.len()))
        .unwrap();
    let mut entries = Vec::new();
    for (title, door, good) in DOORS {
        if let Door::Entry(..) = door {
            entries.push((title, door));
            continue;
        }
        let row: Vec<_> = (0..ATTACKS.len()).map(|n| stage.knock(*door, &name(n, good))).collect();
        assert!(!row.iter().any(|said| said == "CHANGED" || said == "SHOWN"), "{title}: {row:?}");
        writeln!(table, "| {title} | {} |", row.join(" | ")).unwrap();
    }
    table.push_str("\nFolders that entries of the INI file name: each is the owner's word, and may be anywhere but where others write.\n\n");
    let scratch = Scratch::copy_of(&root().join("configs/printer"));
    let ini = scratch.read("printer.ini");
    let ini = ini.replace("PROGRAM_PREFIX = /home/carlos/linuxcnc/nc_files", "PROGRAM_PREFIX = nc");
    fs::create_dir_all(scratch.path().join("nc/uploads")).unwrap();
    fs::create_dir_all(scratch.path().join("output")).unwrap();
    symlink("nc/uploads", scratch.path().join("link")).unwrap();
    for folder in ["own", "nc/uploads/a", "output/a", "."] {
        fs::create_dir_all(scratch.path().join(folder)).unwrap();
        scratch.write(&format!("{folder}/top.py"), "");
    }
    scratch.write("nc/uploads/top.py", "");
    let places = [
        ("its own folder", "own"),
        ("the uploads", "nc/uploads"),
        ("a link to the uploads", "link"),
        ("below the uploads, by `..`", "own/../nc/uploads/a"),
        ("the output folder", "output/a"),
        ("the INI file's folder", "."),
    ];
    writeln!(
        table,
        "| entry | {} |\n|---|{}",
        places.map(|(title, _)| title).join(" | "),
        "---|".repeat(places.len())
    )
    .unwrap();
    for (title, door) in entries {
        let Door::Entry(section, entry) = door else { continue };
        // This one names a file.
        let file = if *entry == "TOPLEVEL" { "/top.py" } else { "" };
        let row = places.map(|(_, place)| {
            let place = format!("{place}{file}");
            start(&scratch, &ini, section, entry, &place)
        });
        writeln!(table, "| {title} | {} |", row.join(" | ")).unwrap();
    }
    table.push_str("\nThe tool table, the parameter file, the record of the spindle and the journal are the owner's files too, and no value in them is a name of a file. `[RS274NGC]REMAP`\nnames subroutines, which are found as `o<NAME> call` finds them, and modules in Python, whose folders are entries of `[PYTHON]` above.\n`program_open` of Python opens what the machine's own user names, on this computer alone; with `HAL_FROM_AFAR` it is held to `set open`'s row.\n");
    check(&root().join("tests/names.md"), &table);
}

#[test]
fn each_door_of_the_panel_with_a_name_is_in_the_table() {
    let document = fs::read_to_string(root().join("components/remote/panel/openapi.json")).unwrap();
    let document: Value = serde_json::from_str(&document).unwrap();
    for (path, methods) in document["paths"].as_object().unwrap() {
        let Some((before, behind)) = path.split_once("{name}") else { continue };
        for method in ["get", "put", "post", "delete"].iter().filter(|m| methods.get(**m).is_some())
        {
            let is_known = DOORS.iter().any(|(_, door, _)| {
                matches!(door, Door::Request(m, b, e) if m.eq_ignore_ascii_case(method) && *b == before && *e == behind)
            });
            assert!(is_known, "{method} {path} has no row in the table of names");
        }
    }
    let source =
        fs::read_to_string(root().join("components/remote/panel/src/commands.rs")).unwrap();
    for line in
        source.lines().filter(|line| line.contains("Open(") && line.trim().starts_with("row("))
    {
        let command = line.split('"').nth(1).unwrap();
        let is_known =
            DOORS.iter().any(|(_, door, _)| matches!(door, Door::Command(c) if *c == command));
        assert!(is_known, "the command {command} has no row in the table of names");
    }
    // Files that programs write, by the calls of the interpreter.
    let calls = fs::read_to_string(root().join("components/motion/task/src/convert.rs")).unwrap();
    let opened = calls.matches("FileAction::Open").count();
    assert_eq!(
        opened, 2,
        "another call opens files: LOGOPEN and LOGAPPEND are one, PROBEOPEN is the other"
    );
    let code = fs::read_to_string(root().join("components/motion/job/src/places.rs")).unwrap();
    let code =
        code.split_once("const CODE").unwrap().1.split_once("];").unwrap().0.matches("(\"").count();
    let entries = DOORS.iter().filter(|(_, door, _)| matches!(door, Door::Entry(..)));
    // The output folder holds no code.
    assert_eq!(code, entries.count() - 1, "an entry that names code has its row");
}
