//! Codes of findings, one table row each.

use crate::Level;
use serde::{Deserialize, Serialize};

macro_rules! codes {
    ($($name:ident = $id:literal $level:ident $title:literal;)*) => {
        /// Kind of a finding. The numbers are shown to users and never change.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        pub enum Code {
            $(
                #[doc = concat!("`", $id, "`: ", $title, ".")]
                #[serde(rename = $id)]
                $name,
            )*
        }

        impl Code {
            /// All codes, in ascending order of their numbers.
            pub const ALL: &[Self] = &[$(Self::$name,)*];

            /// Returns the code as users write it, such as `H306`.
            #[must_use]
            pub const fn id(self) -> &'static str {
                match self { $(Self::$name => $id,)* }
            }

            /// Returns the level of findings with this code.
            #[must_use]
            pub const fn level(self) -> Level {
                match self { $(Self::$name => Level::$level,)* }
            }

            /// Returns a noun phrase that describes the finding.
            #[must_use]
            pub const fn title(self) -> &'static str {
                match self { $(Self::$name => $title,)* }
            }
        }
    };
}

codes! {
    Unreadable = "H101" Error "a line that cannot be read";
    UnknownCommand = "H102" Error "a command that does not exist";
    WrongWords = "H103" Error "a command with the wrong words";
    NoEnvironment = "H104" Error "an environment variable that is not set";
    NoIniEntry = "H105" Error "an INI entry that is not there";
    NoFile = "H106" Error "a file that is not there";
    Refused = "H107" Error "a line that is refused";
    DosLines = "H108" Note "lines that end as DOS writes them";
    ProgramPins = "H109" Note "a program whose pins are not known";
    NoProgramAwaited = "H110" Error "a program that is waited for and not there";
    NoProgram = "H111" Warning "a program that is not there";
    NotSupported = "H112" Error "something that is not supported";
    IdleAllowance = "H113" Note "an allowance that nothing needs";
    TclNotFollowed = "H114" Note "a Tcl file that is not known as a whole";

    NoComponent = "H201" Error "a component that does not exist";
    NoSuchName = "H202" Error "a name that does not exist";
    NameTaken = "H203" Error "a name that is taken";
    BadName = "H204" Error "a name that cannot be one";
    BadArgument = "H205" Error "a wrong argument of a component";
    LoadRefused = "H206" Error "a component that refuses to load";
    NoService = "H207" Error "a component that needs another one first";
    BadCall = "H208" Error "a component's command with wrong arguments";
    AliasShadows = "H209" Warning "a second name that hides another thing";
    Unused = "H210" Note "a component that nothing uses";
    Foreign = "H211" Note "a component whose reads and writes are not known";
    LoadedAlready = "H212" Note "a component that the start has loaded already";

    TypeMismatch = "H301" Error "a pin and a signal of different types";
    TwoWriters = "H302" Error "a signal with two writers";
    LinkedTwice = "H303" Error "a pin that is linked already";
    NamedAsPin = "H304" Error "a signal named as a pin";
    PortMisused = "H305" Error "a port that is joined wrongly";
    NoReader = "H306" Note "a signal that nothing reads";
    NoWriter = "H307" Note "a signal that nothing writes";
    Unguarded = "H308" Note "a protective input that is not linked";
    NeverEnabled = "H309" Warning "an e-stop input that is never true";
    Unfed = "H310" Note "an output that no signal feeds";
    NoPins = "H311" Note "a signal without pins";
    NoChargePump = "H312" Note "outputs without a charge pump";
    EstopNotReturned = "H313" Warning "an e-stop that its chain does not follow";
    EstopNotJoined = "H314" Warning "motion that no e-stop stops";
    HalfWired = "H315" Warning "a linked pin whose counterpart is not connected";
    InputOpen = "H316" Warning "an input that nothing feeds";
    ResultUnused = "H317" Warning "a result that nothing uses";
    OddChannel = "H318" Warning "a channel that lacks what all others have";
    Crossed = "H319" Warning "channels that are crossed";
    ArrowTurned = "H320" Warning "an arrow that points the wrong way";
    SignalMisspelt = "H321" Warning "a signal whose name is nearly another one's";
    ToolChangeOpen = "H322" Warning "a tool change that nothing answers";

    NotWritable = "H401" Error "something that cannot be set";
    BadValue = "H402" Error "a value of the wrong kind";
    SetTwice = "H403" Warning "a value that is set twice";
    SetThenLinked = "H404" Warning "a pin that is set and then driven";
    SetThenWritten = "H405" Warning "a signal that is set and then written";
    ScaleZero = "H406" Warning "a scale of zero";
    BoundsCross = "H407" Warning "a lower bound above the upper one";
    EarlierValue = "H408" Note "a value that LinuxCNC 2.9 has otherwise";
    NotFinite = "H409" Warning "a value that is no finite number";

    NeverAdded = "H501" Warning "a function that no thread runs";
    AddedTwice = "H502" Error "a function in two threads";
    BadPosition = "H503" Error "a position that a thread does not have";
    EmptyThread = "H504" Note "a thread without functions";
    NeverStarted = "H505" Note "threads that are never started";
    FastInSlow = "H506" Warning "a fast function in a slow thread";
    SlowInFast = "H507" Warning "a slow function in the fast thread";
    OrderCosts = "H508" Note "an order that costs a cycle";
    Feedback = "H509" Note "a feedback loop";
    Crossing = "H510" Note "a signal between threads";
    BadPeriod = "H511" Error "a period that a thread cannot have";
    NothingHandedOver = "H512" Warning "a function that waits for one that no thread runs";
    NeedsFp = "H513" Error "a floating-point function in a thread without floating point";
    OrderLate = "H514" Warning "an order of functions that delays the motors";

    StepsTooFast = "H601" Warning "steps faster than the thread can make them";
    DoubleStep = "H602" Note "double steps without a reset";
    StepsMerge = "H603" Warning "step pulses that merge";
    ResetUnmarked = "H604" Warning "a step pin that is not reset";
    ResetNotRun = "H605" Warning "a reset that never runs";
    ResetLate = "H606" Warning "a reset that comes too late";

    IniUnreadable = "H701" Error "an INI file that cannot be read";
    NoHalfile = "H702" Error "a HALFILE that is not there";
    NoPostgui = "H703" Warning "a POSTGUI_HALFILE that is not there";
    IniUnused = "H704" Note "an INI entry that nothing reads";
    SectionRepeated = "H705" Note "a section that is repeated";
    JointTooFast = "H706" Warning "a joint faster than its steps";
    MotionRefuses = "H707" Error "machine data that motion refuses";
    StepgenSlower = "H708" Warning "a stepgen that accelerates less than its joint";
    EntryMissing = "H709" Warning "an INI entry that is missing";
    EntryMisplaced = "H710" Warning "an INI entry that is misspelt or in the wrong section";
    EntriesDisagree = "H711" Warning "INI entries that contradict each other or the wiring";
    IniIgnored = "H712" Warning "a line of an INI file that is ignored";
    EntryTwice = "H713" Warning "an INI entry that is there twice with two values";
    CoordinatesOdd = "H714" Warning "coordinates that do not fit the joints";
    NoToolTable = "H715" Warning "a tool table that is not there";
    NoProgramFolder = "H716" Note "a folder of programs that is not there";
}

impl Code {
    /// Returns the code with this number. Ignores letter case.
    #[must_use]
    pub fn parse(word: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|c| c.id().eq_ignore_ascii_case(word))
    }
}

impl core::fmt::Display for Code {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.id())
    }
}

#[cfg(test)]
mod tests {
    use super::Code;

    #[test]
    fn numbers_rise_and_are_read_back() {
        for pair in Code::ALL.windows(2) {
            let [a, b] = pair else { continue };
            assert!(a.id() < b.id(), "{a} {b}");
        }
        for code in Code::ALL {
            assert_eq!(Code::parse(&code.id().to_lowercase()), Some(*code));
            assert_eq!(serde_json::to_string(code).unwrap(), format!("\"{}\"", code.id()));
        }
        assert_eq!(Code::parse("H999"), None);
    }
}
