//! Files on the plugin path that are not libraries, that other users can write, or that end the
//! process that opens them: each is refused by name, none is executed in order to find out what it
//! offers, and the machine continues.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_engine::{ClockKind, Engine};
use hal_protocol::{Link, Place, Request};
use hal_tests::{
    foreign::{compile, component},
    machine::{bit, cycles, options, says, script, thread, wait},
    programs::programs,
    scratch::{Scratch, until},
    user::{as_user, is_root},
};
use rustix::{
    fs::{CWD, FileType, Mode, mknodat},
    process::Signal,
};
use std::{
    fs,
    os::unix::{
        fs::{PermissionsExt, chown, symlink},
        net::UnixListener,
    },
    path::Path,
    process::Command,
};

const OTHER: u32 = 60_002;

/// Set in a process that runs one test alone.
const ALONE: &str = "HAL_TEST_ALONE";

/// Creates an engine that searches these folders for plugins.
fn engine(clock: ClockKind, path: &[&Path]) -> Engine {
    let mut options = options(Place::at("/nonexistent", "test").unwrap(), clock);
    options.path = path.iter().map(|p| (*p).to_owned()).collect();
    Engine::without_socket(options).unwrap()
}

fn virtual_one(path: &[&Path]) -> Engine {
    engine(ClockKind::Virtual, path)
}

/// Copies a built plugin library into a folder.
fn put(folder: &Path, library: &str) {
    let name = format!("lib{library}.so");
    symlink(programs().join(&name), folder.join(&name)).unwrap();
}

/// Returns the source of a plugin library that declares some components and executes `does` when it
/// is opened. It first appends a letter to a file of its name.
fn plugin(folder: &Path, name: &str, offers: Option<&[&str]>, does: &str) -> String {
    let names = offers.map(|offers| {
        let all: String = offers.iter().map(|o| format!("\\0c\" \"{o}")).collect();
        format!("const char hal_names_{name}[] = \"hal-names 1\" \"{all}\";\n")
    });
    let ran = folder.join(format!("{name}.ran"));
    format!(
        "#include <fcntl.h>\n#include <signal.h>\n#include <stdlib.h>\n#include <string.h>\n\
         #include <unistd.h>\n{}const unsigned hal_library_{name}[4] = {{ 16, 1, 0, 1 }};\n\
         __attribute__((constructor)) static void as_it_is_opened(void)\n{{\n \
         int fd = open(\"{}\", O_WRONLY | O_CREAT | O_APPEND, 0600);\n \
         if (write(fd, \"x\", 1) != 1) abort();\n close(fd);\n {does}\n}}\n",
        names.unwrap_or_default(),
        ran.display()
    )
}

/// Compiles a library to `libNAME.so`. Returns false, with a message, if there is no compiler.
fn make(folder: &Path, name: &str, source: &str) -> bool {
    let Some(made) = compile(folder, name, source, &["-Wno-unused", "-D_GNU_SOURCE"]) else {
        return false;
    };
    fs::rename(made, folder.join(format!("lib{name}.so"))).unwrap();
    true
}

/// Returns the number of times that a library was opened.
fn opened(folder: &Path, name: &str) -> usize {
    fs::read(folder.join(format!("{name}.ran"))).map_or(0, |bytes| bytes.len())
}

fn file(folder: &Path, name: &str) -> String {
    folder.join(name).display().to_string()
}

/// Code that ends a process or does not return, and the message about it.
const ENDS: [(&str, &str); 9] = [
    ("abort();", "ended by an abort (SIGABRT)"),
    ("volatile int *volatile at = NULL; *at = 1;", "ended by a segmentation fault (SIGSEGV)"),
    ("__builtin_trap();", "ended by an illegal instruction (SIGILL)"),
    ("raise(SIGKILL);", "ended by SIGKILL"),
    ("raise(SIGTERM);", "ended by signal 15"),
    ("exit(0);", "ended the process, with status 0"),
    ("exit(3);", "ended the process, with status 3"),
    ("_exit(0);", "ended the process, with status 0"),
    ("quick_exit(1);", "ended the process, with status 1"),
];

#[test]
fn who_offers_a_component_is_found_without_opening_a_library() {
    let scratch = Scratch::new("found");
    let folder = scratch.path();
    let hostile = |name: &str, offers: Option<&[&str]>| {
        make(folder, name, &plugin(folder, name, offers, "exit(0);"))
    };
    // Names that sort before and after the intact family.
    if !hostile("a_first", Some(&["something", "and3"])) {
        return;
    }
    assert!(hostile("a_silent", None) && hostile("z_last", Some(&["and2"])));
    put(folder, "logic");
    let mut e = virtual_one(&[folder]);
    assert_eq!(says(&mut e, "loadrt and2"), "ok");
    let missing = says(&mut e, "loadrt something_else");
    assert!(missing.contains("no plugin library offers this component"), "{missing}");
    // A component that a library does not declare is not looked for in it, even under the library's
    // name.
    let said = says(&mut e, "loadrt a_first");
    assert!(said.contains("a_first: no plugin library offers this component"), "{said}");
    for name in ["a_first", "a_silent", "z_last"] {
        assert_eq!(opened(folder, name), 0, "{name}");
    }
    // A library built before libraries declared their components is opened when it is requested by
    // name.
    let said = says(&mut e, "loadrt a_silent");
    assert!(said.contains("ended the process, with status 0"), "{said}");
    assert_eq!(opened(folder, "a_silent"), 1);
    // Only the library that offers the component is opened.
    let said = says(&mut e, "loadrt something");
    let want = format!(
        "{}: opened in a process of its own first, it ended the process, with status 0",
        file(folder, "liba_first.so")
    );
    assert_eq!(said, want);
    assert_eq!((opened(folder, "a_first"), opened(folder, "z_last")), (1, 0));
    e.close();
}

#[test]
fn a_library_that_ends_the_process_breaks_only_its_own_load() {
    let scratch = Scratch::new("ends");
    let folder = scratch.path();
    put(folder, "logic");
    put(folder, "threads");
    put(folder, "compat");
    for (n, (does, how)) in ENDS.into_iter().enumerate() {
        let (family, offers) = (format!("family{n}"), format!("member{n}"));
        let source = plugin(folder, &family, Some(&[&offers]), does);
        if !make(folder, &family, &source) {
            return;
        }
        // The same for a component in C.
        let constructor = format!("__attribute__((constructor)) static void go(void) {{ {does} }}");
        let globals =
            format!("#include <signal.h>\n#include <stdlib.h>\n#include <unistd.h>\n{constructor}");
        let source = component(&globals, "", "").replace("mine", &format!("inc{n}"));
        compile(folder, &format!("inc{n}"), &source, &["-Wno-unused", "-D_GNU_SOURCE"]).unwrap();
        let _: &str = how;
    }
    for clock in [ClockKind::Virtual, ClockKind::Real] {
        let mut e = engine(clock, &[folder]);
        script(&mut e, "loadrt threads name1=t period1=1000000\nloadrt and2\naddf and2.0 t\nstart");
        script(&mut e, "setp and2.0.in0 1\nsetp and2.0.in1 1");
        for (n, (_, how)) in ENDS.into_iter().enumerate() {
            for (line, so) in [
                (format!("loadrt member{n}"), format!("libfamily{n}.so")),
                (format!("loadrt inc{n}"), format!("inc{n}.so")),
            ] {
                let said = says(&mut e, &line);
                let so = file(folder, &so);
                let want = format!("{so}: opened in a process of its own first, it {how}");
                assert_eq!(said, want, "{line}");
            }
            // The failure is remembered and not tried again by any engine of this process.
            assert_eq!(opened(folder, &format!("family{n}")), 1);
        }
        // The machine runs, and loads an intact component.
        assert_eq!(says(&mut e, "loadrt or2"), "ok");
        if clock == ClockKind::Real {
            cycles(&mut e, "t", 3);
        } else {
            script(&mut e, "run 5000000");
            assert_eq!(thread(&mut e, "t").cycles, 5);
        }
        wait(&mut e, "the gate", |e| bit(e, "and2.0.out"));
        e.close();
    }
    // `check` reports it at its line, and continues.
    scratch.write("m.hal", "loadrt member0\nloadrt and2\nloadrt inc1\nsetp and2.0.nothing 1\n");
    let mut halcmd = scratch.command(&[], "halcmd");
    let output = scratch.run(halcmd.env("HAL_RTMOD_DIR", folder).args(["check", "m.hal"]));
    let all = output.stdout + &output.stderr;
    for (line, part) in [
        ("m.hal:1: ", "it ended by an abort (SIGABRT)"),
        ("m.hal:3: ", "it ended by a segmentation fault (SIGSEGV)"),
        ("m.hal:4: ", "and2.0.nothing"),
    ] {
        assert!(all.lines().any(|l| l.contains(line) && l.contains(part)), "{line} {part}: {all}");
    }
    assert_eq!(output.status, Some(2), "{all}");
}

#[test]
fn a_library_is_tried_once_and_again_when_it_has_changed() {
    let scratch = Scratch::new("once");
    let folder = scratch.path();
    let make = |does: &str| make(folder, "once", &plugin(folder, "once", Some(&["once"]), does));
    if !make("") {
        return;
    }
    // The library is tried, then opened; its descriptor lacks that name.
    let load = || says(&mut virtual_one(&[folder]), "loadrt once");
    let said = load();
    assert!(said.contains("not a plugin: its descriptor is cut"), "{said}");
    assert_eq!(opened(folder, "once"), 2);
    // The library is mapped now, so it need not be tried again.
    assert_eq!(load(), said);
    assert_eq!(opened(folder, "once"), 2);
    // A new file of that name is another library.
    fs::remove_file(folder.join("libonce.so")).unwrap();
    assert!(make("abort();"));
    assert!(load().contains("it ended by an abort"));
    assert_eq!(opened(folder, "once"), 3);
    fs::remove_file(folder.join("libonce.so")).unwrap();
    assert!(load().contains("no plugin library offers this component"));
}

#[test]
fn a_component_in_c_is_tried_with_those_whose_symbols_it_takes() {
    let scratch = Scratch::new("symbols");
    let folder = scratch.path();
    put(folder, "compat");
    let provider = component("int shared_number = 7;", "", "").replace("mine", "provider");
    if compile(folder, "provider", &provider, &[]).is_none() {
        return;
    }
    // Its constructor reads a variable of the other library, and calls the interface.
    let globals = "#include <stdlib.h>\nextern int shared_number;\n\
                   __attribute__((constructor)) static void look(void)\n\
                   { if (shared_number != 7 || hal_init(\"x\") >= 0) abort(); }";
    let taker = component(globals, "", "").replace("mine", "taker");
    compile(folder, "taker", &taker, &[]).unwrap();
    let mut e = virtual_one(&[folder]);
    let said = says(&mut e, "loadrt taker");
    assert!(said.contains("undefined symbol: shared_number"), "{said}");
    script(&mut e, "loadrt provider\nloadrt taker");
    assert_eq!(says(&mut e, "unloadrt taker"), "ok");
    e.close();
}

/// The package was changed while the machine runs: its new plugins are for the new engine. A plugin of somebody else's
/// says no release, and needs the binary interface alone.
#[test]
fn a_plugin_of_another_release_asks_for_a_restart() {
    let scratch = Scratch::new("release");
    let folder = scratch.path();
    let own = env!("CARGO_PKG_VERSION");
    let other = format!("9{}", &own[1..]);
    let patched = |name: &str, letter: char, release: &str| {
        let path = folder.join(format!("lib{name}.so"));
        drop(fs::remove_file(&path));
        put(folder, name);
        let mut bytes = fs::read(&path).unwrap();
        let tag = format!("\0v{own}\0");
        let at: Vec<usize> = (0..bytes.len() - tag.len())
            .filter(|i| bytes[*i..].starts_with(tag.as_bytes()))
            .collect();
        assert_eq!(at.len(), 1, "{name} says its release once");
        let new = format!("\0{letter}{release}\0");
        bytes[at[0]..at[0] + new.len()].copy_from_slice(new.as_bytes());
        fs::remove_file(&path).unwrap();
        fs::write(&path, bytes).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    };
    patched("logic", 'v', &other);
    patched("math", 'x', &other);
    patched("compat", 'v', &other);
    let mut e = virtual_one(&[folder]);
    let refused = |so: &str| {
        let so = file(folder, so);
        format!(
            "{so}: part of Ferrule {other}, and this instance runs {own}: restart the machine, which then uses {other}"
        )
    };
    assert_eq!(says(&mut e, "loadrt and2"), refused("liblogic.so"));
    assert_eq!(says(&mut e, "loadrt sum2"), "ok");
    let component = component("", "", "").replace("mine", "old");
    if compile(folder, "old", &component, &[]).is_some() {
        assert_eq!(says(&mut e, "loadrt old"), refused("libcompat.so"));
    }
    patched("logic", 'v', own);
    assert_eq!(says(&mut e, "loadrt and2"), "ok");
    e.close();
}

#[test]
fn what_is_no_file_is_refused_by_name_and_never_opened() {
    let scratch = Scratch::new("irregular");
    let folder = scratch.path();
    put(folder, "logic");
    put(folder, "compat");
    let at = |name: &str| folder.join(name);
    mknodat(CWD, at("liba_pipe.so"), FileType::Fifo, Mode::from_raw_mode(0o666), 0).unwrap();
    mknodat(CWD, at("c_pipe.so"), FileType::Fifo, Mode::from_raw_mode(0o666), 0).unwrap();
    let listener = UnixListener::bind(at("liba_socket.so")).unwrap();
    fs::create_dir(at("liba_folder.so")).unwrap();
    symlink("/dev/zero", at("liba_device.so")).unwrap();
    symlink(at("nothing"), at("liba_link.so")).unwrap();
    symlink(at("liba_loop.so"), at("liba_loop.so")).unwrap();
    symlink(at("liba_pipe.so"), at("liba_linked.so")).unwrap();
    let mut e = virtual_one(&[folder]);
    for (name, what) in [
        ("a_pipe", "a named pipe"),
        ("a_socket", "a socket"),
        ("a_folder", "a folder"),
        ("a_device", "a device"),
        ("a_link", "a symbolic link to nothing"),
        ("a_loop", "a symbolic link to itself"),
        ("a_linked", "a named pipe"),
    ] {
        let so = file(folder, &format!("lib{name}.so"));
        let want = format!("{so}: not a plugin: it is {what}, not a regular file");
        assert_eq!(says(&mut e, &format!("loadrt {name}")), want);
        // The same as a component in C.
        let request =
            Request::LoadForeign { module: name.into(), args: vec![], prefix: String::new() };
        assert_eq!(e.call(request).unwrap_err().to_string(), want);
    }
    let want = format!(
        "{}: not a plugin: it is a named pipe, not a regular file",
        file(folder, "c_pipe.so")
    );
    assert_eq!(says(&mut e, "loadrt c_pipe"), want);
    // They sort before the intact family, and are skipped.
    assert_eq!(says(&mut e, "loadrt and2"), "ok");
    assert!(e.catalogue().iter().any(|o| o.component == "and2"));
    drop(listener);
    // A file that this user may not read is reported as such.
    if !rustix::process::geteuid().is_root() {
        fs::write(at("liba_secret.so"), "").unwrap();
        fs::set_permissions(at("liba_secret.so"), fs::Permissions::from_mode(0o0)).unwrap();
        let said = says(&mut e, "loadrt a_secret");
        assert!(said.ends_with("liba_secret.so: not a plugin: Permission denied"), "{said}");
    }
    e.close();
}

/// Runs a test of this file in a separate process, unless this is that process. No engine on the
/// real clock has locked all memory there, which would keep another user from mapping more.
fn is_alone(test: &str) -> bool {
    if std::env::var_os(ALONE).is_some() {
        return true;
    }
    let mut again = Command::new(std::env::current_exe().unwrap());
    again
        .args(["--exact", &hal_tests::programs::own_test(module_path!(), test)])
        .env(ALONE, "1")
        .env("HAL_TEST_PROGRAMS", programs());
    let output = again.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    false
}

#[test]
fn root_opens_only_what_others_cannot_have_put_there() {
    if !is_root() || !is_alone("root_opens_only_what_others_cannot_have_put_there") {
        return;
    }
    let scratch = Scratch::new("root");
    let folder = &scratch.path().join("plugins");
    let elsewhere = &scratch.path().join("elsewhere");
    for folder in [folder, elsewhere] {
        fs::create_dir(folder).unwrap();
        fs::copy(programs().join("liblogic.so"), folder.join("liblogic.so")).unwrap();
        fs::set_permissions(folder, fs::Permissions::from_mode(0o755)).unwrap();
        fs::set_permissions(folder.join("liblogic.so"), fs::Permissions::from_mode(0o755)).unwrap();
    }
    let so = &folder.join("liblogic.so");
    let load = |path: &Path| {
        let mut e = virtual_one(&[path]);
        // By the name of the family, and by the name of the file.
        let said = says(&mut e, "loadrt and2");
        e.close();
        said
    };
    let mode =
        |path: &Path, mode| fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
    let shown = |path: &Path| path.display().to_string();
    let start = format!("{}: not opened as root: ", shown(so));
    assert_eq!(load(folder), "ok");
    for (path, bits, right) in [
        (so, 0o775, 0o755),
        (so, 0o757, 0o755),
        (so, 0o4777, 0o755),
        (folder, 0o775, 0o755),
        (folder, 0o757, 0o755),
        (folder, 0o1777, 0o755),
    ] {
        mode(path, bits);
        let path_shown = shown(path);
        let want = format!(
            "{start}other users can change {path_shown} (mode {bits:04o}); chmod go-w {path_shown}"
        );
        assert_eq!(load(folder), want);
        mode(path, right);
        assert_eq!(load(folder), "ok");
    }
    for path in [so, folder] {
        chown(path, Some(OTHER), None).unwrap();
        let path_shown = shown(path);
        let want = format!(
            "{start}{path_shown} belongs to user {OTHER}; root opens files of root's and, under \
             sudo, of the user's who called it: chown root {path_shown}"
        );
        assert_eq!(load(folder), want);
        // Another user may open the file: a user may open files of their own.
        assert_eq!(as_user(OTHER, || load(folder)), "ok");
        chown(path, Some(0), None).unwrap();
    }
    // For a link, its target counts, the target's folder, and the folder of the link.
    fs::remove_file(so).unwrap();
    symlink(elsewhere.join("liblogic.so"), so).unwrap();
    assert_eq!(load(folder), "ok");
    mode(folder, 0o777);
    assert!(load(folder).contains(&format!("other users can change {}", shown(folder))));
    mode(folder, 0o755);
    mode(elsewhere, 0o777);
    assert!(load(folder).contains(&format!("other users can change {}", shown(elsewhere))));
    mode(elsewhere, 0o755);
    chown(elsewhere.join("liblogic.so"), Some(OTHER), None).unwrap();
    let said = load(folder);
    assert!(
        said.contains(&format!(
            "{} belongs to user {OTHER}",
            shown(&elsewhere.join("liblogic.so"))
        )),
        "{said}"
    );

    // Under sudo, files of the calling user are trusted like root's own.
    chown(elsewhere, Some(OTHER), None).unwrap();
    scratch.write("m.hal", "loadrt and2\n");
    let run = |uid: &str| {
        let mut halrun = scratch.command(&[], "halrun");
        halrun.env("HAL_RTMOD_DIR", elsewhere).env("SUDO_UID", uid);
        scratch.run(halrun.args(["-f", "m.hal"]))
    };
    let output = run(&OTHER.to_string());
    assert_eq!(output.status, Some(0), "{}", output.stderr);
    for uid in ["60003", "", "x", "-1"] {
        let output = run(uid);
        assert_ne!(output.status, Some(0));
        assert!(output.stderr.contains(&format!("belongs to user {OTHER}")), "{}", output.stderr);
    }
    // The same holds for components in C, before any of their code runs.
    let c = &scratch.path().join("c");
    fs::create_dir(c).unwrap();
    put(c, "compat");
    let globals = format!(
        "#include <stdlib.h>\n__attribute__((constructor)) static void go(void) {{ \
         if (system(\"touch {}/mine.ran\")) abort(); }}",
        c.display()
    );
    if compile(c, "mine", &component(&globals, "", ""), &[]).is_none() {
        return;
    }
    mode(&c.join("mine.so"), 0o777);
    let said = says(&mut virtual_one(&[c]), "loadrt mine");
    assert!(said.contains("mine.so: not opened as root: other users can change"), "{said}");
    assert!(!c.join("mine.ran").exists());
    // On the real clock: a virtual machine refuses this constructor, which starts a program.
    scratch.write("mine.hal", "loadrt mine\n");
    let run = || {
        let mut halrun = scratch.command(&[], "halrun");
        scratch.run(halrun.env("HAL_RTMOD_DIR", c).args(["-f", "mine.hal"]))
    };
    let said = run().stderr;
    assert!(said.contains("mine.so: not opened as root: other users can change"), "{said}");
    assert!(!c.join("mine.ran").exists());
    mode(&c.join("mine.so"), 0o755);
    let output = run();
    assert_eq!((output.status, output.stderr.as_str()), (Some(0), ""));
    assert!(c.join("mine.ran").exists());
}

#[test]
fn a_signal_is_heeded_while_a_library_is_opened_and_one_that_hangs_is_given_up() {
    let scratch = Scratch::new("hangs");
    let folder = scratch.path();
    let source = plugin(folder, "hangs", Some(&["hangs"]), "for (;;) pause();");
    if !make(folder, "hangs", &source) {
        return;
    }
    scratch.write("m.hal", "loadrt hangs\nprint loaded\n");
    let start = || {
        let mut halrun = scratch.command(&[], "halrun");
        scratch.start(halrun.env("HAL_RTMOD_DIR", folder).arg("m.hal"))
    };
    let running = start();
    until("it is opened", || opened(folder, "hangs") == 1);
    running.signal(Signal::TERM);
    let output = running.wait();
    assert!(
        output.stderr.contains("libhangs.so: not opened: the instance is ending"),
        "{output:?}"
    );
    assert_eq!(output.status, Some(1));
    let output = start().wait();
    let want =
        "libhangs.so: opened in a process of its own first, it did not come back within 10 s";
    assert!(output.stderr.contains(want), "{}", output.stderr);
    assert_eq!((output.status, output.stdout.as_str()), (Some(1), ""));
    // No process is left behind.
    until("they have ended", || {
        let all = fs::read_dir("/proc")
            .unwrap()
            .filter_map(|e| fs::read(e.ok()?.path().join("cmdline")).ok());
        !all.into_iter()
            .any(|words| String::from_utf8_lossy(&words).contains(folder.to_str().unwrap()))
    });
}
