//! Passwords, and what is refused before anything listens.

use super::{attacks::list::Tries, printer::Printer};
use hal_tests::{
    user::{as_user, is_root},
    web,
};
use serde_json::json;
use std::{
    fs::{self, File},
    os::unix::fs::PermissionsExt as _,
};

/// A user without rights: `nobody`.
const NOBODY: u32 = 65_534;

/// Adds an account to the file `people`, which nobody else reaches.
pub(super) fn add(printer: &Printer, account: &str, password: &str) {
    let scratch = &printer.scratch;
    scratch.write("password", format!("{password}\n"));
    let mut command = scratch.command(&[], "halpanel");
    command.args(["--accounts", &scratch.private("people"), "--add-account", account]);
    command.stdin(File::open(scratch.path().join("password")).unwrap());
    let output = scratch.run(&mut command);
    assert_eq!((output.status, &*output.stderr), (Some(0), ""), "{account}");
}

#[test]
fn a_person_signs_in_with_a_password_and_has_the_role_of_the_account() {
    let mut printer = Printer::start("viewer");
    add(&printer, "ana=operator", "correct horse");
    add(&printer, "eva=integrator", "battery staple");
    let people = printer.scratch.read(".private/people");
    assert!(!people.contains("horse") && people.lines().count() == 2, "{people}");
    printer.restart("viewer", &["--accounts", ".private/people"]);
    let sign_in = |user: &str, password: &str| {
        let body = json!({ "user": user, "password": password }).to_string();
        printer.request("POST", "/api/v1/session", &printer.host(), body.as_bytes())
    };
    for (user, password, role) in [
        ("ana", "correct horse", "operator"),
        ("eva", "battery staple", "integrator"),
        ("ana", "battery staple", ""),
        ("nobody", "correct horse", ""),
        ("", "", ""),
    ] {
        let answer = sign_in(user, password);
        let wanted = if role.is_empty() { (401, "wrong-login") } else { (200, "") };
        assert_eq!((answer.status, &*answer.code()), wanted, "{user} {password}");
        assert_eq!(answer.json()["role"].as_str().unwrap_or_default(), role);
    }
    // The token opens a session as before, with the role of the option.
    let by_token = printer.sign_in();
    let who = printer.request("GET", "/api/v1/session", &by_token.headers(), b"");
    assert_eq!(who.json(), json!({ "role": "viewer", "user": "local" }));
    let audit = printer.scratch.read(".private/audit");
    assert!(audit.contains(r#""user":"ana""#) && audit.contains("wrong-login"), "{audit}");
    assert!(!audit.contains("horse"), "{audit}");
}

#[test]
fn what_does_not_fit_is_refused_before_anything_listens() {
    let mut printer = Printer::start("viewer");
    add(&printer, "ana=operator", "correct horse");
    let scratch = &printer.scratch;
    scratch.write(".private/damaged", "ana operator\n");
    scratch.write(".private/open", scratch.read(".private/people"));
    scratch.write(".private/bad.pem", "no certificate\n");
    scratch.write("people", scratch.read(".private/people"));
    let mode = |name: &str, mode| {
        fs::set_permissions(scratch.path().join(name), fs::Permissions::from_mode(mode)).unwrap();
    };
    mode(".private/damaged", 0o600);
    mode(".private/open", 0o644);
    mode(".private/bad.pem", 0o600);
    mode("people", 0o600);
    let taken = format!("--listen 127.0.0.1:{}", printer.port);
    for (options, why) in [
        (&*taken, "in use"),
        ("--listen 192.0.2.1:7776", "is a network address: it needs --accounts and --certificate"),
        (
            "--listen 0.0.0.0:0 --accounts .private/people --certificate .private/new.pem",
            "--name states",
        ),
        ("--accounts .private/damaged", "damaged:1: this is no account, must be NAME ROLE HASH"),
        ("--accounts .private/open", "open: others than its owner may use it: chmod 600"),
        ("--accounts .private/nothing", "nothing: "),
        ("--certificate .private/bad.pem", "bad.pem: it has no certificate"),
        ("--instance nobody", "nobody"),
        ("--ini-file nothing.ini", "nothing.ini"),
        ("--add-account ana=king --accounts .private/people", "the role is 'king'"),
        // A file that lies beside the machine's is neither used nor moved: who has written it?
        ("--accounts ./people --ini-file machine.ini", "people: the file of accounts lies beside"),
        ("--accounts people", "people: the file of accounts lies beside"),
        ("--audit ./audit --ini-file machine.ini", "audit: the audit log lies beside"),
        ("--certificate programs/a.pem", "others can reach the folder of the file with the key"),
    ] {
        let mut command = scratch.command(&[], "halpanel");
        let output = scratch.run(command.args(options.split(' ')));
        assert_eq!((output.status, &*output.stdout), (Some(1), ""), "{options}: {output:?}");
        assert!(output.stderr.contains(why), "{options}: {}", output.stderr);
    }
    // The panel that listens goes on.
    assert_eq!(printer.sign_in().socket().command("abort", &json!({})), "");
    // With a certificate it speaks TLS alone, and says which one.
    printer.restart("viewer", &["--certificate", ".private/own.pem"]);
    assert!(printer.address().starts_with("https://127.0.0.1:"), "{}", printer.address());
    assert_eq!(printer.request("GET", "/", &printer.host(), b"").status, 0);
    assert!(printer.said().contains("SHA-256 fingerprint"), "{}", printer.said());
    let pem = fs::metadata(printer.scratch.path().join(".private/own.pem")).unwrap();
    assert_eq!(pem.permissions().mode() & 0o777, 0o600);
}

/// Tries to sign in; returns the code of the refusal and the cookies.
pub(super) fn tries(
    printer: &Printer,
    cookie: &str,
    user: &str,
    password: &str,
) -> (String, Vec<String>) {
    let headers = format!("{}Cookie: {cookie}\r\n", printer.host());
    let body = json!({ "user": user, "password": password }).to_string();
    let answer = printer.request("POST", "/api/v1/session", &headers, body.as_bytes());
    let cookies = answer.head.lines().filter_map(|line| line.strip_prefix("set-cookie: "));
    let cookies = cookies.filter_map(|line| line.split_once(';')).map(|(cookie, _)| cookie);
    (answer.code(), cookies.map(str::to_owned).collect())
}

#[test]
fn guesses_of_strangers_keep_no_person_out() {
    let mut printer = Printer::start("viewer");
    add(&printer, "ana=operator", "correct horse");
    add(&printer, "eva=viewer", "battery staple");
    printer.restart("viewer", &["--accounts", ".private/people"]);
    let (code, cookies) = tries(&printer, "", "ana", "correct horse");
    assert_eq!(code, "");
    let mut devices = cookies.iter().filter_map(|cookie| cookie.strip_prefix("ferrule-device-"));
    let (_, device) = devices.next_back().unwrap().split_once('=').unwrap();
    // Each start of this panel has another port, which the name of the cookie has.
    let device = |printer: &Printer| format!("ferrule-device-{}={device}", printer.port);
    // The same user of this computer guesses: five are tried, and then not even the right password is.
    let codes: Vec<_> = (0..30).map(|_| tries(&printer, "", "ana", "a guess too few").0).collect();
    assert!(codes[..5].iter().all(|code| code == "wrong-login"), "{codes:?}");
    let refused = codes[5..].iter().filter(|code| *code == "too-many").count();
    assert!(refused >= 15, "{codes:?}");
    // A browser that has signed in before does not wait, and is known after a restart of the panel.
    assert_eq!(tries(&printer, &device(&printer), "ana", "correct horse").0, "");
    printer.restart("viewer", &["--accounts", ".private/people"]);
    while tries(&printer, "", "ana", "a guess too few").0 != "too-many" {}
    assert_eq!(tries(&printer, &device(&printer), "ana", "correct horse").0, "");
    // It is known to its account alone, and its guesses are its own.
    assert_eq!(tries(&printer, &device(&printer), "eva", "battery staple").0, "too-many");
    while tries(&printer, &device(&printer), "ana", "a guess too few").0 != "too-many" {}
    // People who have signed in go on, and the token is for those who may read its file.
    assert_eq!(printer.sign_in().socket().command("estop", &json!({})), "");
    if is_root() {
        // Another user of this computer, whose address is the same, keeps nobody out, and is not kept out.
        printer.restart("viewer", &["--accounts", ".private/people"]);
        let (port, host) = (printer.port, printer.host());
        let ask = |password: &str| {
            let body = json!({ "user": "ana", "password": password }).to_string();
            web::request(port, "POST", "/api/v1/session", &host, body.as_bytes()).code()
        };
        as_user(NOBODY, || while ask("a guess too few") != "too-many" {});
        let said = ask("correct horse");
        let mut tries = Tries::default();
        tries.note("another user: guesses that keep an operator out", !said.is_empty(), &said);
        tries.finish("panel::accounts::guesses_of_strangers_keep_no_person_out");
    }
}
