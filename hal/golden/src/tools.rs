//! Programs that a test needs and a machine may lack: each skipped test is reported, and CI can demand a program.
//!
//! - `FERRULE_REQUIRE` lists the programs that must be there, separated by commas (`cc,linuxcnc`; `all` for every one).
//!   A test that lacks one of them fails.
//! - `FERRULE_SKIPPED` names a file. Each skipped test adds a line `TEST: PROGRAM is not installed (REMEDY)`, which
//!   `.ci/run` prints at its end.

use std::{
    fs::OpenOptions,
    io::Write,
    process::{Command, ExitStatus, Stdio},
    thread,
};

/// A program outside the workspace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tool {
    /// Name in `FERRULE_REQUIRE`.
    pub name: &'static str,
    /// Description for a person.
    pub what: &'static str,
    /// Command that installs it.
    pub remedy: &'static str,
}

/// A C compiler.
pub const COMPILER: Tool =
    Tool { name: "cc", what: "a C compiler", remedy: "apt-get install build-essential" };
/// LinuxCNC's package, to measure its components.
pub const LINUXCNC: Tool = Tool {
    name: "linuxcnc",
    what: "LinuxCNC's package",
    remedy: "apt-get install linuxcnc-uspace",
};
/// Programs that read and write traces, and others that tests start by name.
const PROGRAMS: &[Tool] = &[
    Tool { name: "vcd2fst", what: "vcd2fst", remedy: "apt-get install gtkwave" },
    Tool { name: "fst2vcd", what: "fst2vcd", remedy: "apt-get install gtkwave" },
    Tool { name: "sigrok-cli", what: "sigrok-cli", remedy: "apt-get install sigrok-cli" },
    Tool { name: "tclsh", what: "tclsh", remedy: "apt-get install tcl" },
    Tool { name: "xvfb-run", what: "xvfb-run", remedy: "apt-get install xvfb xauth" },
    Tool { name: "dot", what: "Graphviz", remedy: "apt-get install graphviz" },
    Tool { name: "python3", what: "python3", remedy: "apt-get install python3" },
    Tool { name: "node", what: "node", remedy: "apt-get install nodejs" },
    Tool { name: "pytest", what: "pytest", remedy: "apt-get install python3-pytest" },
    Tool { name: "ssconvert", what: "ssconvert", remedy: "apt-get install gnumeric" },
    Tool { name: "unshare", what: "unshare, with the right to mount", remedy: "run it as root" },
    Tool { name: "taskset", what: "taskset", remedy: "apt-get install util-linux" },
    Tool { name: "chromium", what: "Chromium", remedy: "apt-get install chromium" },
    Tool {
        name: "chromedriver",
        what: "Chromium's driver",
        remedy: "apt-get install chromium-driver",
    },
    Tool { name: "prlimit", what: "prlimit", remedy: "apt-get install util-linux" },
    Tool { name: "setpriv", what: "setpriv", remedy: "apt-get install util-linux" },
    Tool { name: "setarch", what: "setarch", remedy: "apt-get install util-linux" },
];

impl Tool {
    /// Returns the program that is started by this name.
    ///
    /// # Panics
    /// The name is not in the list of this module.
    pub fn of(program: &str) -> Self {
        let found = PROGRAMS.iter().find(|t| t.name == program);
        *found.unwrap_or_else(|| panic!("{program}: add it to hal/golden/src/tools.rs"))
    }

    /// Reports that the running test is skipped because this program is not there.
    ///
    /// # Panics
    /// `FERRULE_REQUIRE` demands the program.
    pub fn skip(self) {
        let line = format!("{} is not installed ({})", self.what, self.remedy);
        let required = std::env::var("FERRULE_REQUIRE").unwrap_or_default();
        let demanded = |name: &str| name == self.name || name == "all";
        assert!(
            !required.split(',').any(demanded),
            "{line}, and FERRULE_REQUIRE={required} demands it"
        );
        report(&line);
    }

    /// Returns whether `NAME --version` succeeds; otherwise reports that the running test is skipped.
    #[must_use]
    pub fn is_installed(self) -> bool {
        let silent = || Stdio::null();
        let mut command = Command::new(self.name);
        command.arg("--version").stdin(silent()).stdout(silent()).stderr(silent());
        self.or_skip(command.status().ok().filter(ExitStatus::success)).is_some()
    }

    /// Returns `found`, or reports that the running test is skipped.
    pub fn or_skip<T>(self, found: Option<T>) -> Option<T> {
        if found.is_none() {
            self.skip();
        }
        found
    }
}

/// Reports that the running test is skipped for a reason other than a missing program (a right that this user lacks, a
/// processor of another kind).
pub fn report(reason: &str) {
    let current = thread::current();
    let test = current.name().unwrap_or("a test");
    eprintln!("skipped: {reason}");
    let Some(path) = std::env::var_os("FERRULE_SKIPPED").filter(|p| !p.is_empty()) else { return };
    let file = OpenOptions::new().append(true).create(true).open(path);
    // One write per line, so that lines of concurrent tests do not mix.
    file.and_then(|mut f| f.write_all(format!("{test}: {reason}\n").as_bytes())).unwrap();
}
