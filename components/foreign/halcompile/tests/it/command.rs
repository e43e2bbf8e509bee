//! The command line: what is written where, and what is not.
#![expect(clippy::unwrap_used, reason = "tests")]

use std::{
    collections::BTreeMap,
    fs,
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
    process::Command,
    sync::atomic::{AtomicU32, Ordering},
};

const GOOD: &str = "component good \"Good.\";\npin in bit a;\npin out bit b;\nfunction _;\nlicense \"MIT\";\n;;\nb = a;\n";

/// A folder of its own.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let n = NEXT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("halcompile-{}-{n}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        let folder = Self(path);
        folder.write("good.comp", GOOD);
        folder
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.0.join(name), text).unwrap();
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.0.join(name)).unwrap()
    }

    fn names(&self, folder: &str) -> Vec<String> {
        let all = fs::read_dir(self.0.join(folder)).unwrap();
        let mut names: Vec<String> =
            all.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// halcompile, to be run here.
    fn command(&self, words: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_halcompile"));
        command.args(words).current_dir(&self.0).env("HOME", &self.0).env_remove("XDG_CACHE_HOME");
        command.env("HAL_RTMOD_DIR", self.0.join("modules")).env_remove("HAL_INCLUDE_DIR");
        command.env("USER_MODULE_DIR", self.0.join("programs")).env_remove("HAL_MAN_DIR");
        command
    }

    /// Runs halcompile here: status, what it said, and what it complained about.
    fn run(&self, words: &[&str]) -> (i32, String, String) {
        let output = self.command(words).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        drop(fs::remove_dir_all(&self.0));
    }
}

fn has_compiler() -> bool {
    Command::new("cc").arg("--version").output().is_ok()
}

#[test]
fn texts_go_into_this_folder_or_where_they_are_asked_to() {
    let folder = Folder::new();
    let nothing = (0, String::new(), String::new());
    assert_eq!(folder.run(&["good.comp"]), nothing);
    assert_eq!(folder.run(&["--preprocess", "--outfile=other.c", "good.comp"]), nothing);
    assert_eq!(folder.run(&["--document", "good.comp"]), nothing);
    assert_eq!(folder.run(&["-a", "good.comp"]), nothing);
    assert_eq!(folder.run(&["-d", "-o", "page", "-k", "kept.adoc", "good.comp"]), nothing);
    assert_eq!(folder.run(&["--rust", "good.comp"]), nothing);
    assert_eq!(folder.run(&["--install-doc", "good.comp"]), nothing);
    let made = ["good.9", "good.adoc", "good.c", "good.rs", "kept.adoc", "other.c", "page"];
    for name in made {
        assert!(!folder.read(name).is_empty(), "{name}");
    }
    assert_eq!(folder.names(".local/share/man/man9"), ["good.9"]);
    assert!(folder.read("other.c").contains("#line 7 \"good.comp\""));
}

/// No file for `man` lies where another user could have put one first.
#[test]
fn man_reads_a_page_from_a_pipe() {
    let folder = Folder::new();
    let man = folder.0.join("bin/man");
    let view = |says: &str| {
        fs::create_dir_all(folder.0.join("bin")).unwrap();
        fs::write(&man, format!("#!/bin/sh\n{says}\n")).unwrap();
        fs::set_permissions(&man, fs::Permissions::from_mode(0o755)).unwrap();
        let path = format!("{}:/usr/bin:/bin", folder.0.join("bin").display());
        let mut command = folder.command(&["--view-doc", "good.comp"]);
        let output = command.env("PATH", path).env("TMPDIR", "/nonexistent").output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let page = view("exit 1");
    assert!(page.contains(".TH"), "as it is, where man fails: {page}");
    assert_eq!(view("echo \"$@\"; cat"), format!("-l -\n{page}"));
    // It need not read.
    assert_eq!(view("echo no"), "no\n");
}

#[test]
fn what_is_refused_leaves_nothing() {
    let folder = Folder::new();
    folder
        .write("bad.comp", "component worse;\npin in bit a;\nfunction _;\nlicense \"MIT\";\n;;\n");
    folder.write("dos.comp", &GOOD.replace("good", "dos").replace('\n', "\r\n"));
    folder.write("text.txt", "text");
    let before = folder.names("");
    let refusals: BTreeMap<&str, &str> = BTreeMap::from([
        ("bad.comp", "bad.comp:1:11: Component name (worse) does not match filename (bad)"),
        ("-c bad.comp", "bad.comp:1:11: Component name (worse) does not match filename (bad)"),
        ("-d bad.comp", "bad.comp:1:11:"),
        ("--unix dos.comp", "dos.comp: lines end as DOS writes them"),
        ("text.txt", "text.txt: neither .comp, .c nor .py"),
        ("none.comp", "none.comp: No such file or directory"),
        ("none.c", "none.c: a C file is for --compile and --install"),
        ("none.py", "none.py: a Python file is for --install --userspace"),
        ("-o x good.comp good.comp", "--outfile is for a single file"),
    ]);
    for (words, why) in refusals {
        let words: Vec<&str> = words.split(' ').collect();
        let (status, out, err) = folder.run(&words);
        assert_eq!((status, out.as_str()), (1, ""), "{words:?}: {err}");
        assert!(err.starts_with(why), "{words:?}: {err}");
    }
    assert_eq!(folder.run(&["--no-such"]).0, 2);
    assert_eq!(folder.run(&["-P", "0", "good.comp"]).0, 2);
    assert_eq!(folder.names(""), before);
    // Without --unix, any end of line will do.
    assert_eq!(folder.run(&["dos.comp"]), (0, String::new(), String::new()));
}

#[test]
fn modules_and_programs_are_installed_where_they_are_found() {
    let folder = Folder::new();
    folder.write("tool.py", "#!/usr/bin/python2\nprint('tool')\n");
    folder.write("bare.py", "print('bare')\n");
    assert_eq!(folder.run(&["-i", "-u", "tool.py", "bare.py"]), (0, String::new(), String::new()));
    assert_eq!(folder.read("programs/tool"), "#!/usr/bin/env python3\nprint('tool')\n");
    assert_eq!(folder.read("programs/bare"), "#!/usr/bin/env python3\nprint('bare')\n");
    if !has_compiler() {
        return;
    }
    folder.write("plain.h", "#define PLAIN 7\n");
    folder.write(
        "plain.c",
        "#include \"rtapi.h\"\n#include \"rtapi_app.h\"\n#include \"hal.h\"\n#include \"plain.h\"\n\
         int rtapi_app_main(void) { return PLAIN - EXTRA; }\nvoid rtapi_app_exit(void) {}\n",
    );
    let nothing = (0, String::new(), String::new());
    assert_eq!(folder.run(&["--install", "good.comp"]), nothing);
    assert_eq!(folder.run(&["-i", "--extra-compile-args=-DEXTRA=7 -Wall", "plain.c"]), nothing);
    assert_eq!(folder.names("modules"), ["good.so", "plain.so"]);
    // Modules are loaded, not run.
    let mode = fs::metadata(folder.0.join("modules/good.so")).unwrap().permissions().mode();
    assert_eq!(mode & 0o111, 0, "{mode:o}");
    assert!(!folder.names("").iter().any(|n| n.ends_with(".so") || n.ends_with(".o")));
}

#[test]
fn headers_and_the_makefile_are_laid_out() {
    let folder = Folder::new();
    let (status, include, _) = folder.run(&["--print-include"]);
    assert_eq!(status, 0);
    let include = Path::new(include.trim()).to_owned();
    for header in ["hal.h", "rtapi.h", "rtapi_app.h", "rtapi_math.h"] {
        assert!(include.join(header).is_file(), "{header}");
    }
    let (status, makefile, _) = folder.run(&["--print-modinc"]);
    assert_eq!(status, 0);
    let is_there = Command::new("make").arg("--version").output().is_ok();
    if !has_compiler() || !is_there {
        return;
    }
    folder.run(&["good.comp"]);
    folder.write("Makefile", &format!("obj-m += good.o\ninclude {makefile}"));
    let made = Command::new("make").arg("modules").current_dir(&folder.0).output().unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    assert!(folder.0.join("good.so").is_file());
}
