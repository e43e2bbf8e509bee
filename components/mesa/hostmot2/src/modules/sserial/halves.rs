//! Realtime. The halves of all ports that the functions `read` and `write` run.

use super::{
    data::{Taken, Word},
    parts::{Exchanged, Seen},
    port::Port,
};
use crate::{
    link::Outgoing,
    module::{Cycle, Reads, Writes},
    plan::{Place, ReadAnswer},
};
use core::sync::atomic::Ordering::{Acquire, Relaxed, Release};
use hal_component::{Gives, Takes, Touch};

/// A remote's data in an answer.
#[derive(Touch)]
pub(super) struct Incoming {
    #[state]
    pub(super) channel: usize,
    #[state]
    pub(super) status: Place,
    #[state]
    pub(super) words: Vec<Place>,
    pub(super) taken: Vec<Taken>,
}

/// Half of a port that reads.
#[derive(Touch)]
pub(super) struct Inputs {
    #[state]
    pub(super) command: Place,
    #[state]
    pub(super) data: Place,
    pub(super) remotes: Vec<Incoming>,
    pub(super) seen: Gives<Seen>,
    pub(super) exchanged: Takes<Exchanged>,
    /// Number of the start to which the data of the pins belong.
    #[state]
    pub(super) start: u32,
}

impl Inputs {
    fn read(&mut self, answer: ReadAnswer<'_>, fresh: bool) {
        let (command, faults) = (answer.get(self.command), answer.get(self.data));
        self.seen.command.store(command, Relaxed); // Published with `answers`.
        self.seen.data.store(faults, Relaxed); // Published with `answers`.
        for remote in &self.remotes {
            if let Some(status) = self.seen.status.get(remote.channel) {
                status.store(answer.get(remote.status), Relaxed); // Published with `answers`.
            }
        }
        if !fresh {
            self.seen.missed.fetch_add(1, Relaxed); // Published with `answers`.
        }
        self.seen.answers.fetch_add(1, Release); // Pairs with Acquire in `Port::news`.
        let start = self.exchanged.load(Acquire); // Pairs with Release in `Port::write`.
        if start == 0 || !fresh || command != 0 {
            return;
        }
        let begins = core::mem::replace(&mut self.start, start) != start;
        for remote in &mut self.remotes {
            if faults >> remote.channel & 1 == 1 {
                continue;
            }
            let words = remote.words.iter().enumerate();
            let word = words
                .fold(0, |all: Word, (n, place)| all | Word::from(answer.get(*place)) << (n * 32));
            for taken in &mut remote.taken {
                taken.take(word, begins);
            }
        }
    }
}

/// Function half that reads.
#[derive(Touch)]
pub(super) struct Incomings {
    pub(super) ports: Vec<Inputs>,
}

impl Reads for Incomings {
    fn read(&mut self, answer: ReadAnswer<'_>, _: Cycle, fresh: bool) {
        for port in &mut self.ports {
            port.read(answer, fresh);
        }
    }
}

/// Function half that writes.
#[derive(Touch)]
pub(super) struct Ports {
    pub(super) ports: Vec<Port>,
}

impl Writes for Ports {
    fn write(&mut self, to: &mut Outgoing<'_>, cycle: Cycle) {
        for port in &mut self.ports {
            port.write(to, cycle);
        }
    }
}
