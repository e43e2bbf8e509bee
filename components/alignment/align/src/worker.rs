//! The worker: takes and searches pictures.

use crate::{
    bench::{Bench, Failure, Look},
    eye::{Action, Ends, EyeEvent, Shared, Station},
    lock,
    pins::Results,
    view::{View, Watched},
};
use hal_component::{Clock, Messages, Receiver, SeqReader, SeqWriter, Touch, Work};
use std::sync::{Arc, Mutex, atomic::Ordering::Relaxed};

/// Event in progress.
struct Progress {
    event: EyeEvent,
    look: Look,
    /// Machine time of its begin, in nanoseconds.
    begun: i64,
    /// Machine time of the last picture, in nanoseconds.
    since: i64,
}

/// The worker.
#[derive(Touch)]
pub(crate) struct Worker {
    events: Receiver<EyeEvent>,
    results: SeqWriter<Results>,
    station: SeqReader<Station>,
    clock: Clock,
    messages: Messages,
    #[state]
    view: View,
    #[state]
    bench: Arc<Mutex<Bench>>,
    #[state]
    shared: Arc<Shared>,
    #[state]
    last: Results,
    #[state]
    progress: Option<Progress>,
}

impl Worker {
    pub(crate) fn new(
        bench: Arc<Mutex<Bench>>,
        shared: Arc<Shared>,
        ends: Ends,
        watched: Watched,
        clock: Clock,
        messages: Messages,
    ) -> Self {
        let Ends { results, events, station } = ends;
        let view = View::new(watched);
        Self {
            events,
            results,
            station,
            clock,
            messages,
            view,
            bench,
            shared,
            last: Results::default(),
            progress: None,
        }
    }

    /// Goes on with an event. Returns its result when it is done.
    fn go_on(&mut self, progress: &mut Progress) -> Option<Result<(), Failure>> {
        let Progress { event, look, begun, since } = progress;
        let at = event.station.at();
        let moved = || self.shared.moved.load(Relaxed);
        let mut bench = lock(&self.bench);
        match event.action {
            Action::Solve => return Some(bench.solve()),
            Action::Clear => {
                bench.clear();
                return Some(Ok(()));
            }
            Action::Calibrate => return Some(bench.calibrate()),
            Action::Look(_) | Action::Sight => {}
        }
        if moved() {
            return Some(Err(Failure::Moved));
        }
        let early = (self.clock.now_ns() - *begun) as f64 / 1e9;
        if bench.skip_early(early) {
            *since = self.clock.now_ns();
            return None;
        }
        // Commands may use the bench while a picture is read and searched.
        let mut camera = bench.lend();
        drop(bench);
        let searched = camera.search(&event.station);
        let mut bench = lock(&self.bench);
        let taken = bench.give_back(camera, searched, look);
        if moved() {
            return Some(Err(Failure::Moved));
        }
        let now = self.clock.now_ns();
        match taken {
            Err(failure) => return Some(Err(failure)),
            Ok(None) => {
                let waited = (now - *since) as f64 / 1e9;
                let ends = waited > bench.timeout();
                return ends.then(|| Err(bench.no_picture()));
            }
            Ok(Some(false)) => {
                *since = now;
                return None;
            }
            Ok(Some(true)) => {}
        }
        Some(match event.action {
            Action::Look(mark) => {
                bench.measure(look, mark.unwrap_or(event.mark), at, &mut self.last)
            }
            _ => bench.sight(look, at),
        })
    }

    /// Reports the end of an event.
    fn end(&mut self, event: &EyeEvent, result: Result<(), Failure>) {
        let looks = matches!(event.action, Action::Look(_) | Action::Sight);
        self.last.looks = event.number;
        self.last.error = result.err().map_or(0, |f| f as i32);
        if looks {
            self.last.found = result.is_ok();
        }
        if let Err(failure) = result
            && !event.is_awaited
        {
            self.messages.error(failure.text(), &[]);
        }
    }
}

impl Work for Worker {
    fn work(&mut self, _: u32) -> u32 {
        let mut done = 0;
        if self.progress.is_none()
            && let Some(event) = self.events.take()
        {
            let mark = match event.action {
                Action::Look(mark) => Some(mark.unwrap_or(event.mark)),
                _ => None,
            };
            let begun = lock(&self.bench).begin(mark);
            let since = self.clock.now_ns();
            match begun {
                Ok(()) => {
                    let look = Look::default();
                    self.progress = Some(Progress { event, look, begun: since, since });
                }
                Err(failure) => self.end(&event, Err(failure)),
            }
        }
        if let Some(mut progress) = self.progress.take() {
            done = 1;
            match self.go_on(&mut progress) {
                None => self.progress = Some(progress),
                Some(result) => {
                    let event = progress.event;
                    self.end(&event, result);
                }
            }
        }
        let mark = self.shared.mark.load(Relaxed);
        lock(&self.bench).report(mark, &mut self.last);
        self.results.set(&self.last);
        if self.view.take_turn(self.clock.now_ns()) {
            done = 1;
            self.view.show(&self.bench, &self.station.get());
        }
        done
    }
}
