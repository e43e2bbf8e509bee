//! Compilation of C files with the system's compiler, to a module or a program.

use crate::{
    error::{Error, at},
    headers::{OFFERED, include_folder},
};
use object::{Object, ObjectSection};
use std::{
    env,
    ffi::OsString,
    fs,
    os::unix::fs::MetadataExt,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

/// Kind of result of a compilation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Realtime component, for `loadrt`.
    Module,
    /// Program with pins, for `loadusr`.
    Program,
}

/// C file and the way to compile it.
#[derive(Clone, Debug)]
pub struct Job<'a> {
    /// C file to compile.
    pub c_file: &'a Path,
    /// User's own source file, for messages and for headers beside it.
    pub source: &'a Path,
    /// File to write.
    pub out: &'a Path,
    /// Kind of the file to write.
    pub target: Target,
    /// True if all users of the machine shall find the file.
    pub installed: bool,
    /// Additional arguments for the compiler.
    pub compile_args: Vec<String>,
    /// Additional arguments for the linker.
    pub link_args: Vec<String>,
}

/// Compiler flags of every compilation. Fused operations are off, so that results are the same on every machine. From
/// DWARF 4, unlike 5, linkers name the lines of the .comp file.
pub(crate) const FLAGS: &[&str] = &[
    "-std=gnu11",
    "-D_GNU_SOURCE",
    "-fPIC",
    "-Os",
    "-gdwarf-4",
    "-fno-fast-math",
    "-ffp-contract=off",
];

/// Compiles and links. The output appears under its name only once complete; if there is an error, an existing file
/// stays.
///
/// # Errors
/// There is no compiler, or it reported errors itself.
pub fn build(job: &Job<'_>) -> Result<(), Error> {
    let scratch = Scratch::beside(job.out)?;
    let object = scratch.path.join("module.o");
    let include = include_folder()?;
    let mut cc = compiler();
    cc.args(FLAGS);
    match job.target {
        Target::Module => cc.args(["-DRTAPI", "-Drealtime", "-D__MODULE__", "-DSIM"]),
        Target::Program => cc.arg("-DULAPI"),
    };
    let beside = job.source.parent().filter(|p| !p.as_os_str().is_empty());
    cc.arg("-I").arg(&include).arg("-I").arg(beside.unwrap_or(Path::new(".")));
    cc.args(&job.compile_args).arg("-c").arg(job.c_file).arg("-o").arg(&object);
    run(cc, job.source)?;
    if job.target == Target::Module {
        resolve(job, &scratch.path, &object)?;
    }
    let out = scratch.path.join("out");
    let mut link = compiler();
    match job.target {
        Target::Module => {
            let script = scratch.path.join("symbols");
            fs::write(&script, symbols(&object)?).map_err(at(&script))?;
            let mut list = OsString::from("-Wl,--version-script=");
            list.push(&script);
            link.args(["-shared", "-Wl,-Bsymbolic", "-Wl,-z,now"]).arg(list);
        }
        Target::Program => {
            link.arg("-rdynamic");
        }
    }
    link.arg("-o").arg(&out).arg(&object).args(&job.link_args);
    if job.target == Target::Program {
        link.args(crate::program::link_words(&scratch.path, &include)?);
    }
    link.arg("-lm");
    run(link, job.source)?;
    let bytes = fs::read(&out).map_err(at(&out))?;
    // A module is loaded, not run.
    let wanted = if job.target == Target::Module { 0o644 } else { 0o755 };
    let linked = fs::metadata(&out).map_err(at(&out))?.mode();
    // The linker's file has the author's umask. Installed files are for all users, whatever that is.
    let mode = if job.installed { wanted } else { linked & wanted };
    hal_output::install(job.out, &bytes, mode).map_err(at(job.out))
}

/// Returns the system's compiler, or that of `CC`.
fn compiler() -> Command {
    let words = env::var("CC").unwrap_or_default();
    let mut words = words.split_whitespace();
    let mut command = Command::new(words.next().unwrap_or("cc"));
    command.args(words).stdin(Stdio::null());
    command
}

fn run(mut command: Command, file: &Path) -> Result<(), Error> {
    let compiler: Box<str> = command.get_program().to_string_lossy().into();
    let file = file.display().to_string().into();
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(_) => Err(Error::Compiler { compiler, file }),
        Err(cause) => Err(Error::NoCompiler { compiler, cause }),
    }
}

/// Lets the linker name function and line of each symbol that neither the file, its libraries, the engine nor another
/// component in C offers.
fn resolve(job: &Job<'_>, scratch: &Path, object: &Path) -> Result<(), Error> {
    let elsewhere = marked(object, ".rtapi_import")?;
    let known = elsewhere.iter().map(String::as_str).chain(OFFERED.iter().copied());
    let lines: String = known.map(|name| format!("PROVIDE({name} = 0);\n")).collect();
    let script = scratch.join("offered");
    fs::write(&script, lines).map_err(at(&script))?;
    let mut link = compiler();
    link.args(["-shared", "-Wl,-z,defs", "-o"]).arg(scratch.join("resolved")).arg(object);
    link.args(&job.link_args).arg(&script).arg("-lm");
    match run(link, job.source) {
        Err(Error::Compiler { file, .. }) => Err(Error::Unresolved { file }),
        other => other,
    }
}

/// Returns the linker's version script: it exports what loaders look for and what `EXPORT_SYMBOL` names, and hides all
/// other symbols, so that those of different modules do not collide.
fn symbols(object: &Path) -> Result<String, Error> {
    let mut script = String::from("{ global: rtapi_app_main; rtapi_app_exit; rtapi_info_*;");
    for name in marked(object, ".rtapi_export")? {
        script = format!("{script} {name};");
    }
    Ok(format!("{script} local: *; }};\n"))
}

/// Returns the names that macros have put in a section.
fn marked(object: &Path, section: &str) -> Result<Vec<String>, Error> {
    let bytes = fs::read(object).map_err(at(object))?;
    let wrong = |e: object::Error| Error::Object {
        path: object.display().to_string().into(),
        cause: e.to_string().into(),
    };
    let file = object::File::parse(bytes.as_slice()).map_err(wrong)?;
    let mut found = Vec::new();
    for section in file.sections().filter(|s| s.name() == Ok(section)) {
        let names = section.data().map_err(wrong)?.split(|b| *b == 0).filter(|n| !n.is_empty());
        found.extend(names.map(|name| String::from_utf8_lossy(name).into_owned()));
    }
    Ok(found)
}

/// Splits a line into words as a shell does: quotes keep blanks.
#[must_use]
pub fn words(line: &str) -> Vec<String> {
    let mut out = Vec::new();
    let mut word: Option<String> = None;
    let mut quote = None;
    for c in line.chars() {
        match (quote, c) {
            (Some(q), c) if q == c => quote = None,
            (None, '"' | '\'') => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (None, c) if c.is_whitespace() => out.extend(word.take()),
            (_, c) => word.get_or_insert_default().push(c),
        }
    }
    out.extend(word);
    out
}

/// Temporary folder beside an output file, removed when dropped.
struct Scratch {
    path: PathBuf,
}

impl Scratch {
    fn beside(out: &Path) -> Result<Self, Error> {
        let name = out.file_name().unwrap_or_default().to_string_lossy();
        let path = out.with_file_name(format!(".{name}.{}", std::process::id()));
        fs::create_dir_all(&path).map_err(at(&path))?;
        Ok(Self { path })
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // A folder that cannot be removed is small and hidden.
        drop(fs::remove_dir_all(&self.path));
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn words_as_a_shell_has_them() {
        assert_eq!(
            super::words(" -lfoo  '-I a b' \"\" -D\"x y\""),
            ["-lfoo", "-I a b", "", "-Dx y"]
        );
    }
}
