//! Options of halrun.

use super::folders::LINUXCNC_MODULES;
use crate::{
    programs::{common::Id as Common, options::Opt, profile},
    session::remote::instance_option,
};

/// Meaning of an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Id {
    Common(Common),
    Interactive,
    Tcl,
    Stop,
    Detach,
    Detached,
    Virtual,
    Clock,
    Hold,
    Pace,
    Simulate,
    For,
    Record,
    Modules,
    Flight,
    Linuxcnc,
    Cpu,
    Compat,
    DmaLatency,
    StuckTime,
    MaxGap,
    Log,
    Instance,
    Profile,
    Job,
    From,
    Resume,
    Yes,
    MaxWait,
    Headless,
    Stub,
    Healthy,
    Help,
}

/// Options of the help text.
pub(super) const OPTIONS: &[Opt<Id>] = &[
    flag('f', Id::Common(Common::File), "end when the script ends (FILE follows)"),
    flag('I', Id::Interactive, "after the script, take commands from standard input"),
    flag('T', Id::Tcl, "after the script, take commands in Tcl from standard input (haltcl)"),
    flag('U', Id::Stop, "end the running instance"),
    with("detach", Id::Detach, None, None, "go on in the background once the script is done"),
    with("virtual", Id::Virtual, None, None, "run on the virtual clock: --clock virtual"),
    with("run", Id::Job, Some("FILE"), None, "switch on, home, run this program, end"),
    with(
        "from",
        Id::From,
        Some("PLACE"),
        None,
        "begin --run at [FILE:]LINE[/PASS], after a question",
    ),
    with("resume", Id::Resume, None, None, "begin where the last job broke off, after questions"),
    with("yes", Id::Yes, None, None, "begin at --from or --resume without a question"),
    with(
        "max-wait",
        Id::MaxWait,
        Some("TIME"),
        Some("HAL_MAX_WAIT"),
        "end --run with status 3 after a wait of TIME, or never; 60s off a terminal, where nobody sees it",
    ),
    with("headless", Id::Headless, None, Some("HAL_HEADLESS"), "without a user interface"),
    with(
        "stub",
        Id::Stub,
        Some("NAMES"),
        Some("HAL_STUB"),
        "put pins in place of these components and programs, or of all that are missing",
    ),
    with(
        "healthy",
        Id::Healthy,
        None,
        Some("HAL_HEALTHY"),
        "let inputs of simulated ports that nobody sets be those of a machine at rest; --run does so",
    ),
    with("for", Id::For, Some("TIME"), Some("HAL_FOR"), "end after TIME of the machine"),
    with("clock", Id::Clock, Some("KIND"), Some("HAL_CLOCK"), "the clock: real or virtual"),
    with("hold", Id::Hold, None, Some("HAL_HOLD"), "move the virtual clock only in 'run TIME'"),
    with(
        "pace",
        Id::Pace,
        Some("N"),
        Some("HAL_PACE"),
        "let N seconds pass on the virtual clock in a second; else as many as it can",
    ),
    with("simulate", Id::Simulate, None, Some("HAL_SIMULATE"), "simulate the hardware"),
    with("record", Id::Record, Some("FILE"), Some("HAL_RECORD"), "record every pin to a VCD file"),
    with("flight", Id::Flight, Some("'WORDS'"), Some("HAL_FLIGHT"), "'flight on' with these words"),
    with(
        "linuxcnc-modules",
        Id::Linuxcnc,
        None,
        Some(LINUXCNC_MODULES),
        "find LinuxCNC's own components in C too",
    ),
    with(
        "rtmod-dir",
        Id::Modules,
        Some("FOLDERS"),
        Some("HAL_RTMOD_DIR"),
        "find plugins and components in C there, too",
    ),
    with("cpu", Id::Cpu, Some("N"), Some("HAL_CPU"), "run the threads on processor N"),
    with(
        "dma-latency",
        Id::DmaLatency,
        Some("US"),
        Some("HAL_DMA_LATENCY"),
        "let processors take US microseconds to wake (0 if not said), or off: as they like",
    ),
    with(
        "stuck-time",
        Id::StuckTime,
        Some("TIME"),
        Some("HAL_STUCK_TIME"),
        "stop the machine when a function does not return within TIME",
    ),
    with(
        "max-gap",
        Id::MaxGap,
        Some("TIME"),
        Some("HAL_MAX_GAP"),
        "switch motion off after the process stood still for TIME (500ms if not said)",
    ),
    with(
        "compat",
        Id::Compat,
        Some("VERSION"),
        Some("HAL_COMPAT"),
        "begin with the values of LinuxCNC 2.9 where 2.10 has others: 2.9 or 2.10",
    ),
    with(
        "log",
        Id::Log,
        Some("'WORDS'"),
        Some("HAL_LOG"),
        "show messages of component=NAME or thread=NAME only; several names are possible",
    ),
    instance_option(Id::Instance),
    with(
        "profile",
        Id::Profile,
        Some("FILE"),
        Some(profile::VARIABLE),
        "settings that neither options nor the environment give",
    ),
    Opt { long: Some("help"), ..flag('h', Id::Help, "print this") },
];

/// Undocumented option that `--detach` passes to the process it starts.
pub(super) const HIDDEN: &[Opt<Id>] = &[with("detached", Id::Detached, None, None, "")];

const fn flag(letter: char, id: Id, help: &'static str) -> Opt<Id> {
    Opt { id, short: Some(letter), long: None, value: None, variable: None, help }
}

const fn with(
    name: &'static str,
    id: Id,
    value: Option<&'static str>,
    variable: Option<&'static str>,
    help: &'static str,
) -> Opt<Id> {
    Opt { id, short: None, long: Some(name), value, variable, help }
}
