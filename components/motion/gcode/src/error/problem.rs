//! The table of problems: each with its message and its remedy.

use core::fmt;
use std::borrow::Cow;

use crate::foreign;

/// Declares the problems with their messages and remedies.
macro_rules! problems {
    ($($name:ident $({ $($field:ident : $type:ty),+ })? : $message:literal, $remedy:literal;)+) => {
        /// A problem that a user can fix. Messages that users of LinuxCNC know keep its wording.
        #[derive(Clone, Debug, PartialEq)]
        pub enum Problem {
            $(
                #[doc = $message]
                $name $({ $(
                    #[doc = "A part of the message."]
                    $field: $type
                ),+ })?,
            )+
        }

        impl Problem {
            fn standing_remedy(&self) -> &'static str {
                match self { $( Self::$name $({ $($field: _),+ })? => $remedy, )+ }
            }
        }

        impl fmt::Display for Problem {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                match self { $( Self::$name $({ $($field),+ })? => write!(f, $message), )+ }
            }
        }
    };
}

problems! {
    // The text of a line.
    BadCharacter { shown: Box<str> }: "Bad character '{shown}' used", "a word begins with a letter; a value follows it";
    LineTooLong { limit: usize }: "Command too long (limit {limit} bytes)", "break the line up";
    NestedComment: "Nested comment found", "use other brackets inside a comment";
    UnclosedComment: "Unclosed comment found", "close the comment with )";
    NoNumber: "No characters found in reading real value", "write a number, #parameter, function or [expression]";
    NumberFormat { shown: Box<str> }: "bad number format (conversion failed) parsing '{shown}'", "write a number, #parameter, function or [expression]";
    NumberTooLarge: "number is too large", "";
    BadUnsigned: "Bad format unsigned integer", "write digits only";
    NoName: "Expected a name in < >", "write #<name>";
    UnclosedName: "Named parameter not terminated", "end the name with >";
    NoBracket: "Left bracket missing after word", "write [expression]";
    UnclosedExpression: "Unclosed expression", "close the expression with ]";
    UnknownOperator: "Unknown operation", "operators are + - * / ** mod eq ne gt ge lt le and or xor";
    ExistsUnclosed: "Expected ] reading bracketed parameter", "exists takes one parameter and no operators";
    ExistsNeedsName: "Expected # reading parameter", "write exists[#<name>] or exists[#n]";
    AtanNeedsSlash: "Slash missing after first atan argument", "write atan[y]/[x]";
    AtanNeedsBracket: "Left bracket missing after slash with atan", "write atan[y]/[x]";
    UnknownWord { first: char }: "Unknown word starting with {first}", "functions are abs acos asin atan cos exists exp fix fup ln round sin sqrt tan";
    NestedTooDeep { limit: u32 }: "expression is nested deeper than {limit} levels", "use a parameter for a part of it";
    TooManyOperators { limit: u32 }: "expression has more than {limit} operators", "use a parameter for a part of it";
    NoEqualSign: "Equal sign missing in parameter setting", "write #n=value";
    Foreign { said: Box<str> }: "{said}", "";
    UnknownOCommand: "Unknown control command in o word", "keywords are sub endsub return call do while endwhile if elseif else endif repeat endrepeat break continue";
    AfterOWord: "Unexpected character after O-word", "only a comment may follow it";
    NotInDialect { what: Box<str> }: "{what} is not part of RS274-D", "it has G00 to G04, G20, G21, G28, G29, G90, G91, G92, M00, M01, M02, M30, words and numbers without exponent";
    LineNumberLong: "line number has more than 5 digits", "use N0 to N99999";
    WordNotOfCommand { letter: char, command: &'static str, words: &'static str }: "{command} does not take {letter}; it takes {words}", "";
    TooManyArguments: "Too many subroutine parameters", "use at most 30";

    // Values.
    NotANumber: "Calculation resulted in 'not a number'", "";
    Infinite: "Calculation resulted in 'infinity'", "";
    NotAnInteger: "Non integer value for integer", "";
    DivideByZero: "Attempt to divide by zero", "";
    PowerRange: "Attempt to raise negative to non integer power", "";
    AcosRange: "Argument to acos out of range", "use -1 to 1";
    AsinRange: "Argument to asin out of range", "use -1 to 1";
    LnRange: "Zero or negative argument to ln", "";
    SqrtRange: "Negative argument to sqrt", "";
    ParameterRange: "Parameter number out of range", "use 1 to 5601";
    ParameterReadOnly: "Parameter is readonly", "";
    NamedReadOnly { name: Box<str> }: "Cannot assign to read-only parameter #<{name}>", "";
    NamedUndefined { name: Box<str> }: "Named parameter #<{name}> not defined", "assign it first, or test it with exists[]";
    TooManyNames { limit: usize }: "more than {limit} named parameters", "";

    // Words of a block.
    MultipleWords { letter: char }: "Multiple {letter} words on one line", "";
    UnknownG { code: f64 }: "Unknown g code used: G{code}", "";
    NegativeG: "Negative g code used", "";
    GRange { code: f64 }: "G-code out of range: G{code}", "";
    UnknownM { code: i32 }: "Unknown m code used: M{code}", "user codes M100 to M199 need a program of that name";
    NegativeM: "Negative m code used", "";
    MTooLarge { code: i32 }: "M-code greater than 199: M{code}", "";
    RemapMissing { code: Box<str>, letters: Box<str> }: "user-defined {code}: missing: {letters}", "the INI file's argspec asks for them";
    RemapSpeed { code: Box<str> }: "spindle speed must be greater than 0 for {code}", "program S";
    RemapFeed { code: Box<str> }: "feed rate must be greater than 0 for {code}", "program F";
    RemapRecursion { code: Box<str> }: "recursive call of remapped {code}", "a code that only a remap defines cannot use itself";
    RemapFile { code: Box<str>, name: Box<str> }: "{code}: no subroutine o<{name}>", "put {name}.ngc on the INI file's SUBROUTINE_PATH";
    ExecutedOWord: "a function can execute no O-word but call", "write the loop in the function";
    FunctionTooLong { name: Box<str>, limit: u64 }: "{name}: more than {limit} steps", "the function may have no end";
    FunctionAsks: "the host's answer does not fit the question", "";
    FieldFixed { name: Box<str> }: "self.{name} cannot be set", "";
    ToolOnlyStated { tool: i32 }: "the current tool was set to {tool}, but the machine was not informed: the function has to make the canonical call of a tool change", "";
    CallUnknown { name: Box<str> }: "emccanon.{name} is not a call that a function can make", "";
    CallWords { name: Box<str> }: "emccanon.{name}: wrong number, type or range of arguments", "";
    FinishFailed { reason: Box<str> }: "{reason}", "";
    HookFailed { name: Box<str>, reason: Box<str> }: "{name}: {reason}", "";
    SameGGroup: "Two g codes used from same modal group", "use one of them, or two lines";
    SameMGroup: "Two m codes used from same modal group", "use one of them, or two lines";
    TooManyM: "Too many m codes on line", "use at most 4";
    TwoAxisCodes: "Cannot use two g codes that both use axis values", "use two lines";
    AxisWithG80: "Cannot use axis values with g80", "program a motion code";
    AxisWithoutCode: "Cannot use axis values without a g code that uses them", "program a motion code";
    AxesMissing: "All axes missing with motion code", "";
    AxesMissingG52OrG92 : "All axes missing with g52 or g92", "";
    UnusedWord { letter: char, with: &'static str }: "{letter} word with no {with}", "";
    NegativeWord { letter: char }: "Negative {letter} word used", "";
    ValueNotInteger { letter: char }: "{letter} number not an integer", "";
    PolarAndAxis { letter: char }: "Cannot specify both polar coordinate and {letter} word", "leave one of them out";
    PolarPlane: "Cannot use polar coordinate except in G17 plane", "select the plane with G17 on a line before";
    PolarG53: "Cannot use polar coordinates with G53", "give X and Y";
    PolarNoMotion: "Polar coordinates can only be used for motion", "give X and Y";
    PolarAtOrigin: "Incremental motion with polar coordinates is indeterminate when at the origin", "use G90";
    PolarNeedsAngle: "Must specify angle in polar coordinate if at the origin", "";

    // Feed, spindle, tool.
    ZeroFeed { code: &'static str }: "Cannot do {code} with zero feed rate", "program F";
    ZeroFeedArc: "Cannot make arc with zero feed rate", "program F";
    ZeroFeedCycle: "Cannot feed with zero feed rate", "program F";
    InverseFeedMissing { code: &'static str }: "F word missing with inverse time {code} move", "";
    FeedZero: "F must be above 0", "leave F out for the default feed";
    NegativeFeed: "Negative f word used", "";
    NegativeSpeed: "Negative spindle speed used", "";
    ZeroSpindleFeed: "Cannot feed with zero spindle speed in feed per rev mode", "program S";
    SpindleRange { with: &'static str }: "Invalid spindle ($) number in {with} command", "";
    SpindleOff { code: &'static str }: "Spindle not turning in {code}", "start it with M3 or M4";
    SpindleCw { code: &'static str }: "Spindle turning clockwise in {code}", "";
    G96NeedsS: "S word missing with G96", "";
    OrientRange: "R value must be within 0..360 with M19", "";
    OrientMode: "P value must be 0,1,or 2 with M19", "";
    OrientTimeout: "Q word with M19 requires a value > 0", "";
    ToolMissing { tool: i32 }: "Requested tool {tool} not found in the tool table", "add its line to the tool table, such as T1 P1";
    NegativeTool: "Negative tool id (tool not found)", "";
    NoToolSelected: "Need tool prepared -Txx- for toolchange", "";
    M61NeedsQ: "Need non-negative Q-word to specify tool number with M61", "";
    ToolChangeFailed { reason: Box<str> }: "toolchange failed: {reason}", "";
    ProbeFailed { reason: Box<str> }: "probe failed: {reason}", "";
    HalFailed { reason: Box<str> }: "HAL: {reason}", "";
    InputFailed { reason: Box<str> }: "input failed: {reason}", "";
    UserCodeRefused { code: u16, reason: Box<str> }: "M{code} is not run: {reason}", "";
    UserCodeFailed { code: u16, reason: Box<str> }: "M{code} failed: {reason}", "";

    // Offsets and coordinate systems.
    OffsetWordsMissing: "G43.2: No axes specified and H word missing", "";
    OffsetWordsBoth: "G43.2: Can not have both H and axis words", "use two lines";
    G10NeedsL: "Line with G10 does not have L0, L1, L10, L11, L2, or L20", "";
    G10LRange: "Line with G10 does not have L0, L1, L10, L11, L2, or L20", "";
    G10PRange: "P value out of range (0-9) with G10 L2", "";
    G10NeedsTool: "P value out of range with G10 L1", "";
    G10ToolRange: "P value out of range with G10 L1, L10 or L11", "";
    G10Orientation: "Invalid tool orientation", "use 0 to 9";
    G10AxisRotation: "R not allowed in G10 L20", "";
    OffsetWithComp { what: &'static str }: "{what} with cutter radius compensation on", "program G40 first";
    G53Motion: "Must use g0 or g1 with g53", "";
    G53Incremental: "Cannot use g53 incremental", "program G90";
    G92WithComp: "Cannot change axis offsets with cutter radius comp", "program G40 first";

    WrappedRange { axis: char }: "Invalid absolute position for wrapped rotary axis {axis}", "use -360 to 360";

    // Motion.
    ArcWordsMissing { words: &'static str }: "{words} words all missing for arc", "give R or the centre";
    ArcBothCentre { letter: char }: "{letter} word missing in absolute center arc", "";
    ArcMixed: "Mixed radius ijk format for arc", "give R or the centre";
    ArcWordPlane { letter: char, plane: &'static str }: "{letter} word given for arc in {plane} plane", "";
    ArcEndMissing { words: &'static str, plane: &'static str }: "{words} words missing for arc in {plane} plane", "";
    ArcSamePlace: "Current point same as end point of arc", "use the centre for a full circle";
    ArcRadiusSmall: "Arc radius too small to reach end point", "";
    ArcSize: "the radius of the arc is out of range", "use 1e-6 to 1e9 mm, or a line";
    ArcRadiusZero { detail: Box<str> }: "Zero-radius arc: {detail}", "";
    ArcRadiiDiffer { detail: Box<str> }: "Radius to end of arc differs from radius to start: {detail}", "";
    ArcTurns: "P value should be 1 or greater with G2 or G3", "";
    TurnsNotInteger: "P value not an integer with M19 G2 or G3", "";
    ArcUvw: "Cannot move UVW axes with arcs in XYZ planes", "";
    ArcXyz: "Cannot move XYZ axes with arcs in UVW planes", "";
    DwellTime: "Dwell time missing with g4", "program P seconds";
    DwellBoth: "G04 with both X and P", "give X seconds or P milliseconds";
    DwellTimeOrX: "G04 without a time", "give X seconds or P milliseconds";
    NoPointToReturn: "G29 without a point that G28 remembered", "program G28 with X, Y or Z before it";
    ArcRise: "K of the arc is not its rise in Z", "give Z, or K as the rise from the start";
    DwellNegative: "Negative P word used", "";
    ProbeComp: "Cannot probe with cutter radius comp on", "program G40 first";
    ProbeInverse: "Cannot probe in inverse time feed mode", "program G94";
    ProbeStart: "Start point too close to probe point", "";
    ThreadNeedsK: "K word missing with g33/g33.1", "";
    SplinePlane: "Splines must be in the XY plane", "program G17";
    SplineAxes: "Splines may move X and Y only", "";
    SplineComp: "Cannot convert spline with cutter radius compensation", "program G40 first";
    SplineIj: "Must specify both I and J with G5", "";
    SplinePq: "Must specify both P and Q with G5", "";
    QuadraticIj: "Must specify both I and J with G5.1", "";
    NurbsXy: "Must specify both X and Y coordinates for Control Point", "";
    NurbsWeight: "Must specify positive weight P for every Control Point", "";
    NurbsFew: "You must specify a number of control points at least equal to the order L", "";
    NurbsOrder: "L word out of range for G5.2", "";
    NurbsNotOpen: "Cannot use G5.3 without G5.2 first", "";

    // Ticks.
    NoTicks { what: &'static str }: "T-mode has no {what}", "it has straight lines, and arcs in XY";
    TicksTooMany { limit: u64 }: "more than {limit} ticks", "use fewer steps to the inch";
    TicksTooFar: "the place is more than 2147483647 steps away", "use fewer steps to the inch";

    // Cycles.
    CycleRepeats: "Cannot do zero repeats of cycle", "";
    CycleR { letter: char, plane: &'static str }: "R less than {letter} in cycle in {plane} plane", "";
    CycleAxis { letter: char }: "Cannot put an {letter} in canned cycle", "";
    CycleQNegative { code: &'static str }: "Negative or zero q value used with {code}", "";
    SpindleCcw { code: &'static str }: "Spindle turning counterclockwise in {code}", "";
    ProbeFeed: "Cannot probe with zero feed rate", "program F";
    CycleRMissing: "R clearance plane unspecified in cycle", "";
    CycleZMissing { letter: char, plane: &'static str }: "{letter} value unspecified in {plane} plane canned cycle", "";
    CycleInverse: "Cannot use inverse time feed with canned cycles", "program G94";
    CycleComp: "Cannot use canned cycles with cutter compensation on", "program G40 first";
    CycleDwell { code: &'static str }: "Dwell time p word missing with {code}", "";
    CycleQ { code: &'static str }: "Q word missing with {code}", "";
    G76Words { detail: &'static str }: "{detail}", "";

    // Compensation.
    CompPlane: "Cutter radius compensation allowed only in XY, XZ planes", "program G17 or G18";
    CompLathePlane { code: &'static str }: "{code} with lathe tool, but plane is not G18", "";
    CompLPlane { code: &'static str }: "{code} with L word, but plane is not G18", "";
    CompLRange { code: &'static str }: "{code} with an L word out of range", "use 0 to 9";
    CompOn: "Cannot turn cutter radius comp on when on", "program G40 first";
    CompEndArc: "The move just after exiting cutter compensation mode must be straight, not an arc", "move with G0 or G1 first";
    CompOverride { what: &'static str }: "Cannot {what} overrides with cutter radius compensation on", "program G40 first";
    CompPlaneChange: "Cannot change planes with cutter radius compensation on", "program G40 first";
    CompUnits: "Cannot change units with cutter radius comp on", "program G40 first";
    CompNeedsD { code: &'static str }: "{code} with no D word", "";
    CompEntryShort: "Length of cutter compensation entry move is not greater than the tool radius", "";
    CompGouge: "Straight feed in concave corner cannot be reached by the tool without gouging", "use a tool with a smaller radius";
    CompGougeArc: "Arc move in concave corner cannot be reached by the tool without gouging", "use a tool with a smaller radius";
    CompArcRadius: "Tool radius not less than arc radius with comp", "use a tool with a smaller radius";
    CompMotion { what: &'static str }: "{what}", "program G40 first";
    CompWith { code: &'static str }: "Cannot use {code} with cutter radius compensation on", "program G40 first";
    CompRange: "a compensated move or the tool's radius is out of range", "use at most 1e9 units";
    CompFixed: "the inside corner before this move was passed without it", "program both moves of the corner in one program";
    CompNoIntersection: "compensated moves do not meet", "use a tool with a smaller radius";

    // Profiles.
    ProfilePlane: "G7x requires the XZ plane", "program G18";
    ProfileNeedsQ: "G7x requires a Q word", "Q is the number of the profile's subroutine";
    ProfileIncrement: "G71 and G72 need an I above 0", "";
    ProfileRange { letter: char }: "{letter} of the cycle or its profile is out of range", "use at most 1e9 units";
    ProfileLevels { limit: u32 }: "the cycle has more than {limit} levels", "use a larger I";
    ProfileCalls { label: Box<str> }: "the profile calls '{label}', which is a function of another language", "describe the profile in lines of G-code";
    ProfileEmpty: "the profile has no motion", "";
    ProfileSide: "cutter radius compensation puts the tool on the other side of the profile than it comes from", "use the other one of G41 and G42";
    ProfileEndFalls: "a compensated tool cannot come back from the fall at the end of the profile to its next pass", "use one pass, or end the profile with a rise";
    ProfileGoesBack: "the profile is not monotonic", "Z must go one way for G71, X for G72, and each fillet must fit";

    // M codes.
    OutputP { code: &'static str }: "No valid P word with {code}", "";
    OutputQ { code: &'static str }: "Q word missing with {code}", "give the value";
    OutputE { code: &'static str }: "Invalid analog index with {code}", "";
    InputWords: "Need to have either a valid P or a valid E word with M66", "";
    InputBoth: "Invalid to select both a digital and an analog input with M66", "";
    InputL: "Invalid L word with M66", "use 0 to 4";
    InputQ: "Zero timeout with wait type != immediate return", "";
    InputAnalog: "Can't select analog input with wait type != immediate return", "";

    // Flow.
    NoProgramEnd: "File ended with no percent sign or program end", "end the program with M2, M30 or %";
    LabelDuplicate { label: Box<str> }: "o-word label is already defined: o<{label}>", "";
    SubNested: "Nested subroutine definition", "end the outer one first";
    PartCalled: "Fanuc 'O....' subroutine must be called with 'M98'", "call it with M98, or begin it with sub and end it with endsub";
    PartEnded: "Fanuc 'O....' subroutine definition must end with 'M99'", "end it with M99, or begin it with sub and call it with call";
    SubAsPart: "'O.... sub' subroutine must be called with 'O.... call'", "call it with call, or take its sub away and end it with M99";
    SubEndedByM99: "'O.... endsub' or 'O.... return' must follow 'O.... sub' subroutine definition", "end it with endsub";
    NotInSub { label: Box<str>, word: &'static str }: "not in a subroutine definition: 'o{label} {word}'", "";
    NotInLoop { label: Box<str>, word: &'static str }: "undefined O-word label: 'o{label} {word}'", "its beginning is missing";
    LabelMissing { label: Box<str> }: "Unable to open file or find o-word: o<{label}>", "";
    EndMissing { label: Box<str>, line: u32 }: "end of file while seeking o-word o<{label}> of line {line}", "";
    TooManyLevels: "Too many subroutine levels", "end the recursion, or raise the limit";
    LoopsTooDeep { limit: u32 }: "o-words are nested deeper than {limit} levels", "";
    RunAway { limit: u64 }: "{limit} lines without a canonical call", "end the loop, or raise the limit";
    LinesSpent { limit: u64 }: "{limit} lines were run", "raise the limit";
    OutputTooLarge { limit: usize }: "one line makes more than {limit} canonical calls", "";
    NothingSaved: "Cannot restore context from invalid stack frame - missing M70/M73?", "";
    FanucSubs { what: &'static str }: "{what}", "use o<name> sub and o<name> call, or take the entry out of [RS274NGC]";
    M98NeedsP: "Found 'm98' code with no P-word", "";
    M99Context: "M99 outside of a program part", "";
    PythonComment: "Python in a comment is not run", "put it into a function of the module that [PYTHON] names, and write o<name> call";
    UserAbort { text: Box<str> }: "{text}", "";
    NoFile { name: Box<str> }: "Unable to open file <{name}>", "";
    FileUnread { name: Box<str>, reason: Box<str> }: "Unable to read file <{name}>: {reason}", "load the program again";
    WrongAnswer: "the answer does not fit the request", "";
    CalledBeforeAnswer: "the interpreter waits for an answer", "";
    Unsupported { thing: &'static str }: "{thing} is not supported yet", "";
}

impl Problem {
    /// Returns advice, or nothing where the message says it all. That of a code of another control says what it means there.
    pub fn remedy(&self) -> Cow<'static, str> {
        let advice = match self {
            Self::UnknownG { code } | Self::GRange { code } => foreign::advice(b'g', *code),
            Self::UnknownM { code } | Self::MTooLarge { code } => {
                foreign::advice(b'm', f64::from(*code))
            }
            Self::ToolMissing { tool } if *tool > 0 => {
                Some(format!("add a line to the tool table: T{tool} P{tool}"))
            }
            _ => None,
        };
        advice.map_or(Cow::Borrowed(self.standing_remedy()), Cow::Owned)
    }

    /// Returns the problem of a byte that begins nothing; `None` is the end of the line.
    pub fn of_byte(byte: Option<u8>) -> Self {
        match byte {
            None => Self::NoNumber,
            Some(b) if b.is_ascii_graphic() => {
                Self::BadCharacter { shown: char::from(b).to_string().into() }
            }
            Some(b) => Self::BadCharacter { shown: format!("\\{b:03o}").into() },
        }
    }
}
