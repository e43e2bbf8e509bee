//! Requests of a client: the table of states.

use crate::{
    answer::{Answer, Reason},
    line::TextLine,
    server::{Action, CurrentJob, MAX_SESSIONS, Phase, Server, full},
    session::{Wait, refusal},
    words::{Code, Word},
};

/// Refusals in a row before the login, after which the connection closes.
const MAX_REFUSALS: u32 = 10;
/// Longest name of a user in bytes.
const MAX_USER: usize = 32;
/// Longest part of a request that an answer repeats, in characters.
const MAX_SHOWN: usize = 32;

impl Server {
    /// Executes the requests that have arrived, up to one whose answer comes later.
    pub(crate) fn work(&mut self, id: u64, now: u64) {
        loop {
            if self.is_stopped() {
                return;
            }
            let Some(session) = self.sessions.get_mut(&id).filter(|s| !s.closes) else { return };
            if session.wait == Some(Wait::Start) {
                if session.hold() {
                    self.cancel_start(id);
                }
                return;
            }
            if session.wait.is_some() {
                return;
            }
            let Some(line) = session.next_line() else { return };
            session.heard = now;
            if let Some(payload) = session.payload.take() {
                session.read(payload, &line);
            } else {
                self.request(id, &line);
            }
            self.count_refusals(id);
        }
    }

    /// Cancels the start of a client's job: nothing shall begin to move.
    fn cancel_start(&mut self, id: u64) {
        if let Some(CurrentJob { owner, phase: Phase::Starts, .. }) = self.job
            && owner == Some(id)
        {
            self.cancel(true);
        }
    }

    /// Closes a connection that is only refused.
    fn count_refusals(&mut self, id: u64) {
        let Some(session) = self.sessions.get_mut(&id) else { return };
        if session.user.is_none() && session.refusals >= MAX_REFUSALS {
            self.close(id);
        }
    }

    fn request(&mut self, id: u64, line: &TextLine) {
        let line = match line {
            TextLine::Text(text) => text.trim(),
            TextLine::Long => {
                return self.refuse(id, Code::Largo, "a line has at most 1024 bytes".to_owned());
            }
            TextLine::NoText => {
                return self.refuse(id, Code::Desconocido, "the line is no UTF-8".to_owned());
            }
        };
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim_start();
        if word.is_empty() {
            return;
        }
        let Some(request) = Word::parse(word) else {
            let shown: String = word.chars().take(MAX_SHOWN).collect();
            return self.refuse(id, Code::Desconocido, format!("{shown} is no request"));
        };
        let takes_rest =
            matches!(request, Word::Ingresar | Word::EnviarNuevo | Word::EnviarAgregar);
        if !takes_rest && !rest.is_empty() {
            let text = format!("{} has no argument", request.text());
            return self.refuse(id, Code::Desconocido, text);
        }
        let Some(session) = self.sessions.get_mut(&id) else { return };
        let is_new = session.user.is_none();
        match request {
            Word::Ingresar if is_new => self.sign_in(id, rest),
            Word::Ingresar => self.refuse(id, Code::Orden, "you have logged in".to_owned()),
            Word::Salir if is_new || !self.is_owner(id) => {
                self.tell(Some(id), &Answer::Adios);
                self.close(id);
            }
            Word::Salir => self.refuse(id, Code::Ocupado, "your job runs".to_owned()),
            Word::EnviarNuevo | Word::EnviarAgregar => self.send(id, request, rest),
            Word::Ejecutar | Word::Avance | Word::Cancelar if is_new => self.log_in_first(id),
            Word::Avance => {
                let answer = Answer::Avance(self.progress());
                self.tell(Some(id), &answer);
            }
            Word::Ejecutar => self.execute(id),
            Word::Cancelar => match self.job {
                Some(CurrentJob { owner, phase: Phase::Runs, .. }) if owner == Some(id) => {
                    self.cancel(true);
                    self.wait(id, Wait::Cancel);
                }
                Some(CurrentJob { owner, phase: Phase::Ends { by_owner: true }, .. })
                    if owner == Some(id) =>
                {
                    self.wait(id, Wait::Cancel);
                }
                Some(CurrentJob { owner, phase: Phase::Cancelled, .. }) if owner == Some(id) => {
                    self.job = None;
                    self.tell(Some(id), &Answer::Cancelado);
                }
                Some(CurrentJob { owner, .. }) if owner == Some(id) => {
                    self.refuse(id, Code::Ocupado, "the server stops".to_owned());
                }
                Some(_) => {
                    let text = "the job is another session's".to_owned();
                    self.refuse(id, Code::Permiso, text);
                }
                None => self.tell(Some(id), &Answer::Cancelado),
            },
        }
    }

    fn is_owner(&self, id: u64) -> bool {
        self.job.is_some_and(|job| job.owner == Some(id))
    }

    fn wait(&mut self, id: u64, wait: Wait) {
        if let Some(session) = self.sessions.get_mut(&id) {
            session.wait = Some(wait);
        }
    }

    fn refuse(&mut self, id: u64, code: Code, text: String) {
        self.tell(Some(id), &Answer::Error(Reason::new(code, text)));
        if let Some(session) = self.sessions.get_mut(&id) {
            session.refusals += 1;
        }
    }

    fn log_in_first(&mut self, id: u64) {
        self.refuse(id, Code::Orden, "log in first".to_owned());
    }

    fn sign_in(&mut self, id: u64, rest: &str) {
        // A person has seen where the user ends and the secret begins.
        let (user, secret) = rest.split_once(':').unwrap_or((rest, ""));
        let usual = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
        let is_name = !user.is_empty() && user.len() <= MAX_USER && user.chars().all(usual);
        if !is_name || secret.is_empty() {
            let text = format!(
                "INGRESAR USER:SECRET; a user has 1 to {MAX_USER} letters, digits, dots, underscores and dashes"
            );
            return self.deny(id, Reason::new(Code::Permiso, text));
        }
        if self.users() >= MAX_SESSIONS {
            return self.deny(id, full());
        }
        let (user, secret) = (user.to_owned(), secret.to_owned());
        self.wait(id, Wait::SignIn(user.clone()));
        self.actions.push_back(Action::SignIn { id, user, secret });
    }

    fn send(&mut self, id: u64, word: Word, line: &str) {
        let owns = self.is_owner(id);
        let Some(session) = self.sessions.get_mut(&id) else { return };
        let why = |code, text: &str| Reason::new(code, text);
        let refused = if session.user.is_none() {
            session.refusals += 1;
            Some(Answer::Error(why(Code::Orden, "log in first")))
        } else if owns {
            Some(refusal(word, why(Code::Ocupado, "your job runs")))
        } else if session.works {
            None
        } else {
            Some(refusal(word, may_not()))
        };
        session.begin(word, line, refused);
    }

    fn execute(&mut self, id: u64) {
        let why = match (&self.job, &self.machine.busy) {
            (Some(job), _) if job.owner == Some(id) => {
                Some(Reason::new(Code::Ocupado, "your job runs"))
            }
            (Some(_), _) => Some(Reason::new(Code::Ocupado, "another job runs")),
            (None, Some(busy)) => Some(Reason::new(Code::Ocupado, busy.clone())),
            (None, None) => None,
        };
        let Some(session) = self.sessions.get(&id) else { return };
        let why = match why {
            Some(_) => why,
            None if !session.works => Some(may_not()),
            None if session.program.iter().all(u8::is_ascii_whitespace) => {
                Some(Reason::new(Code::Vacio, "send a program first"))
            }
            None => None,
        };
        match why {
            Some(why) => self.tell(Some(id), &Answer::ErrorEjecutar(why)),
            None => {
                let program = session.program.clone();
                self.begin(id, program);
                self.wait(id, Wait::Start);
            }
        }
    }
}

/// Returns the refusal of a user who only looks on.
fn may_not() -> Reason {
    Reason::new(Code::Permiso, "this needs the role operator")
}
