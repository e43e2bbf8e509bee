//! Programs that were started under the lease.

use super::rig::Rig;
use crate::keeper::work_of;
use hal_component::{MotionCommand, MotionStatus, motion_kind};

impl Rig {
    /// Begins a program: a long move, for which the task claims motion.
    pub(super) fn program(&mut self) {
        self.command("motion.mode", "mode=coord").unwrap();
        self.cycles(10);
        assert!(self.motion.claim(self.token, true));
        self.moves();
        self.cycles(1000);
        assert!(self.at(0) > 1.0, "the program moves");
    }

    fn moves(&self) {
        let pose = [100.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let line = MotionCommand {
            pose,
            letters: 1,
            speed_kind: 2,
            speed: 10.0,
            ..MotionCommand::new(motion_kind::MOVE)
        };
        self.motion.push(self.token, &line).unwrap();
    }

    pub(super) fn homed(args: &[&str]) -> Self {
        let mut rig = Self::leased(args);
        rig.command("motion.home", "joint=all").unwrap();
        rig.cycles(200);
        rig
    }

    /// Rests in a pause of the program in which no move is left, as M0 does: the task lets go of motion.
    fn rests(&mut self) {
        assert!(self.motion.claim(self.token, true));
        self.bench.set("remote.job", true);
        self.cycles(100);
        assert!(self.motion.claim(self.token, false));
        self.cycles(2500);
    }

    /// Returns how often the abort rises within so many cycles.
    fn aborts(&mut self, cycles: usize) -> usize {
        let mut was = self.is("abort");
        let rises = (0..cycles).filter(|_| {
            self.cycles(1);
            let before = core::mem::replace(&mut was, self.is("abort"));
            was && !before
        });
        rises.count()
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
fn a_job_does_what_its_start_said_and_the_next_one_what_the_machine_says() {
    // Effect of the machine, of the start and of what goes on, and whether the program moves on without its lease.
    for (preset, started, resumed, goes_on) in [
        ("hold", "continue", "", true),
        ("continue", "hold", "", false),
        ("continue", "abort", "", false),
        ("abort", "continue", "", true),
        ("hold", "", "continue", true),
        ("continue", "continue", "hold", false),
    ] {
        let mut rig = Rig::homed(&[&format!("on_loss={preset}")]);
        let on_loss = |word: &str| match word {
            "" => String::new(),
            word => format!(" on-loss={word}"),
        };
        let said = rig.command("remote.start", &format!("lease=1{}", on_loss(started))).unwrap();
        let effect = if started.is_empty() { preset } else { started };
        assert_eq!(said, [format!("on-loss={effect}")]);
        rig.program();
        let line = format!("lease=1 release=TRUE{}", on_loss(resumed));
        let said = rig.command("remote.start", &line).unwrap();
        let effect = if resumed.is_empty() { effect } else { resumed };
        assert_eq!(said, [format!("on-loss={effect}")]);
        rig.ends_lease("beats");
        let at = rig.at(0);
        rig.cycles(500);
        assert_eq!(rig.at(0) > at, goes_on, "{preset} {started} {resumed}");
        let status = rig.motion.status().unwrap();
        assert_eq!(status.queue == 0, effect == "abort", "{preset} {started} {resumed}");
        // The job ends, and with it what its start said.
        rig.command("motion.abort", "").unwrap();
        rig.cycles(500);
        let status = rig.command("remote.status", "").unwrap().concat();
        assert!(status.ends_with(&format!("hold=FALSE on-loss={preset}")), "{status}");
    }
    let rig = Rig::homed(&[]);
    let why = rig.command("remote.start", "lease=1 on-loss=stop").unwrap_err();
    assert_eq!(why, "on-loss is stop, must be hold, continue or abort");
    assert!(rig.command("remote.status", "").unwrap().concat().ends_with("on-loss=hold"));
}

#[test]
fn each_sign_of_work_counts_alone() {
    let rig = Rig::homed(&[]);
    let idle = rig.motion.status().unwrap();
    for set in 0..32_u32 {
        let is = |n: u32| set >> n & 1 == 1;
        let (claimed, queue, homing, in_position) = (is(0), u32::from(is(1)) * 7, is(2), !is(3));
        let status = MotionStatus { claimed, queue, homing, in_position, ..idle };
        let work = work_of(&status, is(4));
        let (waits, moves) = (is(0) || is(1), is(0) || is(1) || is(2) || is(3));
        assert_eq!((work.waits, work.moves, work.homes, work.job), (waits, moves, is(2), is(4)));
    }
}

#[test]
fn the_status_names_the_holder_while_there_is_one() {
    let rig = Rig::homed(&[]);
    let status = || rig.command("remote.status", "").unwrap().concat();
    assert!(status().starts_with("lease=1 holder=ana "), "{}", status());
    rig.command("remote.give", "lease=1").unwrap();
    assert!(status().starts_with("lease=0 holder= "), "{}", status());
}

#[test]
fn an_order_from_before_a_stop_is_refused() {
    let mut rig = Rig::homed(&[]);
    for (stop, jog, start, release) in [
        ("motion.feed", true, true, true),
        ("motion.pause", false, true, false),
        ("motion.abort", false, false, false),
    ] {
        let epoch = rig.motion.epoch().number();
        rig.command(stop, "").unwrap();
        rig.cycles(20);
        let done = |line: &str, name: &str| rig.command(name, &format!("{line} epoch={epoch}"));
        assert_eq!(done("lease=1", "remote.start").is_ok(), start, "{stop}");
        assert_eq!(done("lease=1 release=TRUE", "remote.start").is_ok(), release, "{stop}");
        assert_eq!(done("", "remote.release").is_ok(), release, "{stop}");
        done("lease=1 joint=0 velocity=20 distance=1", "remote.jog").unwrap();
        let at = rig.at(0);
        rig.cycles(500);
        assert_eq!(rig.at(0) > at, jog, "{stop}");
        rig.command("remote.start", "lease=1 epoch=-1").unwrap();
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

#[test]
fn a_job_that_rests_in_a_pause_has_not_ended() {
    for on_loss in ["hold", "continue", "abort"] {
        let mut rig = Rig::homed(&[&format!("on_loss={on_loss}")]);
        rig.command("remote.start", "lease=1").unwrap();
        rig.rests();
        rig.ends_lease("give");
        assert_eq!(rig.is("hold"), on_loss != "continue", "{on_loss}");
        assert_eq!(rig.aborts(400), if on_loss == "abort" { 2 } else { 0 }, "{on_loss}");
        // The next part of the program, which somebody resumes at the machine.
        if on_loss != "abort" {
            let at = rig.at(0);
            rig.command("motion.mode", "mode=coord").unwrap();
            rig.cycles(10);
            assert!(rig.motion.claim(rig.token, true));
            rig.moves();
            rig.cycles(500);
            assert_eq!(rig.at(0) > at, on_loss == "continue", "{on_loss}");
        }
        rig.bench.set("remote.job", false);
        rig.command("motion.abort", "").unwrap();
        assert!(rig.motion.claim(rig.token, false));
        rig.cycles(500);
        assert!(!rig.is("hold") && !rig.is("abort"), "{on_loss}");
    }
}

#[test]
fn a_job_that_begins_after_the_end_of_its_lease_is_aborted_too() {
    let mut rig = Rig::homed(&["on_loss=abort"]);
    rig.command("remote.start", "lease=1").unwrap();
    rig.command("remote.give", "lease=1").unwrap();
    assert_eq!(rig.aborts(100), 0, "nothing to abort yet");
    // Neither a release nor the next lease keeps it.
    rig.command("remote.release", "").unwrap();
    rig.command("remote.take", "holder=eva").unwrap();
    let refused = rig.command("remote.start", "lease=2 release=TRUE").unwrap_err();
    assert!(refused.contains("is being aborted"), "{refused}");
    rig.bench.set("remote.job", true);
    assert_eq!(rig.aborts(100), 1);
    rig.bench.set("remote.job", false);
    rig.cycles(20);
    assert!(!rig.is("abort"));
    rig.command("remote.start", "lease=2").unwrap();
    rig.bench.set("remote.job", true);
    assert_eq!(rig.aborts(500), 0, "a job of the next lease");
}

#[test]
fn an_answer_to_a_tool_change_ends_with_the_request() {
    let mut rig = Rig::leased(&[]);
    rig.command("remote.tool-changed", "lease=1").unwrap();
    rig.cycles(50);
    assert!(rig.is("tool-changed"));
    rig.bench.set("remote.tool-change", false);
    rig.cycles(10);
    // The next request finds no answer.
    rig.bench.set("remote.tool-change", true);
    rig.cycles(10);
    assert!(!rig.is("tool-changed"));
}

#[test]
fn an_answer_to_a_tool_change_ends_by_itself() {
    let mut rig = Rig::leased(&[]);
    rig.command("remote.tool-changed", "lease=2").unwrap_err();
    assert!(!rig.is("tool-changed"));
    rig.command("remote.tool-changed", "lease=1").unwrap();
    rig.cycles(150);
    assert!(rig.is("tool-changed"));
    rig.command("remote.give", "lease=1").unwrap();
    rig.cycles(100);
    assert!(!rig.is("tool-changed"));
    rig.command("remote.tool-changed", "lease=1").unwrap_err();
}

#[test]
fn a_program_that_was_refused_is_forgotten_and_one_that_runs_is_not() {
    let mut rig = Rig::homed(&[]);
    rig.command("remote.start", "lease=1").unwrap();
    rig.command("remote.refused", "lease=1").unwrap();
    rig.command("remote.give", "lease=1").unwrap();
    rig.cycles(20);
    assert!(!rig.is("hold"));
    rig.command("remote.refused", "lease=1").unwrap_err();
    rig.command("remote.take", "holder=eva").unwrap();
    rig.cycles(100);
    rig.command("remote.start", "lease=2").unwrap();
    rig.program();
    rig.command("remote.refused", "lease=2").unwrap();
    rig.command("remote.give", "lease=2").unwrap();
    rig.cycles(20);
    assert!(rig.is("hold"));
}
