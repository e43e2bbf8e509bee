//! Pins and values of stand-ins, from lines and wires written by hand.

use super::{
    asked::Asked,
    healthy::{Driver, Want, driver, wants},
    infer::infer,
    known, reach,
    settle::gpio_line,
    wires::{Wired, Wires},
};
use hal_protocol::{At, Direction, SignalInfo, Value};
use std::collections::BTreeMap;

/// Makes wires of lines `OWNER NAME DIRECTION [SIGNAL]`; `f`, `s` or `i` before the direction is the type, else a bit.
fn wires(text: &str) -> Wires {
    let mut wires = Wires::default();
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [owner, name, dir, signal @ ..] = &words[..] else { panic!("{line}") };
        let (value, dir) = match dir.strip_prefix('f') {
            Some(dir) => (Value::Float(0.0), dir),
            None => (Value::Bit(false), *dir),
        };
        let direction = match dir {
            "in" => Direction::In,
            "out" => Direction::Out,
            "io" => Direction::Io,
            _ => panic!("{line}"),
        };
        let signal = signal.first().map(|signal| (*signal).to_owned());
        if let Some(signal) = &signal {
            let new = SignalInfo { value, name: signal.clone(), pins: Vec::new() };
            let signal = wires.signals.entry(signal.clone()).or_insert(new);
            signal.pins.push((direction, (*name).to_owned()));
        }
        let owner = (*owner).to_owned();
        wires.pins.insert((*name).to_owned(), Wired { direction, value, signal, owner });
    }
    wires
}

/// Returns the pins that lines make, each with what `standin` gets, and the functions.
fn inferred(known: &str, lines: &str) -> (Vec<String>, Vec<String>) {
    let split = |line: &str| line.split_whitespace().map(str::to_owned).collect();
    let statements: Vec<(At, Vec<String>)> =
        lines.lines().map(|line| (At::new("m.hal", 1), split(line))).collect();
    let found = infer(&statements, &wires(known), |name| name.starts_with("card."));
    let args = found.arguments();
    let pins = args.first().unwrap().strip_prefix("pins=").unwrap();
    let mut pins: Vec<String> = pins.split(',').map(str::to_owned).collect();
    let doubtful: Vec<&str> = found.doubtful().collect();
    for pin in &mut pins {
        if doubtful.contains(&pin.split('|').next().unwrap()) {
            pin.push('?');
        }
    }
    (pins, found.functs)
}

#[test]
fn lines_tell_type_direction_and_rule() {
    let joint = "motmod joint.0.motor-pos-cmd fout x-cmd
        motmod joint.0.motor-pos-fb fin x-fb
        motmod joint.0.index-enable io x-index
        motmod spindle.0.revs fin turns
        motmod spindle.0.index-enable io s-index
        iocontrol iocontrol.0.emc-enable-in in ok";
    for (lines, want) in [
        // A writer is there: the pin reads. None is there: it writes. A copy of the command.
        (
            "net x-cmd joint.0.motor-pos-cmd => card.0.position-cmd\nnet x-fb card.0.position-fb => joint.0.motor-pos-fb",
            "card.0.position-cmd|float|in||| card.0.position-fb|float|out||copy|card.0.position-cmd",
        ),
        // The integral of a velocity.
        (
            "net x-cmd card.0.velocity-cmd\nnet x-fb card.0.position-fb",
            "card.0.position-fb|float|out||sum|card.0.velocity-cmd card.0.velocity-cmd|float|in|||",
        ),
        ("net ok card.in-3-not", "card.in-3-not|bit|out|||"),
        ("net x-index card.0.index-enable", "card.0.index-enable|bit|io||index|"),
        // Turns of a spindle, and its index.
        (
            "net turns card.1.position\nnet s-index card.1.index-enable",
            "card.1.index-enable|bit|io||index|card.1.position \
             card.1.position|float|out||sum|standin.sim.rps-0 standin.sim.rps-0|float|in|||",
        ),
        // Values that lines set.
        ("setp card.a TRUE", "card.a|bit|in|||"),
        ("setp card.a 5", "card.a|float|in|||"),
        ("setp card.a 0x10", "card.a|u32|in|||"),
        ("card.a = 1.5", "card.a|float|in|||"),
        // Types and writers of signals that only lines make.
        ("newsig s s32\nnet s card.a => card.b", "card.a|s32|out||| card.b|s32|in|||"),
        ("net s card.a <= card.b", "card.a|bit|in|||? card.b|bit|out|||?"),
        ("sets s 1.5\nnet s card.a", "card.a|float|in|||"),
        ("net s card.0.fault", "card.0.fault|bit|out|||?"),
        ("net s card.0.enable", "card.0.enable|bit|in|||?"),
        ("linkps card.a x-cmd", "card.a|float|in|||"),
        ("linksp x-cmd card.a", "card.a|float|in|||"),
    ] {
        let (pins, _) = inferred(joint, lines);
        assert_eq!(pins.join(" "), want, "{lines}");
    }
}

#[test]
fn outputs_are_written_by_the_function_that_reads() {
    let lines = "addf card.0.write t\naddf card.0.read t\naddf card.1.update t\naddf other.read t\naddf card.0.read t\n\
                 getp card.0.a\ngetp card.1.b";
    let (pins, functs) = inferred("", lines);
    assert_eq!(functs, ["card.0.write", "card.0.read", "card.1.update"]);
    assert_eq!(pins, ["card.0.a|bit|in|1||", "card.1.b|bit|in|2||"]);
}

#[test]
fn what_is_known_is_not_made_again() {
    let (pins, _) = inferred(
        "",
        "addf card.read t\nnet s card.read.time\nnet t card.read.tmax\nnet u card.read.times",
    );
    assert_eq!(pins, ["card.read.times|bit|in|0||?"]);
    let (pins, functs) =
        inferred("x card.0.a in", "setp card.0.a 1\nsetp card.0.b 1\nsetp and2.0.in0 1");
    assert_eq!((pins, functs.len()), (vec!["card.0.b|float|in|||".to_owned()], 0));
}

/// A chain from hardware to a pin of motion, with what the hardware should be.
#[test]
fn wants_go_back_through_logic() {
    let ends = "motmod joint.0.neg-lim-sw-in in lim
        motmod joint.0.home-sw-in in home
        iocontrol iocontrol.0.emc-enable-in in ok
        motmod spindle.0.at-speed in fast";
    for (chain, want) in [
        ("c card.a out lim", "a=0"),
        ("c card.a out ok", "a=1"),
        ("c card.a out fast", "a=1"),
        ("not n.out out lim\nnot n.in in s\nc card.a out s", "a=1"),
        (
            "and2 g.out out ok\nand2 g.in0 in s\nand2 g.in1 in t\nc card.a out s\nc card.b out t",
            "a=1 b=1",
        ),
        (
            "and2 g.out out lim\nand2 g.in0 in s\nand2 g.in1 in t\nc card.a out s\nc card.b out t",
            "a=0",
        ),
        (
            "or2 g.out out lim\nor2 g.in0 in s\nor2 g.in1 in t\nc card.a out s\nc card.b out t",
            "a=0 b=0",
        ),
        ("or2 g.out out ok\nor2 g.in0 in s\nor2 g.in1 in t\nc card.a out s\nc card.b out t", "a=1"),
        (
            "logic l.nand out lim\nlogic l.in-00 in s\nlogic l.in-01 in t\nc card.a out s\nc card.b out t",
            "a=1 b=1",
        ),
        (
            "logic l.nor out ok\nlogic l.in-00 in s\nlogic l.in-01 in t\nc card.a out s\nc card.b out t",
            "a=0 b=0",
        ),
        (
            "estop_latch e.ok-out out ok\nestop_latch e.ok-in in s\nestop_latch e.fault-in in t\nc card.a out s\nc card.b out t",
            "a=1 b=0",
        ),
        ("debounce d.0.out out home\ndebounce d.0.in in s\nc card.a out s", "a=0"),
        // Feedback and answers are those of their requests.
        ("motmod joint.0.motor-pos-fb fin fb\nc card.a fout fb", "a~joint.0.motor-pos-cmd"),
        (
            "iocontrol iocontrol.0.tool-changed in done\nc card.a out done",
            "a~iocontrol.0.tool-change",
        ),
        ("near n.out out fast\nnear n.in1 fin cmd\nnear n.in2 fin fb\nc card.a fout fb", "a~n.in1"),
        ("halui halui.program.pause in p\nc card.a out p", "a=0"),
        (
            "xor2 x.out out lim\nxor2 x.in0 in s\nxor2 x.in1 in t\nc card.a out s\nc card.b out t",
            "a=0 b=0",
        ),
        // The e-stop counts before a limit on the same wire.
        ("c card.a out ok\nmotmod joint.1.neg-lim-sw-in in ok", "a=1"),
        // Nothing is wanted of what a component computes, or of what nobody reads.
        ("comp p.out out ok\nc card.a out s", ""),
        ("c card.a out elsewhere", ""),
    ] {
        let wires = wires(&format!("{ends}\n{chain}"));
        let found = wants(&wires, &|pin| pin.starts_with("card."));
        let found: Vec<String> = found
            .iter()
            .map(|(pin, want)| match want {
                Want::Bit(value) => format!("{}={}", &pin[5..], u8::from(*value)),
                Want::As(other) => format!("{}~{other}", &pin[5..]),
            })
            .collect();
        assert_eq!(found.join(" "), want, "{chain}");
    }
}

/// A table of five inputs gives the row with the fewest inputs that are TRUE, of those that are linked.
#[test]
fn wants_go_back_through_tables() {
    let chain = "iocontrol iocontrol.0.emc-enable-in in ok\nlut5 l.out out ok\nlut5 l.in-0 in s\nlut5 l.in-1 in t\n\
                 lut5 l.in-2 in\nc card.a out s\nc card.b out t";
    for (function, want) in [
        (0b1000, "a=1 b=1"),
        (0b0100, "a=0 b=1"),
        (0b1110, "a=1 b=0"),
        (0b0001, "a=0 b=0"),
        // Only the third input, which is not linked, or nothing makes it TRUE.
        (0b1_0000, ""),
        (0, ""),
    ] {
        let mut wires = wires(chain);
        let value = Value::U32(function);
        let owner = "lut5".to_owned();
        let pin = Wired { direction: Direction::Rw, value, signal: None, owner };
        wires.pins.insert("l.function".to_owned(), pin);
        let found: Vec<String> = wants(&wires, &|pin| pin.starts_with("card."))
            .iter()
            .map(|(pin, want)| format!("{}={}", &pin[5..], u8::from(*want == Want::Bit(true))))
            .collect();
        assert_eq!(found.join(" "), want, "{function:#b}");
    }
}

#[test]
fn circles_of_logic_end() {
    let wires = wires(
        "iocontrol iocontrol.0.emc-enable-in in ok
         or2 a.out out ok\nor2 a.in0 in ok\nor2 a.in1 in s\nnot b.out out s\nnot b.in in ok",
    );
    assert_eq!(wants(&wires, &|_| false), BTreeMap::new());
    assert_eq!(driver(&wires, &|_| false, "iocontrol.0.emc-enable-in"), Driver::Nobody);
}

#[test]
fn a_switch_has_a_driver_or_none() {
    for (chain, want) in [
        ("motmod joint.0.home-sw-in in", Driver::Nobody),
        ("motmod joint.0.home-sw-in in s", Driver::Nobody),
        ("motmod joint.0.home-sw-in in s\nc card.a out s", Driver::Hardware),
        (
            "motmod joint.0.home-sw-in in s\nnot n.out out s\nnot n.in in t\nc card.a out t",
            Driver::Hardware,
        ),
        ("motmod joint.0.home-sw-in in s\nsim_home_switch h.home-sw out s", Driver::Somebody),
        (
            "motmod joint.0.home-sw-in in s\nor2 o.out out s\nor2 o.in0 in t\nor2 o.in1 in u\nc card.a out t\ncomp p.out out u",
            Driver::Somebody,
        ),
    ] {
        let wires = wires(chain);
        let found = driver(&wires, &|pin| pin.starts_with("card."), "joint.0.home-sw-in");
        assert_eq!(found, want, "{chain}");
    }
}

#[test]
fn on_the_real_clock_nothing_of_safety_depends_on_them() {
    let all = "c card.a out s
        mux2 m.in in s\nmux2 m.out out t
        motmod joint.0.pos-lim-sw-in in t
        c card.b out u\nmotmod motion.probe-input in u
        c card.c fout v\npid p.feedback fin v
        c card.d out w\niocontrol iocontrol.0.tool-changed in w\niocontrol iocontrol.0.user-enable-out out x
        iocontrol iocontrol.0.emc-enable-in in x";
    let wires = wires(all);
    let reached = |pin| reach::depended(&wires, [pin].into_iter()).map(|(_, pin)| pin);
    assert_eq!(reached("card.a").as_deref(), Some("joint.0.pos-lim-sw-in"));
    assert_eq!(reached("card.c").as_deref(), Some("p.feedback"));
    assert_eq!((reached("card.b"), reached("card.d")), (None, None));
}

#[test]
fn a_simulation_replaces_programs_of_hardware_and_no_modules() {
    let asked =
        |text: &str, simulated, headless| Asked::of([text].into_iter(), simulated, headless);
    for (asked, name, absent, want) in [
        (asked("", true, false), "gs2_vfd", false, true),
        (asked("", false, false), "gs2_vfd", false, false),
        (asked("", true, false), "hostmot2", true, false),
        (asked("a,hostmot2 b", true, false), "hostmot2", false, true),
        (asked("missing", true, false), "mine", true, true),
        (asked("missing", true, false), "mine", false, false),
        (asked("", true, false), "gladevcp", false, false),
        (asked("", true, true), "gladevcp", false, true),
        (asked("", false, true), "puma560gui", false, true),
    ] {
        assert_eq!(asked.replaces(name, absent), want, "{asked:?} {name} {absent}");
    }
    for (text, want) in [
        ("loadusr -W gs2_vfd -d /dev/ttyUSB0", true),
        ("loadusr -W /usr/bin/gs2_vfd", true),
        ("loadusr -W pumagui", true),
        ("# loadusr -W gs2_vfd", false),
        ("loadrt hostmot2\nsetp gs2_vfd.0.a 1", false),
    ] {
        assert_eq!(known::is_named_in(text.as_bytes()), want, "{text}");
    }
}

#[test]
fn a_simulated_gpio_line_may_be_active_low() {
    let mut wires = wires(
        "hal_gpio hal_gpio.GPIO5-in out
        hal_gpio hal_gpio.GPIO5-in-not out
        hal_gpio hal_gpio.sim.GPIO5 in",
    );
    for (args, is_low) in [
        ("inputs=GPIO5", false),
        ("inputs=GPIO5 activelow=GPIO5", true),
        ("inputs=GPIO5 activelow=\"GPIO5\"", true),
        ("inputs=\"GPIO4,GPIO5\" activelow=\"GPIO4,GPIO5\"", true),
        ("\"activelow=GPIO5,GPIO6\"", true),
        ("activelow=\"GPIO55\"", false),
    ] {
        wires.args.insert("hal_gpio".to_owned(), args.to_owned());
        for (pin, not) in [("hal_gpio.GPIO5-in", false), ("hal_gpio.GPIO5-in-not", true)] {
            let want = Some(("hal_gpio.sim.GPIO5".to_owned(), not ^ is_low));
            assert_eq!(gpio_line(&wires, pin), want, "{args}: {pin}");
        }
    }
}
