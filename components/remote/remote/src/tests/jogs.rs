//! Jogs under the lease.

use super::rig::{ACCELERATION, PERIOD, Rig, VELOCITY};

/// Milliseconds up to which a beat permits a held jog.
const PERMIT_MS: usize = 95;

#[test]
fn a_held_jog_ends_when_beats_end() {
    let dt = PERIOD as f64 * 1e-9;
    let mut worst = 0.0_f64;
    // Round trips of the connection, and cycles from the begin of the jog to the cut.
    for delay in [0, 1, 7, 20, 40, 55, 70] {
        for cut in [200, 203, 211, 217, 230] {
            let mut rig = Rig::leased(&[]);
            rig.delay = delay;
            rig.cycles(200);
            rig.command("remote.jog", "lease=1 joint=0 velocity=20").unwrap();
            rig.cycles(cut);
            assert_eq!(rig.bench.get::<f64>("joint.0.vel-cmd"), VELOCITY);
            rig.answers = false;
            let (at, cycle) = (rig.at(0), rig.cycle);
            rig.rest();
            let gone = rig.at(0) - at;
            // The last pulse before the cut permits the jog for 95 ms, whatever the delay of its answer.
            let last = cycle - cycle % rig.every;
            let stops = last + PERMIT_MS + 1;
            let expected =
                VELOCITY * (stops - cycle) as f64 * dt + VELOCITY * VELOCITY / (2.0 * ACCELERATION);
            assert!(
                (gone - expected).abs() <= 2.0 * VELOCITY * dt,
                "delay {delay}, cut {cut}: {gone} mm, not {expected}"
            );
            worst = worst.max(gone);
            // Answers come again, and nothing moves.
            rig.answers = true;
            let at = rig.at(0);
            rig.cycles(2000);
            assert_eq!(rig.at(0), at);
        }
    }
    assert!(worst <= VELOCITY * 0.1 + VELOCITY * VELOCITY / (2.0 * ACCELERATION), "{worst}");
}

#[test]
fn the_keeper_says_which_pins_it_touches() {
    let rig = Rig::new(&[]);
    let touched = rig.bench.touches("remote-keeper");
    for pin in ["job r", "abort w", "tool-change r", "tool-changed w"] {
        assert!(touched.contains(&format!("remote.{pin}")), "{pin}: {touched:?}");
    }
}

#[test]
fn a_slow_connection_permits_steps_alone() {
    let mut rig = Rig::leased(&[]);
    rig.delay = 150;
    rig.cycles(500);
    let why = rig.command("remote.jog", "lease=1 joint=0 velocity=20").unwrap_err();
    assert!(why.contains("no beat younger than 95 ms"), "{why}");
    rig.command("remote.jog", "lease=1 joint=0 velocity=20 distance=-3").unwrap();
    rig.rest();
    assert!((rig.at(0) + 3.0).abs() < 1e-6, "{}", rig.at(0));
}

#[test]
fn beats_that_are_repeated_or_invented_permit_nothing() {
    for beat in [0_u32, 1, 50, 4_000_000_000, u32::MAX] {
        let mut rig = Rig::leased(&[]);
        rig.command("remote.jog", "lease=1 joint=0 velocity=20").unwrap();
        rig.cycles(100);
        rig.answers = false;
        rig.cycles(90);
        let at = rig.at(0);
        for _ in 0..500 {
            rig.bench.set("remote.beat", beat);
            rig.cycles(1);
        }
        let most = VELOCITY * 0.1 + VELOCITY * VELOCITY / (2.0 * ACCELERATION);
        assert!(rig.at(0) - at <= most, "{beat}: {}", rig.at(0) - at);
        assert!(!rig.is("permit"));
    }
}

#[test]
fn steps_end_with_the_lease() {
    for end in ["beats", "give", "allow-motion", "handed over"] {
        let mut rig = Rig::leased(&[]);
        rig.command("remote.jog", "lease=1 joint=0 velocity=20 distance=1000").unwrap();
        rig.cycles(100);
        let at = rig.at(0);
        let lasts = match end {
            "beats" => {
                rig.answers = false;
                1.05
            }
            "give" => {
                rig.command("remote.give", "lease=1").unwrap();
                0.005
            }
            "allow-motion" => {
                rig.bench.set("remote.allow-motion", false);
                0.005
            }
            _ => {
                let taken = rig.command("remote.take", "holder=eva from=1");
                assert_eq!(taken, Ok(vec!["lease=2".to_owned()]));
                0.005
            }
        };
        rig.rest();
        let most = VELOCITY * lasts + VELOCITY * VELOCITY / (2.0 * ACCELERATION);
        assert!(rig.at(0) - at <= most, "{end}: {}", rig.at(0) - at);
        let at = rig.at(0);
        rig.bench.set("remote.allow-motion", true);
        rig.answers = true;
        rig.cycles(1000);
        assert_eq!(rig.at(0), at, "{end}");
    }
}

#[test]
fn a_jog_that_is_on_its_way_ends_too() {
    let mut rig = Rig::leased(&[]);
    // Motion takes the command a cycle after the lease has gone.
    rig.command("remote.jog", "lease=1 joint=0 velocity=20").unwrap();
    rig.command("remote.give", "lease=1").unwrap();
    let at = rig.at(0);
    rig.rest();
    rig.cycles(200);
    assert!(rig.at(0) - at < 0.1, "{}", rig.at(0) - at);
}

#[test]
fn refusals() {
    let mut rig = Rig::new(&[]);
    let no_lease = "this is not the number of the control lease: it has ended, or another has it";
    let jog = "lease=1 joint=0 velocity=20 distance=1";
    assert_eq!(rig.command("remote.jog", jog), Err(no_lease.to_owned()));
    assert_eq!(rig.command("remote.give", "lease=0"), Err(no_lease.to_owned()));
    rig.command("remote.take", "holder=ana").unwrap();
    rig.cycles(100);
    for (command, args, why) in [
        ("remote.take", "holder=eva", "ana has the control lease"),
        ("remote.take", "holder=eva from=7", "ana has the control lease"),
        ("remote.jog", "lease=2 joint=0 velocity=20", no_lease),
        ("remote.jog", "lease=-1 joint=0 velocity=20", no_lease),
        ("remote.jog", "lease=1 joint=-1 velocity=20", "there is no joint -1"),
        ("remote.jog", "lease=1 axis=q velocity=20", "axis is q, must be one of xyzabcuvw"),
        (
            "remote.jog",
            "lease=1 velocity=20",
            "a jog is of a joint or of an axis: joint=N or axis=LETTER",
        ),
        (
            "remote.jog",
            "lease=1 joint=0 velocity=20 distance=1 position=2",
            "a jog goes by a distance or to a position, not both",
        ),
        ("remote.start", "lease=2", no_lease),
    ] {
        assert_eq!(rig.command(command, args), Err(why.to_owned()), "{command} {args}");
    }
    rig.bench.set("remote.allow-motion", false);
    rig.cycles(1);
    let why = "remote.allow-motion is FALSE: the machine permits no remote motion";
    assert_eq!(rig.command("remote.jog", jog), Err(why.to_owned()));
    rig.bench.set("remote.allow-motion", true);
    rig.answers = false;
    rig.cycles(1200);
    assert!(!rig.is("present"));
    assert_eq!(rig.command("remote.jog", jog), Err(no_lease.to_owned()));
}

#[test]
fn a_local_command_ends_a_remote_jog() {
    let mut rig = Rig::leased(&[]);
    rig.command("remote.jog", "lease=1 joint=0 velocity=20").unwrap();
    rig.cycles(200);
    rig.command("motion.jog", "joint=1 velocity=5").unwrap();
    rig.rest();
    assert_eq!(rig.at(1), 0.0, "the first local command only ends what is remote");
    rig.command("motion.jog", "joint=1 velocity=5").unwrap();
    rig.cycles(50);
    // The end of the lease stops remote jogs, and no local one.
    rig.command("remote.give", "lease=1").unwrap();
    rig.cycles(1000);
    assert_eq!(rig.bench.get::<f64>("joint.1.vel-cmd"), 5.0);
}

#[test]
fn a_jog_beside_a_paused_program_ends_when_beats_end() {
    let mut rig = Rig::homed(&[]);
    rig.program();
    rig.command("motion.pause", "").unwrap();
    rig.cycles(500);
    // As the task does while a program rests.
    assert!(rig.motion.claim(rig.token, false));
    rig.command("motion.mode", "mode=teleop").unwrap();
    rig.cycles(10);
    rig.command("remote.jog", "lease=1 axis=y velocity=20").unwrap();
    rig.cycles(300);
    assert!(rig.at(1) > 1.0, "{}", rig.at(1));
    rig.answers = false;
    rig.cycles(300);
    let at = rig.at(1);
    rig.cycles(300);
    assert_eq!(rig.at(1), at, "the dead man ends the jog");
}

#[test]
fn an_answer_to_a_pulse_of_the_lease_before_is_no_beat() {
    let mut rig = Rig::leased(&[]);
    rig.delay = 60;
    rig.cycles(200);
    rig.answers = false;
    rig.command("remote.take", "holder=eva from=1").unwrap();
    for _ in 0..200 {
        rig.cycles(1);
        assert!(!rig.is("heartbeat") && !rig.is("permit"));
    }
}

#[test]
fn a_pulse_of_the_lease_before_keeps_no_other() {
    let mut rig = Rig::leased(&[]);
    rig.lose();
    // It has the number of the new lease's first millisecond.
    let pulse: u32 = rig.bench.get("remote.pulse");
    rig.command("remote.take", "holder=eva from=1").unwrap();
    rig.bench.run("remote", PERIOD);
    rig.bench.set("remote.beat", pulse);
    rig.bench.run("remote", PERIOD);
    assert!(!rig.is("heartbeat"));
    rig.cycles(1);
    rig.bench.set("remote.beat", rig.bench.get::<u32>("remote.pulse"));
    rig.cycles(1);
    assert!(rig.is("heartbeat"), "its own");
    // It comes true after that lease.
    let future = rig.bench.get::<u32>("remote.pulse") + 50;
    rig.command("remote.beat", &format!("lease=2 pulse={future}")).unwrap();
    rig.command("remote.give", "lease=2").unwrap();
    rig.command("remote.take", "holder=ana").unwrap();
    for _ in 0..200 {
        rig.cycles(1);
        assert!(!rig.is("heartbeat"));
    }
}

#[test]
fn a_program_without_the_pin_sends_pulses_back_by_a_command() {
    let mut rig = Rig::leased(&[]);
    rig.lose();
    let beat = |rig: &mut Rig, pulse: &str| {
        let lines = rig.command("remote.beat", &format!("lease=1{pulse}")).unwrap();
        let number = lines[0].split_once("pulse=").unwrap().1.split(' ').next().unwrap();
        format!(" pulse={number}")
    };
    let mut pulse = beat(&mut rig, "");
    for n in 0..100 {
        rig.cycles(20);
        pulse = beat(&mut rig, &pulse);
        if n == 10 {
            rig.command("remote.jog", "lease=1 joint=0 velocity=20").unwrap();
        }
        assert!(n < 11 || rig.bench.get::<f64>("joint.0.vel-cmd") > 0.0, "round {n}");
    }
    // A number from the future, and that of another lease, keep nothing.
    beat(&mut rig, " pulse=4000000000");
    let why = rig.command("remote.beat", "lease=2 pulse=9").unwrap_err();
    assert!(why.contains("not the number of the control lease"), "{why}");
    let at = rig.at(0);
    rig.rest();
    assert!(rig.at(0) - at <= VELOCITY * 0.1 + VELOCITY * VELOCITY / (2.0 * ACCELERATION));
    rig.cycles(2000);
    rig.command("remote.beat", "lease=1").unwrap_err();
}
