//! Kinematics of the page against those of the machine: tips, directions of tools, joints of arms.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use hal_arm::Arm;
use hal_bench::{Bench, Random};
use hal_component::{Component, KinematicsRef, Pose};
use hal_golden::tools::Tool;
use kinematics as k;
use serde_json::{Map, Value, json};
use std::{
    io::Write as _,
    path::Path,
    process::{Command, Stdio},
};

/// Kinematics on the bench, with the values of their pins.
struct Rig {
    bench: Bench,
    k: KinematicsRef,
    name: &'static str,
    values: Map<String, Value>,
}

impl Rig {
    fn new<C: Component>(args: &[&str]) -> Self {
        let mut bench = Bench::new();
        bench.load::<C>(args).unwrap();
        let k = bench.find();
        Self { bench, k, name: C::NAME, values: Map::new() }
    }

    fn set(&mut self, pin: &str, value: f64) {
        self.bench.set(&format!("{}.{pin}", self.name), value);
        self.values.insert(pin.to_owned(), value.into());
    }

    fn pose(&self, joints: &[f64]) -> Pose {
        let mut all = [0.0; 16];
        all[..joints.len()].copy_from_slice(joints);
        let mut pose = [0.0; 9];
        self.k.forward(&all, &mut pose).unwrap();
        pose
    }

    /// Returns what the page gets, with these samples.
    fn case(&self, kind: u32, samples: Vec<Value>) -> Value {
        json!({ "name": self.name, "type": kind, "values": self.values, "samples": samples })
    }
}

/// Returns an arm at random joints, and the joints that the machine chooses near others.
fn arm(model: &str, arm: &Arm, random: &mut Random) -> Value {
    let mut rig = Rig::new::<k::Armkins>(&[&format!("model={model}")]);
    let lengths = [arm.a1, arm.a2, arm.a3, arm.d1, arm.d4, arm.d6];
    for (name, value) in ["A1", "A2", "A3", "D1", "D4", "D6"].into_iter().zip(lengths) {
        rig.set(name, value);
    }
    for (n, _) in arm.min.iter().enumerate() {
        let lists = [("offset", arm.offset), ("min", arm.min), ("max", arm.max)];
        lists.into_iter().for_each(|(name, list)| rig.set(&format!("{name}-{n}"), list[n]));
        rig.values.insert(format!("sign-{n}"), arm.sign[n].into());
    }
    rig.values.insert("config".to_owned(), (-1).into());
    for (name, numbers) in [
        ("tool", [5.0, -7.0, 275.0, 10.0, 20.0, 30.0]),
        ("frame", [400.0, 100.0, -100.0, 0.0, 5.0, 60.0]),
    ] {
        for (letter, number) in ["x", "y", "z", "a", "b", "c"].into_iter().zip(numbers) {
            rig.set(&format!("{name}.{letter}"), number);
        }
    }
    let mut samples = Vec::new();
    for n in 0..5000 {
        let draw = |random: &mut Random| {
            let limits = arm.min.iter().zip(&arm.max);
            limits.map(|(low, high)| random.between(*low, *high)).collect::<Vec<_>>()
        };
        let (mut joints, last) = (draw(random), draw(random));
        // Also straight wrists, and places that the arm does not reach.
        if n % 50 == 0 {
            joints[4] = 0.0;
        }
        let mut pose = rig.pose(&joints);
        if n % 7 == 0 {
            pose[0] += 300.0;
        }
        let mut near = [0.0; 16];
        near[..6].copy_from_slice(&last);
        let found = rig.k.inverse(&pose, &mut near).is_ok();
        let near: Value = if found { json!(near[..6]) } else { Value::Null };
        let is_moved = n % 7 == 0;
        samples.push(json!({ "joints": joints, "pose": pose, "is_moved": is_moved, "last": last, "near": near }));
    }
    rig.case(0, samples)
}

/// Returns a machine with rotary axes at random places: the tip, and where the tool points. `along` returns the direction
/// out of poses of joints that the machine may take.
fn tilting<C: Component>(
    letters: &[usize],
    own: u32,
    pins: &[&str],
    random: &mut Random,
    along: impl Fn(&Rig, &[f64]) -> [f64; 3],
) -> Value {
    let mut rig = Rig::new::<C>(&[]);
    for pin in pins {
        rig.set(pin, random.between(-60.0, 60.0));
    }
    assert!(own == 0 || rig.k.switch(own));
    let mut samples = Vec::new();
    for _ in 0..300 {
        let joints: Vec<f64> = letters.iter().map(|_| random.between(-170.0, 170.0)).collect();
        let mut place = [0.0; 9];
        letters.iter().zip(&joints).for_each(|(letter, joint)| place[*letter] = *joint);
        samples.push(json!({ "joints": joints, "letters": place, "pose": rig.pose(&joints), "axis": along(&rig, &joints) }));
    }
    rig.case(own, samples)
}

/// Returns a machine at random joints, with these values of its pins.
fn placed<C: Component>(pins: &[(&str, f64)], joints: &[(f64, f64)], random: &mut Random) -> Value {
    let mut rig = Rig::new::<C>(&[]);
    pins.iter().for_each(|(pin, value)| rig.set(pin, *value));
    let sample = |_| {
        let joints: Vec<f64> =
            joints.iter().map(|(low, high)| random.between(*low, *high)).collect();
        json!({ "joints": joints, "pose": rig.pose(&joints) })
    };
    let samples = (0..300).map(sample).collect();
    rig.case(0, samples)
}

/// Returns how far the tip goes when a joint does.
fn change(rig: &Rig, joints: &[f64], joint: usize) -> [f64; 3] {
    let (mut other, from) = (joints.to_vec(), rig.pose(joints));
    other[joint] += 1.0;
    let to = rig.pose(&other);
    [0, 1, 2].map(|i| to[i] - from[i])
}

/// A table alone turns: the tool comes down as Z does.
fn by_table(rig: &Rig, joints: &[f64]) -> [f64; 3] {
    change(rig, joints, 2)
}

/// W lowers the tool along itself.
fn by_quill<const W: usize>(rig: &Rig, joints: &[f64]) -> [f64; 3] {
    change(rig, joints, W).map(|v| -v)
}

/// A longer pivot lowers the tool along itself, and the machine counts from the upright tool.
fn by_pivot(rig: &Rig, joints: &[f64]) -> [f64; 3] {
    let pin = format!("{}.z-pivot", rig.name);
    let pivot: f64 = rig.bench.get(&pin);
    let from = rig.pose(joints);
    rig.bench.set(&pin, pivot + 1.0);
    let to = rig.pose(joints);
    rig.bench.set(&pin, pivot);
    let up = change(rig, joints, 2);
    [0, 1, 2].map(|i| up[i] - (to[i] - from[i]))
}

#[test]
fn the_page_knows_where_tools_are_and_point() {
    if !Tool::of("node").is_installed() {
        return;
    }
    let random = &mut Random::new(11);
    let mut cases = vec![arm("rx90", &Arm::RX90, random), arm("rs03n", &Arm::RS03N, random)];
    let point = ["x-rot-point", "y-rot-point", "z-rot-point", "x-offset", "z-offset"];
    let trunnion = [&point[..], &["y-offset", "tool-offset"]].concat();
    let tables = [&point[..], &["tool-offset-z"]].concat();
    let head = |letter: &'static str| match letter {
        "y" => ["tool-offset-z", "z-pivot", "z-rot-axis", "nut-angle", "y-pivot", "y-rot-axis"],
        _ => ["tool-offset-z", "z-pivot", "z-rot-axis", "nut-angle", "x-pivot", "x-rot-axis"],
    };
    cases.extend([
        tilting::<k::FiveAxiskins>(
            &[0, 1, 2, 4, 5, 8],
            0,
            &["pivot-length"],
            random,
            by_quill::<5>,
        ),
        tilting::<k::Maxkins>(
            &[0, 1, 2, 3, 4, 5, 6, 7, 8],
            0,
            &["pivot-length"],
            random,
            by_quill::<8>,
        ),
        tilting::<k::XyzacTrt>(&[0, 1, 2, 3, 5], 0, &trunnion, random, by_table),
        tilting::<k::XyzbcTrt>(&[0, 1, 2, 4, 5], 0, &trunnion, random, by_table),
        tilting::<k::XyzabTdr>(&[0, 1, 2, 3, 4], 1, &tables, random, by_table),
        tilting::<k::XyzacbTrsrn>(&[0, 1, 2, 3, 5, 4], 1, &head("y"), random, by_pivot),
        tilting::<k::XyzbcaTrsrn>(&[0, 1, 2, 4, 5, 3], 1, &head("x"), random, by_pivot),
    ]);
    let turn = (-170.0, 170.0);
    let links: Vec<_> = (0..6)
        .flat_map(|n| {
            [(format!("A-{n}"), 100.0), (format!("ALPHA-{n}"), 2.0), (format!("D-{n}"), 200.0)]
        })
        .map(|(pin, most)| (pin, random.between(-most, most)))
        .collect();
    let links: Vec<_> = links.iter().map(|(pin, value)| (pin.as_str(), *value)).collect();
    let puma = [("A2", 400.0), ("A3", 50.0), ("D3", 100.0), ("D4", 400.0), ("D6", 100.0)];
    let lengths = ["D1", "D2", "D3", "D4", "D5", "D6"];
    let scara: Vec<_> = lengths.into_iter().zip([490.0, 340.0, 50.0, 250.0, 60.0, 40.0]).collect();
    let height = (300.0, 350.0);
    let still = (0.0, 0.0);
    cases.extend([
        placed::<k::Genserkins>(&links, &[turn; 6], random),
        placed::<k::Pumakins>(&puma, &[turn; 6], random),
        placed::<k::Scarakins>(&scara, &[turn, turn, (0.0, 300.0), turn, still, still], random),
        placed::<k::Lineardeltakins>(&[("R", 130.0), ("L", 270.0)], &[height; 3], random),
    ]);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/page/kinematics.mjs");
    let mut node = Command::new("node");
    let mut node = node.arg(script).stdin(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // A script that fails before it has read everything tells why.
    drop(node.stdin.take().unwrap().write_all(json!(cases).to_string().as_bytes()));
    let done = node.wait_with_output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}
