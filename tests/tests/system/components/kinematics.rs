//! Our kinematics compared with those of LinuxCNC's package, at the same positions.
//!
//! `cargo test -p hal-tests --test system components::kinematics -- --ignored` queries both at seeded random positions, and compares with
//! `tests/compat/kinematics.md`; with `UPDATE_EXPECT=1` it writes that file. A small C program,
//! `tests/compat/kinematics.c`, queries LinuxCNC's modules, each in a process of its own. Without the package or a C
//! compiler, the test is reported as skipped.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]
#![expect(clippy::print_stderr, reason = "what is skipped is said")]

use hal_bench::Bench;
use hal_component::{KinematicsRef, Pose};
use hal_tests::{foreign::installed, golden, programs::root, tools};
use kinematics as k;
use std::{
    collections::BTreeMap,
    fmt::Write as _,
    io::{BufRead, BufReader, Write as _},
    path::{Path, PathBuf},
    process::{Child, ChildStdin, ChildStdout, Command, Stdio},
};

/// A LinuxCNC kinematics module, in a process of its own.
struct Theirs {
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
}

impl Theirs {
    fn new(program: &Path, module: &str) -> Self {
        let file = installed().unwrap().join(format!("{module}.so"));
        let mut child = Command::new(program)
            .arg(file)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (to, from) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        Self { child, to, from: BufReader::new(from) }
    }

    fn say(&mut self, line: &str) {
        writeln!(self.to, "{line}").unwrap();
    }

    fn line(&mut self) -> String {
        let mut line = String::new();
        assert!(self.from.read_line(&mut line).unwrap() > 0, "it has ended");
        line.trim().to_owned()
    }

    /// Sends a query; returns whether there was an answer, the numbers, and the flags.
    fn ask(&mut self, line: &str) -> (bool, Vec<f64>, f64) {
        self.say(line);
        let mut numbers: Vec<f64> =
            self.line().split(' ').map(|x| x.parse().unwrap_or(f64::NAN)).collect();
        let flags = numbers.pop().unwrap();
        let result = numbers.remove(0);
        let finite = numbers.iter().all(|x| x.is_finite());
        ((0.0..5.0).contains(&result) && finite, numbers, flags)
    }

    /// Returns name, type, direction and first value of each pin.
    fn pins(&mut self) -> BTreeMap<String, (String, f64)> {
        self.say("pins");
        let mut out = BTreeMap::new();
        loop {
            let line = self.line();
            if line == "." {
                return out;
            }
            let words: Vec<&str> = line.split(' ').collect();
            let ty = match words[1] {
                "f" => "float",
                "b" => "bit",
                "s" => "s32",
                _ => "u32",
            };
            let dir = match words[2] {
                "16" => "IN",
                "32" => "OUT",
                "48" => "I/O",
                "64" => "RO",
                _ => "RW",
            };
            out.insert(words[0].to_owned(), (format!("{ty} {dir}"), words[3].parse().unwrap()));
        }
    }
}

impl Drop for Theirs {
    fn drop(&mut self) {
        drop(self.child.kill());
        drop(self.child.wait());
    }
}

/// Domain in which two are compared.
#[derive(Clone)]
struct KinematicsCase {
    module: &'static str,
    load: fn(&mut Bench) -> Result<(), String>,
    /// Size of the workspace, in units.
    size: f64,
    /// Range of each joint, or of each letter where poses are drawn.
    ranges: Vec<(f64, f64)>,
    /// Letters of the random poses; if empty, random joint positions are drawn instead.
    letters: &'static [usize],
    /// True if A B C are roll, pitch and yaw.
    abc: bool,
    set: &'static [(&'static str, f64)],
    switch: u32,
    /// Flags that LinuxCNC's inverse needs to stay in the configuration of the joints.
    flags: Option<fn(&[f64]) -> f64>,
    /// Known differences (forward, inverse or pins) and their reasons.
    differs: &'static [(&'static str, &'static str)],
}

const ROUNDS: usize = 2000;
/// Tolerance for equality: relative to the size, or in radians.
const SAME: f64 = 1e-7;

fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) as f64 / 2f64.powi(64)
}

fn spelled(list: &[f64]) -> String {
    list.iter().map(|x| format!("{x:e}")).collect::<Vec<_>>().join(" ")
}

/// Converts an angle in degrees to radians, wrapped to half a turn in either direction.
fn turn(angle: f64) -> f64 {
    (angle - 360.0 * (angle / 360.0).round()).to_radians()
}

/// Returns the rotation matrix of roll, pitch and yaw, row by row.
fn matrix(p: &[f64]) -> [f64; 9] {
    let [(sa, ca), (sb, cb), (sc, cc)] = [3, 4, 5].map(|i| p[i].to_radians().sin_cos());
    [
        cc * cb,
        cc * sb * sa - sc * ca,
        cc * sb * ca + sc * sa,
        sc * cb,
        sc * sb * sa + cc * ca,
        sc * sb * ca - cc * sa,
        -sb,
        cb * sa,
        cb * ca,
    ]
}

fn apart(place: &KinematicsCase, a: &[f64], b: &[f64]) -> f64 {
    let mut far = 0.0_f64;
    for i in [0, 1, 2, 6, 7, 8] {
        far = far.max((a[i] - b[i]).abs() / place.size);
    }
    if place.abc {
        let (a, b) = (matrix(a), matrix(b));
        return a.iter().zip(&b).fold(far, |far, (a, b)| far.max((a - b).abs()));
    }
    (3..6).fold(far, |far, i| far.max(turn(a[i] - b[i]).abs()))
}

/// Figures of one direction: number of positions that both could solve, and the largest difference.
#[derive(Default)]
struct Seen {
    both: usize,
    far: f64,
    one: usize,
}

impl Seen {
    fn tell(&self) -> String {
        let far = if self.far < 1e-13 { "0".to_owned() } else { format!("{:.0e}", self.far) };
        let one = if self.one > 0 { format!(", {} one alone", self.one) } else { String::new() };
        format!("{} places, {far}{one}", self.both)
    }
}

fn compare(program: &Path, place: &KinematicsCase) -> String {
    let mut bench = Bench::new();
    (place.load)(&mut bench).unwrap();
    let ours: KinematicsRef = bench.find();
    let mut theirs = Theirs::new(program, place.module);
    let (pins, missing, more) = pins(&bench, &theirs.pins());
    for (name, value) in place.set {
        bench.set(name, *value);
        theirs.say(&format!("set {name} {value:e}"));
    }
    if place.switch > 0 {
        assert!(ours.switch(place.switch));
        theirs.say(&format!("switch {}", place.switch));
    }
    let (mut forward, mut inverse) = (Seen::default(), Seen::default());
    let mut state = 7;
    for _ in 0..ROUNDS {
        let drawn: Vec<f64> =
            place.ranges.iter().map(|(a, b)| a + (b - a) * random(&mut state)).collect();
        let (mut joints, mut guess) = ([0.0; 16], [0.0; 9]);
        if place.letters.is_empty() {
            joints[..drawn.len()].copy_from_slice(&drawn);
        } else {
            for (l, value) in place.letters.iter().zip(&drawn) {
                guess[*l] = *value;
            }
            if ours.inverse(&guess, &mut joints).is_err() {
                continue;
            }
        }
        let mut pose: Pose = guess;
        let found = ours.forward(&joints, &mut pose).is_ok();
        let ask = format!("forward {} {}", spelled(&joints), spelled(&guess));
        let (theirs_found, their_pose, mut flags) = theirs.ask(&ask);
        if found && theirs_found {
            forward.both += 1;
            forward.far = forward.far.max(apart(place, &pose, &their_pose));
        }
        forward.one += usize::from(found != theirs_found);
        if !found {
            continue;
        }
        if let Some(choose) = place.flags {
            flags = choose(&joints);
        }
        let mut back = joints;
        let found = ours.inverse(&pose, &mut back).is_ok();
        let ask = format!("inverse {} {} {flags}", spelled(&pose), spelled(&joints));
        let (theirs_found, their_joints, _) = theirs.ask(&ask);
        if found && theirs_found {
            inverse.both += 1;
            for n in 0..ours.joints() {
                let way = back[n] - their_joints[n];
                let linear = way.abs() / place.size;
                inverse.far = inverse.far.max(linear.min(turn(way).abs()));
            }
        }
        inverse.one += usize::from(found != theirs_found);
    }
    let mut why = Vec::new();
    for (what, bad) in
        [("forward", forward.far > SAME), ("inverse", inverse.far > SAME), ("pins", missing)]
    {
        let known = place.differs.iter().find(|(w, _)| *w == what);
        match (bad, known) {
            (true, Some((_, text))) => why.push(format!("{what}: {text}")),
            (true, None) => why.push(format!("DIFFERS: {what}")),
            (false, Some(_)) => why.push(format!("DIFFERS: {what} is the same")),
            (false, None) => {}
        }
    }
    if !more.is_empty() {
        why.push(format!("more pins: {more}"));
    }
    assert!(forward.both > ROUNDS / 4 && inverse.both > ROUNDS / 4, "{}", place.module);
    let name = match place.switch {
        0 => format!("`{}`", place.module),
        n => format!("`{}`, type {n}", place.module),
    };
    format!("| {name} | {pins} | {} | {} | {} |", forward.tell(), inverse.tell(), why.join("; "))
}

/// Returns the number of equal pins, whether one is missing or different, and the pins that only ours has.
fn pins(bench: &Bench, theirs: &BTreeMap<String, (String, f64)>) -> (String, bool, String) {
    let ours: BTreeMap<String, String> = bench
        .names()
        .iter()
        .filter_map(|line| line.split_once(' '))
        .map(|(n, t)| (n.to_owned(), t.to_owned()))
        .collect();
    let mut same = 0;
    let mut wrong = false;
    for (name, (ty, first)) in theirs {
        let value = match ours.get(name).filter(|t| *t == ty).map(|t| t.split(' ').next().unwrap())
        {
            Some("float") => bench.get::<f64>(name),
            Some("bit") => f64::from(u8::from(bench.get::<bool>(name))),
            Some("s32") => f64::from(bench.get::<i32>(name)),
            Some(_) => f64::from(bench.get::<u32>(name)),
            None => f64::NAN,
        };
        if value == *first {
            same += 1;
        } else {
            eprintln!("{name}: {ty} {first}, ours {:?} {value}", ours.get(name));
            wrong = true;
        }
    }
    let more: Vec<String> =
        ours.keys().filter(|n| !theirs.contains_key(*n)).map(|n| format!("`{n}`")).collect();
    (format!("{same} of {}", theirs.len()), wrong, more.join(" "))
}

fn places() -> Vec<KinematicsCase> {
    let base = KinematicsCase {
        module: "",
        load: |_| Ok(()),
        size: 1000.0,
        ranges: Vec::new(),
        letters: &[],
        abc: false,
        set: &[],
        switch: 0,
        flags: None,
        differs: &[],
    };
    let (line, turn) = ((-300.0, 300.0), (-170.0, 170.0));
    let mixed = |n: usize, turns: &[usize]| -> Vec<(f64, f64)> {
        (0..n).map(|i| if turns.contains(&i) { turn } else { line }).collect()
    };
    let one = |module, load, ranges| KinematicsCase { module, load, ranges, ..base.clone() };
    const OLD: &str = "theirs are not each other's inverse where B and C, or U, are not 0";
    vec![
        KinematicsCase {
            size: 600.0,
            ..one("5axiskins", |b| b.load::<k::FiveAxiskins>(&[]), mixed(6, &[3, 4]))
        },
        one("corexykins", |b| b.load::<k::Corexykins>(&[]), mixed(9, &[])),
        KinematicsCase {
            size: 40.0,
            abc: true,
            letters: &[0, 1, 2, 3, 4, 5],
            ranges: [(-8., 8.), (-8., 8.), (20., 40.), (-20., 20.), (-20., 20.), (-20., 20.)]
                .into(),
            set: &[("genhexkins.tool-offset", 5.0), ("genhexkins.spindle-offset", 3.0)],
            ..one("genhexkins", |b| b.load::<k::Genhexkins>(&[]), Vec::new())
        },
        KinematicsCase {
            size: 800.0,
            abc: true,
            set: &[("genserkins.D-5", 60.0), ("genserkins.A-1", 30.0)],
            ..one("genserkins", |b| b.load::<k::Genserkins>(&[]), mixed(9, &[0, 1, 2, 3, 4, 5]))
        },
        KinematicsCase {
            size: 269.0,
            letters: &[0, 1, 2, 3, 4, 5, 6, 7, 8],
            ranges: [&[(-90., 90.), (-90., 90.), (-100., 400.)][..], &[(-50., 50.); 6]].concat(),
            ..one("lineardeltakins", |b| b.load::<k::Lineardeltakins>(&[]), Vec::new())
        },
        KinematicsCase {
            set: &[("maxkins.pivot-length", 100.0)],
            differs: &[("forward", OLD)],
            ..one("maxkins", |b| b.load::<k::Maxkins>(&[]), mixed(9, &[3, 4, 5]))
        },
        one("millturn", |b| b.load::<k::Millturn>(&[]), mixed(4, &[3])),
        KinematicsCase {
            switch: 1,
            ..one("millturn", |b| b.load::<k::Millturn>(&[]), mixed(4, &[3]))
        },
        KinematicsCase {
            size: 600.0,
            letters: &[0, 1, 2, 3, 4],
            ranges: [(-90., 90.), (-90., 90.), (250., 420.), (-10., 10.), (-10., 10.)].into(),
            set: &[("pentakins.tool-offset", 20.0)],
            differs: &[("pins", "theirs has parameters of a sixth strut, which it does not use")],
            ..one("pentakins", |b| b.load::<k::Pentakins>(&[]), Vec::new())
        },
        KinematicsCase {
            size: 800.0,
            abc: true,
            differs: &[("inverse", "theirs does not always stay on the side where the joints are")],
            ..one("pumakins", |b| b.load::<k::Pumakins>(&[]), vec![turn; 6])
        },
        KinematicsCase {
            size: 300.0,
            ..one("rosekins", |b| b.load::<k::Rosekins>(&[]), vec![(1.0, 300.0), line, turn])
        },
        KinematicsCase {
            size: 14.0,
            letters: &[0, 1, 2, 3, 4, 5, 6, 7, 8],
            ranges: [&[(-4., 4.), (-4., 4.), (-15., -9.)][..], &[(-5., 5.); 6]].concat(),
            ..one("rotarydeltakins", |b| b.load::<k::Rotarydeltakins>(&[]), Vec::new())
        },
        one("rotatekins", |b| b.load::<k::Rotatekins>(&[]), mixed(9, &[3, 4, 5])),
        KinematicsCase {
            size: 640.0,
            flags: Some(|joints| f64::from(u8::from(joints[1] < 0.0))),
            ..one("scarakins", |b| b.load::<k::Scarakins>(&[]), mixed(6, &[0, 1, 3, 4, 5]))
        },
        KinematicsCase {
            size: 458.0,
            letters: &[0, 1, 2, 3, 4],
            ranges: [(60., 280.), (-200., 200.), (0., 400.), turn, turn].into(),
            differs: &[("inverse", "theirs goes elsewhere when the forearm leans back under it")],
            ..one("scorbot-kins", |b| b.load::<k::ScorbotKins>(&[]), Vec::new())
        },
        KinematicsCase {
            size: 300.0,
            letters: &[0, 1, 2],
            ranges: [(-300., 300.), (-300., 300.), (10., 300.)].into(),
            set: &[("tripodkins.Bx", 300.0), ("tripodkins.Cx", 120.0), ("tripodkins.Cy", 250.0)],
            ..one("tripodkins", |b| b.load::<k::Tripodkins>(&[]), Vec::new())
        },
        one("userkins", |b| b.load::<k::Userkins>(&[]), mixed(3, &[])),
        KinematicsCase {
            switch: 1,
            set: &[
                ("xyzab_tdr_kins.x-offset", 10.0),
                ("xyzab_tdr_kins.z-offset", 20.0),
                ("xyzab_tdr_kins.y-rot-point", 30.0),
                ("xyzab_tdr_kins.tool-offset-z", 40.0),
            ],
            ..one("xyzab_tdr_kins", |b| b.load::<k::XyzabTdr>(&[]), mixed(5, &[3, 4]))
        },
        KinematicsCase {
            set: &[
                ("xyzac-trt-kins.y-offset", 10.0),
                ("xyzac-trt-kins.z-offset", 20.0),
                ("xyzac-trt-kins.x-rot-point", 30.0),
                ("xyzac-trt-kins.tool-offset", 40.0),
            ],
            ..one("xyzac-trt-kins", |b| b.load::<k::XyzacTrt>(&[]), mixed(5, &[3, 4]))
        },
        KinematicsCase {
            set: &[
                ("xyzbc-trt-kins.x-offset", 10.0),
                ("xyzbc-trt-kins.z-offset", 20.0),
                ("xyzbc-trt-kins.z-rot-point", 30.0),
                ("xyzbc-trt-kins.tool-offset", 40.0),
            ],
            ..one("xyzbc-trt-kins", |b| b.load::<k::XyzbcTrt>(&[]), mixed(5, &[3, 4]))
        },
    ]
}

const HEAD: &str = "\
# Kinematics beside LinuxCNC's

Written by `UPDATE_EXPECT=1 cargo test -p hal-tests --test system components::kinematics -- --ignored`, where LinuxCNC's
package is installed: each module of it is asked at the same seeded random places as ours. Differences
are parts of the machine's size, or radians; 0 is below 1e-13. A place that only one of both has an
answer for is counted. `three21kins`, `matrixkins`, `xyzacb_trsrn` and `xyzbca_trsrn` are not in the
package: nothing compares them, and the pins of the last two beside `dummy` are our own.

| module | pins the same | joints to pose | pose to joints | what differs |
|---|---|---|---|---|
";

/// Compiles the query program and returns its path.
fn program() -> Option<PathBuf> {
    let out = std::env::temp_dir().join(format!("ferrule-kinematics-{}", std::process::id()));
    let source = root().join("tests/compat/kinematics.c");
    let mut cc = Command::new("cc");
    cc.args(["-O1", "-w", "-rdynamic", "-o"]).arg(&out).arg(source).args(["-ldl", "-lm"]);
    let done = cc.status().ok()?;
    done.success().then_some(out)
}

#[test]
#[ignore = "needs LinuxCNC's package and cc: cargo test -p hal-tests --test system components::kinematics -- --ignored"]
fn ours_and_theirs_at_the_same_places() {
    if tools::linuxcnc().is_none() {
        return;
    }
    let Some(program) = program() else {
        tools::COMPILER.skip();
        return;
    };
    let mut text = HEAD.to_owned();
    for place in places() {
        writeln!(text, "{}", compare(&program, &place)).unwrap();
    }
    std::fs::remove_file(&program).unwrap();
    assert!(!text.contains("DIFFERS"), "{text}");
    let path = root().join("tests/compat/kinematics.md");
    golden::check(&path, &text);
}
