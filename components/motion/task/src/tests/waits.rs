//! Waits of the job, as the snapshot reports them.

use super::*;
use hal_component::Wait;

/// A program, the step that leads to the wait, and the line of `task.status`.
type Case = (&'static str, fn(&mut Rig), &'static str);

const CASES: [Case; 16] = [
    (
        "M0",
        |_| {},
        "for=m0 number=0 until=never a person at M0: task.resume goes on, task.abort ends it",
    ),
    (
        "M1",
        |_| {},
        "for=m1 number=0 until=never a person at M1: task.resume goes on, task.abort ends it",
    ),
    (
        "M60",
        |_| {},
        "for=m60 number=0 until=never a person who changes the pallet at M60: task.resume goes on, task.abort ends it",
    ),
    (
        "G1 X1",
        |rig| rig.good(Command::Pause),
        "for=pause number=0 until=never a resume: task.resume goes on, task.abort ends it",
    ),
    (
        "T2 M6",
        |_| {},
        "for=tool number=2 until=never tool 2: it goes on when iocontrol.0.tool-changed says that it is in the spindle, \
         task.abort ends it",
    ),
    ("G4 P9", |_| {}, "for=dwell number=0 until=9.010 time at G4: it goes on by itself"),
    (
        "M66 P3 L3 Q2",
        |_| {},
        "for=input number=3 until=2.010 input 3 at M66: it goes on when motion.digital-in-03 is TRUE, or its time is over",
    ),
    ("M66 E1 L0", |_| {}, ""),
    (
        "M101",
        |_| {},
        "for=program number=101 until=itself M101 of the user: it goes on when that program has ended",
    ),
    (
        "G1 X1",
        |rig| of_motion(rig, Wait::AtSpeed),
        "for=at-speed number=0 until=never the speed of spindle 0: it goes on when spindle.0.at-speed is TRUE; the job ends \
         after 5 s",
    ),
    (
        "G1 X1",
        |rig| {
            of_motion(rig, Wait::AtSpeed);
            rig.fake.motion.wait_ends = true;
        },
        "for=at-speed number=0 until=itself the speed of spindle 0: it goes on when spindle.0.at-speed is TRUE; the job ends \
         after 5 s",
    ),
    (
        "G33 Z-5 K1",
        |rig| of_motion(rig, Wait::Index),
        "for=index number=0 until=never the index of spindle 0: it goes on when the encoder sets spindle.0.index-enable FALSE",
    ),
    (
        "G1 X1",
        |rig| of_motion(rig, Wait::FeedHold),
        "for=feed-hold number=0 until=never the end of a feed hold: motion.feed-hold is TRUE",
    ),
    (
        "G1 X1",
        |rig| {
            rig.fake.hal.insert("remote.hold".to_owned(), 1.0);
            of_motion(rig, Wait::FeedInhibit);
        },
        "for=page number=0 until=never a page that is lost: it goes on when the page resumes it, or by remote.release",
    ),
    (
        "G1 X1",
        |rig| {
            rig.good(Command::Pause);
            (rig.fake.motion.spindles_stopped, rig.fake.motion.spindles_inhibited) = (2, 2);
        },
        "for=spindle-stopped number=1 until=never a resume: spindle 1 was stopped after it was turned for the path; task.resume \
         turns it again and goes on, task.abort ends it; spindle.1.inhibit must be FALSE first",
    ),
    (
        "M0",
        |rig| rig.fake.motion.spindles_stopped = 1,
        "for=m0 number=0 until=never a person at M0: task.resume goes on, task.abort ends it; spindle 0, which was stopped, \
         turns again then",
    ),
];

fn of_motion(rig: &mut Rig, wait: Wait) {
    (rig.fake.motion.wait, rig.fake.motion.wait_since) = (wait as u32, 0.5);
}

#[test]
fn each_wait_has_its_record() {
    for (program, then, wanted) in CASES {
        let mut rig = Rig::new(&format!("G21 G90 F1\n{program}\nM2\n"));
        let path = rig.folder.join("M101");
        std::fs::write(&path, "#!/bin/sh\n").unwrap();
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        rig.fake.move_time = 100.0;
        rig.send(Command::Run);
        rig.pass(0.02);
        then(&mut rig);
        rig.pass(0.05);
        let line = rig.core.wait_record().line().unwrap_or_default();
        let line = line.strip_prefix("wait ").unwrap_or_default();
        // Since when is checked below.
        let words: Vec<&str> = line.split(' ').filter(|word| !word.starts_with("since=")).collect();
        assert_eq!(words.join(" "), wanted, "{program}");
        let since = rig.core.wait_record().since;
        rig.pass(0.2);
        assert_eq!(rig.core.wait_record().since, since, "{program}: since when changes");
        rig.good(Command::Abort);
        rig.fake.motion = MotionState { wait: 0, spindles_stopped: 0, ..rig.fake.motion };
        rig.pass(0.1);
        assert_eq!(rig.core.wait_record().kind, Wait::Nothing, "{program}: it outlives the job");
    }
}
