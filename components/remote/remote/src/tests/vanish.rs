//! Teleoperated jobs whose clients vanish at random moments: the server of the protocol beside the servo thread.

use super::rig::{ACCELERATION, Rig};
use hal_bench::Random;
use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv4Addr};
use teleop::{Action, LIVENESS_MS, Server};

/// Number of clients that vanish.
const TRIALS: u64 = 500;
/// Velocity of the program.
const VELOCITY: f64 = 10.0;
/// Distance for stopping.
const BRAKE: f64 = VELOCITY * VELOCITY / (2.0 * ACCELERATION);

/// Kinds of ends of a client.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Loss {
    /// The connection is cut.
    Cut,
    /// The connection is cut inside a request.
    CutInside,
    /// The connection is cut while the job starts.
    CutAtStart,
    /// The connection is cut, and the engine refuses to take the lease back.
    CutRefused,
    /// The client says nothing more.
    Silence,
    /// The program with the server dies: no beat comes, and nobody gives the lease back.
    Death,
}

/// The server with its one client, and the machine.
struct Stage {
    rig: Rig,
    server: Server,
    id: u64,
    /// True while the server's program lives.
    lives: bool,
    /// True while the engine takes the lease back.
    gives: bool,
    /// Milliseconds of the server in a cycle: ten where a long silence must end before the program does.
    pace: u64,
}

impl Stage {
    fn new(on_loss: &str, pace: u64) -> Self {
        let rig = Rig::homed(&[&format!("on_loss={on_loss}")]);
        let mut server = Server::default();
        let id = server.connect(IpAddr::V4(Ipv4Addr::LOCALHOST), 0).unwrap();
        let mut stage = Self { rig, server, id, lives: true, gives: true, pace };
        stage.say("INGRESAR ana:clave\nENVIAR_NUEVO G1 X100 F600\n");
        stage.act();
        stage
    }

    /// Returns the server's time in milliseconds.
    fn now(&self) -> u64 {
        self.rig.cycle as u64 * self.pace
    }

    fn say(&mut self, text: &str) {
        let now = self.now();
        self.server.receive(self.id, text.as_bytes(), now);
    }

    /// Does what the server wants; returns true once a job shall start.
    fn act(&mut self) -> bool {
        let now = self.now();
        let mut starts = false;
        while let Some(action) = self.server.action() {
            match action {
                Action::SignIn { id, .. } => self.server.signed_in(id, Ok(true), now),
                Action::Start { .. } => starts = true,
                // The servo thread may have ended the lease first.
                Action::Lose if self.gives => drop(self.rig.command("remote.give", "lease=1")),
                Action::Lose => {}
                Action::Cancel | Action::Close(_) => panic!("nobody has asked for {action:?}"),
            }
        }
        starts
    }

    /// Passes time; the server looks at the machine every 20 ms.
    fn pass(&mut self, cycles: usize) {
        for _ in 0..cycles.div_ceil(20) {
            self.rig.cycles(20);
            if self.lives {
                let now = self.now();
                self.server.poll(now);
                self.act();
                self.rig.answers = now <= self.server.answers_until(now);
            }
        }
    }

    fn start(&mut self, gone: bool) {
        self.say("EJECUTAR\n");
        assert!(self.act(), "the job starts");
        self.rig.command("remote.start", "lease=1").unwrap();
        self.rig.program();
        if gone {
            self.server.gone(self.id);
        }
        let now = self.now();
        self.server.started(Ok(()), now);
        self.act();
    }

    /// Lets the client vanish; returns the longest time until the loss is known, in cycles.
    fn vanish(&mut self, loss: Loss) -> usize {
        match loss {
            Loss::Cut | Loss::CutInside => {
                if loss == Loss::CutInside {
                    self.say("AVAN");
                }
                self.server.gone(self.id);
                self.act();
                20
            }
            Loss::CutRefused => {
                self.gives = false;
                self.server.gone(self.id);
                self.act();
                // The beats have ended: the servo thread ends the lease.
                1020 + self.rig.delay
            }
            Loss::CutAtStart => 20,
            Loss::Silence => usize::try_from(LIVENESS_MS / self.pace).unwrap() + 20,
            Loss::Death => {
                (self.lives, self.rig.answers) = (false, false);
                1020
            }
        }
    }
}

#[test]
fn a_job_of_a_vanished_client_is_in_the_state_that_the_machine_is_configured_for() {
    let mut random = Random::new(2005);
    let mut tried = BTreeMap::<(&str, Loss), u32>::new();
    for trial in 0..TRIALS {
        let on_loss = random.pick(&["hold", "continue", "abort"]);
        let loss = match random.below(20) {
            0 => Loss::Silence,
            1..8 => Loss::Cut,
            8..12 => Loss::CutInside,
            12..14 => Loss::CutAtStart,
            14..16 => Loss::CutRefused,
            _ => Loss::Death,
        };
        let what = format!("trial {trial}: {on_loss} {loss:?}");
        *tried.entry((on_loss, loss)).or_default() += 1;
        let mut stage = Stage::new(on_loss, if loss == Loss::Silence { 10 } else { 1 });
        let moves = usize::try_from(random.below(1500)).unwrap();
        stage.rig.delay = usize::try_from(random.below(60)).unwrap();
        stage.start(loss == Loss::CutAtStart);
        if loss != Loss::CutAtStart {
            stage.pass(if loss == Loss::Silence { moves / 10 } else { moves });
            stage.say("AVANCE\n");
        }
        let from = stage.rig.at(0);
        assert!(from > 1.0 && !stage.rig.is("hold") || loss == Loss::CutAtStart, "{what}: {from}");
        let latest = stage.vanish(loss);
        // Time until the loss is known, and to brake.
        stage.pass(latest + 100);
        let rest = stage.rig.at(0);
        stage.pass(400);
        let after = stage.rig.at(0);
        let status = stage.rig.motion.status().unwrap();
        match on_loss {
            "continue" => assert!(after > rest + 0.3 * VELOCITY, "{what}: {rest}, {after}"),
            "hold" => {
                let far = VELOCITY * (latest as f64 / 1000.0) + BRAKE + 0.1;
                assert!(rest <= from + far, "{what}: from {from} to {rest}");
                assert!(after.to_bits() == rest.to_bits() && stage.rig.is("hold"), "{what}");
                assert!(status.queue == 1 && status.velocity == 0.0, "{what}: {status:?}");
            }
            _ => {
                assert_eq!(after.to_bits(), rest.to_bits(), "{what}");
                assert!(status.queue == 0 && status.velocity == 0.0, "{what}: {status:?}");
            }
        }
    }
    assert!(tried.len() >= 17, "{tried:?}");
}
