//! The background task: e-stop, coolant, and the pins of the tool changer.

use crate::{
    changer::{Answers, Changer, End, Tool},
    estop::{self, Shared},
    pins::Pins,
    service::{Reply, Results},
};
use hal_component::{Gives, Messages, Period, Receiver, Touch, Update};

/// Requests of commands.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Request {
    /// The e-stop is already active; `reads` is the number of reads of the interlock at that time.
    Estop {
        reads: u32,
    },
    /// `stops` is the number of e-stop commands before it.
    EstopReset {
        stops: u32,
    },
    Prepare(Tool),
    Change,
    SetTool(Tool),
    Coolant {
        mist: Option<bool>,
        flood: Option<bool>,
        lube: Option<bool>,
    },
    Abort,
}

/// Number of cycles for the external chain to follow user-enable-out, in both directions.
const TIMEOUT: u32 = 10;

/// An e-stop that has not taken effect yet.
#[derive(Clone, Copy, Debug)]
struct Stopping {
    ticket: Reply,
    /// Number of cycles left.
    left: u32,
    /// Number of reads of the interlock at the time of the command.
    reads: u32,
}

/// State of the task.
#[derive(Debug, Touch)]
pub(crate) struct Task {
    pins: Pins,
    from: Receiver<(Request, Reply)>,
    shared: Gives<Shared>,
    messages: Messages,
    results: Results,
    #[state]
    changer: Changer,
    /// Receiver of the result of the changer's current request.
    #[state]
    requester: Option<Reply>,
    /// Ticket that waits for the end of e-stop, and the cycles left.
    #[state]
    resetting: Option<(Reply, u32)>,
    #[state]
    stopping: Vec<Stopping>,
    #[state]
    was_enabled: bool,
    /// Numbers of e-stop commands and of reads of the interlock, as of the last cycle.
    #[state]
    stops: u32,
    #[state]
    reads: u32,
}

impl Update for Task {
    fn update(&mut self, _: Period) {
        self.look_at_estop();
        self.look_at_changer();
        while let Some((ask, ticket)) = self.from.take() {
            match self.execute(ask, ticket) {
                Ok(true) => self.results.done(ticket),
                Ok(false) => {}
                Err(why) => self.results.fail(ticket, why),
            }
        }
    }
}

impl Task {
    pub(crate) const fn new(
        pins: Pins,
        from: Receiver<(Request, Reply)>,
        shared: Gives<Shared>,
        messages: Messages,
        results: Results,
    ) -> Self {
        Self {
            pins,
            from,
            shared,
            messages,
            results,
            changer: Changer::new(),
            requester: None,
            resetting: None,
            stopping: Vec::new(),
            was_enabled: false,
            stops: 0,
            reads: 0,
        }
    }

    fn look_at_estop(&mut self) {
        let (reads, stops) = (self.shared.reads(), self.shared.stops());
        self.shared.set_unread(reads != 0 && reads == self.reads);
        self.reads = reads;
        let enabled = self.is_released();
        self.pins.user_request_enable.set(false);
        if stops != self.stops || self.was_enabled && !enabled {
            self.quiet("e-stop");
            self.pins.lube.set(false);
        }
        if stops != self.stops
            && let Some((ticket, _)) = self.resetting.take()
        {
            self.results.fail(ticket, "e-stop");
        }
        self.stops = stops;
        self.was_enabled = enabled;
        self.look_at_stopping();
        self.resetting = match self.resetting {
            Some((ticket, _)) if enabled => {
                self.results.done(ticket);
                None
            }
            Some((ticket, 0)) => {
                self.results
                    .fail(ticket, "emc-enable-in stays FALSE: something outside holds the e-stop");
                None
            }
            Some((ticket, left)) => Some((ticket, left - 1)),
            None => None,
        };
    }

    /// Completes tickets of e-stops: the external contacts have opened, and motion has read the interlock.
    fn look_at_stopping(&mut self) {
        let is_open = !self.pins.emc_enable_in.get();
        let reads = self.shared.reads();
        self.stopping.retain_mut(|stopping| {
            let is_read = reads == 0 || reads != stopping.reads;
            if is_open && is_read {
                self.results.done(stopping.ticket);
                return false;
            }
            if stopping.left > 0 {
                stopping.left -= 1;
                return true;
            }
            let why = match (is_read, reads) {
                (false, _) => UNREAD,
                (true, 0) => STAYS,
                (true, _) => STAYS_LOCKED,
            };
            self.messages.error(why, &[]);
            self.results.fail(stopping.ticket, why);
            false
        });
    }

    fn is_released(&self) -> bool {
        estop::state(&self.shared, self.pins.emc_enable_in).is_released()
    }

    fn look_at_changer(&mut self) {
        let end = self.changer.follow(self.answers());
        self.show_changer();
        let (Some(end), Some(requester)) = (end, self.requester) else { return };
        self.requester = None;
        match end {
            End::Prepared | End::Changed => self.results.done(requester),
            End::Failed(why) => {
                self.messages.error(why, &[]);
                self.results.fail(requester, why);
            }
        }
    }

    fn answers(&self) -> Answers {
        let p = &self.pins;
        Answers { prepared: p.tool_prepared.get(), changed: p.tool_changed.get() }
    }

    /// Writes the changer's state to its pins.
    fn show_changer(&self) {
        let (p, shown, spindle) = (&self.pins, self.changer.shown(), self.changer.spindle());
        p.tool_number.set(spindle.number);
        p.tool_from_pocket.set(spindle.pocket);
        p.tool_prep_number.set(shown.number);
        p.tool_prep_pocket.set(shown.pocket);
        p.tool_prep_index.set(shown.index);
        let (prepare, change) = self.changer.requests();
        p.tool_prepare.set(prepare);
        p.tool_change.set(change);
        // An e-stop may have come from another thread in between.
        if !self.is_released() {
            p.tool_prepare.set(false);
            p.tool_change.set(false);
        }
    }

    /// Executes a request. Returns true if it is complete, false if the ticket is completed later.
    fn execute(&mut self, request: Request, ticket: Reply) -> Result<bool, &'static str> {
        let p = self.pins;
        match request {
            Request::Estop { reads } => {
                self.stopping.push(Stopping { ticket, left: TIMEOUT, reads });
                self.look_at_stopping();
                return Ok(false);
            }
            Request::EstopReset { stops } => {
                if stops != self.shared.stops() {
                    return Err("e-stop");
                }
                if self.is_released() {
                    return Ok(true);
                }
                for stopping in self.stopping.drain(..) {
                    self.results.fail(stopping.ticket, "superseded by iocontrol.estop-reset");
                }
                estop::release(&self.shared, &p);
                if let Some((earlier, _)) = self.resetting.replace((ticket, TIMEOUT)) {
                    self.results.fail(earlier, "superseded by another reset");
                }
                return Ok(false);
            }
            Request::Prepare(tool) => {
                self.needs_enabled()?;
                self.changer.prepare(tool, self.answers())?;
                return Ok(self.wait_for_changer(ticket));
            }
            Request::Change => {
                self.needs_enabled()?;
                let is_there = self.changer.change(self.answers())?;
                return Ok(is_there || self.wait_for_changer(ticket));
            }
            Request::SetTool(tool) => {
                self.changer.set_tool(tool)?;
                self.show_changer();
            }
            Request::Coolant { mist, flood, lube } => {
                if [mist, flood, lube].contains(&Some(true)) {
                    self.needs_enabled()?;
                }
                for (pin, value) in
                    [(p.coolant_mist, mist), (p.coolant_flood, flood), (p.lube, lube)]
                {
                    if let Some(value) = value {
                        pin.set(value);
                    }
                }
            }
            Request::Abort => self.quiet("aborted"),
        }
        Ok(true)
    }

    /// Leaves the result of a request to the changer's answer. Returns false: it is not complete.
    fn wait_for_changer(&mut self, requester: Reply) -> bool {
        self.requester = Some(requester);
        self.show_changer();
        false
    }

    fn needs_enabled(&self) -> Result<(), &'static str> {
        if self.is_released() { Ok(()) } else { Err("the machine is in e-stop") }
    }

    /// Switches coolant off and withdraws requests to the changer. A prepared tool stays prepared.
    fn quiet(&mut self, why: &'static str) {
        self.pins.coolant_mist.set(false);
        self.pins.coolant_flood.set(false);
        self.changer.withdraw();
        self.show_changer();
        if let Some(requester) = self.requester.take() {
            self.results.fail(requester, why);
        }
    }
}

const STAYS: &str = "{iocontrol.0.emc-enable-in} stays TRUE: the e-stop chain does not follow \
                     {iocontrol.0.user-enable-out}, and what hangs at the chain goes on. Lead \
                     user-enable-out to emc-enable-in, directly or through the components of the \
                     chain";
const STAYS_LOCKED: &str = "{iocontrol.0.emc-enable-in} stays TRUE: the e-stop chain does not \
                            follow {iocontrol.0.user-enable-out}. The interlock has switched \
                            motion off, and nothing else: lead user-enable-out to emc-enable-in, \
                            directly or through the components of the chain";
const UNREAD: &str = "motion has not read the interlock since: motion-controller runs in no \
                      thread, or the threads stand still, so what it last put out stays";
