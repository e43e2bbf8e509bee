//! The words of the protocol: requests of a client, and codes of refusals.

/// A request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Word {
    /// Log in.
    Ingresar,
    /// Replace the session's program.
    EnviarNuevo,
    /// Append to the session's program.
    EnviarAgregar,
    /// Run the program.
    Ejecutar,
    /// Ask for the progress.
    Avance,
    /// Cancel the job.
    Cancelar,
    /// Leave.
    Salir,
}

/// A row of the table of requests.
#[derive(Clone, Copy, Debug)]
pub struct RequestRow {
    /// The request.
    pub word: Word,
    /// Keyword.
    pub text: &'static str,
    /// Argument, as the manual writes it; empty without one.
    pub argument: &'static str,
    /// Answers.
    pub answers: &'static str,
    /// Effect.
    pub doc: &'static str,
}

const fn request(
    word: Word,
    text: &'static str,
    argument: &'static str,
    answers: &'static str,
    doc: &'static str,
) -> RequestRow {
    RequestRow { word, text, argument, answers, doc }
}

/// All requests.
pub const REQUESTS: &[RequestRow] = &[
    request(
        Word::Ingresar,
        "INGRESAR",
        "USER:SECRET",
        "ACEPTADO, DENEGADO",
        "Logs in. DENEGADO closes the connection.",
    ),
    request(
        Word::EnviarNuevo,
        "ENVIAR_NUEVO",
        "[LINE]",
        "RECIBIDO, ERROR_NUEVO",
        "Replaces the program of this session. Nothing is checked yet.",
    ),
    request(
        Word::EnviarAgregar,
        "ENVIAR_AGREGAR",
        "[LINE]",
        "RECIBIDO, ERROR_AGREGAR",
        "Appends lines to the program of this session.",
    ),
    request(
        Word::Ejecutar,
        "EJECUTAR",
        "",
        "TERMINADO, ERROR_EJECUTAR",
        "Checks the program and runs it. The start has no answer: TERMINADO comes when the motion has ended.",
    ),
    request(
        Word::Avance,
        "AVANCE",
        "",
        "AVANCE PERCENT",
        "Tells how much of the machine's job is done.",
    ),
    request(
        Word::Cancelar,
        "CANCELAR",
        "",
        "CANCELADO",
        "Brakes and ends the job of this session; answered when it has ended, without a TERMINADO.",
    ),
    request(Word::Salir, "SALIR", "", "ADIOS", "Leaves; the server closes the connection."),
];

/// Kind of a refusal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Code {
    /// The machine works for somebody else, or the user has a session.
    Ocupado,
    /// There is no program.
    Vacio,
    /// The machine is off, or permits no remote motion.
    Apagado,
    /// The machine is not adjusted.
    SinAjuste,
    /// The program has an error.
    Sintaxis,
    /// The program leaves the machine's travel.
    Limite,
    /// The job ended by an error.
    Falla,
    /// The job was cancelled because the server stops.
    Detenido,
    /// The request is unknown.
    Desconocido,
    /// The request is not possible now.
    Orden,
    /// A line or a program is too long.
    Largo,
    /// This user may not do this.
    Permiso,
}

/// A row of the table of codes.
#[derive(Clone, Copy, Debug)]
pub struct CodeRow {
    /// The code.
    pub code: Code,
    /// Word.
    pub text: &'static str,
    /// Meaning.
    pub doc: &'static str,
}

const fn code(code: Code, text: &'static str, doc: &'static str) -> CodeRow {
    CodeRow { code, text, doc }
}

/// All codes. A start checks those that refuse it in this order. If a stop has ended the start, the answer names that stop and
/// not the job or the motion that the stop has yet to end.
pub const CODES: &[CodeRow] = &[
    code(
        Code::Ocupado,
        "OCUPADO",
        "the machine works for somebody, somebody has the control lease, or a stop has come since the request; at a login: the user has a session, or there are 16",
    ),
    code(Code::Vacio, "VACIO", "no program has been sent"),
    code(
        Code::Apagado,
        "APAGADO",
        "the machine is off or in e-stop, or `remote.allow-motion` is FALSE",
    ),
    code(Code::SinAjuste, "SIN_AJUSTE", "the machine is not adjusted: a joint is not homed"),
    code(
        Code::Sintaxis,
        "SINTAXIS",
        "the program has an error; the line and the reason follow. A text that is no UTF-8 too",
    ),
    code(
        Code::Limite,
        "LIMITE",
        "the program leaves the machine's travel; the line, the place and the limit follow",
    ),
    code(
        Code::Falla,
        "FALLA",
        "the job ended by an error: a limit, an e-stop, a fault, an abort at the machine",
    ),
    code(Code::Detenido, "DETENIDO", "the job was cancelled because the server stops"),
    code(Code::Desconocido, "DESCONOCIDO", "there is no such request"),
    code(Code::Orden, "ORDEN", "the request is not possible now: log in first, or only once"),
    code(Code::Largo, "LARGO", "a line has more than 1024 bytes, or a program more than 16 MiB"),
    code(
        Code::Permiso,
        "PERMISO",
        "the job is another session's, the role may not do this, or the login is wrong",
    ),
];

impl Word {
    /// Returns the request of a keyword, in capitals or not.
    pub fn parse(text: &str) -> Option<Self> {
        let row = REQUESTS.iter().find(|row| row.text.eq_ignore_ascii_case(text));
        row.map(|row| row.word)
    }

    /// Returns the keyword.
    pub fn text(self) -> &'static str {
        REQUESTS.iter().find(|row| row.word == self).map_or("", |row| row.text)
    }
}

impl Code {
    /// Returns the code of a word, in capitals or not.
    pub fn parse(text: &str) -> Option<Self> {
        CODES.iter().find(|row| row.text.eq_ignore_ascii_case(text)).map(|row| row.code)
    }

    /// Returns the word.
    pub fn text(self) -> &'static str {
        CODES.iter().find(|row| row.code == self).map_or("", |row| row.text)
    }
}
