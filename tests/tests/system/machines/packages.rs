//! Packages: units of systemd, pages and completions made from --help, and the list of what is linked. `halcmd/package/test`
//! builds, installs, upgrades and removes the packages.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use hal_tests::{
    programs::{programs, root},
    scratch::Scratch,
    tools::{self, Tool},
};
use std::{
    collections::BTreeSet,
    fs,
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
    process::Command,
};

const SYSTEMD: Tool =
    Tool { name: "systemd-analyze", what: "systemd-analyze", remedy: "apt-get install systemd" };
const PERL: Tool = Tool { name: "perl", what: "perl", remedy: "apt-get install perl" };
const MANDOC: Tool = Tool { name: "mandoc", what: "mandoc", remedy: "apt-get install mandoc" };

fn package(file: &str) -> PathBuf {
    root().join("halcmd/package").join(file)
}

/// Returns what a command prints on both outputs, and whether it succeeded.
fn said(command: &mut Command) -> (bool, String) {
    let output = command.output().unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.success(), String::from_utf8_lossy(&text).into_owned())
}

fn finds(tool: Tool) -> bool {
    let found = Command::new(tool.name).arg("--version").output();
    let found = found.is_ok_and(|o| o.status.success() || tool.name == MANDOC.name);
    tool.or_skip(found.then_some(())).is_some()
}

/// The lines of a unit, without comments.
fn unit(name: &str) -> Vec<String> {
    let text = fs::read_to_string(package(&format!("system/{name}"))).unwrap();
    text.lines().filter(|l| !l.starts_with('#')).map(str::to_owned).collect()
}

#[test]
fn a_machine_that_failed_is_not_started_again_and_no_unit_is_root() {
    let has = |unit: &[String], line: &str| unit.iter().any(|l| l == line);
    let machine = unit("ferrule@.service");
    for line in
        ["Type=notify", "Restart=no", "User=ferrule", "WatchdogSignal=SIGTERM", "KillMode=mixed"]
    {
        assert!(has(&machine, line), "ferrule@.service lacks {line}");
    }
    // A notification of another process of the machine counts for nothing.
    assert!(has(&machine, "NotifyAccess=main"));
    let panel = unit("ferrule-panel@.service");
    for line in ["User=ferrule-panel", "Group=ferrule", "CapabilityBoundingSet="] {
        assert!(has(&panel, line), "ferrule-panel@.service lacks {line}");
    }
    // Starting a panel starts no machine.
    assert!(panel.iter().all(|l| !l.starts_with("Requires=") && !l.starts_with("BindsTo=")));
}

#[test]
fn units_are_verified_and_exposed_below_five() {
    if !finds(SYSTEMD) {
        return;
    }
    let scratch = Scratch::new("units");
    for name in ["ferrule@", "ferrule-panel@"] {
        // The programs and pages are not installed here.
        let lines = unit(&format!("{name}.service")).into_iter().filter_map(|line| {
            let (key, value) = line.split_once('=').unwrap_or((&line, ""));
            match key {
                "Documentation" => None,
                _ if value.starts_with("@BIN@/") => Some(format!("{key}=/bin/true")),
                _ => Some(line),
            }
        });
        scratch.write(&format!("{name}.service"), lines.collect::<Vec<_>>().join("\n") + "\n");
    }
    let mut verify = Command::new("systemd-analyze");
    verify.args(["verify", "./ferrule@mill.service", "./ferrule-panel@mill.service"]);
    let (is_clean, text) = said(verify.current_dir(scratch.path()));
    assert!(is_clean && text.is_empty(), "{text}");
    for name in ["ferrule@", "ferrule-panel@"] {
        let mut security = Command::new("systemd-analyze");
        security.args(["security", "--offline=true", "--threshold=50", "--no-pager"]);
        let file = format!("./{name}.service");
        let (is_below, text) = said(security.arg(file).current_dir(scratch.path()));
        assert!(is_below && text.contains("Overall exposure level"), "{text}");
    }
}

/// Returns the programs under test.
fn all_programs() -> Vec<String> {
    let mut found = Vec::new();
    for entry in fs::read_dir(programs()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let mode = fs::metadata(&path).unwrap().permissions().mode();
        if path.is_file() && !name.contains('.') && mode & 0o100 != 0 {
            found.push(name);
        }
    }
    found.sort();
    found
}

fn from_help(what: &str, program: &str) -> String {
    let mut command = Command::new(package("from-help"));
    let output = command.arg(what).arg(programs().join(program)).output().unwrap();
    assert!(output.status.success(), "{program}: {}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty(), "{program}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// `halshow` is a program of Tcl that needs a window, and the page of `halcmd` is made from its table of commands.
#[test]
fn every_program_has_a_page_made_from_its_help() {
    if !finds(PERL) {
        return;
    }
    let lint = finds(MANDOC);
    let scratch = Scratch::new("pages");
    let all = all_programs();
    assert!(all.len() > 15, "{all:?}");
    for program in all.iter().filter(|p| *p != "halshow") {
        let page = from_help("man", program);
        let name = format!(".SH NAME\n{} \\- ", program.replace('-', "\\-"));
        assert!(page.contains(&name), "{program}: {page}");
        assert!(
            page.contains(".SH SYNOPSIS\n") && page.contains("\\-\\-help"),
            "{program}: {page}"
        );
        scratch.write(program, page);
        if lint {
            let mut mandoc = Command::new("mandoc");
            mandoc.args(["-T", "lint", "-W", "warning", program]).current_dir(scratch.path());
            let (_, text) = said(&mut mandoc);
            let wrong: Vec<&str> = text.lines().filter(|l| !l.contains("missing date")).collect();
            assert!(wrong.is_empty(), "{wrong:?}");
        }
    }
}

#[test]
fn bash_completes_commands_and_options() {
    if !finds(PERL) {
        return;
    }
    let scratch = Scratch::new("bash");
    let complete = |program: &str, words: &[&str]| -> String {
        scratch.write(program, from_help("bash", program));
        let list = words.iter().map(|w| format!("'{w}'")).collect::<Vec<_>>().join(" ");
        let script = format!(
            "compopt() {{ :; }}; source ./{program}; f=$(complete -p {program}); f=${{f#*-F }}; f=${{f%% *}}; \
             COMP_WORDS=({list}); COMP_CWORD={}; $f; echo \"${{COMPREPLY[*]}}\"",
            words.len() - 1
        );
        let (_, text) =
            said(Command::new("bash").args(["-c", &script]).current_dir(scratch.path()));
        text.trim().to_owned()
    };
    assert_eq!(complete("ferrule", &["ferrule", "st"]), "start status stop");
    assert_eq!(complete("ferrule", &["ferrule", "start", "--s"]), "--simulate --stub");
    assert_eq!(complete("ferrule", &["ferrule", "doctor", "-"]), "--fix -h --help");
    assert_eq!(complete("halpanel", &["halpanel", "--acc"]), "--accounts");
    assert_eq!(complete("halcompile", &["halcompile", "--ins"]), "--install --install-doc");
    // A file is the shell's own.
    assert_eq!(complete("ferrule", &["ferrule", "start", "m"]), "");
}

/// Returns names and versions of the packages that the list has.
fn listed() -> Option<BTreeSet<(String, String)>> {
    finds(PERL).then(|| {
        let output = Command::new(package("sbom")).arg("json").output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(json["bomFormat"], "CycloneDX");
        let all = json["components"].as_array().unwrap().iter();
        all.map(|c| {
            let text = |key: &str| c[key].as_str().unwrap().to_owned();
            assert!(!c["licenses"][0]["expression"].as_str().unwrap().is_empty(), "{c}");
            (text("name"), text("version"))
        })
        .collect()
    })
}

/// Programs name the sources of their packages where they could panic: an independent witness of what is linked.
#[test]
fn every_package_in_a_program_is_in_the_list() {
    let Some(listed) = listed() else { return };
    let mut files: Vec<PathBuf> = all_programs().iter().map(|p| programs().join(p)).collect();
    for entry in fs::read_dir(programs()).unwrap() {
        let path = entry.unwrap().path();
        // The library of macros runs in the compiler.
        let is_library = path.extension().is_some_and(|e| e == "so");
        if is_library && !path.ends_with(Path::new("libhal_derive.so")) {
            files.push(path);
        }
    }
    let mut grep = Command::new("grep");
    let pattern = "registry/src/[^/]+/[A-Za-z0-9_.+-]+-[0-9]+[.][0-9]+[.][0-9]+[A-Za-z0-9_.+-]*/";
    let (_, text) = said(grep.args(["-aohE", pattern]).args(&files).env("LC_ALL", "C"));
    let mut seen = BTreeSet::new();
    for line in text.lines() {
        let folder = line.trim_end_matches('/').rsplit('/').next().unwrap();
        let digit = |i: &usize| folder[i + 1..].starts_with(|c: char| c.is_ascii_digit());
        let at = folder.match_indices('-').map(|(i, _)| i).find(digit).unwrap();
        seen.insert((folder[..at].to_owned(), folder[at + 1..].to_owned()));
    }
    assert!(seen.len() > 50, "the programs name only {} packages", seen.len());
    let missing: Vec<_> = seen.difference(&listed).collect();
    assert!(missing.is_empty(), "linked, and not in the list: {missing:?}");
}

#[test]
fn the_list_has_only_what_is_locked() {
    let Some(listed) = listed() else { return };
    let lock: toml::Table = fs::read_to_string(root().join("Cargo.lock")).unwrap().parse().unwrap();
    let locked: BTreeSet<_> = lock["package"]
        .as_array()
        .unwrap()
        .iter()
        .map(|p| {
            (p["name"].as_str().unwrap().to_owned(), p["version"].as_str().unwrap().to_owned())
        })
        .collect();
    assert!(
        listed.iter().any(|(name, _)| name == "rustls")
            && listed.iter().any(|(n, _)| n == "halcmd")
    );
    assert!(listed.iter().all(|(name, _)| name != "hal-tests" && name != "syn"), "{listed:?}");
    let unknown: Vec<_> = listed.difference(&locked).collect();
    assert!(unknown.is_empty(), "{unknown:?}");
}

#[test]
fn packages_are_installed_upgraded_and_removed() {
    if std::env::var_os("FERRULE_PACKAGES").is_none() {
        return tools::report(
            "the packages, which need root, debootstrap, lintian and a release build (halcmd/package/test, or FERRULE_PACKAGES=1)",
        );
    }
    let (is_done, text) = said(&mut Command::new(package("test")));
    assert!(is_done, "{text}");
}
