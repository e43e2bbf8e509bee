//! Waits of a program that `--run` runs: reported once, and bounded where nobody at a terminal can help.

use super::job::Status;
use crate::Session;
use hal_protocol::{Kind, Reply, Request};

/// Exit status of halrun after a wait that has lasted for `--max-wait`.
pub(super) const WAITED: u8 = 3;

/// `--max-wait` off a terminal, if it is not given.
const MAX_WAIT_NS: u64 = 60_000_000_000;

/// Waits for a person, a tool or a page are told at once; others may be the ramp of a spindle, or a program that is about to
/// end.
const AT_ONCE: [&str; 8] = ["m0", "m1", "m60", "pause", "step", "tool", "page", "spindle-stopped"];
const SOON_NS: u64 = 1_000_000_000;
/// Waits that end by themselves are told later.
const LATER_NS: u64 = 5_000_000_000;

/// Longest wait, as the command line gives it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum MaxWait {
    /// A minute of machine time off a terminal, and no limit on one.
    #[default]
    Preset,
    /// No limit.
    Never,
    /// Nanoseconds of machine time.
    Ns(u64),
}

impl MaxWait {
    /// Parses `never` or a time.
    pub(super) fn parse(text: &str) -> Option<Self> {
        match text {
            "never" => Some(Self::Never),
            time => crate::nanoseconds(time).ok().map(Self::Ns),
        }
    }

    const fn ns(self, is_person: bool) -> Option<u64> {
        match self {
            Self::Ns(ns) => Some(ns),
            Self::Preset if !is_person => Some(MAX_WAIT_NS),
            Self::Preset | Self::Never => None,
        }
    }
}

/// The wait in progress.
pub(super) struct Waiting {
    most_ns: Option<u64>,
    /// Kind, object and begin of the wait, as `task.status` writes them.
    words: String,
    /// Machine time for which it has lasted, and for which it has been one that does not end by itself.
    lasted_ns: u64,
    endless_ns: u64,
    is_told: bool,
}

/// Result of a look at the wait.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum WaitLook {
    /// Nothing new.
    Same,
    /// A wait that is to be told: who is waited for, and how to go on.
    Tell(String),
    /// The wait has lasted for too long.
    TooLong(String),
}

impl Waiting {
    pub(super) fn new(most: MaxWait, is_person: bool) -> Self {
        Self {
            most_ns: most.ns(is_person),
            words: String::new(),
            lasted_ns: 0,
            endless_ns: 0,
            is_told: false,
        }
    }

    /// Looks at the status, after this machine time since the last look.
    pub(super) fn look(&mut self, status: &Status, ns: u64) -> WaitLook {
        let Some((words, until, text)) = status.wait() else {
            *self = Self { most_ns: self.most_ns, ..Self::new(MaxWait::Never, true) };
            return WaitLook::Same;
        };
        if words != self.words {
            *self = Self {
                most_ns: self.most_ns,
                words: words.to_owned(),
                ..Self::new(MaxWait::Never, true)
            };
        }
        let ends = until != "never";
        self.lasted_ns += ns;
        self.endless_ns = if ends { 0 } else { self.endless_ns + ns };
        if self.most_ns.is_some_and(|most| self.endless_ns >= most && !ends) {
            return WaitLook::TooLong(text.to_owned());
        }
        let is_at_once = words.split(' ').next().is_some_and(|kind| AT_ONCE.contains(&kind));
        let is_due = match ends {
            true => self.lasted_ns >= LATER_NS,
            false => is_at_once || self.endless_ns >= SOON_NS,
        };
        if self.is_told || !is_due {
            return WaitLook::Same;
        }
        self.is_told = true;
        WaitLook::Tell(text.to_owned())
    }

    /// Returns the longest wait in seconds.
    pub(super) fn most(&self) -> f64 {
        self.most_ns.unwrap_or(0) as f64 / 1e9
    }
}

/// Returns the text of a wait, with the pins in it that no signal drives.
pub(super) fn with_links(session: &mut Session<'_>, text: &str) -> String {
    let mut out = text.to_owned();
    for word in text.split(' ').map(|word| word.trim_end_matches([';', ',', ':', '.'])) {
        // `task.abort` is a pin too, but the text means the command.
        if !word.contains('.') || word.starts_with("task.") {
            continue;
        }
        let list = Request::List { kind: Kind::Pins, patterns: vec![word.to_owned()], ty: None };
        if let Ok(Reply::Items(pins)) = session.ask(list)
            && pins.iter().any(|pin| pin.name == word && pin.signal.is_none())
        {
            out.push_str(&format!(" ({word} is not linked)"));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(wait: &str) -> Status {
        Status::new(vec!["task state=on".to_owned(), wait.to_owned()])
    }

    #[test]
    fn a_wait_is_told_once_and_ends_at_its_bound() {
        let mut waiting = Waiting::new(MaxWait::Ns(5_000_000_000), false);
        let person = status("wait for=m0 number=0 since=1.000 until=never a person at M0");
        let second = 1_000_000_000;
        let looks: Vec<WaitLook> = (0..5).map(|_| waiting.look(&person, second)).collect();
        let text = "a person at M0".to_owned();
        assert_eq!(looks[0], WaitLook::Tell(text.clone()));
        assert!(looks[1..4].iter().all(|look| *look == WaitLook::Same), "{looks:?}");
        assert_eq!(looks[4], WaitLook::TooLong(text));
    }

    #[test]
    fn a_ramp_and_time_do_not_count() {
        let mut waiting = Waiting::new(MaxWait::Ns(1_000_000_000), false);
        let ramp = status("wait for=at-speed number=0 since=1.000 until=itself the speed");
        let stands = status("wait for=at-speed number=0 since=1.000 until=never the speed");
        let look = |waiting: &mut Waiting, status| waiting.look(status, 400_000_000);
        for _ in 0..10 {
            assert_eq!(look(&mut waiting, &ramp), WaitLook::Same);
        }
        assert_eq!(look(&mut waiting, &stands), WaitLook::Same);
        assert_eq!(look(&mut waiting, &stands), WaitLook::Same);
        assert_eq!(look(&mut waiting, &stands), WaitLook::TooLong("the speed".to_owned()));
        // Another wait counts from its own begin.
        let later = status("wait for=at-speed number=0 since=9.000 until=never the speed");
        let none = status("tool number=0");
        assert_eq!(look(&mut waiting, &later), WaitLook::Same);
        assert_eq!(look(&mut waiting, &none), WaitLook::Same);
        assert_eq!(look(&mut waiting, &later), WaitLook::Same);
    }

    #[test]
    fn bounds() {
        assert_eq!(MaxWait::parse("never"), Some(MaxWait::Never));
        assert_eq!(MaxWait::parse("2s"), Some(MaxWait::Ns(2_000_000_000)));
        assert_eq!(MaxWait::parse("2"), None);
        assert_eq!(MaxWait::Preset.ns(true), None);
        assert_eq!(MaxWait::Preset.ns(false), Some(60_000_000_000));
    }
}
