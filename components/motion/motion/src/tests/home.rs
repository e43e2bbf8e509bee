//! Homing on switches and on the encoder's index.

use super::*;

/// Joint 0 on a rail, with a home switch and an encoder that has an index.
struct Rail {
    rig: Rig,
    /// Range in which the switch is closed.
    switch: (f64, f64),
    /// Distance between index pulses; infinite without an index.
    pitch: f64,
    /// Position of the encoder's zero on the rail, the joint's position and speed, and whether the index resets the
    /// encoder.
    zero: f64,
    at: f64,
    speed: f64,
    resets: bool,
    states: Vec<i32>,
}

impl Rail {
    fn new(switch: (f64, f64), start: f64, config: &str) -> Self {
        let mut rig = Rig::off(&[]);
        rig.stuck[0] = true;
        rig.strict = false;
        rig.say(&format!("motion.configure joint=0 {config}"));
        let mut rail = Self {
            rig,
            switch,
            pitch: f64::INFINITY,
            // The zero of the encoder is unrelated to the joint's position.
            zero: start - 5.0,
            at: start,
            speed: 0.0,
            resets: true,
            states: Vec::new(),
        };
        rail.rig.bench.set("joint.0.motor-pos-fb", 5.0);
        rail.rig.bench.set("joint.0.home-sw-in", rail.is_on());
        rail.rig.done("motion.enable");
        rail
    }

    fn is_on(&self) -> bool {
        self.switch.0 <= self.at && self.at <= self.switch.1
    }

    fn cycle(&mut self) {
        self.rig.cycle();
        let was = self.at;
        self.at = self.rig.joint(0, "motor-pos-cmd") + self.zero;
        let speed = (self.at - was) / DT;
        let acc = (speed - self.speed) / DT;
        let is_on = self.rig.is("motion.motion-enabled");
        let most = LIMITS[0].1 * (1.0 + 1e-4);
        assert!(!is_on || acc.abs() <= most, "{acc} units/s² in {:?}", self.states);
        self.speed = speed;
        let turn = |at: f64| (at / self.pitch).floor();
        if self.rig.is("joint.0.index-enable") && turn(was) != turn(self.at) {
            if self.resets {
                self.zero = turn(was.max(self.at)) * self.pitch;
            }
            self.rig.bench.set("joint.0.index-enable", false);
        }
        self.rig.bench.set("joint.0.motor-pos-fb", self.at - self.zero);
        self.rig.bench.set("joint.0.home-sw-in", self.is_on());
        let state = self.rig.bench.get("joint.0.home-state");
        if self.states.last() != Some(&state) {
            self.states.push(state);
        }
    }

    /// Homes the joint; returns the position of the joint's zero on the rail.
    fn home(&mut self) -> Result<f64, &'static str> {
        self.rig.say("motion.home joint=0");
        self.cycle();
        while self.rig.is("joint.0.homing") {
            self.cycle();
        }
        self.cycle();
        self.rig.end()?;
        assert!(self.rig.is("joint.0.homed"));
        assert_eq!(self.rig.bench.get::<u32>("motion.watch.violations"), 0);
        Ok(self.at - self.rig.joint(0, "pos-fb"))
    }
}

/// The edge is found within the distance that the latch velocity covers in two cycles.
#[test]
fn on_a_switch() {
    let config = "home-offset=-3 home=2 home-final-vel=50 max-velocity=90";
    for (search, latch, switch, start, edge, states) in [
        // Onto the switch at the end, back, and slowly onto it.
        (-20.0, -1.0, (-99.0, -40.0), 7.0, -40.0, &[6, 7, 9, 10, 11, 12, 20, 21, 0][..]),
        // The same with a slow search off the switch.
        (-20.0, 1.0, (-99.0, -40.0), 7.0, -40.0, &[6, 7, 13, 14, 20, 21, 0]),
        // It begins on the switch.
        (-20.0, 1.0, (-99.0, -40.0), -41.0, -40.0, &[4, 5, 6, 7, 13, 14, 20, 21, 0]),
        (20.0, 0.5, (30.0, 99.0), 7.0, 30.0, &[6, 7, 9, 10, 11, 12, 20, 21, 0]),
        (20.0, -0.5, (30.0, 99.0), 7.0, 30.0, &[6, 7, 13, 14, 20, 21, 0]),
        // A cam that is passed: its far edge is not mistaken.
        (20.0, 0.5, (30.0, 36.0), 31.0, 30.0, &[4, 5, 6, 7, 9, 10, 11, 12, 20, 21, 0]),
    ] {
        let own = format!("{config} home-search-vel={search} home-latch-vel={latch}");
        let mut rail = Rail::new(switch, start, &own);
        let zero = rail.home().unwrap();
        // The switch is at home-offset.
        let off = zero - 3.0 - edge;
        assert!(off.abs() <= 2.0 * f64::abs(latch) * DT, "{off} of {search} {latch}");
        near(rail.rig.joint(0, "pos-cmd"), 2.0);
        assert_eq!(rail.states, states, "{search} {latch}");
        // A second homing finds the same position.
        let again = rail.home().unwrap();
        assert!((again - zero).abs() <= 2.0 * f64::abs(latch) * DT);
    }
}

#[test]
fn on_the_index() {
    let config = "home-use-index=1 home-latch-vel=0.5 home-offset=-1.5 home=4";
    for (resets, reset) in [(true, ""), (false, " home-index-no-encoder-reset=1")] {
        for (search, edge, states) in [
            (" home-search-vel=20", 32.0, &[6, 7, 9, 10, 11, 12, 18, 20, 21, 0][..]),
            // Without a switch: the first index pulse.
            ("", 8.0, &[16, 18, 20, 21, 0]),
        ] {
            let mut rail = Rail::new((30.5, 99.0), 7.0, &format!("{config}{search}{reset}"));
            rail.pitch = 2.0;
            rail.resets = resets;
            let zero = rail.home().unwrap();
            // An encoder that resets itself latches the exact position.
            let room = if resets { 1e-9 } else { 2.0 * 0.5 * DT };
            assert!((zero - 1.5 - edge).abs() <= room, "{zero} {edge}");
            near(rail.rig.joint(0, "pos-cmd"), 4.0);
            assert!(!rail.rig.is("joint.0.index-enable"));
            assert_eq!(rail.states, states);
        }
    }
}

#[test]
fn with_an_absolute_encoder() {
    for (encoder, states, place) in [(1, &[15, 20, 21, 0][..], 2.0), (2, &[15, 20, 21, 0], 8.0)] {
        let config = format!("home-absolute-encoder={encoder} home-offset=3 home=2");
        let mut rail = Rail::new((90.0, 99.0), 7.0, &config);
        // The encoder reads 5: the joint is at 8.
        rail.home().unwrap();
        near(rail.rig.joint(0, "pos-cmd"), place);
        assert_eq!(rail.states, states);
        near(rail.rig.joint(0, "motor-offset"), -3.0);
        // A second homing does not shift it.
        rail.home().unwrap();
        near(rail.rig.joint(0, "pos-cmd"), place);
    }
}

#[test]
fn what_ends_homing() {
    let config = "home-search-vel=20 home-latch-vel=1 min-limit=-5 max-limit=5";
    // The switch never closes.
    let mut rail = Rail::new((900.0, 999.0), 0.0, config);
    let end = "end of move while homing: no home switch or index was found";
    assert_eq!(rail.home(), Err(end));
    assert_eq!(rail.rig.bench.said(), ["j0 end of move in home state 7"]);
    near(rail.at, 20.0);
    assert!(rail.rig.is("motion.motion-enabled") && !rail.rig.is("joint.0.homed"));

    // A limit switch closes; and the machine goes off, as the joint is no longer homing.
    let mut rail = Rail::new((10.0, 99.0), 0.0, config);
    rail.rig.say("motion.home joint=0");
    while rail.at < 3.0 {
        rail.cycle();
    }
    rail.rig.bench.set("joint.0.pos-lim-sw-in", true);
    rail.cycle();
    assert!(!rail.rig.is("motion.motion-enabled"), "in this cycle");
    assert_eq!(rail.rig.end(), Err("hit limit while homing"));
    let said = ["j0 hit limit in home state 7", "axis X on limit switch error"];
    assert_eq!(rail.rig.bench.said(), said);

    // Unless it is configured to ignore the limit switch.
    for ignores in [false, true] {
        let config = format!("{config} home-ignore-limits={}", u8::from(ignores));
        let mut rail = Rail::new((10.0, 99.0), 0.0, &config);
        rail.rig.bench.set("joint.0.neg-lim-sw-in", true);
        rail.rig.done("motion.override-limits");
        match rail.home() {
            Ok(zero) => assert!(ignores && (zero - 10.0).abs() <= 2.0 * DT, "{zero}"),
            Err(why) => assert_eq!((ignores, why), (false, "hit limit while homing")),
        }
    }

    // The switch opens while the joint rests, and closes.
    for (start, flips, said) in [
        (11.0, false, "j0 home switch inactive before start of backoff move in home state 4"),
        (0.0, true, "j0 home switch active before start of search move in home state 6"),
    ] {
        let mut rail = Rail::new((10.0, 99.0), start, config);
        rail.rig.say("motion.home joint=0");
        (0..20).for_each(|_| rail.cycle());
        rail.switch = if flips { (-99.0, 99.0) } else { (98.0, 99.0) };
        while rail.rig.is("joint.0.homing") {
            rail.cycle();
        }
        assert_eq!(rail.rig.bench.said(), [said]);
    }

    // The wait for the index has ended.
    let mut rail = Rail::new((10.0, 99.0), 0.0, "home-latch-vel=1 home-use-index=1");
    rail.rig.say("motion.home joint=0");
    while !rail.rig.is("joint.0.index-enable") {
        rail.cycle();
    }
    rail.rig.say("motion.abort");
    (0..100).for_each(|_| rail.cycle());
    assert_eq!(rail.rig.end(), Ok(()));
    assert!(!rail.rig.is("joint.0.index-enable") && !rail.rig.is("joint.0.homed"));
    assert_eq!(rail.speed, 0.0);
}

#[test]
fn what_cannot_be_homed() {
    let mut rig = Rig::on(&[]);
    for (config, why, said) in [
        (
            "home-search-vel=-5",
            "cannot home: home-search-vel needs a home-latch-vel that is not 0",
            "cannot home joint 1: home-search-vel needs a home-latch-vel that is not 0",
        ),
        (
            "home-search-vel=0 home-latch-vel=1",
            "cannot home: home-latch-vel needs a home-search-vel that is not 0, or home-use-index",
            "cannot home joint 1: home-latch-vel needs a home-search-vel that is not 0, or \
             home-use-index",
        ),
        (
            "home-search-vel=5 home-is-shared=1",
            "Cannot home while shared home switch is closed",
            "Cannot home while shared home switch is closed j=1",
        ),
    ] {
        rig.say(&format!("motion.configure joint=1 {config}"));
        rig.bench.set("joint.1.home-sw-in", true);
        assert_eq!(rig.failed("motion.home joint=all"), why);
        assert_eq!(rig.bench.said(), [said]);
        assert!(!rig.is("joint.0.homing"), "none has begun");
    }
    for (text, why) in [
        ("home-sequence=1001", "home-sequence is 1001, must be -1000 to 1000"),
        ("home-absolute-encoder=3", "home-absolute-encoder is 3, must be 0, 1 or 2"),
        ("home-absolute-encoder=-1", "home-absolute-encoder is -1, must be 0, 1 or 2"),
    ] {
        assert_eq!(rig.try_say(&format!("motion.configure joint=1 {text}")), Err(why.into()));
    }
    let alone = "home-use-index= does not belong to axis=";
    assert_eq!(rig.try_say("motion.configure axis=x home-use-index=1"), Err(alone.into()));
}

/// Returns the sets of joints that are homing, one entry for each change.
fn turns(rig: &mut Rig, text: &str) -> Vec<Vec<usize>> {
    rig.say(text);
    let mut out: Vec<Vec<usize>> = Vec::new();
    rig.cycle();
    while !rig.is("motion.in-position") {
        let now: Vec<usize> = (0..3).filter(|n| rig.is(&format!("joint.{n}.homing"))).collect();
        if out.last() != Some(&now) {
            out.push(now);
        }
        rig.cycle();
    }
    assert_eq!(rig.end(), Ok(()));
    out
}

#[test]
fn one_after_the_other() {
    let mut rig = Rig::on(&[]);
    rig.say("motion.configure joint=0 home-sequence=1");
    rig.say("motion.configure joint=1 home-sequence=2");
    assert_eq!(turns(&mut rig, "motion.home joint=all"), [[2], [0], [1]]);
    assert!(rig.is("motion.is-all-homed"));
    rig.say("motion.configure joint=2 home-sequence=2");
    assert_eq!(turns(&mut rig, "motion.home joint=all"), [vec![0], vec![1, 2]]);
    // A single joint.
    assert_eq!(turns(&mut rig, "motion.home joint=1"), [[1]]);
}

/// Negative sequence: homed together, whichever joint is requested, and both begin the final move at once.
#[test]
fn together() {
    let mut rig = Rig::on(&[]);
    for n in [1, 2] {
        rig.say(&format!(
            "motion.configure joint={n} home-sequence=-1 home=1 home-search-vel=5 home-latch-vel=-1 \
             home-final-vel=5"
        ));
    }
    rig.say("motion.home joint=2");
    let mut left = Vec::new();
    for cycle in 0..4000 {
        for (n, place) in [(1, 2.0), (2, 9.0)] {
            let closed = rig.joint(n, "motor-pos-cmd") > place;
            rig.bench.set(&format!("joint.{n}.home-sw-in"), closed);
        }
        let rest = rig.bench.get::<i32>("joint.1.home-state");
        let late = rig.bench.get::<i32>("joint.2.home-state");
        rig.cycle();
        for (n, before) in [(1, rest), (2, late)] {
            if before == 20 && rig.bench.get::<i32>(&format!("joint.{n}.home-state")) == 21 {
                left.push((n, cycle));
            }
        }
        assert!(!rig.is("joint.0.homing"));
    }
    assert_eq!(rig.end(), Ok(()));
    let [(1, a), (2, b)] = left[..] else { panic!("{left:?}") };
    assert_eq!(a, b);
    assert_eq!(rig.which(&["joint.0.homed", "joint.1.homed", "joint.2.homed"]).len(), 2);
    // An abort of one aborts both.
    rig.say("motion.home joint=1");
    rig.cycles(5);
    rig.bench.set("joint.1.pos-lim-sw-in", true);
    let why = rig.end();
    assert_eq!(why, Err("hit limit while homing"));
    assert!(!rig.is("joint.1.homing") && !rig.is("joint.2.homing"));
    assert!(!rig.is("joint.1.homed") && !rig.is("joint.2.homed"));
}

#[test]
fn a_volatile_home_is_forgotten() {
    let mut rig = Rig::on(&[]);
    rig.say("motion.configure joint=1 volatile-home=1");
    rig.done("motion.home joint=all");
    rig.done("motion.disable");
    rig.cycles(1);
    assert_eq!(rig.which(&["joint.0.homed", "joint.1.homed"]), ["joint.0.homed"]);
}

/// A joint that is homed later finds its shared switch closed by another one.
#[test]
fn a_shared_switch_that_another_joint_holds() {
    let mut rig = Rig::on(&[]);
    for n in [0, 1] {
        rig.say(&format!(
            "motion.configure joint={n} home-sequence={n} home-search-vel=5 home-latch-vel=-1 \
             home-is-shared=1"
        ));
    }
    rig.say("motion.configure joint=2 home-sequence=2");
    rig.say("motion.home joint=all");
    let close = |rig: &Rig, on: bool| {
        [0, 1].iter().for_each(|n| rig.bench.set(&format!("joint.{n}.home-sw-in"), on));
    };
    let mut closed = false;
    while !rig.is("joint.0.homed") {
        let place = rig.joint(0, "motor-pos-cmd");
        close(&rig, place > 2.0);
        closed |= place > 2.0;
        rig.cycle();
    }
    assert!(closed);
    // Joint 0 is pushed back onto the switch.
    close(&rig, true);
    assert_eq!(rig.end(), Err("Cannot home while shared home switch is closed"));
    assert_eq!(rig.bench.said(), ["Cannot home while shared home switch is closed j=1"]);
    assert_eq!(rig.which(&["joint.0.homed", "joint.1.homed", "joint.2.homed"]), ["joint.0.homed"]);
    assert!(rig.is("motion.motion-enabled") && !rig.is("joint.2.homing"));
}

/// Both sides of a gantry are squared by their own switches: neither jogs before, and neither is homed alone.
#[test]
fn the_sides_of_a_gantry_do_not_jog_before_they_are_square() {
    let mut bench = Bench::new();
    bench.load::<Trivkins>(&["coordinates=xyy", "kinstype=b"]).unwrap();
    let mut rig = Rig::with(bench);
    // The frame is askew by 0.3: the switches are at 2 and 2.3 of the motors.
    for n in [1, 2] {
        rig.say(&format!(
            "motion.configure joint={n} home-sequence=-1 home=1 home-offset=3 home-search-vel=5 \
             home-latch-vel=-0.5 max-velocity=10 max-acceleration=35"
        ));
    }
    rig.done("motion.enable");
    let why = "cannot jog a joint that is homed together with others before it is homed";
    assert_eq!(rig.failed("motion.jog joint=2 velocity=1"), why);
    let said = "cannot jog joint 2 before it is homed: its home-sequence is below 0";
    assert_eq!(rig.bench.said(), [said]);
    rig.bench.set("joint.1.jog-enable", true);
    rig.bench.set("joint.1.jog-scale", 1.0);
    rig.cycle();
    rig.bench.set("joint.1.jog-counts", 3);
    rig.cycles(100);
    assert_eq!(rig.joint(1, "pos-cmd"), 0.0);
    rig.say("motion.home joint=1");
    let mut last: Option<f64> = None;
    let mut far = 0.0_f64;
    for _ in 0..20_000 {
        let motors = [1, 2].map(|n| rig.joint(n, "motor-pos-cmd"));
        rig.bench.set("joint.1.home-sw-in", motors[0] > 2.0);
        rig.bench.set("joint.2.home-sw-in", motors[1] > 2.3);
        let states: [i32; 2] = [1, 2].map(|n| rig.bench.get(&format!("joint.{n}.home-state")));
        // From the beginning of the final move, the motors stay 0.3 apart.
        if states == [21, 21] {
            let apart = motors[1] - motors[0];
            far = far.max((apart - last.unwrap_or(apart)).abs());
            last = Some(apart);
        }
        rig.cycle();
    }
    assert_eq!(rig.end(), Ok(()));
    assert!(far < 1e-3, "{far}");
    let apart = last.unwrap();
    assert!((apart - 0.3).abs() < 2.0 * 0.5 * DT, "{apart}");
    near(rig.joint(1, "pos-cmd"), 1.0);
    near(rig.joint(2, "pos-cmd"), 1.0);
    // Now the frame is square and moves as one.
    rig.done("motion.home joint=0");
    rig.done("motion.move y=5 velocity=5");
    near(rig.joint(1, "pos-cmd"), rig.joint(2, "pos-cmd"));
    rig.done("motion.jog joint=2 velocity=1 position=5");
}

/// Returns a machine whose joint 1 is an indexer with a lock.
fn indexer() -> Rig {
    let mut bench = Bench::new();
    bench.load::<Trivkins>(&[]).unwrap();
    let mut rig = Rig::load::<Motmod>(bench, &["unlock_joints_mask=2"]);
    rig.say("motion.configure joint=1 locking-indexer=1 home=5 home-final-vel=20");
    rig.done("motion.enable");
    rig
}

#[test]
fn a_locked_indexer_opens_for_homing_alone() {
    let mut rig = indexer();
    rig.say("motion.home joint=1");
    let mut states: Vec<i32> = Vec::new();
    let mut late = 0;
    while rig.bench.ticket().unwrap() == TicketState::Pending {
        let before = rig.joint(1, "motor-pos-cmd");
        // The lock needs 50 cycles.
        let unlock = rig.is("joint.1.unlock");
        late = if unlock == rig.is("joint.1.is-unlocked") { 0 } else { late + 1 };
        if late == 50 {
            rig.bench.set("joint.1.is-unlocked", unlock);
        }
        let open = rig.is("joint.1.is-unlocked") && unlock;
        rig.cycle();
        assert!(open || rig.joint(1, "motor-pos-cmd") == before, "moves while locked");
        let state = rig.bench.get("joint.1.home-state");
        if states.last() != Some(&state) {
            states.push(state);
        }
    }
    assert_eq!(rig.end(), Ok(()));
    assert_eq!(states, [2, 3, 15, 20, 21, 22, 23, 0]);
    near(rig.joint(1, "pos-cmd"), 5.0);
    assert!(!rig.is("joint.1.unlock") && !rig.is("joint.1.is-unlocked"));
    // It does not jog, by itself or with its axis.
    assert_eq!(rig.failed("motion.jog joint=1 velocity=1"), "cannot jog a locking indexer");
    let why = "cannot jog: a joint of this axis is locked";
    assert_eq!(rig.failed("motion.jog axis=y velocity=1"), why);
    let said = ["cannot jog joint 1: it is a locking indexer", "cannot jog: joint 1 is locked"];
    assert_eq!(rig.bench.said(), said);
    // Nor does it move with the others.
    assert_eq!(rig.failed("motion.move x=9 y=9 velocity=20"), "a joint that would move is locked");
    assert_eq!(rig.bench.said(), ["joint 1 would move, and is locked"]);
    near(rig.joint(1, "pos-cmd"), 5.0);
    assert!(rig.joint(0, "pos-cmd") < 1e-3 && rig.is("motion.motion-enabled"));
    rig.done("motion.move x=9 velocity=20");
    rig.done("motion.jog axis=x velocity=1 distance=1");
}

#[test]
fn a_lock_that_does_not_answer() {
    let mut rig = indexer();
    assert_eq!(rig.failed("motion.home joint=1"), "the lock did not open in 30 s");
    assert_eq!(rig.bench.said(), ["j1 lock did not open in 30 s, in home state 3"]);
    rig.cycle();
    assert!(!rig.is("joint.1.unlock"));
    rig.bench.set("joint.1.is-unlocked", true);
    assert_eq!(rig.failed("motion.home joint=1"), "the lock did not close in 30 s");
    assert_eq!(rig.bench.said(), ["j1 lock did not close in 30 s, in home state 23"]);
    assert!(!rig.is("joint.1.homed"));
    // An abort in motion: the lock stays open until the joint is at rest.
    rig.say("motion.configure joint=1 home=60");
    rig.say("motion.home joint=1");
    while rig.joint(1, "vel-cmd") < 15.0 {
        rig.cycle();
    }
    rig.say("motion.abort");
    while rig.joint(1, "vel-cmd") > 0.0 {
        assert!(rig.is("joint.1.unlock"));
        rig.cycle();
    }
    rig.cycles(2);
    assert!(!rig.is("joint.1.unlock"));
    // No such pins.
    let mut rig = Rig::on(&[]);
    rig.say("motion.configure joint=0 locking-indexer=1");
    let why = "cannot home: locking-indexer needs the joint in unlock_joints_mask";
    assert_eq!(rig.failed("motion.home joint=0"), why);
}

/// A limit switch of one side stops both in the same cycle, whatever moves them.
#[test]
fn the_sides_of_a_gantry_stop_together() {
    for text in [
        "motion.move y=60 velocity=8",
        "motion.jog axis=y velocity=8 position=60",
        "motion.home joint=1",
    ] {
        let mut rig = Rig::off(&["coordinates=xyy", "kinstype=b"]);
        for n in [1, 2] {
            rig.say(&format!("motion.configure joint={n} home-sequence=-1 max-velocity=10"));
            rig.say(&format!("motion.configure joint={n} max-acceleration=35"));
        }
        rig.done("motion.enable");
        rig.done("motion.home joint=all");
        for n in [1, 2] {
            rig.say(&format!("motion.configure joint={n} home-search-vel=8 home-latch-vel=-1"));
        }
        rig.say(text);
        while rig.joint(1, "pos-cmd") < 5.0 {
            rig.cycle();
        }
        assert!(rig.joint(1, "vel-cmd") > 7.9, "{text}");
        let apart = |rig: &Rig| rig.joint(1, "motor-pos-cmd") - rig.joint(2, "motor-pos-cmd");
        near(apart(&rig), 0.0);
        rig.bench.set("joint.2.pos-lim-sw-in", true);
        rig.strict = false;
        for _ in 0..100 {
            rig.cycle();
            near(apart(&rig), 0.0);
        }
        assert!(!rig.is("motion.motion-enabled"), "{text}");
        assert!(rig.joint(1, "motor-pos-cmd") < 5.1, "{text}");
        assert!(rig.is("joint.2.error") && !rig.is("joint.1.error"), "{text}");
    }
}
