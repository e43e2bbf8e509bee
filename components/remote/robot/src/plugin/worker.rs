//! The worker: it keeps the session, and ends it where the machine's state demands that.

use super::{
    cause::Cause,
    gate::{Ends, Shared, press},
    orders::{Inbox, RobotOrder, Waiting},
    pins::{Results, SimInputs, SimResults},
    report::Report,
    session::Session,
    shown::SessionState,
};
use crate::{Volume, link::lock};
use arc_swap::ArcSwapOption;
use hal_component::{
    Builder, Clock, Error, Messages, ParamRw, SeqReader, SeqWriter, Texts, TicketHandle, Touch,
    Work,
};
use std::{
    io::Write as _,
    net::{Shutdown, TcpStream},
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
};

/// Largest number of different messages.
const MESSAGES: usize = 1000;
/// Largest number of remarks on a program that are logged.
const MAX_REMARKS: usize = 10;
/// Time without a cycle of the function after which a connection ends, in seconds.
const IDLE: f64 = 0.5;
/// Longest time for which an order waits that begins a move, in nanoseconds: who gave it still expects the move then.
const PATIENCE_NS: i64 = 1_000_000_000;

/// Arguments of `loadrt`.
pub(crate) struct Settings {
    pub(crate) to: String,
    pub(crate) timeout: f64,
    pub(crate) connect: f64,
    pub(crate) volume: Volume,
    pub(crate) is_simulated: bool,
}

/// Connection for the stop action.
#[derive(Debug, Default)]
pub(crate) struct Halt {
    has_stopped: AtomicBool,
    socket: ArcSwapOption<TcpStream>,
    /// Flag of a connection that a thread makes.
    opening: ArcSwapOption<Mutex<bool>>,
}

impl Halt {
    /// Stops the robot, whatever has become of the worker.
    pub(crate) fn stop(&self) {
        self.has_stopped.store(true, Relaxed);
        if let Some(opening) = self.opening.swap(None) {
            *lock(&opening) = true;
        }
        if let Some(socket) = self.socket.swap(None) {
            // A controller that reads neither of the two has lost its client.
            drop((&*socket).write_all(b"EXIT\r\n"));
            drop(socket.shutdown(Shutdown::Both));
        }
    }
}

/// Tickets whose ends are still to come.
#[derive(Default)]
struct Pending {
    connect: Option<TicketHandle>,
    run: Option<TicketHandle>,
    pause: Option<TicketHandle>,
    /// Tickets whose ends are known, and are reported once the pins show them.
    ended: Vec<(TicketHandle, Result<(), &'static str>)>,
}

impl Pending {
    /// Returns the place for the ticket of an order that takes time.
    const fn of(&mut self, order: &RobotOrder) -> Option<&mut Option<TicketHandle>> {
        match order {
            RobotOrder::Connect => Some(&mut self.connect),
            RobotOrder::Run(_) => Some(&mut self.run),
            RobotOrder::Pause => Some(&mut self.pause),
            RobotOrder::Disconnect
            | RobotOrder::Load(_)
            | RobotOrder::Resume
            | RobotOrder::Stop => None,
        }
    }
}

/// The worker.
#[derive(Touch)]
pub(crate) struct Worker {
    cutting_speed: ParamRw<f64>,
    tool_length: ParamRw<f64>,
    results: SeqWriter<Results>,
    simulated: Option<(SeqReader<SimInputs>, SeqWriter<SimResults>)>,
    clock: Clock,
    messages: Messages,
    #[state]
    session: Session,
    #[state]
    to: String,
    #[state]
    connect: f64,
    #[state]
    shared: Arc<Shared>,
    #[state]
    inbox: Arc<Mutex<Inbox>>,
    #[state]
    report: Arc<Mutex<Report>>,
    #[state]
    halt: Arc<Halt>,
    #[state]
    texts: Texts,
    #[state]
    pending: Pending,
    /// Number of cycles of the function, and the time at which it last changed.
    #[state]
    cycles: (u32, f64),
    /// Results that the function has, or is about to have.
    #[state]
    last: Results,
    /// Cycles of the function when the results were last set.
    #[state]
    shown_since: u32,
    /// Reason that was reported.
    #[state]
    reported: Option<Cause>,
}

impl Worker {
    pub(crate) fn make(
        b: &mut Builder<'_>,
        settings: Settings,
        ends: Ends,
        shared: Arc<Shared>,
        inbox: Arc<Mutex<Inbox>>,
        report: Arc<Mutex<Report>>,
        halt: Arc<Halt>,
    ) -> Result<Self, Error> {
        let Settings { to, timeout, connect, volume, is_simulated } = settings;
        let zero = is_simulated.then_some([-400.0, 0.0, -30.0]);
        let (speed, tool) = (
            "Highest cutting speed of the programs that are loaded, above 0 and at most 15, in mm/s.",
            "Length of the tool beyond the flange, from 0 to 500, in mm.",
        );
        Ok(Self {
            cutting_speed: b.item("robot.cutting-speed", speed, 5.0)?,
            tool_length: b.item("robot.tool-length", tool, 0.0)?,
            results: ends.results,
            simulated: ends.simulated,
            clock: b.clock(),
            messages: b.messages(),
            session: Session::new(&volume, timeout, zero),
            to,
            connect,
            shared,
            inbox,
            report,
            halt,
            texts: Texts::new(MESSAGES),
            pending: Pending::default(),
            cycles: (0, 0.0),
            last: Results::default(),
            shown_since: 0,
            reported: None,
        })
    }

    /// Ends a connection that the machine's state forbids.
    fn guard(&mut self, now: f64) {
        let cycles = self.shared.cycles.load(Relaxed);
        if cycles != self.cycles.0 {
            self.cycles = (cycles, now);
        }
        let was_disabled = self.shared.dropped.swap(false, Relaxed);
        let cause = if was_disabled || !self.shared.enabled.load(Relaxed) {
            Cause::Enable
        } else if now - self.cycles.1 > IDLE {
            Cause::Function
        } else {
            return;
        };
        self.session.stop(cause, now);
    }

    /// Refuses to connect where the machine's state forbids that.
    fn check_state(&self, now: f64) -> Result<(), String> {
        let why = if self.cycles.0 == 0 || now - self.cycles.1 > IDLE {
            "function robot is in no thread that runs"
        } else if !self.shared.enabled.load(Relaxed) {
            "robot.enable is FALSE"
        } else {
            return Ok(());
        };
        Err(why.to_owned())
    }

    fn order(
        &mut self,
        order: &RobotOrder,
        ticket: Option<TicketHandle>,
        sim: &SimInputs,
        now: f64,
    ) {
        let (speed, tool) = (self.cutting_speed.get(), self.tool_length.get());
        let done = match order {
            _ if order.begins_a_move() && self.shared.hold.load(Relaxed) => {
                Err("robot.hold is TRUE".to_owned())
            }
            RobotOrder::Connect => self
                .check_state(now)
                .and_then(|()| self.session.connect(&self.to, self.connect, sim, now)),
            RobotOrder::Disconnect => self.session.disconnect(now),
            RobotOrder::Load(path) => {
                self.shared.loads.store(true, Relaxed);
                let loaded = self.session.load(path, speed, tool).map(|warnings| {
                    for warning in warnings.iter().take(MAX_REMARKS) {
                        self.messages.notice(self.texts.keep(warning), &[]);
                    }
                });
                self.shared.loads.store(false, Relaxed);
                loaded
            }
            RobotOrder::Run(from) => self.session.run(*from, speed, tool, now),
            RobotOrder::Pause => self.session.pause(true),
            RobotOrder::Resume => self.session.pause(false),
            RobotOrder::Stop => {
                self.session.stop(Cause::Command, now);
                Ok(())
            }
        };
        let done = done.map_err(|why| self.texts.keep(&why));
        let Some(ticket) = ticket else {
            if let Err(why) = done {
                self.messages.error(why, &[]);
            }
            return;
        };
        let waits = self.pending.of(order);
        let takes_time = waits.is_some();
        if let (Ok(()), Some(waits)) = (done, waits) {
            if let Some(before) = waits.replace(ticket) {
                before.fail("another command of this kind has followed");
            }
            return;
        }
        if let Err(why) = done
            && takes_time
            && !(*order == RobotOrder::Connect && self.session.cause() == Some(Cause::Unreachable))
        {
            // Perhaps nobody waits for the ticket. A connection that fails is logged as such.
            self.messages.error(why, &[]);
        }
        self.pending.ended.push((ticket, done));
    }

    /// Tells tickets and the log how things have ended, once the pins show it.
    fn tell(&mut self, now: f64) {
        let cycles = self.shared.cycles.load(Relaxed).wrapping_sub(self.shown_since);
        if self.cycles.0 != 0 && cycles < 2 && now - self.cycles.1 <= IDLE {
            return;
        }
        for (ticket, end) in self.pending.ended.drain(..) {
            match end {
                Ok(()) => ticket.done(),
                Err(why) => ticket.fail(why),
            }
        }
        let (state, cause) = (self.session.state(), self.session.cause());
        let number = self.session.line as f64;
        let why = match cause {
            Some(Cause::Unreachable) => self.texts.keep(&self.session.problem),
            Some(cause) => cause.text(),
            None => "robot.disconnect has ended the connection",
        };
        let end = |ticket: &mut Option<TicketHandle>, is_done: bool, is_over: bool| {
            if !is_done && !is_over {
                return;
            }
            let Some(ticket) = ticket.take() else { return };
            if is_done {
                ticket.done();
            } else {
                ticket.fail_with(why, &[number]);
            }
        };
        let has_ended = state == SessionState::Ended;
        let is_ready = state == SessionState::Ready || state.runs();
        end(&mut self.pending.connect, is_ready, !state.is_connected());
        end(&mut self.pending.run, has_ended, !state.runs());
        let rests = has_ended || state == SessionState::Paused;
        end(&mut self.pending.pause, rests, !state.runs());
        if cause != self.reported {
            self.reported = cause;
            match cause {
                None => {}
                Some(Cause::Command) => self.messages.info(why, &[number]),
                Some(_) => self.messages.error(why, &[number]),
            }
        }
    }
}

impl Work for Worker {
    fn work(&mut self, _: u32) -> u32 {
        let clock = self.clock;
        let time = move || clock.now_ns() as f64 * 1e-9;
        let sim =
            self.simulated.as_mut().map_or_else(SimInputs::default, |(inputs, _)| inputs.get());
        self.tell(time());
        // Nobody has spoken with the controller for long: before an answer that waits sends the next line.
        let was_dead = self.shared.dead.swap(false, Relaxed);
        if was_dead {
            self.session.stop(Cause::Worker, time());
        }
        let hold = self.shared.hold.load(Relaxed);
        if hold {
            self.session.give_up_opening("robot.hold is TRUE");
        }
        let came = self.session.exchange(hold, time, &sim);
        let now = time();
        if self.halt.has_stopped.swap(false, Relaxed) {
            self.session.end_with_instance(now);
        }
        self.guard(now);
        let orders = core::mem::take(&mut *lock(&self.inbox));
        for Waiting { order, ticket, since } in orders {
            if order.begins_a_move() && clock.now_ns() - since > PATIENCE_NS {
                let why = "the order has waited too long for the worker: give it again";
                self.messages.error(why, &[]);
                self.pending.ended.push((ticket, Err(why)));
                continue;
            }
            self.order(&order, Some(ticket), &sim, now);
        }
        let mut presses = self.shared.presses.swap(0, Relaxed);
        if was_dead {
            presses &= !(press::RUN | press::RESUME);
        }
        let buttons = [
            (press::RUN, RobotOrder::Run(0)),
            (press::RESUME, RobotOrder::Resume),
            (press::PAUSE, RobotOrder::Pause),
            (press::STOP, RobotOrder::Stop),
        ];
        for (_, order) in buttons.iter().filter(|(bit, _)| presses & bit != 0) {
            self.order(order, None, &sim, now);
        }
        self.session.flush(self.shared.hold.load(Relaxed), now);
        self.halt.socket.store(self.session.socket().cloned());
        self.halt.opening.store(self.session.opening().cloned());
        let results = self.session.results();
        if results != self.last {
            (self.last, self.shown_since) = (results, self.shared.cycles.load(Relaxed));
            self.results.set(&results);
        }
        if let Some((_, results)) = &mut self.simulated {
            results.set(&self.session.sim_results(now));
        }
        self.session.report(&mut lock(&self.report));
        self.shared.steps.store(self.shared.steps.load(Relaxed).wrapping_add(1), Relaxed);
        u32::from(came)
    }
}
