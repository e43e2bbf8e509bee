//! `order` and `graph`: examination of the running machine, or of one on trial.

use crate::{
    Command, Error, Session,
    graph::{self, Drawing, Format, Wanted},
    language::command::Subject,
    order,
    programs::options::{Given, Opt, options},
    session::dry_run::Trial,
    session::execute::written,
};
use hal_protocol::{Link, Reply, Request};

/// Sends a request to the machine that is examined.
type Ask<'a> = dyn FnMut(Request) -> Result<Reply, Error> + 'a;

const ORDER: &[Opt<char>] = &[Opt::short_with('i', 'i', "FILE"), long('s', "script", None)];

const fn long(id: char, name: &'static str, value: Option<&'static str>) -> Opt<char> {
    Opt { id, short: None, long: Some(name), value, variable: None, help: "" }
}

const GRAPH: &[Opt<char>] = &[
    Opt::short_with('i', 'i', "FILE"),
    Opt::short_with('o', 'o', "FILE"),
    long('d', "dot", None),
    long('m', "mermaid", None),
    long('s', "svg", None),
    long('a', "all", None),
    long('p', "params", None),
];

/// Parses the arguments of `graph`.
pub(crate) fn graph(words: &[String]) -> Result<Command, Error> {
    let (given, others) = mixed("graph", GRAPH, words)?;
    let has = |wanted| given.iter().any(|(id, _)| *id == wanted);
    let file = given.iter().rev().find(|(id, _)| *id == 'o').and_then(|(_, file)| file.clone());
    let said = given.iter().rev().find_map(|(id, _)| match id {
        'd' => Some(Format::Dot),
        'm' => Some(Format::Mermaid),
        's' => Some(Format::Svg),
        _ => None,
    });
    let format = said.or_else(|| Format::of(file.as_deref()?)).unwrap_or_default();
    // A word that is not a file of a machine is a pattern.
    let is_file = |w: &String| w.ends_with(".hal") || w.ends_with(".ini") || w.contains('/');
    let (files, patterns) = others.into_iter().partition(is_file);
    let wanted = Wanted { patterns, all: has('a'), params: has('p') };
    Ok(Command::Graph(subject(&given, files), wanted, format, file))
}

/// Parses the arguments of `order`.
pub(crate) fn order(words: &[String]) -> Result<Command, Error> {
    let (given, files) = mixed("order", ORDER, words)?;
    let script = given.iter().any(|(id, _)| *id == 's');
    Ok(Command::Order(subject(&given, files), script))
}

fn subject(given: &[(char, Option<String>)], files: Vec<String>) -> Subject {
    let ini = given.iter().rev().find(|(id, _)| *id == 'i').and_then(|(_, ini)| ini.clone());
    match ini {
        // An INI file without other files is a machine.
        Some(ini) if files.is_empty() => Subject { files: vec![ini], ini: None },
        ini => Subject { files, ini },
    }
}

/// Parses options before, between and after other words.
pub(crate) fn mixed<T: Copy>(
    command: &'static str,
    table: &[Opt<T>],
    words: &[String],
) -> Result<Given<T>, Error> {
    let (mut given, mut others) = (Vec::new(), Vec::new());
    let mut rest = words.to_vec();
    while !rest.is_empty() {
        let (options, words) = options(command, table, &rest)?;
        given.extend(options);
        let mut words = words.into_iter();
        others.extend(words.next());
        rest = words.collect();
    }
    Ok((given, others))
}

impl Session<'_> {
    /// Executes `order`.
    pub(crate) fn order(&mut self, subject: &Subject, script: bool) -> Result<(), Error> {
        let (reply, refused) = self.examine(subject, &mut |ask| ask(Request::Order))?;
        self.print(&reply, |reply| match reply {
            Reply::Order(info) if script => Some(order::script(info)),
            Reply::Order(info) => Some(order::text(info)),
            _ => None,
        })?;
        if refused { Err(Error::Told) } else { Ok(()) }
    }

    /// Executes `graph`.
    pub(crate) fn graph(
        &mut self,
        subject: &Subject,
        wanted: &Wanted,
        format: Format,
        file: Option<&str>,
    ) -> Result<(), Error> {
        let title = if subject.files.is_empty() {
            self.instance.clone()
        } else {
            let name = |f: &String| f.rsplit('/').next().unwrap_or(f).to_owned();
            subject.files.iter().map(name).collect::<Vec<_>>().join(" ")
        };
        let (drawing, refused) =
            self.examine(subject, &mut |ask| Drawing::of(&title, wanted, ask))?;
        let text = if self.style.json {
            serde_json::to_string(&drawing).map_err(|_| Error::Unexpected)? + "\n"
        } else {
            graph::text(&drawing, format)
        };
        match file {
            None => self.terminal.out(&text)?,
            Some(file) => written(file, &text)?,
        }
        if refused { Err(Error::Told) } else { Ok(()) }
    }

    /// Examines the running machine, or a machine made from files. Reports refused lines of the
    /// files, and returns whether there were any.
    fn examine<T>(
        &mut self,
        subject: &Subject,
        look: &mut dyn FnMut(&mut Ask<'_>) -> Result<T, Error>,
    ) -> Result<(T, bool), Error> {
        if subject.files.is_empty() {
            return Ok((look(&mut |request| self.ask(request))?, false));
        }
        let mut trial = Trial::of(&subject.files, subject.ini.as_deref())?;
        for refusal in &trial.attempt().refusals {
            self.refuse(&refusal.at, &refusal.error);
        }
        let refused = !trial.attempt().refusals.is_empty();
        let seen = look(&mut |request| trial.engine().call(request).map_err(Error::Engine))?;
        Ok((seen, refused))
    }
}
