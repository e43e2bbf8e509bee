//! Waits: what a machine or a job waits for, and how it goes on.

/// Condition for which a machine or a job waits. Its number is that of the field `wait` of the snapshots
/// `motion.status` and `task.status`, and `wait_number` is the object: a spindle, a tool, an input, a user code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
pub enum Wait {
    /// Nothing.
    #[default]
    Nothing = 0,
    /// The speed of a spindle (`spindle.N.at-speed`).
    AtSpeed = 1,
    /// The index of a spindle, at which a thread or a tap begins.
    Index = 2,
    /// A spindle that turns to an angle (`spindle.N.is-oriented`).
    Orient = 3,
    /// A resume, after somebody has stopped a spindle that the program needs.
    SpindleStopped = 4,
    /// A resume, after a pause.
    Pause = 5,
    /// The end of `motion.feed-hold`.
    FeedHold = 6,
    /// The end of `motion.feed-inhibit`.
    FeedInhibit = 7,
    /// An override or an adaptive feed above 0.
    Override = 8,
    /// A measured speed, which a feed per turn follows (`spindle.N.speed-in`).
    SpindleSpeed = 9,
    /// A person, at M0.
    Stop = 10,
    /// A person, at M1.
    OptionalStop = 11,
    /// A person who changes the pallet, at M60.
    Pallet = 12,
    /// A person, in single steps.
    Step = 13,
    /// A tool, at M6.
    Tool = 14,
    /// An input, at M66.
    Input = 15,
    /// The end of a program of the user, M100 to M199.
    Program = 16,
    /// The end of a function in Python.
    Function = 17,
    /// A page that is lost: `remote.hold`.
    Page = 18,
    /// Time, at G4.
    Dwell = 19,
    /// The answer of iocontrol to another request than a tool.
    Io = 20,
}

impl Wait {
    /// All of them, by their numbers.
    pub const ALL: [Self; 21] = [
        Self::Nothing,
        Self::AtSpeed,
        Self::Index,
        Self::Orient,
        Self::SpindleStopped,
        Self::Pause,
        Self::FeedHold,
        Self::FeedInhibit,
        Self::Override,
        Self::SpindleSpeed,
        Self::Stop,
        Self::OptionalStop,
        Self::Pallet,
        Self::Step,
        Self::Tool,
        Self::Input,
        Self::Program,
        Self::Function,
        Self::Page,
        Self::Dwell,
        Self::Io,
    ];

    /// Returns the wait with this number, or [`Self::Nothing`].
    #[must_use]
    pub fn of(number: u32) -> Self {
        Self::ALL.into_iter().find(|wait| *wait as u32 == number).unwrap_or_default()
    }

    /// Returns the name in commands and documents.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::AtSpeed => "at-speed",
            Self::Index => "index",
            Self::Orient => "orient",
            Self::SpindleStopped => "spindle-stopped",
            Self::Pause => "pause",
            Self::FeedHold => "feed-hold",
            Self::FeedInhibit => "feed-inhibit",
            Self::Override => "override",
            Self::SpindleSpeed => "spindle-speed",
            Self::Stop => "m0",
            Self::OptionalStop => "m1",
            Self::Pallet => "m60",
            Self::Step => "step",
            Self::Tool => "tool",
            Self::Input => "input",
            Self::Program => "program",
            Self::Function => "function",
            Self::Page => "page",
            Self::Dwell => "dwell",
            Self::Io => "iocontrol",
        }
    }

    /// Returns who is waited for and how to go on. `owner` is the component whose commands go on and abort: `task` or
    /// `motion`. `n` is the number of the object.
    #[must_use]
    pub fn text(self, owner: &str, n: i32) -> String {
        let person = format!("{owner}.resume goes on, {owner}.abort ends it");
        match self {
            Self::Nothing => String::new(),
            Self::AtSpeed => {
                format!("the speed of spindle {n}: it goes on when spindle.{n}.at-speed is TRUE")
            }
            Self::Index => format!(
                "the index of spindle {n}: it goes on when the encoder sets spindle.{n}.index-enable FALSE"
            ),
            Self::Orient => format!(
                "the angle of spindle {n}: it goes on when spindle.{n}.is-oriented is TRUE and the spindle rests"
            ),
            Self::SpindleStopped => format!(
                "a resume: spindle {n} was stopped after it was turned for the path; {owner}.resume turns it again and goes \
                 on, {owner}.abort ends it"
            ),
            Self::Pause => format!("a resume: {person}"),
            Self::FeedHold => "the end of a feed hold: motion.feed-hold is TRUE".to_owned(),
            Self::FeedInhibit => "the end of a feed inhibit: motion.feed-inhibit is TRUE".to_owned(),
            Self::Override => {
                "an override above 0: the override of the feed or of rapid moves, or the adaptive feed, is 0".to_owned()
            }
            Self::SpindleSpeed => format!(
                "the turns of spindle {n}, which the path follows: spindle.{n}.speed-in is 0 or against the command, or \
                 spindle.{n}.revs stands still"
            ),
            Self::Stop => format!("a person at M0: {person}"),
            Self::OptionalStop => format!("a person at M1: {person}"),
            Self::Pallet => format!("a person who changes the pallet at M60: {person}"),
            Self::Step => {
                format!("a person in single steps: {owner}.step executes the next line, {person}")
            }
            Self::Tool => format!(
                "tool {n}: it goes on when iocontrol.0.tool-changed says that it is in the spindle, {owner}.abort ends it"
            ),
            Self::Input => format!("input {n} at M66"),
            Self::Program => format!("M{n} of the user: it goes on when that program has ended"),
            Self::Function => "a function in Python: it goes on when that has answered".to_owned(),
            Self::Page => {
                "a page that is lost: it goes on when the page resumes it, or by remote.release".to_owned()
            }
            Self::Dwell => "time at G4: it goes on by itself".to_owned(),
            Self::Io => "iocontrol: it goes on when that has answered".to_owned(),
        }
    }

    /// Returns whether the wait ends by itself, whatever anybody does: those for time and for programs.
    #[must_use]
    pub const fn ends_by_itself(self) -> bool {
        matches!(self, Self::Nothing | Self::Program | Self::Function | Self::Dwell | Self::Io)
    }
}

#[cfg(test)]
mod tests {
    use super::Wait;

    #[test]
    fn numbers_names_and_texts() {
        for (n, wait) in (0u32..).zip(Wait::ALL) {
            assert_eq!((wait as u32, Wait::of(n)), (n, wait));
            let text = wait.text("task", 3);
            assert_eq!(text.is_empty(), wait == Wait::Nothing);
            assert!(text.len() <= 200, "{text}");
            let same = Wait::ALL.iter().filter(|other| other.name() == wait.name()).count();
            assert_eq!(same, 1, "{wait:?}");
        }
        assert_eq!(Wait::of(1000), Wait::Nothing);
    }
}
