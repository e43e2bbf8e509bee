//! Reasons why a connection or a run has ended.

use crate::{Refusal, Stopped};

/// Declares the reasons: number at the pin `error`, and text with the number of the line.
macro_rules! causes {
    ($($name:ident = $number:literal, $doc:literal, $text:literal;)*) => {
        /// Reason why a connection or a run has ended.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Cause { $(#[doc = $doc] $name,)* }

        impl Cause {
            const fn row(self) -> (i32, &'static str) {
                match self { $(Self::$name => ($number, $text),)* }
            }
        }
    };
}

causes! {
    Command = 1, "A command.", "stopped at line {}";
    Enable = 2, "The e-stop chain.", "robot.enable is FALSE: stopped at line {}";
    Lost = 3, "The connection.", "the connection to the controller was lost at line {}";
    Silent = 4, "No answer.", "the controller does not answer line {}";
    Unknown = 5, "A refusal.", "the controller does not know line {}";
    Format = 5, "A refusal.", "the controller finds wrong numbers in line {}";
    Range = 5, "A refusal.", "the controller finds line {} outside its range";
    Busy = 6, "Another client.", "another client is connected to the controller";
    Unreachable = 7, "No connection.", "the controller cannot be reached: robot.status has the reason";
    Worker = 8, "The worker.", "the worker of robot did not work: stopped at line {}";
    Function = 9, "The function.", "function robot is in no thread that runs: stopped at line {}";
    Instance = 10, "The instance.", "the instance has stopped: stopped at line {}";
}

impl Cause {
    /// Returns the number at the pin `error`.
    pub(crate) const fn number(self) -> i32 {
        self.row().0
    }

    /// Returns the text, with a place for the number of the line.
    pub(crate) const fn text(self) -> &'static str {
        self.row().1
    }

    /// Returns the reason that a driver gives.
    pub(crate) const fn of(stopped: &Stopped) -> Self {
        match stopped {
            Stopped::User(_) => Self::Command,
            Stopped::Lost(_) => Self::Lost,
            Stopped::Silent(_) => Self::Silent,
            Stopped::Refused(_, Refusal::Unknown) => Self::Unknown,
            Stopped::Refused(_, Refusal::Format) => Self::Format,
            Stopped::Refused(_, Refusal::Range) => Self::Range,
            Stopped::Refused(_, Refusal::Busy) | Stopped::Busy => Self::Busy,
        }
    }

    /// Returns the text with the number of the line.
    pub(crate) fn with(self, line: usize) -> String {
        self.text().replace("{}", &line.to_string())
    }
}
