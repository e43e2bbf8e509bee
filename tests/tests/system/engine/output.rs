//! Output that cannot be written is an error in every program: it sets the status, prints one line,
//! and leaves an existing good file as it was.
#![expect(clippy::unwrap_used, clippy::panic, reason = "tests")]

use hal_tests::{programs::root, scratch::Scratch, tools::Tool};
use std::{
    fs::{self, File, Permissions},
    io::Read,
    os::unix::{
        fs::{PermissionsExt, symlink},
        process::ExitStatusExt,
    },
    path::Path,
    process::{Child, Command, Stdio},
    sync::Mutex,
};

const SIGPIPE: i32 = 13;

/// A machine that waits for commands, and the files that the commands use.
struct Fixture {
    scratch: Scratch,
    machine: Child,
}

const MACHINE: &str = "loadrt threads name1=t period1=1000000
loadrt siggen
loadrt sampler cfg=ff depth=4000
net x siggen.0.sawtooth => sampler.0.pin.0
addf siggen.0.update t
addf sampler.0 t
";

/// Machine of the scripts.
const PLAIN: &str = "loadrt threads name1=t period1=1000000
loadrt siggen
net x siggen.0.sawtooth
addf siggen.0.update t
";

const COMP: &str = "component one \"One.\";
pin out bit out;
function _;
license \"GPL\";
;;
FUNCTION(_) { out = 1; }
";

impl Fixture {
    fn new() -> Self {
        let scratch = Scratch::new("output");
        scratch.write("m.hal", MACHINE);
        scratch.write("served.hal", format!("{MACHINE}start\nrun 3s\n"));
        scratch.write("script.hal", "\nhelp net\n");
        scratch.write("one.comp", COMP);
        scratch.write("hello.py", "print('hello')\n");
        fs::create_dir(scratch.path().join("test")).unwrap();
        scratch.write("test/a.toml", "machine = \"../m.hal\"\n\n[[step]]\nrun = \"1ms\"\n");
        scratch.write("good.csv", "time [ns],a (bit)\n0,0\n1000,1\n2000,0\n");
        let mut command = scratch.command(&[], "halrun");
        command.args(["--virtual", "--hold", "served.hal"]);
        let machine = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        hal_tests::scratch::until("the machine has run", || {
            let time = scratch.halcmd(&["getp", "sampler.0.curr-depth"]);
            time.stdout.trim() == "3000"
        });
        Self { scratch, machine }
    }

    /// Creates a command of the table.
    fn command(&self, before: &[&str], words: &str) -> Command {
        if let Some(lines) = words.strip_prefix("@script ") {
            let lines: String = lines.split(';').map(|l| format!("{}\n", l.trim())).collect();
            self.scratch.write("test.hal", format!("{PLAIN}{lines}"));
            let mut command = self.scratch.command(before, "halrun");
            command.args(["--instance", "other", "--virtual", "-f", "test.hal"]);
            return command;
        }
        let mut words = words.split_whitespace();
        let mut command = self.scratch.command(before, words.next().unwrap());
        command.args(words).env("COMP_LINE", "halcmd loadr").env("MANPAGER", "cat");
        command
    }
}

impl Drop for Fixture {
    fn drop(&mut self) {
        drop(self.machine.kill());
        drop(self.machine.wait());
    }
}

/// Returns a script of the shell that runs a command whose descriptor is a pipe without a reader.
///
/// The command's own process opens the pipe. A pipe of this process would be inherited by processes
/// that other tests start at the same time, which keep it open until they execute their programs.
fn without_reader(descriptor: u32) -> String {
    let open = format!("exec 3<>unread {descriptor}>unread 3<&-");
    format!("rm -f unread && mkfifo unread && {open} && exec \"$@\"")
}

/// Runs a program. Returns its status or signal, and its messages.
fn ended(command: &mut Command, stdout: Stdio) -> (Result<i32, i32>, String) {
    let mut child = command.stdout(stdout).stderr(Stdio::piped()).spawn().unwrap();
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    let status = child.wait().unwrap();
    (status.code().ok_or_else(|| status.signal().unwrap()), said)
}

/// Returns the groups of a table: headings and commands.
fn groups(name: &str) -> Vec<(Vec<String>, Vec<String>)> {
    let text = fs::read_to_string(root().join("tests/output").join(name)).unwrap();
    let mut groups: Vec<(Vec<String>, Vec<String>)> = Vec::new();
    let mut is_head = false;
    for line in text.lines().filter(|l| !l.is_empty() && !l.starts_with('#')) {
        match line.strip_prefix("= ") {
            Some(head) if is_head => groups.last_mut().unwrap().0.push(head.to_owned()),
            Some(head) => groups.push((vec![head.to_owned()], Vec::new())),
            None => groups.last_mut().unwrap().1.push(line.to_owned()),
        }
        is_head = line.starts_with("= ");
    }
    assert!(!groups.is_empty() && groups.iter().all(|g| !g.1.is_empty()));
    groups
}

/// Reason why a file cannot be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wrong {
    Full,
    Limit,
    Missing,
    Folder,
    Readonly,
}

impl Wrong {
    const ALL: [(Self, &str, &str); 5] = [
        (Self::Full, "full", "No space left on device"),
        (Self::Limit, "limit", "File too large"),
        (Self::Missing, "missing", "No such file or directory"),
        (Self::Folder, "folder", "Is a directory"),
        (Self::Readonly, "readonly", "Read-only file system"),
    ];

    /// Returns whether a good file exists there.
    fn has_good(self) -> bool {
        matches!(self, Self::Limit | Self::Readonly)
    }

    /// Creates the folder and the file at `out`.
    fn set(self, out: &Path) {
        let folder = out.parent().unwrap();
        if self == Self::Missing {
            return;
        }
        fs::create_dir_all(folder).unwrap();
        match self {
            Self::Full => symlink("/dev/full", out).unwrap(),
            Self::Folder => fs::create_dir(out).unwrap(),
            _ => {
                fs::write(out, "good").unwrap();
                fs::set_permissions(out, Permissions::from_mode(0o640)).unwrap();
            }
        }
    }

    /// Returns the words before a command that make it meet this condition.
    fn before(self, folder: &str) -> Vec<String> {
        let script = match self {
            Self::Limit => "ulimit -f 0; exec \"$@\"".to_owned(),
            Self::Readonly => {
                format!(
                    "mount --bind {folder} {folder} && mount -o remount,bind,ro {folder} && exec \"$@\""
                )
            }
            Self::Full | Self::Missing | Self::Folder => return Vec::new(),
        };
        let mut words: Vec<&str> =
            if self == Self::Readonly { vec!["unshare", unshared()] } else { Vec::new() };
        words.extend(["sh", "-c", &script, "sh"]);
        words.into_iter().map(str::to_owned).collect()
    }
}

/// Returns the option of `unshare` for private mounts.
fn unshared() -> &'static str {
    if rustix::process::geteuid().is_root() { "-m" } else { "-rm" }
}

/// Returns whether this user may create private mounts.
fn may_mount() -> bool {
    let mut unshare = Command::new("unshare");
    unshare.args([unshared(), "mount", "-t", "tmpfs", "none", "/tmp"]);
    unshare.stderr(Stdio::null()).status().is_ok_and(|s| s.success())
}

/// Row of the table of files: the command, and the file that it writes.
struct Writes<'a> {
    environment: Vec<(&'a str, String)>,
    words: String,
    out: String,
}

impl<'a> Writes<'a> {
    /// Parses the row for a condition; `None` if the condition does not apply to it.
    fn new(row: &'a str, wrong: &str) -> Option<Self> {
        let (row, not) = row.split_once(" | not ").unwrap_or((row, ""));
        if not.split(' ').any(|n| n == wrong) {
            return None;
        }
        let (row, name) = row.split_once(" -> ").map_or((row, None), |(r, n)| (r, Some(n)));
        let named = row.split(' ').find_map(|w| Some(w.strip_prefix("OUT")?.trim_end_matches(';')));
        let out = match (name, named) {
            (Some(name), None) => format!("{wrong}/{name}"),
            (None, Some(ending)) => format!("{wrong}/out{ending}"),
            _ => panic!("{row}: which file?"),
        };
        let row_words = row.split(' ');
        let environment = row_words.clone().map_while(|w| w.split_once('='));
        let environment: Vec<_> =
            environment.map(|(name, value)| (name, value.replace("DIR", wrong))).collect();
        let words: Vec<String> = row_words
            .skip(environment.len())
            .map(|w| w.replace("OUT", &format!("{wrong}/out")).replace("DIR", wrong))
            .collect();
        Some(Self { environment, words: words.join(" "), out })
    }
}

/// Calls `run` for each row, several at a time, each with its own files. Fails with all errors.
fn for_each<T: Sync>(rows: &[T], run: impl Fn(&Fixture, &T) -> Result<(), String> + Sync) {
    let (next, wrong) = (Mutex::new(rows.iter()), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                let fixture = Fixture::new();
                loop {
                    let Some(row) = next.lock().unwrap().next() else { break };
                    if let Err(why) = run(&fixture, row) {
                        wrong.lock().unwrap().push(why);
                    }
                }
            });
        }
    });
    let wrong = wrong.into_inner().unwrap();
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), rows.len(), wrong.join("\n"));
}

#[test]
fn what_cannot_be_printed_is_an_error() {
    let rows: Vec<(String, String)> = groups("prints")
        .into_iter()
        .flat_map(|(head, rows)| rows.into_iter().map(move |row| (head.concat(), row)))
        .collect();
    for_each(&rows, |fixture, (head, row)| {
        let (status, line) = head.split_once(' ').unwrap();
        let full = File::options().write(true).open("/dev/full").unwrap();
        let (got, said) = ended(&mut fixture.command(&[], row), full.into());
        if got != Ok(status.parse().unwrap()) || !said.lines().any(|l| l == line) {
            return Err(format!("{row}, full: {got:?}\n{said}"));
        }
        if said.contains("panicked") {
            return Err(format!("{row}, full: {said}"));
        }
        let (got, said) = ended(
            &mut fixture.command(&["sh", "-c", &without_reader(1), "sh"], row),
            Stdio::null(),
        );
        if got != Err(SIGPIPE) || !said.is_empty() {
            return Err(format!("{row}, closed: {got:?}\n{said}"));
        }
        Ok(())
    });
}

#[test]
fn a_file_that_cannot_be_written_is_an_error_and_a_good_one_stays() {
    let mut rows = Vec::new();
    let mut conditions = Wrong::ALL.to_vec();
    if !may_mount() {
        Tool::of("unshare").skip();
        conditions.retain(|(wrong, _, _)| *wrong != Wrong::Readonly);
    }
    for (head, commands) in groups("writes") {
        for command in commands {
            for wrong in conditions.clone() {
                rows.push((head.clone(), command.clone(), wrong));
            }
        }
    }
    for_each(&rows, |fixture, (head, row, (wrong, name, reason))| {
        let Some(Writes { environment, words, out }) = Writes::new(row, name) else {
            return Ok(());
        };
        let folder = fixture.scratch.path();
        let path = folder.join(&out);
        wrong.set(&path);
        let before = wrong.before(&folder.join(name).display().to_string());
        let before: Vec<&str> = before.iter().map(String::as_str).collect();
        let mut command = fixture.command(&before, &words);
        command.envs(environment);
        let (got, said) = ended(&mut command, Stdio::null());
        let left: Vec<String> = names(&folder.join(name));
        let good = wrong.has_good().then(|| {
            let mode = fs::metadata(&path).unwrap().permissions().mode() & 0o7777;
            (fs::read_to_string(&path).unwrap(), mode)
        });
        drop(fs::remove_dir_all(folder.join(name)));
        let opens = !matches!(wrong, Wrong::Full | Wrong::Limit);
        let (status, line) = head[usize::from(!opens).min(head.len() - 1)].split_once(' ').unwrap();
        let line = line.replace("OUT", &out).replace("REASON", reason);
        let line = line.replace("FULL", &path.display().to_string());
        let complaint = if got != Ok(status.parse().unwrap()) || !said.lines().any(|l| l == line) {
            format!("wanted: {line}")
        } else if !said.contains(reason) || said.contains("panicked") {
            "without its reason".to_owned()
        } else if good.as_ref().is_some_and(|g| *g != ("good".to_owned(), 0o640)) {
            format!("the good file has become {good:?}")
        } else if left.iter().any(|name| name.contains("ferrule")) {
            format!("left behind: {left:?}")
        } else {
            return Ok(());
        };
        Err(format!("{row}, {name}: {got:?}, {complaint}\n{said}"))
    });
}

/// Returns the names of all files below a folder.
fn names(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let entry = entry.unwrap();
        names.push(entry.file_name().into_string().unwrap());
        if entry.file_type().unwrap().is_dir() {
            names.extend(self::names(&entry.path()));
        }
    }
    names
}

#[test]
fn standard_error_that_cannot_be_written_to_disturbs_nothing() {
    let rows = [
        ("halcmd getp nothing", 1),
        ("halcmd -x", 255),
        ("halcmd -v setp siggen.0.offset 0", 0),
        ("halcmd check none.hal", 2),
        // The engine, a component and the script each print a message.
        ("@script record none.vcd nothing*; start; run 1ms; record off; print x", 0),
        ("@script print x; getp nothing", 1),
        ("@script loadrt sampler; loadusr -w halcmd getp nothing", 1),
        ("halrun -x", 1),
        ("halscope capture nothing", 1),
        ("halscope capture --run 5ms -l 3 x", 0),
        ("halsampler -c 7", 1),
        ("halstreamer", 1),
        ("halsetup none.toml", 1),
        ("latency-test never", 1),
        ("haltest none", 2),
        ("haltest test", 0),
        ("halcompile none.comp", 1),
        ("halcompile --nonsense", 2),
        ("hal_manualtoolchange -x", 1),
    ];
    for_each(&rows, |fixture, (row, wanted)| {
        let script = without_reader(2);
        for closed in [false, true] {
            let full = File::options().write(true).open("/dev/full").unwrap();
            let before: &[&str] = if closed { &["sh", "-c", &script, "sh"] } else { &[] };
            let mut command = fixture.command(before, row);
            let status = command.stdout(Stdio::null()).stderr(full).status().unwrap();
            if status.code() != Some(*wanted) {
                return Err(format!("{row}, closed {closed}: {status}"));
            }
        }
        Ok(())
    });
}
