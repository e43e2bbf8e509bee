//! Files that cannot be used, disks that are full, and engines that end: the page says so, and nothing is half done.

use super::{fixture::Fixture, printer::Printer};
use hal_tests::{
    browser::{Browser, DESKTOP},
    scratch::until,
    tools::Tool,
    web,
};
use serde_json::json;
use std::{
    fs,
    process::{Command, Stdio},
};

/// A program that fits nowhere: 300 kB.
fn long() -> String {
    "G1 X1 F100\n".repeat(30_000)
}

/// Mounts a small disk at a folder, which ends with this.
struct SmallDisk(std::path::PathBuf);

impl SmallDisk {
    /// Mounts it; reports the running test as skipped where this user may not.
    fn mount(folder: std::path::PathBuf) -> Option<Self> {
        let mut mount = Command::new("mount");
        mount.args(["-t", "tmpfs", "-o", "size=64k", "none"]).arg(&folder).stderr(Stdio::null());
        let mounted = mount.status().is_ok_and(|status| status.success());
        Tool::of("unshare").or_skip(mounted.then_some(Self(folder)))
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        // The folder is the test's own.
        drop(Command::new("umount").arg("-l").arg(&self.0).status());
    }
}

#[test]
fn a_full_disk_keeps_the_program_as_it_was() {
    let printer = Printer::start("operator");
    let folder = printer.scratch.path().join("programs");
    let Some(disk) = SmallDisk::mount(folder.clone()) else { return };
    let good = printer.sign_in().headers();
    let path = "/api/v1/programs/a.ngc";
    assert_eq!(printer.request("PUT", path, &good, b"G0 X1\nM2\n").status, 200);
    let answer = printer.request("PUT", path, &good, long().as_bytes());
    assert_eq!((answer.status, answer.code()), (507, "disk".to_owned()), "{answer:?}");
    assert_eq!(printer.request("GET", path, &good, b"").body, b"G0 X1\nM2\n");
    let left = fs::read_dir(folder.join("uploads")).unwrap().count();
    assert_eq!(left, 1, "the part that was written is left");
    drop(disk);
}

#[test]
fn what_is_no_program_is_told_and_moves_nothing() {
    let printer = Printer::start("operator");
    let session = printer.sign_in();
    let good = session.headers();
    let picture: Vec<u8> = (0..=255).cycle().take(5000).collect();
    let put = |name: &str, bytes: &[u8]| {
        printer.request("PUT", &format!("/api/v1/programs/{name}"), &good, bytes)
    };
    // A file is stored as it is; the reason why it is no program is reported with the line.
    assert_eq!(put("picture.nc", &picture).status, 200);
    assert_eq!(put("half.ngc", b"G21\nG1 X1\nG1 X[\n").status, 200);
    for (name, line) in [("picture.nc", ""), ("half.ngc", "2 ")] {
        let path = format!("/api/v1/programs/{name}/path");
        let answer = printer.request("GET", &path, &good, b"");
        let told = answer.header("x-ferrule-error").unwrap_or_default().to_owned();
        let refused = answer.status == 422 || told.starts_with(&line.replace(' ', "%20"));
        assert!(refused && (answer.status == 422 || !told.is_empty()), "{name}: {answer:?}");
    }
    for name in [".hidden", "a/b", "..", "a%2Fb", "\u{7f}", &"n".repeat(201)] {
        let answer = put(&web::encoded(name), b"M2\n");
        assert!([400, 404, 405].contains(&answer.status), "{name}: {answer:?}");
    }
    let files = fs::read_dir(printer.scratch.path().join("programs/uploads")).unwrap().count();
    assert_eq!(files, 2);
    assert_eq!(printer.number("getp joint.0.pos-cmd"), 0.0);
}

#[test]
fn the_page_tells_of_uploads_that_fail_and_of_an_engine_that_ends() {
    let Some(mut fixture) = Fixture::start(DESKTOP) else { return };
    let folder = fixture.printer.scratch.path().join("programs");
    let b = &fixture.browser;
    let disk = SmallDisk::mount(folder);
    if disk.is_some() {
        fixture.printer.scratch.write("long.ngc", long());
        b.fill("#upload", fixture.printer.scratch.path().join("long.ngc").to_str().unwrap());
        b.until("[...document.querySelectorAll('.toast[data-level=error], #messages [data-level=error]')].some((m) => /space|disk|device/i.test(m.textContent))");
        b.until("!document.querySelector('.files .plain')");
        fixture.picture("trouble-disk");
    }
    drop(disk);
    fixture.printer.end_machine();
    let b = &fixture.browser;
    b.until("/engine has ended/i.test(document.body.textContent)");
    // The page stays usable: its other face opens, and its buttons that move something do nothing.
    b.run("document.querySelector('[data-page=integrate]').click()");
    b.until("document.querySelector('#tree')");
    b.run("document.querySelector('[data-page=operate]').click()");
    b.until("document.querySelector('#estop-reset').disabled || document.querySelector('#estop-reset').getAttribute('aria-disabled') === 'true'");
    fixture.picture("trouble-engine");
    assert_eq!(b.errors(), Vec::<String>::new());
}

#[test]
fn an_engine_that_is_started_again_is_joined_only_by_a_new_panel() {
    let mut printer = Printer::start("operator");
    let session = printer.sign_in();
    let mut socket = session.socket();
    printer.end_machine();
    socket.wait(|m| m["panel"]["engine"] == "gone").unwrap();
    printer.start_machine();
    // The panel that is there does not join by itself, and refuses by name.
    for _ in 0..20 {
        assert_eq!(socket.command("abort", &json!({})), "no-engine");
    }
    let answer = printer.request("GET", "/api/v1/pins", &session.headers(), b"");
    assert_eq!((answer.status, answer.code()), (503, "no-engine".to_owned()));
    printer.restart("operator", &[]);
    let mut next = printer.sign_in().socket();
    assert_eq!(next.command("abort", &json!({})), "");
    until("the machine is as it was started", || {
        printer.halcmd("getp motion.motion-enabled").trim() == "FALSE"
    });
}

#[test]
fn a_part_of_the_page_that_does_not_arrive_is_loaded_again() {
    if !Browser::is_there() {
        return;
    }
    let printer = Printer::start("operator");
    let b = Browser::open(&printer.scratch, DESKTOP);
    let again = "/it is loaded again/.test(document.body.textContent)";
    // What the page asks for may be lost too: it goes on asking.
    let asks = "document.querySelector('.sign-in [role=status]')";
    for (lost, shown) in [
        ("*/src/operator/overrides.js", again),
        ("*/style/base.css", again),
        ("*/src/main.js", again),
        ("*/api/v1/session", asks),
    ] {
        b.block(&[lost]);
        b.go("about:blank");
        b.go(&printer.address());
        b.until(shown);
        b.block(&[]);
        b.until("document.querySelector('#machine-state')?.textContent");
    }
}

#[test]
fn a_page_that_is_left_gives_up_its_lease() {
    if !Browser::is_there() {
        return;
    }
    // The machine's time stands, so that the lease does not end by itself.
    let printer = Printer::with("integrator", &["--virtual", "--hold"], "");
    printer.halcmd("run 1s");
    let b = Browser::open(&printer.scratch, DESKTOP);
    b.go(&printer.address());
    b.until("document.querySelector('#lease-holder')?.textContent === 'nobody has control'");
    b.click("#lease");
    b.until("document.querySelector('#lease').getAttribute('aria-pressed') === 'true'");
    b.go("about:blank");
    let mut other = printer.sign_in().socket();
    let mut ask = |what: &str| other.ask(json!({ "type": "lease", "do": what }))["error"].is_null();
    until("another client may take the lease", || ask("take"));
    assert!(ask("give"));
    // The page that the browser has kept is a new client.
    b.run("history.back()");
    b.until("document.querySelector('#lease-holder')?.textContent === 'nobody has control'");
}
