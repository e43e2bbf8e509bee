//! The background task: e-stop, and the handshakes with the tool changer.
//!
//! ```text
//!          prepare              tool-prepared
//! idle ───────────▶ preparing ───────────────▶ idle, with a tool prepared
//! idle ───────────▶ changing  ───────────────▶ idle, with the tool in the spindle
//!          change               tool-changed
//! ```

use crate::{
    estop::{self, Shared},
    pins::Pins,
    service::{Reply, Results},
};
use hal_component::{Gives, Messages, Period, Receiver, Touch, Update};

/// Requested tool.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tool {
    pub(crate) number: i32,
    pub(crate) pocket: i32,
    pub(crate) index: i32,
}

/// Requests of commands.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Ask {
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

/// State of the tool changer.
#[derive(Clone, Copy, Debug)]
enum Changer {
    Idle,
    Preparing(Tool, Reply),
    Changing(Tool, Reply),
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
    from: Receiver<(Ask, Reply)>,
    shared: Gives<Shared>,
    messages: Messages,
    results: Results,
    #[state]
    changer: Changer,
    #[state]
    prepared: Option<Tool>,
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
            match self.obey(ask, ticket) {
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
        from: Receiver<(Ask, Reply)>,
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
            changer: Changer::Idle,
            prepared: None,
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
        let p = &self.pins;
        match self.changer {
            Changer::Preparing(tool, ticket) if p.tool_prepared.get() => {
                p.tool_prepare.set(false);
                self.prepared = Some(tool);
                self.changer = Changer::Idle;
                self.results.done(ticket);
            }
            Changer::Changing(tool, ticket) if p.tool_changed.get() => {
                p.tool_number.set(tool.number);
                p.tool_from_pocket.set(tool.pocket);
                self.show_prepared(Tool { number: 0, pocket: 0, index: 0 });
                self.pins.tool_change.set(false);
                self.prepared = None;
                self.changer = Changer::Idle;
                self.results.done(ticket);
            }
            Changer::Idle | Changer::Preparing(..) | Changer::Changing(..) => {}
        }
    }

    /// Executes a request. Returns true if it is complete, false if the ticket is completed later.
    fn obey(&mut self, ask: Ask, ticket: Reply) -> Result<bool, &'static str> {
        let p = self.pins;
        match ask {
            Ask::Estop { reads } => {
                self.stopping.push(Stopping { ticket, left: TIMEOUT, reads });
                self.look_at_stopping();
                return Ok(false);
            }
            Ask::EstopReset { stops } => {
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
            Ask::Prepare(tool) => {
                self.needs_rest()?;
                self.show_prepared(tool);
                p.tool_prepare.set(true);
                self.prepared = None;
                self.changer = Changer::Preparing(tool, ticket);
                return Ok(false);
            }
            Ask::Change => return self.change(ticket),
            Ask::SetTool(tool) => {
                p.tool_number.set(tool.number);
                p.tool_from_pocket.set(tool.pocket);
            }
            Ask::Coolant { mist, flood, lube } => {
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
            Ask::Abort => self.quiet("aborted"),
        }
        Ok(true)
    }

    fn change(&mut self, ticket: Reply) -> Result<bool, &'static str> {
        self.needs_rest()?;
        let Some(tool) = self.prepared else {
            return Err("no tool is prepared: iocontrol.prepare tool=N comes first");
        };
        if tool.number == self.pins.tool_number.get() {
            return Ok(true);
        }
        self.pins.tool_change.set(true);
        self.changer = Changer::Changing(tool, ticket);
        Ok(false)
    }

    fn needs_enabled(&self) -> Result<(), &'static str> {
        if self.is_released() { Ok(()) } else { Err("the machine is in e-stop") }
    }

    fn needs_rest(&self) -> Result<(), &'static str> {
        self.needs_enabled()?;
        match self.changer {
            Changer::Idle => Ok(()),
            Changer::Preparing(..) => Err("a tool is being prepared"),
            Changer::Changing(..) => Err("a tool is being changed"),
        }
    }

    fn show_prepared(&self, tool: Tool) {
        self.pins.tool_prep_number.set(tool.number);
        self.pins.tool_prep_pocket.set(tool.pocket);
        self.pins.tool_prep_index.set(tool.index);
    }

    /// Switches coolant off and withdraws requests to the changer. A prepared tool stays prepared.
    fn quiet(&mut self, why: &'static str) {
        for pin in [
            self.pins.coolant_mist,
            self.pins.coolant_flood,
            self.pins.tool_prepare,
            self.pins.tool_change,
        ] {
            pin.set(false);
        }
        match core::mem::replace(&mut self.changer, Changer::Idle) {
            Changer::Preparing(_, ticket) | Changer::Changing(_, ticket) => {
                self.results.fail(ticket, why);
            }
            Changer::Idle => {}
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
