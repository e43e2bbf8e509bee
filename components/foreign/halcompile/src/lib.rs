//! `halcompile`: components in the `.comp` language and in C, made into what Ferrule loads.
//!
//! A `.comp` file declares pins, parameters and functions, and holds C text after a line `;;`. [`read`] turns it into a
//! [`Component`], or reports all faults with their places. A component is turned into C text ([`c`]), a manual page
//! ([`document`]), or a declaration in Rust ([`rust`]); [`build`] makes a library of the C text with the system's
//! compiler.
#![forbid(unsafe_code)]

pub mod build;
pub mod c;
mod check;
pub mod command;
pub mod document;
mod error;
mod expr;
mod grammar;
pub mod headers;
pub mod install;
mod name;
mod options;
mod place;
mod problem;
mod program;
pub mod rust;
mod token;
mod tree;

pub use check::Component;
pub use error::Error;
pub use expr::Expr;
pub use options::{OPTIONS, Options, Row, Takes};
pub use place::{Fault, Report, Span};
pub use problem::Problem;
pub use tree::*;

/// Parses and checks a file. Returns the component and the warnings.
///
/// # Errors
/// All faults of the file, ready to be shown.
pub fn read(file: &str, bytes: &[u8]) -> Result<(Component, Report), Report> {
    read_as(file, bytes, Version::Latest)
}

/// Version of LinuxCNC whose language a file is read in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Version {
    /// Version 2.9, in which functions have their period also with `option period no`.
    V2_9,
    /// The latest one.
    #[default]
    Latest,
}

/// Does the same in the language of a version.
///
/// # Errors
/// As for [`read`].
pub fn read_as(file: &str, bytes: &[u8], version: Version) -> Result<(Component, Report), Report> {
    let text = match core::str::from_utf8(bytes) {
        Ok(text) => text,
        Err(e) => {
            let start = e.valid_up_to();
            let fault = Fault { span: Span { start, end: start + 1 }, problem: Problem::NotText };
            return Err(Report::new(file, &String::from_utf8_lossy(bytes), vec![fault]));
        }
    };
    let fail = |faults| Report::new(file, text, faults);
    let tree = grammar::parse(text).map_err(fail)?;
    let named = tree.name.clone();
    let (mut component, doubts) = check::check(tree, text).map_err(fail)?;
    let stem = std::path::Path::new(file).file_stem().unwrap_or_default().to_string_lossy();
    if stem != component.name {
        let (name, file) = (component.name.as_str().into(), stem.as_ref().into());
        return Err(fail(vec![Fault {
            span: named.span,
            problem: Problem::FileName { name, file },
        }]));
    }
    if version == Version::V2_9 {
        component.options.keep_period();
    }
    if let Some(fault) = check::misses_period(&component) {
        return Err(fail(vec![fault]));
    }
    Ok((component, Report::new(file, text, doubts)))
}
