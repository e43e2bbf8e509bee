//! Attacks on the machine's files, as an operator, another user of the computer and a file that came from elsewhere would try
//! them. Each row says what it tries, and whether it had success.

pub(crate) mod list;
mod people;
mod planted;

use super::printer::{Printer, Session};
use hal_tests::{
    scratch::{Scratch, until},
    user::{as_user, is_root},
    web::{self, Socket, encoded},
};
use list::Tries;
use serde_json::{Value, json};
use std::{
    fs,
    os::unix::fs::{PermissionsExt as _, symlink},
    path::Path,
    process::Command,
};

/// A user without rights: `nobody`.
const NOBODY: u32 = 65_534;
/// Text of a file that an attack must neither change nor show.
const KEPT: &str = "kept: secret of the machine's owner\n";
/// A program of a user that says that it has run.
const CODE: &str = "#!/bin/sh\necho ran >> ran.txt\n";

/// A machine that is switched on, its panel, and an operator who has the lease.
struct Stage {
    printer: Printer,
    session: Session,
    socket: Socket,
    tries: Tries,
}

fn mode(path: &Path, mode: u32) {
    fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
}

/// Puts the files into the machine's folder that attacks are after, and traps that a local user or a file could have laid.
fn prepare(scratch: &Scratch) {
    let at = |name: &str| scratch.path().join(name);
    for name in ["programs/uploads", "output", "codes", "open"] {
        fs::create_dir_all(at(name)).unwrap();
    }
    for name in ["people", "programs/owner.ngc", "programs/uploads/run.ngc", "own.tbl"] {
        scratch.write(name, KEPT);
    }
    scratch.write(
        "programs/sub.ngc",
        "o<sub> sub\n(LOGOPEN,owner)\n(LOG,owner)\n(LOGCLOSE)\no<sub> endsub\n",
    );
    mode(&at("programs/uploads/run.ngc"), 0o755);
    for (name, bits) in [
        ("programs/M101", 0o755),
        ("programs/M102", 0o757),
        ("programs/uploads/M103", 0o755),
        ("output/M104", 0o755),
        ("open/M105", 0o755),
    ] {
        scratch.write(name, CODE);
        mode(&at(name), bits);
    }
    mode(&at("open"), 0o777);
    symlink(at("programs/uploads/M103"), at("programs/M106")).unwrap();
    for folder in ["programs/uploads", "output"] {
        symlink(at("people"), at(folder).join("link.ngc")).unwrap();
        symlink(at(""), at(folder).join("folder")).unwrap();
        assert!(
            Command::new("mkfifo").arg(at(folder).join("pipe.ngc")).status().unwrap().success()
        );
        fs::hard_link(at("people"), at(folder).join("hard.ngc")).unwrap();
    }
}

impl Stage {
    fn start() -> Self {
        Self::start_with("")
    }

    /// Starts the machine with further entries of its INI file.
    fn start_with(entries: &str) -> Self {
        let traj = format!("{entries}[TRAJ]\nNO_FORCE_HOMING = 1");
        let edit = |ini: &str| {
            let lines = ini.lines().map(|line| match line.split_once('=') {
                Some((name, _)) if name.trim() == "PROGRAM_PREFIX" => "PROGRAM_PREFIX = programs",
                _ if line == "[RS274NGC]" => "[RS274NGC]\nUSER_M_PATH = codes:open",
                _ if line == "[TRAJ]" => &traj,
                _ => line,
            });
            lines.map(|line| format!("{line}\n")).collect()
        };
        let printer = Printer::edited("operator", &["--virtual", "--hold"], edit, prepare);
        printer.halcmd("run 1s");
        let session = printer.sign_in();
        let mut socket = session.socket();
        assert_eq!(socket.ask(json!({ "type": "lease", "do": "take" }))["ok"], json!({}));
        let mut stage = Self { printer, session, socket, tries: Tries::default() };
        for name in ["estop-reset", "on"] {
            assert_eq!(stage.order(name, &json!({})), "", "{name}");
        }
        stage
    }

    /// Gives a command, and returns the reason of its refusal.
    fn order(&mut self, name: &str, args: &Value) -> String {
        let text = |answer: &Value| answer["error"]["text"].as_str().unwrap_or_default().to_owned();
        let reply = self.socket.ask(json!({ "type": "command", "name": name, "args": args }));
        if reply["pending"] == true {
            self.printer.halcmd("run 2s");
            let done = self.socket.wait(|m| m["type"] == "done" && m["id"] == reply["id"]);
            return text(&done.unwrap());
        }
        text(&reply)
    }

    /// Executes lines of MDI, and returns the reasons of refusals.
    fn mdi(&mut self, lines: &[&str]) -> String {
        assert_eq!(self.order("mode", &json!({ "mode": "mdi" })), "");
        let said = lines.iter().map(|line| self.order("mdi", &json!({ "text": line })));
        said.collect::<Vec<_>>().join(" ")
    }

    fn request(&self, method: &str, path: &str, body: &str) -> web::Answer {
        let path = format!("/api/v1{path}");
        self.printer.request(method, &path, &self.session.headers(), body.as_bytes())
    }

    fn at(&self, name: &str) -> std::path::PathBuf {
        self.printer.scratch.path().join(name)
    }

    fn has_run(&self) -> bool {
        self.at("ran.txt").exists()
    }

    /// Notes an attack; one that has `success`, or is not refused in words with `why`, is a breach.
    fn note(&mut self, attack: &str, success: bool, said: &str, why: &str) {
        let files = ["people", "programs/owner.ngc", "programs/uploads/run.ngc", "own.tbl"];
        let changed: Vec<_> = files
            .iter()
            .filter(|name| fs::read_to_string(self.at(name)).ok().as_deref() != Some(KEPT))
            .collect();
        let ran = self.has_run();
        let is_breach = success || !changed.is_empty() || !said.contains(why) || ran;
        let what = format!("success {success}, changed {changed:?}, ran {ran}: {said}");
        if self.tries.note(attack, is_breach, &what) {
            files.iter().for_each(|name| fs::write(self.at(name), KEPT).unwrap());
            // The next attack is judged by what it does itself.
            for made in ["ran.txt", "accounts", ".private/people", "output/evil"] {
                drop(fs::remove_file(self.at(made)));
            }
        }
    }
}

#[test]
fn attacks_on_the_machines_files_have_no_success() {
    let mut s = Stage::start();
    let whole = |s: &Stage, name: &str| s.at(name).display().to_string();

    // An operator, by G-code.
    let said = s.mdi(&["(LOGOPEN,accounts)", "(LOG,NAME integrator $argon2id$)", "(LOGCLOSE)"]);
    let wrote = |name: &str| fs::read_to_string(s.at(name)).is_ok_and(|t| t.starts_with("NAME"));
    let (is_account, is_output) = (wrote("accounts"), wrote("output/accounts"));
    s.note("operator: an account by (LOGOPEN,accounts)", is_account || !is_output, &said, "");
    let account = whole(&s, ".private/people");
    let label = whole(&s, "programs/uploads/evil.ngc");
    let evil =
        format!("o<{label}> sub\n(LOGOPEN,evil)\n(LOG,evil)\n(LOGCLOSE)\no<{label}> endsub\n");
    for (attack, line, why) in [
        ("a log at an absolute name", format!("(LOGOPEN,{account})"), "the name is absolute"),
        ("a log over the INI file", "(LOGOPEN,../machine.ini)".to_owned(), "'..'"),
        ("a log behind the tool table", "(LOGAPPEND,../own.tbl)".to_owned(), "'..'"),
        (
            "points of a probe in another folder",
            "(PROBEOPEN ../programs/owner.ngc)".to_owned(),
            "'..'",
        ),
        ("a log through a link", "(LOGOPEN,link.ngc)".to_owned(), "symbolic link"),
        ("a log in a linked folder", "(LOGOPEN,folder/people)".to_owned(), "symbolic link"),
        ("a log behind a hard link", "(LOGAPPEND,hard.ngc)".to_owned(), "names (hard links)"),
        ("a log over a program that runs", "(LOGOPEN,M104)".to_owned(), "executable"),
        (
            "a subroutine of the uploads by its path",
            format!("o<{}> call", whole(&s, "programs/uploads/evil.ngc")),
            "evil",
        ),
    ] {
        s.printer.scratch.write("programs/uploads/evil.ngc", &evil);
        let said = s.mdi(&[&line, "(LOG,mischief)", "(LOGCLOSE)"]);
        let success = s.at(".private/people").exists() || s.at("output/evil").exists();
        s.note(&format!("operator: {attack}"), success, &said, why);
    }

    // An operator, by uploads.
    for (attack, name, why) in [
        ("PUT of M101 over an executable", "M101", "is no name of a program"),
        ("PUT of a module in Python", "remap.py", "is no name of a program"),
        ("PUT into another folder", "uploads/../owner.ngc", "is no name of a program"),
        ("PUT over a program of the machine", "owner.ngc", "is a program of the machine"),
        ("PUT over an executable upload", "run.ngc", "executable"),
        ("PUT over a link", "link.ngc", "symbolic link"),
        ("PUT over a hard link", "hard.ngc", "names (hard links)"),
        ("PUT of a name in another form", "M\u{ff11}\u{ff10}\u{ff11}.ngc", "another form"),
    ] {
        let path = format!("/programs/{}", encoded(name).replace('/', "%2F"));
        let answer = s.request("PUT", &path, CODE);
        let said = answer.json()["error"]["text"].as_str().unwrap_or_default().to_owned();
        let is_code = fs::read_to_string(s.at("programs/M101")).unwrap() == CODE;
        s.note(&format!("operator: {attack}"), answer.status == 200 || !is_code, &said, why);
    }
    assert_eq!(
        s.request(
            "PUT",
            "/programs/uploads%2Fsub.ngc",
            "o<sub> sub\n(LOGOPEN,sent)\n(LOG,sent)\no<sub> endsub\n"
        )
        .status,
        200
    );
    let said = s.mdi(&["o<sub> call"]);
    let success = s.at("output/sent").exists() || !s.at("output/owner").exists();
    s.note("operator: an upload in the place of a subroutine", success, &said, "");
    let answer = s.request("DELETE", "/programs/owner.ngc", "");
    let said = String::from_utf8_lossy(&answer.body).into_owned();
    s.note(
        "operator: DELETE of a program of the machine",
        answer.status == 200,
        &said,
        "is a program of the machine",
    );
    for name in ["../machine.ini", "/etc/hostname", "link.ngc", "folder/people", "hard.ngc"] {
        let answer =
            s.request("GET", &format!("/output/{}", encoded(name).replace('/', "%2F")), "");
        s.note(&format!("operator: download of {name}"), answer.status == 200, "", "");
    }
    for name in ["link.ngc", "uploads/link.ngc", "uploads/hard.ngc"] {
        let answer =
            s.request("GET", &format!("/programs/{}", encoded(name).replace('/', "%2F")), "");
        s.note(&format!("another user: a secret by {name}"), answer.status == 200, "", "");
        let said = s.order("open", &json!({ "program": name }));
        s.note(&format!("another user: {name} as a program"), said.is_empty(), &said, "");
    }

    // A file that waits for a writer, and would for ever.
    let said = s.order("open", &json!({ "program": "uploads/pipe.ngc" }));
    s.note("file: a pipe among the uploads as a program", said.is_empty(), &said, "");

    // Programs of users that somebody else could have written.
    for (code, attack, why) in [
        (102, "another user: an M102 that everybody may write", "other users may write it"),
        (103, "file: an M103 among the uploads", "Unknown m code"),
        (104, "file: an M104 in the output folder", "Unknown m code"),
        (
            105,
            "another user: an M105 in a folder that everybody may write",
            "other users may write it",
        ),
        (106, "file: an M106 that is a link to an upload", "symbolic link"),
    ] {
        let said = s.mdi(&[&format!("M{code}")]);
        s.note(attack, false, &said, why);
    }
    // The owner's own program runs.
    let said = s.mdi(&["M101"]);
    let runs = said.is_empty() && s.has_run();
    let of_own = said;
    drop(fs::remove_file(s.at("ran.txt")));

    // Another user of the computer, with the rights of a user.
    if is_root() {
        let folder = s.printer.scratch.path().to_owned();
        let reached = as_user(NOBODY, || {
            let files = [".run/ferrule", ".private", ".private/audit", "address"];
            let reads = files.map(|name| {
                fs::read_dir(folder.join(name)).is_ok() || fs::read(folder.join(name)).is_ok()
            });
            let writes =
                ["programs/uploads/x.ngc", "output/x.txt", ".private/people", ".run/ferrule/x"];
            let writes = writes.map(|name| fs::write(folder.join(name), "x").is_ok());
            reads.into_iter().chain(writes).any(|reached| reached)
        });
        s.note("another user: files of the panel and the socket", reached, "", "");
    }

    // Programs of jobs.
    s.printer.scratch.write("programs/calls.ngc", "o<call> call\nM2\n");
    s.printer.scratch.write(
        "programs/uploads/call.ngc",
        "o<call> sub\n(LOGOPEN,called)\n(LOG,x)\n(LOGCLOSE)\no<call> endsub\n",
    );
    assert_eq!(s.order("mode", &json!({ "mode": "auto" })), "");
    assert_eq!(s.order("open", &json!({ "program": "calls.ngc" })), "");
    let said = s.order("run", &json!({}));
    let success = s.at("output/called").exists();
    s.note("file: a program that calls an upload", success, &said, "");
    s.printer.scratch.write("programs/job.ngc", format!("G21\n(LOGOPEN,{account})\n(LOG,x)\nM2\n"));
    assert_eq!(s.order("mode", &json!({ "mode": "auto" })), "");
    assert_eq!(s.order("open", &json!({ "program": "job.ngc" })), "");
    let said = s.order("run", &json!({}));
    let success = s.at(".private/people").exists();
    s.note("file: a program with a log over the accounts", success, &said, "the name is absolute");

    s.tries.finish("panel::attacks::attacks_on_the_machines_files_have_no_success");
    assert!(runs, "the owner's own M101 does not run: {of_own}");
}

#[test]
fn a_machine_whose_files_mix_code_and_output_does_not_start() {
    let scratch = Scratch::copy_of(&hal_tests::programs::root().join("configs/printer"));
    let ini = scratch.read("printer.ini");
    fs::create_dir_all(scratch.path().join("nc/uploads")).unwrap();
    symlink("nc/uploads", scratch.path().join("link")).unwrap();
    let mut tries = Tries::default();
    for (entries, why) in [
        ("USER_M_PATH = nc/uploads", "[RS274NGC]USER_M_PATH 'nc/uploads': it must be outside"),
        (
            "SUBROUTINE_PATH = subs:link",
            "[RS274NGC]SUBROUTINE_PATH 'subs:link': it must be outside",
        ),
        ("OUTPUT_DIR = .", "[RS274NGC]OUTPUT_DIR '.': it must be a folder for output alone"),
        ("OUTPUT_DIR = nc/uploads", "[RS274NGC]OUTPUT_DIR 'nc/uploads': it must be a folder"),
    ] {
        let attack = format!("file: an INI file with {entries}");
        let entries = format!("[RS274NGC]\n{entries}\n");
        let text =
            ini.replace("PROGRAM_PREFIX = /home/carlos/linuxcnc/nc_files", "PROGRAM_PREFIX = nc");
        scratch.write("bad.ini", text.replace("[RS274NGC]\n", &entries));
        let output = scratch.halrun(&["--virtual", "--for", "1ms", "--headless", "bad.ini"]);
        let is_refused = output.status != Some(0)
            && output.stderr.contains(why)
            && output.stderr.contains("bad.ini:");
        tries.note(&attack, !is_refused, &output.stderr);
    }
    // A filter among the uploads is not run.
    scratch.write("nc/uploads/filter", CODE);
    mode(&scratch.path().join("nc/uploads/filter"), 0o755);
    scratch.write("a.png", "");
    let text =
        ini.replace("PROGRAM_PREFIX = /home/carlos/linuxcnc/nc_files", "PROGRAM_PREFIX = nc");
    scratch.write("bad.ini", text.replace("png = image-to-gcode", "png = link/filter"));
    let mut command = scratch.command(&[], "halgcode");
    let output = scratch.run(command.args(["check", "-i", "bad.ini", "a.png"]));
    let is_refused =
        output.stderr.contains("in a folder of uploads or output, where nothing is run");
    let ran = scratch.path().join("ran.txt").exists();
    tries.note("file: a filter among the uploads", !is_refused || ran, &output.stderr);
    tries.finish("panel::attacks::a_machine_whose_files_mix_code_and_output_does_not_start");
}

/// A program of the machine's owner that sets a pin of motion, and says at its end that it has.
const SETS: &str = "#!/bin/sh\n'HALCMD' setp motion.digital-in-00 $(printf %.0f $1) 2> said.txt\ncode=$?\n\
                    touch done.txt\nexit $code\n";

impl Stage {
    /// Executes M120 with this value, from afar or at the machine; returns why it failed, and the value of the pin then.
    fn set(&mut self, value: u32, from_afar: bool) -> (String, String) {
        let text = format!("M120 P{value} Q0");
        drop(fs::remove_file(self.at("done.txt")));
        let mut id = Value::Null;
        if from_afar {
            let args = json!({ "text": text });
            let mdi = json!({ "type": "command", "name": "mdi", "args": args });
            let reply = self.socket.ask(mdi);
            assert_eq!(reply["pending"], true, "{reply}");
            id = reply["id"].clone();
        } else {
            let mut halcmd = self.printer.scratch.command(&[], "halcmd");
            let output =
                self.printer.scratch.run(halcmd.arg("task.mdi").arg(format!("text={text}")));
            assert_eq!(output.status, Some(0), "{output:?}");
        }
        until("M120 has ended", || {
            self.printer.halcmd("run 100ms");
            self.at("done.txt").exists()
        });
        let jobs = || self.printer.halcmd("task.status").contains("interpreter=idle");
        until("the line has ended", || {
            self.printer.halcmd("run 100ms");
            jobs()
        });
        let why = match from_afar {
            true => {
                let done = self.socket.wait(|m| m["type"] == "done" && m["id"] == id).unwrap();
                done["error"]["text"].as_str().unwrap_or_default().to_owned()
            }
            false => String::new(),
        };
        (why, self.printer.halcmd("getp motion.digital-in-00").trim().to_owned())
    }
}

#[test]
fn the_owners_programs_have_the_rights_of_who_has_begun_the_job() {
    for (entries, is_limited) in [
        ("", false),
        ("[REMOTE]\nUSER_CODES = limited\n", true),
        ("[REMOTE]\nUSER_CODES = full\n", false),
    ] {
        let mut s = Stage::start_with(entries);
        let halcmd = s.printer.scratch.command(&[], "halcmd").get_program().to_owned();
        let text = SETS.replace("HALCMD", halcmd.to_str().unwrap());
        s.printer.scratch.write("codes/M120", text);
        mode(&s.at("codes/M120"), 0o755);
        assert_eq!(s.order("mode", &json!({ "mode": "mdi" })), "");
        // At the machine it may.
        assert_eq!(s.set(1, false).1, "TRUE", "{entries}");
        let (why, value) = s.set(0, true);
        let said = s.printer.scratch.read("said.txt");
        if is_limited {
            assert!(
                why.contains("M120 ended with exit status") && why.contains("USER_CODES"),
                "{why}"
            );
            assert!(said.contains("it is not changed from afar"), "{said}");
            assert_eq!(value, "TRUE");
        } else {
            assert_eq!((&*why, &*said, &*value), ("", "", "FALSE"));
        }
    }
}
