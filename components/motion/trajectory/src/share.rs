//! The hand-over from a planner in one thread to a follower in another.
//!
//! The publisher copies cells into shared slots and sweeps over what it has copied, so that the published path always
//! ends at rest, however little of it fits. A follower that meets the end of the path stops there, inside its limits, and
//! goes on when more arrives.

use std::sync::Arc;

use crate::{
    curve::Curve,
    kinematics::Kinematics,
    plan::Planner,
    pose::{AXES, Pose},
    slots::{Order, Slots},
    track::{Cell, Path, Track},
};

/// Words of a cell and of a curve, and the words of a cell that change after it is published.
const CELL: usize = 12;
const CURVE: usize = 56;
const END: usize = 7;
const BEGIN: usize = 8;
const FLAGS: usize = 10;

/// Part of the highest squared speed that counts as not braking.
const UNBRAKED: f64 = 1.0 - 1e-9;

#[derive(Debug)]
struct Shared {
    order: Order,
    cells: Slots<CELL>,
    curves: Slots<CURVE>,
}

/// The planner's end of a hand-over.
#[derive(Debug)]
pub struct Publisher {
    shared: Arc<Shared>,
    /// Copy of what is published, without the curves.
    sent: Track,
    history: u64,
    /// Number of the next cell and curve to be copied.
    next: u64,
    next_curve: u64,
}

/// The follower's end of a hand-over. Realtime.
#[derive(Debug)]
pub struct Reader(Arc<Shared>);

/// Makes a hand-over for `cells` cells, of which `history` behind the follower are kept for reverse motion.
pub fn share(cells: usize, history: usize) -> (Publisher, Reader) {
    let cells = cells.max(16);
    let shared = Arc::new(Shared {
        order: Order::new(),
        cells: Slots::new(cells),
        curves: Slots::new(cells),
    });
    let publisher = Publisher {
        shared: Arc::clone(&shared),
        sent: Track::default(),
        history: history.min(cells / 2) as u64,
        next: 0,
        next_curve: 0,
    };
    (publisher, Reader(shared))
}

impl Publisher {
    /// Publishes as much of the planner's track as fits, and lets the planner forget it. Call it after moves were added,
    /// and in regular intervals while motion lasts.
    pub fn publish<K: Kinematics>(&mut self, planner: &mut Planner<K>) {
        self.give_up();
        let Self { shared, sent, .. } = self;
        let track = planner.track();
        // The last cell may have become a stop since it was published.
        if let Some(last) = self.next.checked_sub(1)
            && track.cell(last).is_some_and(|c| c.stop)
            && sent.cell(last).is_some_and(|c| !c.stop)
        {
            sent.stop_at_end();
            if let Some(cell) = sent.cell(last) {
                shared.cells.set(last, FLAGS, flags(cell));
            }
        }
        let old = self.next;
        let mut first = sent.cells().next().map(|c| c.curve);
        while let Some(cell) = track.cell(self.next)
            && (sent.len() as u64) < shared.cells.len()
            && cell.curve < *first.get_or_insert(cell.curve) + shared.curves.len()
        {
            while self.next_curve <= cell.curve {
                if let Some(curve) = track.curve(self.next_curve) {
                    shared.curves.fill(self.next_curve, &curve_words(curve));
                }
                self.next_curve += 1;
            }
            sent.add_cell(*cell);
            if cell.stop {
                sent.stop_at_end();
            }
            self.next += 1;
        }
        let changed = sent.sweep();
        for number in old..self.next {
            if let Some(cell) = sent.cell(number) {
                shared.cells.fill(number, &cell_words(cell));
            }
        }
        shared.order.publish(self.next);
        for number in (changed..old).rev() {
            if let Some(cell) = sent.cell(number) {
                shared.cells.set(number, END, cell.end.to_bits());
            }
        }
        planner.hand_over(self.next.saturating_sub(1));
    }

    /// Gives up cells far behind the follower.
    fn give_up(&mut self) {
        let Self { shared, sent, .. } = self;
        // While the follower moves backward, the limits of that motion must not change.
        if !shared.order.settle() {
            return;
        }
        let oldest = shared.order.oldest().saturating_sub(self.history);
        if oldest <= sent.oldest() {
            return;
        }
        let same = sent.forget(oldest);
        shared.order.give_up(sent.oldest());
        for number in sent.oldest()..same {
            if let Some(cell) = sent.cell(number) {
                shared.cells.set(number, BEGIN, cell.begin.to_bits());
            }
        }
    }

    /// Returns true if everything that the planner has planned is published.
    pub fn is_complete<K: Kinematics>(&self, planner: &Planner<K>) -> bool {
        planner.track().cell(self.next).is_none()
    }

    /// Returns the least time, in seconds, that the follower moves before it must brake for the end of what is published;
    /// negative if it may brake already. Counts no further than `enough`. `from` is the follower's
    /// [`input`](crate::Follower::input).
    pub fn time_ahead(&self, from: (u64, f64), period: f64, enough: f64) -> f64 {
        let (mut time, mut free, mut filter) = (0.0, 0.0, 0.0_f64);
        let (first, mut gone) = from;
        for number in first.max(self.sent.oldest())..self.next {
            let Some(cell) = self.sent.cell(number) else { break };
            if cell.speed <= 0.0 || free - filter > enough {
                break;
            }
            filter = filter.max(3.0 * f64::from(cell.samples) * period);
            // A long cell brakes at its end only.
            let unbraked = (cell.unbraked() - gone) / cell.speed;
            if unbraked > 0.0 {
                free = time + unbraked;
            }
            time += (cell.length - gone) / cell.speed;
            gone = 0.0;
            // Where only the limits of this cell and the next one hold, nothing brakes for the end yet.
            let next = self.sent.cell(number + 1).map_or(0.0, |c| c.speed);
            let speed = if next < cell.speed { next } else { cell.speed };
            if next > 0.0 && cell.end >= UNBRAKED * speed * speed {
                free = time;
            }
        }
        free - filter
    }

    /// Returns the memory in use, in bytes.
    pub fn memory(&self) -> usize {
        let slots = usize::try_from(self.shared.cells.len()).unwrap_or(0);
        self.sent.memory() + slots * 8 * (CELL + CURVE)
    }
}

impl Path for Reader {
    fn cell(&self, number: u64) -> Option<Cell> {
        if !self.has(number) {
            return None;
        }
        // The end first: a reader that sees it raised sees the cells that it needs.
        Some(cell_from(&self.0.cells.read::<END>(number)?))
    }

    fn has(&self, number: u64) -> bool {
        let order = &self.0.order;
        number < order.count() && order.first() <= number
    }

    fn curve(&self, number: u64) -> Option<Curve> {
        Some(curve_from(self.0.curves.words(number)))
    }

    fn may_turn(&self, reverse: bool) -> bool {
        self.0.order.may_turn(reverse)
    }

    fn release(&self, oldest: u64) {
        self.0.order.release(oldest);
    }
}

const fn flags(cell: &Cell) -> u64 {
    (cell.line as u64) << 32 | (cell.samples as u64) << 1 | cell.stop as u64
}

const fn cell_words(c: &Cell) -> [u64; CELL] {
    [
        c.curve,
        c.from.to_bits(),
        c.length.to_bits(),
        c.speed.to_bits(),
        c.feed.to_bits(),
        c.rest.to_bits(),
        c.fade.to_bits(),
        c.end.to_bits(),
        c.begin.to_bits(),
        c.rapid.to_bits(),
        flags(c),
        (c.lead.to_bits() as u64) << 32 | c.linear.to_bits() as u64,
    ]
}

#[expect(clippy::cast_possible_truncation, reason = "as they were written")]
const fn cell_from(words: &[u64; CELL]) -> Cell {
    let [curve, from, length, speed, feed, rest, fade, end, begin, rapid, flags, leads] = *words;
    Cell {
        curve,
        from: f64::from_bits(from),
        length: f64::from_bits(length),
        speed: f64::from_bits(speed),
        feed: f64::from_bits(feed),
        rapid: f64::from_bits(rapid),
        lead: f32::from_bits((leads >> 32) as u32),
        linear: f32::from_bits(leads as u32),
        rest: f64::from_bits(rest),
        fade: f64::from_bits(fade),
        end: f64::from_bits(end),
        begin: f64::from_bits(begin),
        samples: (flags >> 1) as u16,
        stop: flags & 1 == 1,
        line: (flags >> 32) as u32,
    }
}

/// A curve as its kind and its numbers.
fn curve_words(curve: &Curve) -> [u64; CURVE] {
    let mut out = [0; CURVE];
    let mut slots = out.iter_mut();
    let mut put = |value: u64| {
        if let Some(slot) = slots.next() {
            *slot = value;
        }
    };
    match curve {
        Curve::Line { start, slope } => {
            put(0);
            start.0.iter().chain(&slope.0).for_each(|x| put(x.to_bits()));
        }
        Curve::Arc { center, arm, side, rate, drift } => {
            put(1);
            let all = center.0.iter().chain(&drift.0).chain(arm).chain(side).chain([rate]);
            all.for_each(|x| put(x.to_bits()));
        }
        Curve::Poly { c, length } => {
            put(2);
            c.iter().flat_map(|p| &p.0).chain([length]).for_each(|x| put(x.to_bits()));
        }
    }
    out
}

fn curve_from(mut rest: impl Iterator<Item = u64>) -> Curve {
    let kind = rest.next();
    let mut number = || rest.next().map_or(0.0, f64::from_bits);
    let mut pose = || Pose([0.0; AXES].map(|_: f64| number()));
    match kind {
        Some(0) => {
            let start = pose();
            Curve::Line { start, slope: pose() }
        }
        Some(1) => {
            let center = pose();
            let drift = pose();
            let arm = [0.0; 3].map(|_: f64| number());
            let side = [0.0; 3].map(|_: f64| number());
            Curve::Arc { center, arm, side, rate: number(), drift }
        }
        _ => {
            let c = [Pose::ZERO; 6].map(|_| pose());
            Curve::Poly { c, length: number() }
        }
    }
}
