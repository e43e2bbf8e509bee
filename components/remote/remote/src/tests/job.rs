//! Programs that were started under the lease.

use super::rig::Rig;
use hal_component::{MotionCommand, motion_kind};

impl Rig {
    /// Begins a program: a long move, for which the task claims motion.
    pub(super) fn program(&mut self) {
        self.command("motion.mode", "mode=coord").unwrap();
        self.cycles(10);
        assert!(self.motion.claim(self.token, true));
        let pose = [100.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let line = MotionCommand {
            pose,
            letters: 1,
            speed_kind: 2,
            speed: 10.0,
            ..MotionCommand::new(motion_kind::MOVE)
        };
        self.motion.push(self.token, &line).unwrap();
        self.cycles(1000);
        assert!(self.at(0) > 1.0, "the program moves");
    }

    pub(super) fn homed(args: &[&str]) -> Self {
        let mut rig = Self::leased(args);
        rig.command("motion.home", "joint=all").unwrap();
        rig.cycles(200);
        rig
    }

    fn ends_lease(&mut self, how: &str) {
        match how {
            "give" => drop(self.command("remote.give", "lease=1").unwrap()),
            "allow-motion" => self.bench.set("remote.allow-motion", false),
            _ => self.answers = false,
        }
        self.cycles(1300);
    }
}

#[test]
fn a_program_of_the_lease_holds_until_it_is_released() {
    for how in ["beats", "give", "allow-motion"] {
        let mut rig = Rig::homed(&[]);
        rig.command("remote.start", "lease=1").unwrap();
        rig.program();
        rig.ends_lease(how);
        let at = rig.at(0);
        assert!(rig.is("hold") && at < 25.0, "{how}: {at}");
        // Neither beats, nor a local resume, nor a new lease lets it go on.
        rig.answers = true;
        rig.cycles(500);
        rig.command("motion.resume", "").unwrap();
        drop(rig.command("remote.take", "holder=eva"));
        rig.cycles(2000);
        assert_eq!(rig.at(0), at, "{how}");
        rig.bench.set("remote.allow-motion", true);
        rig.cycles(500);
        assert_eq!(rig.at(0), at, "{how}");
        rig.command("remote.release", "").unwrap();
        rig.cycles(1000);
        assert!(rig.at(0) > at, "{how}");
    }
}

#[test]
fn on_loss_and_the_origin_of_a_program_decide() {
    // Arguments, whether the program is remote, and whether it moves on.
    for (args, remote, goes_on) in [
        (&["on_loss=hold"][..], true, false),
        (&["on_loss=continue"], true, true),
        (&["on_loss=abort"], true, false),
        (&["on_loss=hold"], false, true),
        (&["on_loss=abort"], false, true),
    ] {
        let mut rig = Rig::homed(args);
        if remote {
            rig.command("remote.start", "lease=1").unwrap();
        }
        rig.program();
        rig.ends_lease("beats");
        let at = rig.at(0);
        rig.cycles(500);
        assert_eq!(rig.at(0) > at, goes_on, "{args:?} {remote}");
        if args == ["on_loss=abort"] && remote {
            let status = rig.motion.status().unwrap();
            assert!(status.queue == 0 && !status.claimed && !rig.is("hold"));
        }
    }
}

#[test]
fn a_hold_ends_with_its_program() {
    let mut rig = Rig::homed(&[]);
    rig.command("remote.start", "lease=1").unwrap();
    rig.program();
    rig.ends_lease("beats");
    assert!(rig.is("hold"));
    rig.command("motion.abort", "").unwrap();
    rig.cycles(500);
    assert!(!rig.is("hold"));
    // The next program is local.
    rig.program();
}

#[test]
fn a_program_that_never_began_is_not_held() {
    let mut rig = Rig::homed(&[]);
    rig.command("remote.start", "lease=1").unwrap();
    rig.cycles(2500);
    rig.ends_lease("beats");
    assert!(!rig.is("hold"));
}

#[test]
fn nothing_starts_while_the_wiring_forbids_it() {
    let mut rig = Rig::homed(&[]);
    rig.bench.set("remote.allow-motion", false);
    rig.cycles(1);
    let why = "remote.allow-motion is FALSE: the machine permits no remote motion";
    assert_eq!(rig.command("remote.start", "lease=1"), Err(why.to_owned()));
}

#[test]
fn homing_ends_with_the_lease_and_the_permission() {
    for how in ["give", "allow-motion"] {
        // Homing that runs when the lease ends, and homing that begins later.
        for later in [false, true] {
            let mut rig = Rig::leased(&[]);
            let slow = "joint=0 home=0 home-offset=0 home-search-vel=5 home-latch-vel=1";
            rig.command("motion.configure", slow).unwrap();
            rig.command("remote.start", "lease=1").unwrap();
            if !later {
                rig.command("motion.home", "joint=0").unwrap();
                rig.cycles(100);
                assert!(rig.motion.status().unwrap().homing, "{how}");
            }
            match how {
                "give" => drop(rig.command("remote.give", "lease=1").unwrap()),
                _ => rig.bench.set("remote.allow-motion", false),
            }
            rig.cycles(20);
            if later {
                rig.command("motion.home", "joint=0").unwrap();
            }
            rig.cycles(200);
            assert!(!rig.motion.status().unwrap().homing, "{how} {later}");
        }
    }
}

#[test]
fn a_release_and_a_start_are_one_and_need_the_lease() {
    let mut rig = Rig::homed(&[]);
    rig.command("remote.start", "lease=1").unwrap();
    rig.program();
    rig.ends_lease("give");
    assert!(rig.is("hold"));
    let taken = rig.command("remote.take", "holder=eva");
    assert_eq!(taken, Ok(vec!["lease=2".to_owned()]));
    rig.command("remote.start", "lease=1 release=TRUE").unwrap_err();
    rig.cycles(100);
    assert!(rig.is("hold"), "the number of another lease releases nothing");
    let at = rig.at(0);
    rig.command("remote.start", "lease=2 release=TRUE").unwrap();
    rig.cycles(500);
    assert!(!rig.is("hold") && rig.at(0) > at);
}
