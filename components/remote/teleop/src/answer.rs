//! Answers of the server, as lines.

use crate::{line::MAX_LINE, words::Code};
use core::fmt;

/// Code and text of a refusal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reason {
    /// The code; `None` if a server of another version has sent one that is unknown here.
    pub code: Option<Code>,
    /// The text, for people.
    pub text: String,
}

impl Reason {
    /// Returns the reason with this code and text.
    pub fn new(code: Code, text: impl Into<String>) -> Self {
        Self { code: Some(code), text: text.into() }
    }

    fn parse(text: &str) -> Self {
        let (word, rest) = text.split_once(' ').unwrap_or((text, ""));
        match Code::parse(word) {
            Some(code) => Self::new(code, rest),
            None => Self { code: None, text: text.to_owned() },
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let code = self.code.map_or("", Code::text);
        f.write_str(code)?;
        let blank = if code.is_empty() || self.text.is_empty() { "" } else { " " };
        write!(f, "{blank}{}", self.text)
    }
}

/// An answer of the server.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answer {
    /// The login succeeded.
    Aceptado,
    /// The login failed; the server closes the connection.
    Denegado(Reason),
    /// The program is stored.
    Recibido,
    /// A new program is refused.
    ErrorNuevo(Reason),
    /// Lines to append are refused.
    ErrorAgregar(Reason),
    /// The job has ended.
    Terminado,
    /// The job was refused, or ended by an error.
    ErrorEjecutar(Reason),
    /// Progress of the machine's job in percent.
    Avance(u8),
    /// The job is cancelled.
    Cancelado,
    /// The server closes the connection, as asked.
    Adios,
    /// The server stops.
    Desconexion,
    /// The request is refused.
    Error(Reason),
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Aceptado => f.write_str("ACEPTADO"),
            Self::Denegado(why) => write!(f, "DENEGADO {why}"),
            Self::Recibido => f.write_str("RECIBIDO"),
            Self::ErrorNuevo(why) => write!(f, "ERROR_NUEVO {why}"),
            Self::ErrorAgregar(why) => write!(f, "ERROR_AGREGAR {why}"),
            Self::Terminado => f.write_str("TERMINADO"),
            Self::ErrorEjecutar(why) => write!(f, "ERROR_EJECUTAR {why}"),
            Self::Avance(percent) => write!(f, "AVANCE {percent}"),
            Self::Cancelado => f.write_str("CANCELADO"),
            Self::Adios => f.write_str("ADIOS"),
            Self::Desconexion => f.write_str("DESCONEXION"),
            Self::Error(why) => write!(f, "ERROR {why}"),
        }
    }
}

impl Answer {
    /// Returns the answer of a line; `None` if it is none.
    pub fn parse(line: &str) -> Option<Self> {
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        let why = || Reason::parse(rest.trim());
        Some(match word.to_ascii_uppercase().as_str() {
            "ACEPTADO" => Self::Aceptado,
            "DENEGADO" => Self::Denegado(why()),
            "RECIBIDO" => Self::Recibido,
            "ERROR_NUEVO" => Self::ErrorNuevo(why()),
            "ERROR_AGREGAR" => Self::ErrorAgregar(why()),
            "TERMINADO" => Self::Terminado,
            "ERROR_EJECUTAR" => Self::ErrorEjecutar(why()),
            "AVANCE" => Self::Avance(rest.trim().parse().ok().filter(|n| *n <= 100)?),
            "CANCELADO" => Self::Cancelado,
            "ADIOS" => Self::Adios,
            "DESCONEXION" => Self::Desconexion,
            "ERROR" => Self::Error(why()),
            _ => return None,
        })
    }

    /// Returns the answer as a line of at most [`MAX_LINE`] bytes, with its end.
    pub(crate) fn line(&self) -> String {
        let text = self.to_string();
        let mut line: String =
            text.trim_end().chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        line.truncate(line.floor_char_boundary(MAX_LINE));
        line.push_str("\r\n");
        line
    }
}
