//! The command line.

use crate::{
    Component, Version,
    build::{Job, Target, build, words},
    c,
    error::{Error, at},
    headers, install,
};
use clap::Parser;
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Makes components from .comp and C files.
///
/// Without an action, the C text of a .comp file is written.
#[derive(Debug, Parser)]
#[command(name = "halcompile", version, max_term_width = 100)]
pub struct Args {
    /// Compile: NAME.so in the current folder; a program is written beside its source.
    #[arg(short, long)]
    compile: bool,
    /// Compile, and install the result where `loadrt` or `loadusr` finds it.
    #[arg(short, long)]
    install: bool,
    /// Write the C text of a .comp file: NAME.c.
    #[arg(short, long)]
    preprocess: bool,
    /// Write the manual page: NAME.9, or NAME.1 for a program.
    #[arg(short, long)]
    document: bool,
    /// Write the manual page as `AsciiDoc`: NAME.adoc.
    #[arg(short, long)]
    adoc: bool,
    /// Write the `AsciiDoc` text to this file as well.
    #[arg(short, long, value_name = "FILE")]
    keep_adoc: Option<PathBuf>,
    /// Show the manual page.
    #[arg(short = 'J', long)]
    view_doc: bool,
    /// Install the manual page where `man` finds it.
    #[arg(short = 'j', long)]
    install_doc: bool,
    /// Write the declaration in Rust: NAME.rs, with the C text as comments to be translated.
    #[arg(long)]
    rust: bool,
    /// The C or Python file is a program.
    #[arg(short, long)]
    userspace: bool,
    /// Refuse files with DOS line ends.
    #[arg(short = 'U', long)]
    unix: bool,
    /// Refuse files without a license. This is always done.
    #[arg(short = 'l', long)]
    require_license: bool,
    /// Output file.
    #[arg(short, long, value_name = "FILE")]
    outfile: Option<PathBuf>,
    /// Maximum number of personalities of a module.
    #[arg(short = 'P', long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    personalities: u32,
    /// Version of LinuxCNC whose language the .comp files are in: 2.9 or 2.10.
    #[arg(long, value_name = "VERSION", env = "HAL_COMPAT", default_value = "2.10", value_parser = ["2.9", "2.10"])]
    compat: String,
    /// Additional arguments for the compiler.
    #[arg(long, value_name = "WORDS", allow_hyphen_values = true)]
    extra_compile_args: Vec<String>,
    /// Additional arguments for the linker.
    #[arg(long, value_name = "WORDS", allow_hyphen_values = true)]
    extra_link_args: Vec<String>,
    /// Print the path of the file that makefiles include.
    #[arg(long)]
    print_modinc: bool,
    /// Print the folder with the headers.
    #[arg(long)]
    print_include: bool,
    /// The .comp, .c or .py files.
    files: Vec<PathBuf>,
}

/// Text output of a run.
#[derive(Debug, Default)]
pub struct Said {
    /// For standard output.
    pub out: String,
    /// Doubts, for standard error.
    pub doubts: String,
}

/// Executes a command line.
///
/// # Errors
/// Returns the error of the first file that fails. Files before it have been written.
pub fn run(args: &Args) -> Result<Said, Error> {
    let mut said = Said::default();
    if args.print_modinc {
        said.out = format!("{}\n", headers::modinc()?.display());
        return Ok(said);
    }
    if args.print_include {
        said.out = format!("{}\n", headers::include_folder()?.display());
        return Ok(said);
    }
    if args.outfile.is_some() && args.files.len() != 1 {
        return Err(Error::OutForSeveral);
    }
    for file in &args.files {
        match file.extension().and_then(|e| e.to_str()) {
            Some("comp") => comp(args, file, &mut said)?,
            Some("c") => plain(args, file)?,
            Some("py") => {
                if !args.install || !args.userspace {
                    return Err(not_for(file, "a Python file", "--install --userspace"));
                }
                install::python(file)?;
            }
            _ => return Err(Error::Ending { path: shown(file) }),
        }
    }
    Ok(said)
}

fn comp(args: &Args, file: &Path, said: &mut Said) -> Result<(), Error> {
    let bytes = fs::read(file).map_err(at(file))?;
    if args.unix && bytes.contains(&b'\r') {
        return Err(Error::UnixEnds { path: shown(file) });
    }
    let version = if args.compat == "2.9" { Version::V2_9 } else { Version::Latest };
    let (component, doubts) = crate::read_as(&file.display().to_string(), &bytes, version)?;
    said.doubts.push_str(&doubts.to_string());
    documents(args, &component, said)?;
    if args.rust {
        write(args, &format!("{}.rs", component.name), &crate::rust::text(&component))?;
    }
    let texts = args.document || args.adoc || args.view_doc || args.install_doc || args.rust;
    if args.compile || args.install {
        compiled(args, file, &component)?;
    } else if args.preprocess || !texts {
        let name = format!("{}.c", component.name);
        let out = args.outfile.clone().unwrap_or_else(|| PathBuf::from(&name));
        write(args, &name, &c_text(args, file, &out, &component))?;
    }
    Ok(())
}

fn documents(args: &Args, component: &Component, said: &mut Said) -> Result<(), Error> {
    let section = if component.options.on("userspace") { 1 } else { 9 };
    let page = format!("{}.{section}", component.name);
    let roff = || crate::document::roff(component);
    if args.document {
        write(args, &page, &roff())?;
    }
    if args.adoc {
        write(args, &format!("{}.adoc", component.name), &crate::document::adoc(component))?;
    }
    if let Some(keep) = &args.keep_adoc {
        let text = crate::document::adoc(component);
        hal_output::write(keep, text.as_bytes()).map_err(at(keep))?;
    }
    if args.view_doc {
        said.out.push_str(&install::view(&roff()));
    }
    if args.install_doc {
        install::page(&page, section, &roff())?;
    }
    Ok(())
}

fn c_text(args: &Args, file: &Path, out: &Path, component: &Component) -> String {
    let (source, out) = (file.display().to_string(), out.display().to_string());
    let wanted = c::Wanted { source: &source, out: &out, personalities: args.personalities };
    c::text(component, &wanted)
}

fn compiled(args: &Args, file: &Path, component: &Component) -> Result<(), Error> {
    let userspace = component.options.on("userspace");
    let target = if userspace { Target::Program } else { Target::Module };
    let out = place(args, file, &component.name, target)?;
    // The C file is temporary and is removed after compilation.
    let c_file = out.with_file_name(format!(".{}.{}.c", component.name, std::process::id()));
    let shown = format!("{}.c", component.name);
    let text = c_text(args, file, Path::new(&shown), component);
    fs::write(&c_file, text).map_err(at(&c_file))?;
    let option = |name| component.options.word(name).map(words).unwrap_or_default();
    let mut job = job(args, &c_file, file, &out, target);
    job.compile_args.extend(option("extra_compile_args"));
    job.link_args.extend(option("extra_link_args"));
    let built = build(&job);
    drop(fs::remove_file(&c_file));
    built
}

fn job<'a>(
    args: &Args,
    c_file: &'a Path,
    file: &'a Path,
    out: &'a Path,
    target: Target,
) -> Job<'a> {
    let all = |list: &[String]| list.iter().flat_map(|line| words(line)).collect();
    Job {
        c_file,
        source: file,
        out,
        target,
        installed: args.install,
        compile_args: all(&args.extra_compile_args),
        link_args: all(&args.extra_link_args),
    }
}

/// Compiles a C file as it is.
fn plain(args: &Args, file: &Path) -> Result<(), Error> {
    if !args.compile && !args.install {
        return Err(not_for(file, "a C file", "--compile and --install"));
    }
    let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let target = if args.userspace { Target::Program } else { Target::Module };
    let out = place(args, file, &name, target)?;
    build(&job(args, file, file, &out, target))
}

/// Returns the path of the result.
fn place(args: &Args, file: &Path, name: &str, target: Target) -> Result<PathBuf, Error> {
    if let Some(out) = &args.outfile {
        return Ok(out.clone());
    }
    Ok(match (target, args.install) {
        (Target::Module, true) => install::modules()?.join(format!("{name}.so")),
        (Target::Module, false) => PathBuf::from(format!("{name}.so")),
        (Target::Program, true) => install::programs()?.join(name),
        (Target::Program, false) => file.with_file_name(name),
    })
}

fn write(args: &Args, name: &str, text: &str) -> Result<(), Error> {
    let out = args.outfile.clone().unwrap_or_else(|| PathBuf::from(name));
    hal_output::write(&out, text.as_bytes()).map_err(at(&out))
}

fn not_for(file: &Path, action: &'static str, kinds: &'static str) -> Error {
    Error::NotFor { path: shown(file), action, kinds }
}

fn shown(path: &Path) -> Box<str> {
    path.display().to_string().into()
}
