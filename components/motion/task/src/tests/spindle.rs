//! Spindles, feed per turn and overrides.

use super::*;

#[test]
fn a_surface_speed_follows_the_radius() {
    let mut rig = Rig::new("G21 G96 S100 D2000\nM3\nG0 X50\nG0 X0.1\nM5\nM2\n");
    let sent = rig.run();
    let speeds: Vec<&String> = sent.iter().filter(|s| s.starts_with("Spindle {")).collect();
    assert_eq!(speeds[0], "Spindle { spindle: 0, speed: 2000.0 }", "on the axis, the top speed");
    // 100 m/min at 50 mm.
    assert!(speeds[1].starts_with("Spindle { spindle: 0, speed: 318.3"), "{speeds:?}");
    assert_eq!(speeds[2], "Spindle { spindle: 0, speed: 2000.0 }");
    let mut rig = Rig::new("G21 G96 S100\nM3\nM2\n");
    let ticket = rig.send(Command::Run);
    rig.pass(0.1);
    let why = rig.result(ticket).unwrap().unwrap_err();
    assert!(why.ends_with("job.ngc:2: G96 needs D, its top speed: the INI file has none"), "{why}");
}

#[test]
fn overrides_count_unless_the_program_forbids_them() {
    let mut rig = Rig::new("M49\nG4 P1\nM48\nM2\n");
    rig.good(Command::FeedOverride(0.5));
    assert_eq!(rig.sent(), ["FeedScale { feed: Some(0.5), rapid: None }"]);
    rig.good(Command::RapidOverride(0.75));
    assert_eq!(rig.sent(), ["FeedScale { feed: None, rapid: Some(0.75) }"]);
    rig.send(Command::Run);
    rig.pass(0.5);
    let off = [
        "FeedScale { feed: Some(1.0), rapid: Some(1.0) }",
        "SpindleScale { spindle: 0, scale: 1.0 }",
    ];
    assert_eq!(rig.sent(), off);
    rig.good(Command::FeedOverride(0.25));
    assert_eq!(rig.sent(), ["FeedScale { feed: Some(1.0), rapid: None }"]);
    rig.good(Command::RapidOverride(0.125));
    assert_eq!(rig.sent(), ["FeedScale { feed: None, rapid: Some(1.0) }"]);
    rig.pass(1.0);
    assert_eq!(rig.sent()[0], "FeedScale { feed: Some(0.25), rapid: Some(0.125) }");
    assert_eq!(
        rig.refused(Command::SpindleOverride { spindle: 3, scale: 1.0 }),
        "there is no spindle 3"
    );
}

#[test]
fn a_knob_of_the_operator_is_the_tasks_override() {
    let mut rig = Rig::new("M49\nG4 P1\nM48\nG4 P1\nM49\nG4 P1\nM2\n");
    rig.pass(0.1);
    assert_eq!(rig.sent(), [""; 0]);
    // The knob acts on motion alone.
    (rig.fake.motion.feed_override, rig.fake.motion.spindle_override[0]) = (0.5, 0.75);
    rig.pass(0.1);
    assert_eq!((rig.core.feed.scale, rig.core.spindle_scale[0]), (0.5, 0.75));
    assert_eq!(rig.sent(), [""; 0]);
    rig.send(Command::Run);
    rig.pass(0.5);
    assert_eq!((rig.fake.motion.feed_override, rig.fake.motion.spindle_override[0]), (1.0, 1.0));
    // While the program forbids it, it counts for later.
    (rig.fake.motion.feed_override, rig.fake.motion.spindle_override[0]) = (0.25, 0.125);
    rig.pass(0.1);
    assert_eq!((rig.fake.motion.feed_override, rig.fake.motion.spindle_override[0]), (1.0, 1.0));
    rig.pass(0.6);
    assert_eq!((rig.fake.motion.feed_override, rig.fake.motion.spindle_override[0]), (0.25, 0.125));
    // An override of the task that motion does not show yet stays.
    rig.fake.motion.cycle = 1000;
    rig.good(Command::FeedOverride(0.8));
    rig.fake.motion.feed_override = 0.25;
    rig.step();
    rig.step();
    rig.fake.motion.cycle = 1001;
    rig.step();
    assert_eq!(rig.core.feed.scale, 0.8);
    rig.fake.motion.feed_override = 0.8;
    rig.pass(0.1);
    assert_eq!(rig.core.feed.scale, 0.8);
}

#[test]
fn a_knob_of_rapid_moves_is_the_tasks_override() {
    let mut rig = Rig::new("M50 P0\nG4 P1\nM50 P1\nG4 P1\nM2\n");
    rig.fake.motion.rapid_override = 0.5;
    rig.pass(0.1);
    assert_eq!((rig.core.feed.rapid, rig.core.feed.scale), (0.5, 1.0));
    assert_eq!(rig.sent(), [""; 0]);
    rig.send(Command::Run);
    rig.pass(0.5);
    assert_eq!((rig.fake.motion.rapid_override, rig.core.feed.rapid), (1.0, 0.5));
    // While the program forbids it, it counts for later.
    rig.fake.motion.rapid_override = 0.25;
    rig.pass(0.1);
    assert_eq!((rig.fake.motion.rapid_override, rig.core.feed.rapid), (1.0, 0.25));
    rig.pass(0.6);
    assert_eq!((rig.fake.motion.rapid_override, rig.fake.motion.feed_override), (0.25, 1.0));
}

#[test]
fn each_spindle_has_its_own_top_speed() {
    let job = |program| {
        Rig::on_machine(program, |machine, rules| {
            machine.settings.spindles = 2;
            rules.has_top_speed[1] = true;
        })
    };
    let mut rig = job("G21 G96 S100 $1\nM3 $1\nM2\n");
    let speeds = rig.run();
    assert!(speeds[0].starts_with("Spindle { spindle: 1, speed: "), "{speeds:?}");
    let mut rig = job("G21 G96 S100 $0\nM3 $0\nM2\n");
    let ticket = rig.send(Command::Run);
    rig.pass(0.1);
    let why = rig.result(ticket).unwrap().unwrap_err();
    assert!(why.contains("G96 needs D"), "{why}");
}

fn pitch(rig: &Rig) -> Option<(u8, f64)> {
    let (_, m, _) = rig.fake.moves.back().unwrap();
    m.pitch.map(|p| (p.spindle, p.travel))
}

#[test]
fn feed_per_turn_lasts_from_job_to_job() {
    let mut rig = Rig::on_machine("G1 X3 F0.2\nM2\n", |machine, _| machine.settings.spindles = 2);
    rig.good(Command::Mode(Mode::Mdi));
    rig.send(Command::Mdi("G21 M3 $1 S100".into()));
    rig.pass(0.1);
    rig.send(Command::Mdi("G95 $1 F0.1".into()));
    rig.pass(0.1);
    rig.send(Command::Mdi("G1 X1".into()));
    rig.step();
    assert_eq!(pitch(&rig), Some((1, 0.1)));
    rig.pass(0.5);
    rig.good(Command::Mode(Mode::Auto));
    rig.send(Command::Run);
    rig.step();
    assert_eq!(pitch(&rig), Some((1, 0.2)));
    // The end of a program returns to G94.
    rig.pass(0.5);
    rig.good(Command::Mode(Mode::Mdi));
    rig.send(Command::Mdi("G1 X1 F100".into()));
    rig.step();
    assert_eq!(pitch(&rig), None);
}

#[test]
fn an_abort_returns_to_the_spindles_of_the_line_in_motion() {
    let program = "G21 G95 $0 F0.5\nG96 S100 D1000 $0\nG1 X1\nG4 P1\nS100 $1\nG95 $1 F0.5\nG96 S100 D2000 $0\n\
                   G1 X2\nM2\n";
    let mut rig = Rig::on_machine(program, |machine, _| machine.settings.spindles = 2);
    let ticket = rig.send(Command::Run);
    assert_eq!(rig.result(ticket), None);
    rig.pass(0.05);
    assert_eq!(pitch(&rig), Some((0, 0.5)));
    rig.good(Command::Abort);
    rig.pass(0.1);
    rig.sent();
    rig.good(Command::Mode(Mode::Mdi));
    rig.send(Command::Mdi("G1 X5".into()));
    rig.step();
    assert_eq!(pitch(&rig), Some((0, 0.5)));
    rig.pass(0.5);
    rig.fake.motion.pose = [0.0; 9];
    rig.sent();
    rig.send(Command::Mdi("M3 $0".into()));
    rig.pass(0.5);
    assert_eq!(rig.sent(), ["Spindle { spindle: 0, speed: 1000.0 }"], "the top speed");
}
