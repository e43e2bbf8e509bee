//! Looking at a machine as a whole: the running one, or one on trial.

use crate::{
    Command, Error, Session,
    command::Subject,
    options::{Given, Opt, options},
    order,
    trial::Trial,
};
use hal_protocol::{Link, Reply, Request};

/// Asks the machine that is looked at.
type Ask<'a> = dyn FnMut(Request) -> Result<Reply, Error> + 'a;

const ORDER: &[Opt<char>] = &[Opt::short_with('i', 'i', "FILE"), long('s', "script", None)];

const fn long(id: char, name: &'static str, value: Option<&'static str>) -> Opt<char> {
    Opt { id, short: None, long: Some(name), value, variable: None, help: "" }
}

/// The words of `order`.
pub(crate) fn order(words: &[String]) -> Result<Command, Error> {
    let (given, files) = mixed("order", ORDER, words)?;
    let script = given.iter().any(|(id, _)| *id == 's');
    Ok(Command::Order(subject(&given, files), script))
}

fn subject(given: &[(char, Option<String>)], files: Vec<String>) -> Subject {
    let ini = given.iter().rev().find(|(id, _)| *id == 'i').and_then(|(_, ini)| ini.clone());
    match ini {
        // An INI file by itself is a machine.
        Some(ini) if files.is_empty() => Subject { files: vec![ini], ini: None },
        ini => Subject { files, ini },
    }
}

/// Options before, between and after other words.
pub(crate) fn mixed(
    command: &'static str,
    table: &[Opt<char>],
    words: &[String],
) -> Result<Given<char>, Error> {
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
    /// `order`.
    pub(crate) fn order(&mut self, subject: &Subject, script: bool) -> Result<(), Error> {
        self.examine(subject, &mut |ask| ask(Request::Order), &mut |reply| match reply {
            Reply::Order(info) if script => Some(order::script(info)),
            Reply::Order(info) => Some(order::text(info)),
            _ => None,
        })
    }

    /// Asks the running machine, or one made of files, and prints the answer. Lines of the files
    /// that were refused are said, and make it a failure.
    fn examine(
        &mut self,
        subject: &Subject,
        look: &mut dyn FnMut(&mut Ask<'_>) -> Result<Reply, Error>,
        words: &mut dyn FnMut(&Reply) -> Option<String>,
    ) -> Result<(), Error> {
        if subject.files.is_empty() {
            let reply = look(&mut |request| self.ask(request))?;
            return self.print(&reply, words);
        }
        let mut trial = Trial::of(&subject.files, subject.ini.as_deref())?;
        for refusal in &trial.attempt().refusals {
            self.refuse(&refusal.at, &refusal.error);
        }
        let refused = !trial.attempt().refusals.is_empty();
        let reply = look(&mut |request| trial.engine().call(request).map_err(Error::Engine))?;
        self.print(&reply, words)?;
        if refused { Err(Error::Told) } else { Ok(()) }
    }
}
