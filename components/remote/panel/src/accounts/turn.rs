//! The turn in which a password is tried: one at a time, those from known devices before those of strangers.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// The line before a turn.
#[derive(Debug, Default)]
pub(super) struct Turns {
    line: Mutex<Queue>,
    /// Notified at the end of a turn.
    ended: Condvar,
}

#[derive(Debug, Default)]
struct Queue {
    is_taken: bool,
    /// Number of known devices that wait.
    known: usize,
}

/// A turn until it is dropped.
#[derive(Debug)]
pub(super) struct Turn<'t>(&'t Turns);

impl Turns {
    fn lock(&self) -> MutexGuard<'_, Queue> {
        self.line.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a turn. Of a known device it comes after the one under way, however many strangers wait.
    pub(super) fn take(&self, is_known: bool) -> Turn<'_> {
        let mut line = self.lock();
        line.known += usize::from(is_known);
        while line.is_taken || !is_known && line.known > 0 {
            line = self.ended.wait(line).unwrap_or_else(PoisonError::into_inner);
        }
        line.known -= usize::from(is_known);
        line.is_taken = true;
        Turn(self)
    }
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        self.0.lock().is_taken = false;
        self.0.ended.notify_all();
    }
}

#[cfg(test)]
mod tests {
    //! A device that is known behind strangers who wait.

    use super::Turns;
    use std::{
        sync::{Mutex, mpsc::channel},
        thread,
    };

    #[test]
    fn a_known_device_comes_before_strangers_who_wait_already() {
        let (turns, order) = (Turns::default(), Mutex::new(Vec::new()));
        let (tell, told) = channel();
        thread::scope(|scope| {
            let first = turns.take(false);
            for n in 0..4 {
                let (turns, order, tell) = (&turns, &order, tell.clone());
                scope.spawn(move || {
                    tell.send(()).unwrap();
                    let turn = turns.take(false);
                    order.lock().unwrap().push(n);
                    drop(turn);
                });
            }
            (0..4).for_each(|_| told.recv().unwrap());
            scope.spawn(|| {
                let turn = turns.take(true);
                order.lock().unwrap().push(9);
                drop(turn);
            });
            // The turn under way ends once the device waits.
            while turns.lock().known == 0 {
                thread::yield_now();
            }
            drop(first);
        });
        assert_eq!(order.lock().unwrap()[0], 9);
        assert!(!turns.lock().is_taken);
    }
}
