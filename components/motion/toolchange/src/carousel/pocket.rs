//! Realtime. Sensors that determine the pocket of a magazine at the spindle.

use hal_component::{Builder, Error, In, Out, ParamRo, ParamRw, Touch};

/// Distance from the middle of a pocket that still counts as its mark, in counts.
const AT_MARK: i32 = 2;

/// Encoding of the pocket by sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Encoding {
    Gray,
    Binary,
    Bcd,
    Single,
    Index,
    Edge,
    Counts,
}

impl Encoding {
    /// Returns the encoding that LinuxCNC takes for a word, and whether the word is its name. A word counts as the name
    /// that it begins with, and every other one, capitals among them, as `gray`.
    pub(super) fn of_word(word: &str) -> (Self, bool) {
        let all = [
            ("gray", Self::Gray),
            ("binary", Self::Binary),
            ("bcd", Self::Bcd),
            ("single", Self::Single),
            ("index", Self::Index),
            ("edge", Self::Edge),
            ("counts", Self::Counts),
        ];
        let found = all.into_iter().find(|(name, _)| word.starts_with(name));
        found.map_or((Self::Gray, word.is_empty()), |(name, it)| (it, word == name))
    }

    /// Returns whether the position is counted from a home that must be found.
    const fn counts_from_home(self) -> bool {
        matches!(self, Self::Index | Self::Edge | Self::Counts)
    }
}

/// Sensors of a magazine, and its position.
#[derive(Touch)]
pub(super) struct Pocket {
    strobe: In<bool>,
    parity: In<bool>,
    sense: Vec<In<bool>>,
    counts: In<i32>,
    scale: In<i32>,
    width: In<i32>,
    home_offset: In<i32>,
    unhome: In<bool>,
    parity_error: Out<bool>,
    current_position: Out<i32>,
    homed: Out<bool>,
    debounce: ParamRw<u32>,
    base_counts: ParamRo<i32>,
    counts_offset: ParamRo<i32>,
    #[state]
    encoding: Encoding,
    #[state]
    pockets: i32,
    #[state]
    odd: bool,
    /// Last value of `sense-1`.
    #[state]
    was: bool,
    /// A position that must persist before it counts, and the time that it has persisted.
    #[state]
    waiting: (i32, u32),
    /// Value of `unhome` in the previous run.
    #[state]
    unhomed: bool,
    /// True until the last counted pulse, or home, has ended.
    #[state]
    passed: bool,
    /// Mark of the alignment.
    #[state]
    mark: bool,
}

impl Pocket {
    pub(super) fn new(
        b: &mut Builder<'_>,
        name: &str,
        encoding: Encoding,
        pockets: i32,
        sensors: i32,
        odd: bool,
    ) -> Result<Self, Error> {
        let n = |pin: &str| format!("{name}.{pin}");
        let mut sense = Vec::new();
        for i in 0..sensors {
            let about = match (encoding, i) {
                (Encoding::Single, _) => format!("TRUE in pocket {}.", i + 1),
                (Encoding::Index | Encoding::Edge, 0) => "The index: TRUE at home.".to_owned(),
                (Encoding::Index, 1) => "A pulse for each pocket.".to_owned(),
                (Encoding::Edge, 1) => "Changes at each pocket.".to_owned(),
                (Encoding::Counts, 0) => "TRUE at home.".to_owned(),
                (Encoding::Counts | Encoding::Index | Encoding::Edge, _) => "Not used.".to_owned(),
                _ => format!("Bit {i} of the position."),
            };
            sense.push(b.item(&n(&format!("sense-{i}")), &about, false)?);
        }
        Ok(Self {
            strobe: b.item(&n("strobe"), "The position is valid, and the mark of the alignment.", true)?,
            parity: b.item(&n("parity"), "The parity bit of a code, where there is one.", false)?,
            sense,
            counts: b.item(&n("counts"), "Counts of an encoder or stepper.", 0)?,
            scale: b.item(&n("scale"), "Counts from pocket to pocket.", 100)?,
            width: b.item(
                &n("width"),
                "Counts within which a pocket is reached, half of them to each side. (0 in LinuxCNC 2.9.)",
                10,
            )?,
            home_offset: b.item(&n("home-offset"), "Counts from pocket 1 to home.", 0)?,
            unhome: b.item(&n("unhome"), "Forgets home.", false)?,
            parity_error: b.item(
                &n("parity-error"),
                "The code and its parity bit do not fit.",
                false,
            )?,
            current_position: b.item(
                &n("current-position"),
                "The pocket that was reached last, or what the code says; 0 before.",
                0,
            )?,
            homed: b.item(
                &n("homed"),
                "Home was found, with `encoding` `index`, `edge` or `counts`.",
                false,
            )?,
            debounce: b.item(
                &n("debounce"),
                "For how many runs a code must stay before it counts; 0: at once. (LinuxCNC 2.9 has \
                 it, and no use for it.)",
                0,
            )?,
            base_counts: b.item(
                &n("base-counts"),
                "`counts` at pocket 1. (LinuxCNC 2.9 does not have it.)",
                0,
            )?,
            counts_offset: b.item(
                &n("counts-offset"),
                "`counts` from pocket 1. (LinuxCNC 2.9 does not have it.)",
                0,
            )?,
            encoding,
            pockets,
            odd,
            was: false,
            waiting: (0, 0),
            unhomed: false,
            passed: false,
            mark: false,
        })
    }

    pub(super) fn pockets(&self) -> i32 {
        self.pockets
    }

    pub(super) fn position(&self) -> i32 {
        self.current_position.get()
    }

    /// Returns whether home must be found first.
    pub(super) fn is_lost(&self) -> bool {
        self.encoding.counts_from_home() && !self.homed.get()
    }

    /// Returns, with `encoding=counts`, the counts at a pocket that is approached in this direction.
    pub(super) fn counts_at(&self, target: i32, dir: i32) -> Option<f64> {
        if self.encoding != Encoding::Counts {
            return None;
        }
        let scale = f64::from(self.scale.get());
        let from = self.counts.get().wrapping_sub(self.base_counts.get());
        let last = f64::from(self.pockets);
        let way = f64::from(target.wrapping_sub(self.position())) * f64::from(dir);
        let way = (way - libm::floor(way / last) * last) * f64::from(dir);
        Some(
            f64::from(self.base_counts.get()) + (libm::rint(f64::from(from) / scale) + way) * scale,
        )
    }

    /// Returns the mark of the alignment.
    pub(super) fn mark(&self) -> bool {
        self.mark
    }

    fn sense(&self, i: usize) -> bool {
        self.sense.get(i).is_some_and(In::get)
    }

    /// Returns whether the magazine is at home.
    pub(super) fn is_home(&self, index_enable: bool) -> bool {
        let sensed = self.sense(0) && (self.encoding == Encoding::Counts || self.sense(1));
        (sensed && !self.passed) || !index_enable
    }

    /// Returns whether both sensors are TRUE.
    fn both(&self) -> bool {
        self.sense(0) && self.sense(1)
    }

    /// Records, while pockets pass, the signal that must end before the next one counts.
    pub(super) fn note(&mut self, seeks: bool) {
        match self.encoding {
            _ if seeks => self.passed = self.both(),
            Encoding::Index if self.homed.get() => self.passed = self.sense(1),
            _ => (),
        }
    }

    /// Sets the position to home.
    pub(super) fn found(&mut self) {
        self.homed.set(true);
        self.current_position.set(1);
        self.base_counts.set(self.counts.get().wrapping_sub(self.home_offset.get()));
    }

    /// Updates the position, while the magazine turns in this direction.
    pub(super) fn look(&mut self, dir: i32, turns: bool) {
        let code = self.sense.iter().rev().fold(0_u32, |code, s| code << 1 | u32::from(s.get()));
        match self.encoding {
            Encoding::Gray => self.read(gray(code)),
            Encoding::Binary => self.read(code),
            Encoding::Bcd => self.read(bcd(code)),
            Encoding::Single => {
                // The mark of the previous pocket: a mark is left and reached before its number.
                let pocket = usize::try_from(self.position()).unwrap_or(0);
                // Between pockets, LinuxCNC reads the pin before the first one instead.
                let between = self.parity.get();
                self.mark = pocket.checked_sub(1).map_or(between, |i| self.sense(i));
                if self.strobe.get() {
                    self.check(false);
                    self.steady(32_u32.wrapping_sub(code.leading_zeros()).cast_signed());
                }
            }
            Encoding::Index | Encoding::Edge => self.pulse(dir, turns),
            Encoding::Counts => {
                self.check(false);
                self.count();
            }
        }
        if self.unhome.get() && !self.unhomed {
            self.homed.set(false);
        }
        self.unhomed = self.unhome.get();
    }

    /// Handles a code.
    fn read(&mut self, code: u32) {
        self.mark = self.strobe.get();
        if !self.strobe.get() {
            return;
        }
        self.check(self.sense.iter().filter(|s| s.get()).count() % 2 == 1);
        self.steady(code.cast_signed());
    }

    /// Checks the parity of a code.
    fn check(&self, odd: bool) {
        if self.strobe.get() {
            self.parity_error.set((odd != self.parity.get()) != self.odd);
        }
    }

    /// Handles a position, which counts if it persists.
    fn steady(&mut self, position: i32) {
        let (before, runs) = self.waiting;
        let runs = if before == position { runs.saturating_add(1) } else { 0 };
        self.waiting = (position, runs);
        if runs >= self.debounce.get() {
            self.current_position.set(position);
        }
    }

    /// Handles a pulse, or the end of a pulse.
    fn pulse(&mut self, dir: i32, turns: bool) {
        self.check(false);
        self.mark = self.encoding == Encoding::Edge || self.sense(1);
        let now = self.sense(1);
        let edge = self.encoding == Encoding::Edge;
        let counts = if edge { now != self.was } else { now && !self.passed };
        self.was = now;
        if edge && self.homed.get() && self.strobe.get() {
            self.passed = self.both();
        }
        if counts && dir != 0 && (turns || edge) && self.strobe.get() && self.homed.get() {
            let next = self.position().wrapping_add(dir);
            let next = if next < 1 {
                self.pockets
            } else if next > self.pockets {
                1
            } else {
                next
            };
            self.current_position.set(next);
        }
    }

    /// Handles the counts of an encoder.
    fn count(&mut self) {
        self.mark = false;
        if !self.homed.get() {
            return;
        }
        let from = self.counts.get().wrapping_sub(self.base_counts.get());
        self.counts_offset.set(from);
        self.mark =
            from.checked_rem(self.scale.get()).is_some_and(|beside| beside.abs() <= AT_MARK);
        if !self.strobe.get() {
            return;
        }
        let (half, scale) = (f64::from(self.width.get()) / 2.0, f64::from(self.scale.get()));
        let pocket = libm::floor((f64::from(from) + half) / scale);
        if libm::fabs(f64::from(from) - pocket * scale) <= half {
            let last = f64::from(self.pockets);
            #[expect(clippy::cast_possible_truncation, reason = "less than the pockets")]
            let pocket = (pocket - libm::floor(pocket / last) * last) as i32;
            self.current_position.set(pocket.wrapping_add(1));
        }
    }
}

fn gray(code: u32) -> u32 {
    let mut all = code;
    for shift in [1, 2, 4, 8, 16] {
        all ^= all >> shift;
    }
    all
}

/// Decodes BCD: each four bits are a digit.
fn bcd(code: u32) -> u32 {
    (0..8)
        .rev()
        .fold(0, |sum: u32, digit| sum.wrapping_mul(10).wrapping_add(code >> (4 * digit) & 15))
}
