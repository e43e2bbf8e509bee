//! The mill of the thesis: its two parts from the program to the steps of the motors, and the parts as printed, which the
//! machine refuses.
#![expect(clippy::indexing_slicing, clippy::unwrap_used, reason = "tests")]

use hal_gcode::{
    Interpreter,
    ticks::{Resolution, Ticks},
};
use hal_job::{
    Files, Machine, World,
    run::{Answers, run},
    world,
};
use hal_tests::{programs::root, scratch::Scratch, vcd::Vcd};
use std::{collections::BTreeMap, path::Path};

/// Nanoseconds between two steps of a motor at 1000 steps in a second.
const FASTEST: i64 = 1_000_000;
/// Largest distance in steps from the ticks of T-mode: a step, the 0.002 mm of the exact path, and the rounding of both.
const NEAR: i64 = 2;

/// The mill with a recording of the counts of its motors.
fn mill() -> Scratch {
    let scratch = Scratch::copy_of(&root().join("configs/maxnc"));
    scratch.write("record.hal", "record part.vcd stepgen.*.rawcounts\n");
    scratch.write("part.ini", "#INCLUDE maxnc.ini\n[HAL]\nHALFILE = record.hal\n");
    scratch
}

/// Returns the places in steps after each tick of T-mode.
fn ticks(folder: &Path, part: &str) -> Vec<[i64; 3]> {
    let ini = folder.join("maxnc.ini");
    let machine = Machine::read(&Files { ini: Some(&ini), ..Files::default() }).unwrap();
    let world = World { machine, hal: BTreeMap::new(), functions: None };
    let settings = world.machine.settings.clone();
    let mut it = Interpreter::new(settings, world.machine.numbered.clone());
    it.load(part, world::program(&folder.join(part)).unwrap());
    let state = &it.state;
    let mut ticks = Ticks::new(state.frame, state.position, Resolution::default()).unwrap();
    let mut out = vec![[0; 3]];
    run(&mut it, &world, Answers { probe_trips: false, functions: None }, |_, issued| {
        let mut at = out[out.len() - 1];
        let followed = ticks.follow(issued, &mut |step| {
            for (at, step) in at.iter_mut().zip(step) {
                *at += i64::from(step);
            }
            out.push(at);
        });
        followed.map(drop).unwrap();
        Ok(())
    })
    .unwrap();
    out
}

/// Returns the places in steps after each step of a motor, with their times; the sign of Y and Z is that of the axis.
fn stepped(vcd: &Vcd) -> Vec<(i64, [i64; 3])> {
    let mut changes: Vec<(i64, usize, i64)> = Vec::new();
    for axis in 0..3 {
        let name = format!("stepgen.{axis}.rawcounts");
        let sign = if axis == 0 { 1.0 } else { -1.0 };
        #[expect(clippy::cast_possible_truncation, reason = "counts")]
        changes.extend(vcd.of(&name).iter().map(|(time, v)| (*time, axis, (sign * v) as i64)));
    }
    changes.sort_unstable();
    let mut at = [0; 3];
    let mut out: Vec<(i64, [i64; 3])> = Vec::new();
    for (time, axis, counts) in changes {
        at[axis] = counts;
        match out.last_mut() {
            Some(last) if last.0 == time => last.1 = at,
            _ => out.push((time, at)),
        }
    }
    out
}

#[test]
fn both_parts_end_at_zero_on_the_path_of_the_document() {
    for (part, extents) in [
        ("scissors-a.nc", [(0, 32_000), (0, 6000), (-1000, 1000)]),
        ("scissors-b.nc", [(0, 26_000), (0, 10_000), (-1000, 1000)]),
        ("scissors-b-plunged.nc", [(0, 26_000), (0, 10_000), (-1000, 1000)]),
    ] {
        let scratch = mill();
        let output = scratch.halrun(&["--virtual", "--run", part, "part.ini"]);
        assert_eq!(output.status, Some(0), "{}", output.stderr);
        let places = stepped(&Vcd::parse(&scratch.read("part.vcd")));
        assert_eq!(places.last().unwrap().1, [0; 3], "{part}");
        let path = ticks(scratch.path(), part);
        let mut place = 0;
        for (axis, (low, high)) in extents.into_iter().enumerate() {
            let values = places.iter().map(|(_, at)| at[axis]);
            assert_eq!(values.clone().min().zip(values.max()), Some((low, high)), "{part} {axis}");
            let mut before: Option<(i64, i64)> = None;
            for (time, at) in places.iter().map(|(time, at)| (*time, at[axis])) {
                if let Some((since, counts)) = before.filter(|(_, counts)| *counts != at) {
                    assert_eq!((at - counts).abs(), 1, "{part}: axis {axis} at {time} ns");
                    let is_slow = since == i64::MIN || time - since >= FASTEST;
                    assert!(is_slow, "{part}: axis {axis} steps {} ns after a step", time - since);
                    before = Some((time, at));
                } else if before.is_none() {
                    before = Some((i64::MIN, at));
                }
            }
        }
        for (time, at) in &places {
            let far = |tick: &[i64; 3]| {
                tick.iter().zip(at).map(|(a, b)| (a - b).abs()).max().unwrap_or(0)
            };
            // Along the path, never back.
            let rest = path.iter().enumerate().skip(place);
            let next = rest.take(12).find(|(_, tick)| far(tick) <= NEAR);
            let Some((n, _)) = next else {
                panic!("{part}: {at:?} at {time} ns is not near {:?}", path[place])
            };
            place = n;
        }
        assert!(place + 8 >= path.len(), "{part} ends at tick {place} of {}", path.len());
    }
}

#[test]
fn the_parts_as_printed_are_refused_in_line_7_and_nothing_moves() {
    for part in ["scissors-a-printed.nc", "scissors-b-printed.nc"] {
        let scratch = mill();
        let output = scratch.halrun(&["--virtual", "--run", part, "part.ini"]);
        assert_eq!(output.status, Some(1), "{}", output.stderr);
        let place = format!("/{part}:7: task.run: column 1: Radius to end of arc differs");
        assert!(output.stderr.contains(&place), "{}", output.stderr);
        assert!(output.stderr.contains("failed after 0.000 s"), "{}", output.stderr);
        let vcd = Vcd::parse(&scratch.read("part.vcd"));
        assert!(stepped(&vcd).iter().all(|(_, at)| *at == [0; 3]), "{part}");
    }
}
