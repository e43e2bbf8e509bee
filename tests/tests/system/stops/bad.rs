//! Stops at bad moments and in masses: in the cycle of a start, behind a full queue, in a burst, during loads and tool changes.

use super::{
    data::{Motion, machines},
    judge,
    motion::{self, Moving},
    rig::Rig,
};
use hal_bench::Random;
use hal_protocol::{Link as _, Request};

/// Machines of these tests: one with a task and steppers, one without.
const MACHINES: [&str; 2] = ["printer", "mill"];
/// Stops of one second of a burst.
const BURST: usize = 10_000;
/// Cycles of a second.
const SECOND: usize = 1000;
/// Stops that take effect in the next cycle, with whether they switch the machine off.
const STOPS: [(&str, bool); 4] = [
    ("iocontrol.estop", true),
    ("motion.disable", true),
    ("motion.abort", false),
    ("motion.pause", false),
];

fn rig(name: &str) -> Rig {
    let machine = machines().into_iter().find(|m| m.name == name);
    Rig::start(&machine.unwrap_or_else(|| panic!("no machine {name}")))
}

/// Begins a motion of a machine that is ready.
fn moving(rig: &mut Rig, motion: Motion) -> Moving {
    super::cell::ready(rig).unwrap();
    motion::begin(rig, motion, false).unwrap()
}

/// Judges that the last stop acts in the next cycle, and that nothing moves for a second.
fn acts(rig: &mut Rig, moving: &Moving, is_off: bool, what: &str) {
    rig.run(SECOND);
    let judged = if is_off {
        judge::off(moving, &rig.seen, 1)
    } else {
        judge::brake(moving, &rig.seen, 1, false)
    };
    judged.unwrap_or_else(|why| panic!("{}: {what}: {why}", rig.machine.name));
}

#[test]
fn a_stop_does_not_wait_behind_a_full_queue() {
    for name in MACHINES {
        let mut rig = rig(name);
        for (stop, is_off) in STOPS {
            let moving = moving(&mut rig, Motion::Jog);
            rig.forget();
            let was = rig.refused.len();
            let mut n = 0;
            while rig.refused.len() == was && n < BURST {
                rig.give("motion.feed override=1");
                n += 1;
            }
            let full = rig.refused.pop().unwrap_or_default();
            assert!(full.contains("full") || full.contains("many"), "{stop}: {n}: {full}");
            // It may have no room to tell its end, but it acts.
            let said = if rig.give(stop) { None } else { rig.refused.pop() };
            assert!(said.is_none_or(|why| why.contains("the stop is in force")), "{stop}");
            acts(&mut rig, &moving, is_off, &format!("{stop} behind {n} commands"));
            super::cell::clear_all(&mut rig).unwrap();
        }
    }
}

#[test]
fn ten_thousand_stops_a_second_are_served() {
    for name in MACHINES {
        let mut rig = rig(name);
        let mut random = Random::new(35);
        // The first one of a burst counts like any other, and the burst harms nothing.
        for (stop, is_off) in STOPS {
            let moving = moving(&mut rig, Motion::Line);
            rig.forget();
            rig.give(stop);
            let mut seen = Vec::new();
            for _ in 0..SECOND {
                for _ in 0..BURST / SECOND {
                    // Weaker stops do not undo a stronger one.
                    let (other, _) = STOPS[random.index(STOPS.len())];
                    rig.give(if is_off { other } else { stop });
                }
                rig.run(1);
            }
            seen.append(&mut rig.seen.clone());
            let judged = if is_off {
                judge::off(&moving, &seen, 1)
            } else {
                judge::brake(&moving, &seen, 1, false)
            };
            judged.unwrap_or_else(|why| panic!("{name}: a burst of {stop}: {why}"));
            super::cell::clear_all(&mut rig).unwrap();
        }
        moving_again(&mut rig);
    }
}

/// Checks that a machine obeys as before.
fn moving_again(rig: &mut Rig) {
    let moving = moving(rig, Motion::Jog);
    rig.forget();
    rig.give("motion.abort");
    acts(rig, &moving, false, "after all");
}

/// Commands that begin a motion, for each kind of it.
fn starts(rig: &Rig) -> Vec<String> {
    let mut starts = vec![
        "motion.jog joint=0 velocity=5".to_owned(),
        "motion.move x=5 velocity=5".to_owned(),
        "motion.home joint=0".to_owned(),
    ];
    if rig.has_task() {
        starts.push("task.run".to_owned());
        starts.push("task.mdi text='G1 X5 F300'".to_owned());
    }
    starts
}

#[test]
fn a_stop_in_the_cycle_of_a_start_wins() {
    for name in MACHINES {
        let mut rig = rig(name);
        for start in starts(&rig) {
            for (stop, is_off) in STOPS {
                super::cell::ready(&mut rig).unwrap();
                prepare(&mut rig, &start);
                rig.forget();
                assert!(rig.give(&start), "{name}: {start}: {:?}", rig.refused);
                rig.give(stop);
                rig.run(SECOND);
                let what = format!("{name}: {start}, and {stop} before the next cycle");
                judge::stays(&rig.seen[1..], &what).unwrap();
                let is_on = rig.last().on;
                assert_eq!(is_on, !is_off, "{what}");
                super::cell::clear_all(&mut rig).unwrap();
            }
        }
    }
}

/// Makes ready what a start needs.
fn prepare(rig: &mut Rig, start: &str) {
    if start.starts_with("task.run") {
        rig.scratch.write("start.ngc", "G21 G90\nG1 X5 F300\nG1 X0\nM2\n");
        rig.finish("task.mode mode=auto", 500).unwrap();
        rig.finish("task.open file=start.ngc", 1000).unwrap();
    } else if start.starts_with("task.mdi") {
        rig.finish("task.mode mode=mdi", 500).unwrap();
    } else if start.starts_with("motion.home") {
        let search = "home-search-vel=5 home-latch-vel=1";
        rig.finish(&format!("motion.configure joint=0 {search}"), 20).unwrap();
    } else if start.starts_with("motion.move") {
        rig.finish("motion.mode mode=coord", 100).unwrap();
    }
    rig.run(20);
}

#[test]
fn a_stop_in_the_cycle_of_a_load_is_not_late() {
    for name in MACHINES {
        let mut rig = rig(name);
        for (n, (stop, is_off)) in STOPS.into_iter().enumerate() {
            let moving = moving(&mut rig, Motion::Jog);
            rig.forget();
            let args = vec![format!("names=late-{n}")];
            rig.client.call(Request::Load { module: "and2".to_owned(), args }).unwrap();
            rig.give(stop);
            let unload = Request::Unload { name: "and2".to_owned() };
            // Whether it is unloaded does not matter here.
            drop(rig.client.call(unload));
            acts(&mut rig, &moving, is_off, &format!("{stop} during a load"));
            super::cell::clear_all(&mut rig).unwrap();
        }
    }
}

#[test]
fn a_stop_during_a_tool_change_withdraws_it() {
    let mut rig = rig("printer");
    for (stop, is_off) in STOPS {
        super::cell::ready(&mut rig).unwrap();
        rig.scratch.write("change.ngc", "G21 G90\nT1 M6\nG1 X5 F300\nM2\n");
        rig.finish("task.mode mode=auto", 500).unwrap();
        // A change that was stopped leaves the tool unknown.
        drop(rig.finish("task.mdi-brief text='M61 Q0'", 1000));
        rig.finish("task.open file=change.ngc", 1000).unwrap();
        rig.give("task.run");
        let asked = (0..300).any(|_| {
            rig.run(10);
            rig.is("iocontrol.0.tool-change")
        });
        assert!(asked, "the tool is asked for: {:?}", rig.said());
        rig.forget();
        rig.give(stop);
        rig.run(SECOND);
        judge::stays(&rig.seen[2..], &format!("{stop} in a tool change")).unwrap();
        assert_eq!(rig.last().on, !is_off, "{stop}");
        if stop != "motion.pause" {
            assert!(!rig.is("iocontrol.0.tool-change"), "{stop} withdraws the change");
        }
        // The changer answers, too late: nothing moves by that.
        rig.forget();
        rig.run(SECOND);
        judge::stays(&rig.seen, &format!("a second after {stop} in a tool change")).unwrap();
        super::cell::clear_all(&mut rig).unwrap();
    }
}

#[test]
fn an_order_from_before_a_stop_is_refused() {
    for name in MACHINES {
        let mut rig = rig(name);
        for (stop, is_off) in STOPS {
            for start in [
                "motion.jog joint=0 velocity=5",
                "motion.move x=5 velocity=5",
                "motion.home joint=0",
            ] {
                super::cell::ready(&mut rig).unwrap();
                prepare(&mut rig, start);
                let epoch = rig.number("epoch");
                rig.give(stop);
                rig.run(50);
                if is_off {
                    super::cell::switch_on(&mut rig).unwrap();
                }
                rig.run(50);
                rig.forget();
                let line = format!("{start} epoch={epoch}");
                let was_refused = rig.finish(&line, 100);
                let what = format!("{name}: {line} behind {stop}");
                if stop == "motion.pause" && start.starts_with("motion.move") {
                    // A move of a paused path waits.
                    rig.run(200);
                } else {
                    let why = was_refused.expect_err(&what);
                    assert!(why.contains("stop has come meanwhile"), "{what}: {why}");
                }
                judge::stays(&rig.seen, &what).unwrap();
                super::cell::clear_all(&mut rig).unwrap();
            }
        }
    }
}
