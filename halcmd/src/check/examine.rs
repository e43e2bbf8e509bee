//! `order` and `graph`: examination of the running machine, or of one in a dry run.

use crate::{
    Error, Session,
    graph::{self, Drawing, Format, Wanted},
    language::command::Subject,
    order,
    session::dry_run::DryRun,
    session::execute::written,
};
use hal_protocol::{Link, Reply, Request};

/// Sends a request to the machine that is examined.
type SendRequest<'a> = dyn FnMut(Request) -> Result<Reply, Error> + 'a;

impl Session<'_> {
    /// Executes `order`.
    pub(crate) fn order(&mut self, subject: &Subject, script: bool) -> Result<(), Error> {
        let (reply, refused) = self.examine(subject, &mut |ask| ask(Request::Order))?;
        self.print(&reply, |reply| match reply {
            Reply::Order(info) if script => Some(order::script(info)),
            Reply::Order(info) => Some(order::text(info)),
            _ => None,
        })?;
        if refused { Err(Error::AlreadyReported) } else { Ok(()) }
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
            None => self.out(&text)?,
            Some(file) => written(file, &text)?,
        }
        if refused { Err(Error::AlreadyReported) } else { Ok(()) }
    }

    /// Examines the running machine, or a machine made from files. Reports refused lines of the
    /// files, and returns whether there were any.
    fn examine<T>(
        &mut self,
        subject: &Subject,
        look: &mut dyn FnMut(&mut SendRequest<'_>) -> Result<T, Error>,
    ) -> Result<(T, bool), Error> {
        if subject.files.is_empty() {
            return Ok((look(&mut |request| self.ask(request))?, false));
        }
        let mut dry_run = DryRun::of(&subject.files, subject.ini.as_deref())?;
        for refusal in &dry_run.result().refusals {
            self.refuse(&refusal.at, &refusal.error);
        }
        let refused = !dry_run.result().refusals.is_empty();
        let seen = look(&mut |request| dry_run.engine().call(request).map_err(Error::Engine))?;
        Ok((seen, refused))
    }
}
