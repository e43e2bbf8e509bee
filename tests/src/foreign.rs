//! Components written in C, and LinuxCNC's programs: where tests find them, and how they compile, load and run them.

use crate::{
    golden,
    programs::{programs, root},
    scratch::{Output, Scratch},
    tools,
};
use hal_engine::{ClockKind, Engine, Options};
use hal_protocol::{Failure, FunctInfo, ItemInfo, Kind, Link, Place, Reply, Request, Value};
use std::{
    path::{Path, PathBuf},
    process::Command,
};

/// Returns the folder of the components of LinuxCNC's package, if it is installed.
pub fn installed() -> Option<PathBuf> {
    Some(PathBuf::from("/usr/lib/linuxcnc/modules")).filter(|p| p.join("and2.so").is_file())
}

/// Returns a command for LinuxCNC's program, run by an ordinary user with a home of its own.
pub fn peer(program: &str, home: &Path) -> Command {
    let root = rustix::process::getuid().is_root();
    let mut c = if root { Command::new("runuser") } else { Command::new(program) };
    if root {
        // `env` sets the home folder.
        c.args(["-u", "nobody", "--", "env"]).arg(format!("HOME={}", home.display())).arg(program);
    }
    c.env("HOME", home).current_dir(home).env_remove("HAL_INSTANCE");
    c
}

/// Copies the folder `tests/FOLDER` and compiles its modules there with `halcompile`; returns `None` without a compiler.
///
/// # Panics
/// A module does not compile, or not without a message.
pub fn compiled(folder: &str, modules: &[&str]) -> Option<Scratch> {
    tools::compiler()?;
    let scratch = Scratch::copy_of(&root().join("tests").join(folder));
    for module in modules {
        let output = scratch.run(scratch.command(&[], "halcompile").args(["--compile", module]));
        assert_eq!((output.status, output.stderr.as_str()), (Some(0), ""), "{module}");
    }
    Some(scratch)
}

/// Runs a program that finds the modules of a folder.
pub fn run_beside(scratch: &Scratch, program: &str, words: &[&str]) -> Output {
    let mut command = scratch.command(&[], program);
    scratch.run(command.env("HAL_RTMOD_DIR", scratch.path()).args(words))
}

/// Runs halrun on the virtual clock with the modules of a folder.
pub fn run_virtual(scratch: &Scratch, words: &[&str]) -> Output {
    run_beside(scratch, "halrun", &[&["--virtual"], words].concat())
}

/// Runs each script of `tests/FOLDER` that has a file of expected output twice, and compares both.
///
/// # Panics
/// The output is not that of the file, or not the same twice.
pub fn check_scripts(scratch: &Scratch, folder: &str) {
    let files = std::fs::read_dir(root().join("tests").join(folder)).unwrap();
    let files = files.map(|file| file.unwrap().path());
    for file in files.filter(|file| file.extension().is_some_and(|e| e == "out")) {
        let name = file.file_stem().unwrap().to_str().unwrap();
        let run = || run_virtual(scratch, &["-k", "-f", &format!("{name}.hal")]);
        let output = run();
        assert_eq!(output, run(), "{name}: not the same twice");
        let shown = scratch.path().display().to_string();
        let text = format!("{}--- standard error\n{}", output.stdout, output.stderr);
        golden::check(&file, &text.replace(&shown, "FOLDER"));
    }
}

/// Checks files with `halcmd check`.
///
/// # Panics
/// It finds something wrong.
pub fn check_clean(scratch: &Scratch, files: &[&str]) {
    for file in files {
        let Output { stdout, stderr, status, .. } = run_beside(scratch, "halcmd", &["check", file]);
        assert_eq!((status, stderr.as_str()), (Some(0), ""), "{file}: {stdout}");
        assert!(!stdout.contains("error[") && !stdout.contains("warning["), "{file}: {stdout}");
    }
}

/// An engine on the virtual clock that finds every plugin, and C components in some folders.
#[derive(Debug)]
pub struct Bench {
    /// The engine.
    pub engine: Engine,
}

impl Bench {
    /// Creates an engine that finds C components in these folders.
    pub fn new(folders: &[&Path]) -> Self {
        let mut path = vec![programs().to_owned()];
        path.extend(folders.iter().map(|f| (*f).to_owned()));
        let options = Options {
            path,
            realtime: crate::machine::realtime(),
            ..Options::simulated(Place::at("/nonexistent", "test").unwrap(), ClockKind::Virtual)
        };
        Self { engine: Engine::without_socket(options).unwrap() }
    }

    /// Runs `loadrt --c --prefix P NAME ARGS…`.
    ///
    /// # Errors
    /// The load was refused: the refusal, after the messages that preceded it.
    pub fn load_c(&mut self, prefix: &str, words: &str) -> Result<(), String> {
        let mut words = words.split(' ').filter(|w| !w.is_empty()).map(str::to_owned);
        let module = words.next().unwrap();
        let prefix = prefix.to_owned();
        let done = self.call(Request::LoadForeign { module, args: words.collect(), prefix });
        done.map(drop).map_err(|e| {
            let mut said = self.engine.take_messages();
            said.push(e.to_string());
            said.join(" | ")
        })
    }

    /// Returns the pins or parameters that match a pattern.
    pub fn items(&mut self, kind: Kind, pattern: &str) -> Vec<ItemInfo> {
        let patterns = if pattern.is_empty() { Vec::new() } else { vec![pattern.to_owned()] };
        match self.call(Request::List { kind, patterns, ty: None }) {
            Ok(Reply::Items(list)) => list.into_iter().filter(|i| !is_time(&i.name)).collect(),
            other => panic!("show: {other:?}"),
        }
    }

    /// Returns the functions of a component.
    pub fn functs(&mut self, owner: &str) -> Vec<FunctInfo> {
        match self.call(Request::List { kind: Kind::Functs, patterns: Vec::new(), ty: None }) {
            Ok(Reply::Functs(list)) => list.into_iter().filter(|f| f.owner_name == owner).collect(),
            other => panic!("show funct: {other:?}"),
        }
    }

    /// Sets a pin or parameter.
    pub fn set(&mut self, name: &str, value: Value) {
        let value = written(value);
        self.call(Request::Set { name: name.to_owned(), value }).unwrap();
    }
}

impl Link for Bench {
    fn call(&mut self, request: Request) -> Result<Reply, Failure> {
        self.engine.call(request)
    }
}

/// Returns a value as a user writes it.
pub fn written(value: Value) -> String {
    match value {
        Value::Float(f) if f.is_nan() => "nan".to_owned(),
        Value::Float(f) if f.is_infinite() => if f > 0.0 { "inf" } else { "-inf" }.to_owned(),
        Value::Float(f) => format!("{f:e}"),
        Value::Bit(b) => if b { "1" } else { "0" }.to_owned(),
        other => other.to_string(),
    }
}

/// Returns whether an item shows the time that a function takes, which differs from run to run.
fn is_time(name: &str) -> bool {
    [".time", ".tmax", ".tmax-increased"].iter().any(|end| name.ends_with(end))
}

/// Returns the source of a component `mine` with a bit that it toggles at each run. `globals` is inserted at file level,
/// `main` into `rtapi_app_main`, and `function` into the component's function.
pub fn component(globals: &str, main: &str, function: &str) -> String {
    format!(
        "#include \"rtapi.h\"\n#include \"rtapi_app.h\"\n#include \"hal.h\"\n\
         MODULE_LICENSE(\"GPL\");\n{globals}\nstatic int id;\nstatic hal_bit_t **out;\n\
         static void turn(void *arg, long period)\n{{ (void)arg; (void)period; **out = !**out; \
         {function} }}\n\
         int rtapi_app_main(void)\n{{\n id = hal_init(\"mine\");\n if (id < 0) return id;\n {main}\n \
         out = hal_malloc(sizeof *out);\n \
         if (hal_pin_bit_newf(HAL_OUT, out, id, \"mine.%d.out\", 0)) return -EINVAL;\n \
         if (hal_export_funct(\"mine.0\", turn, NULL, 0, 0, id)) return -EINVAL;\n \
         return hal_ready(id);\n}}\nvoid rtapi_app_exit(void) {{ hal_exit(id); }}\n"
    )
}

/// Compiles C with Ferrule's headers to `FOLDER/NAME.so`; returns `None`, and reports it, if there is no compiler.
pub fn compile(folder: &Path, name: &str, source: &str, options: &[&str]) -> Option<PathBuf> {
    let (from, to) = (folder.join(format!("{name}.c")), folder.join(format!("{name}.so")));
    std::fs::write(&from, source).unwrap();
    let include = root().join("components/foreign/compat/include");
    let mut cc = Command::new("cc");
    cc.args(["-std=gnu11", "-DRTAPI", "-O1", "-Wall", "-Wextra", "-Werror", "-fPIC", "-shared"]);
    cc.args(["-Wl,-Bsymbolic"]).args(options).arg("-I").arg(include);
    let Ok(out) = cc.arg(&from).arg("-o").arg(&to).arg("-lm").output() else {
        tools::COMPILER.skip();
        return None;
    };
    assert!(out.status.success(), "{name}: {}", String::from_utf8_lossy(&out.stderr));
    Some(to)
}
