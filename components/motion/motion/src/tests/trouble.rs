//! A spindle in trouble: each kind of move that follows it × each trouble × each phase. No cell jumps or breaks a limit, which
//! the bench judges in each cycle, and none is silent: it ends as programmed, fails with a name, or waits with a name.

use super::{
    DT,
    follow::{Lathe, PITCH},
};
use hal_component::{MotionStatus, Wait, abi::TicketState};
use std::fmt::Write;

const BEGIN: &str = "<!-- trouble: written by UPDATE_EXPECT=1 cargo test -p motion trouble -->\n";
const END: &str = "<!-- trouble: end -->\n";

/// Turns per second of the spindle, and its acceleration.
const SPEED: f64 = 10.0;
const ACCELERATION: f64 = 80.0;

/// Depth of a tap, and end of a thread.
const DEPTH: f64 = 30.0;

/// Moves that follow a spindle.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// G33, and each pass of G76.
    Thread,
    /// G33.1 with this factor of the way out.
    Tap(f64),
    /// G95.
    PerTurn,
    /// G84 and G74 under G95: in at a feed per turn, the other way round, and out.
    Cycle,
}

const KINDS: [(Kind, &str); 5] = [
    (Kind::Thread, "G33, G76"),
    (Kind::Tap(1.0), "G33.1"),
    (Kind::Tap(2.0), "G33.1, twice as fast out"),
    (Kind::PerTurn, "G95"),
    (Kind::Cycle, "G84, G74 in G95"),
];

/// Trouble of the spindle.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Trouble {
    Slows,
    Stops,
    Stands,
    Reverses,
    LosesIndex,
    GoesBlind,
}

const TROUBLES: [(Trouble, &str); 6] = [
    (Trouble::Slows, "turns at 0.3 of its speed"),
    (Trouble::Stops, "stops for good"),
    (Trouble::Stands, "stands for half a second"),
    (Trouble::Reverses, "turns against its command"),
    (Trouble::LosesIndex, "loses its index"),
    (Trouble::GoesBlind, "has an encoder that falls silent"),
];

/// When it begins.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Before,
    Pass,
    Reversal,
    Out,
    RunOut,
}

const PHASES: [(Phase, &str); 5] = [
    (Phase::Before, "before the index"),
    (Phase::Pass, "in the pass"),
    (Phase::Reversal, "in the reversal"),
    (Phase::Out, "on the way out"),
    (Phase::RunOut, "at the run-out"),
];

impl Kind {
    fn has(self, phase: Phase) -> bool {
        let goes_out = matches!(self, Self::Tap(_) | Self::Cycle);
        goes_out || !matches!(phase, Phase::Reversal | Phase::Out)
    }

    fn follows_place(self) -> bool {
        matches!(self, Self::Thread | Self::Tap(_))
    }

    /// Commands in order: each begins when the one before it has ended.
    fn commands(self) -> Vec<String> {
        match self {
            Self::Thread => vec![format!("motion.move x={DEPTH} pitch={PITCH}")],
            Self::Tap(back) => vec![format!("motion.tap x={DEPTH} pitch={PITCH} return={back}")],
            Self::PerTurn => vec![format!("motion.move x={DEPTH} per-turn={PITCH}")],
            Self::Cycle => vec![
                format!("motion.move x={DEPTH} per-turn={PITCH}"),
                format!("motion.spindle speed={}", -60.0 * SPEED),
                format!("motion.move x=0 per-turn={PITCH}"),
                format!("motion.spindle speed={}", 60.0 * SPEED),
            ],
        }
    }
}

/// Returns whether a phase has come.
fn has_come(lathe: &Lathe, kind: Kind, phase: Phase, deepest: f64) -> bool {
    let (x, out) = (lathe.x(), lathe.rig.float("spindle.0.speed-out") < 0.0);
    match phase {
        Phase::Before => true,
        Phase::Pass => x > 15.0,
        Phase::Reversal => out,
        Phase::Out => out && x < 15.0,
        Phase::RunOut if kind.has(Phase::Reversal) => deepest > DEPTH - 1.0 && x < 0.1,
        Phase::RunOut => x > DEPTH - 0.1,
    }
}

impl Trouble {
    fn begin(self, lathe: &mut Lathe) {
        let turner = &mut lathe.turner;
        match self {
            Self::Slows => turner.factor = 0.3,
            Self::Stops | Self::Stands => turner.is_stalled = true,
            Self::Reverses => turner.factor = -1.0,
            Self::LosesIndex => (turner.has_index, turner.angle) = (false, turner.angle + 7.0),
            Self::GoesBlind => turner.is_blind = true,
        }
    }
}

fn status(lathe: &Lathe) -> MotionStatus {
    lathe.rig.bench.snapshot("motion.status")
}

/// Runs one cell; returns what came of it.
fn cell(kind: Kind, trouble: Trouble, phase: Phase, is_wired: bool) -> String {
    let what = format!("{kind:?} {trouble:?} {phase:?} at-speed wired {is_wired}");
    let mut lathe = Lathe::new(60.0 * SPEED, ACCELERATION);
    lathe.turner.is_always_at_speed = !is_wired;
    lathe.cycles(300);
    let (mut since, mut deepest, mut worst) = (0_u32, 0.0_f64, 0.0_f64);
    let (mut silent, mut waited) = (0, 0);
    let mut end = TicketState::Done;
    'commands: for text in kind.commands() {
        lathe.rig.say(&text);
        let ticket = lathe.rig.bench.tickets().len() - 1;
        loop {
            if since > 0 || has_come(&lathe, kind, phase, deepest) {
                since += 1;
                if since == 1 {
                    trouble.begin(&mut lathe);
                }
                if since == 500 && trouble == Trouble::Stands {
                    lathe.turner.is_stalled = false;
                }
            }
            lathe.cycle();
            let x = lathe.x();
            deepest = deepest.max(x);
            let is_cut = 5.0 < x && x < DEPTH - 1.0 && deepest > 5.0;
            let place = PITCH * lathe.turner.revs();
            if kind.follows_place() && is_cut && !lathe.turner.is_blind {
                let shown = lathe.rig.float("spindle.0.sync-error");
                // Within its limits the axis follows; where it does not, the pin has the distance.
                let is_alone = trouble == Trouble::LosesIndex && since > 0;
                let off = if is_alone { 0.0 } else { (place - x - shown).abs() };
                worst = worst.max(off);
            }
            let state = lathe.rig.bench.tickets()[ticket];
            let status = status(&lathe);
            let rests = lathe.rig.float("motion.current-vel") == 0.0;
            let waits = Wait::of(status.wait) != Wait::Nothing;
            // The planner takes a few cycles before a move begins, and a move to end.
            silent = if rests && !waits && state == TicketState::Pending { silent + 1 } else { 0 };
            assert!(silent < 50, "{what}: at rest at {x} for nothing");
            if state != TicketState::Pending {
                end = state;
                if end != TicketState::Done {
                    break 'commands;
                }
                break;
            }
            waited = if waits && rests { waited + 1 } else { 0 };
            assert!(since < 60_000, "{what}: never ends, at {x}");
            if waited > 1200 {
                end = TicketState::Pending;
                break 'commands;
            }
        }
    }
    assert!(since > 0, "{what}: the phase never came");
    assert!(lathe.rig.is("motion.motion-enabled"), "{what}: {:?}", lathe.rig.bench.said());
    let slack = PITCH * SPEED * 2.0 * DT;
    assert!(worst <= slack, "{what}: {worst} from the spindle, and no pin says it");
    match end {
        TicketState::Done => {
            let x = if kind.has(Phase::Reversal) { 0.0 } else { DEPTH };
            assert_eq!(lathe.x(), x, "{what}");
            assert!(lathe.rig.bench.said().is_empty(), "{what}");
            String::from("ends as programmed")
        }
        TicketState::Failed(why) => {
            assert_eq!(lathe.rig.bench.said(), [why], "{what}");
            lathe.cycles(1000);
            assert_eq!(lathe.rig.float("spindle.0.speed-out"), 0.0, "{what}");
            assert_eq!(lathe.rig.float("motion.current-vel"), 0.0, "{what}");
            format!("fails: {why}")
        }
        TicketState::Pending => {
            let status = status(&lathe);
            let wait = Wait::of(status.wait);
            assert_ne!(wait, Wait::Nothing, "{what}: it rests at {} for nothing", lathe.x());
            assert_eq!(status.wait_number, 0, "{what}");
            // An abort ends the wait, a second one also that of a tap in its hole.
            lathe.rig.say("motion.abort");
            lathe.cycles(300);
            lathe.rig.say("motion.abort");
            lathe.until(|l| l.rig.is("motion.in-position"));
            format!("waits: {}", wait.name())
        }
    }
}

/// Each cell with the pin at-speed of a drive that tells it, and without one.
#[test]
fn no_trouble_of_a_spindle_is_silent() {
    let mut out = String::from("\n| move | the spindle | since | it |\n|---|---|---|---|\n");
    for (kind, moves) in KINDS {
        for (trouble, spindle) in TROUBLES {
            let mut last = String::new();
            let mut phases = Vec::new();
            let flush = |phases: &mut Vec<&str>, last: &str, out: &mut String| {
                if !phases.is_empty() {
                    writeln!(out, "| {moves} | {spindle} | {} | {last} |", phases.join(", "))
                        .unwrap();
                }
                phases.clear();
            };
            for (phase, when) in PHASES.into_iter().filter(|(phase, _)| kind.has(*phase)) {
                let [wired, bare] =
                    [true, false].map(|is_wired| cell(kind, trouble, phase, is_wired));
                let text = match wired == bare {
                    true => wired,
                    false => format!("{wired}; without `at-speed` {bare}"),
                };
                if text != last {
                    flush(&mut phases, &last, &mut out);
                    last = text;
                }
                phases.push(when);
            }
            flush(&mut phases, &last, &mut out);
        }
    }
    out.push('\n');
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/README.md");
    hal_golden::check_part(path.as_ref(), BEGIN, END, &out);
}
