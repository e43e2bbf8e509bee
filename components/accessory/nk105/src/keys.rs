//! Realtime. The effect of each key, and jogs.

use crate::{
    controller::{Controller, FAST, Medium, Mode, SLOW, STEP},
    panel::ScreenRow,
};
use hal_handheld::KeySet;

/// Number of OK.
const OK: u8 = 13;
/// Number of STOP.
const STOP: u8 = 14;
/// Numbers of X+, X-, Y+, Y-, Z+ and Z-.
const JOGS: [u8; 6] = [15, 16, 17, 18, 19, 20];
/// Largest feed override in percent.
const MOST_PERCENT: u32 = 150;

impl Controller {
    /// Does what a key does as it goes down.
    pub(crate) fn press(&mut self, key: u8, medium: &mut impl Medium) {
        if key == STOP {
            self.stop(medium);
            (self.menu, self.entry, self.message) =
                (None, ScreenRow::default(), ScreenRow::default());
            return;
        }
        self.message = ScreenRow::default();
        let is_idle = self.mode == Mode::Idle;
        match key {
            1..=12 if is_idle && self.menu.is_none() => {
                let character = b"1234567890.-".get(usize::from(key - 1));
                character.iter().for_each(|c| self.entry.push(**c));
            }
            OK => self.ok(medium),
            21 => self.run_or_pause(medium),
            22 if is_idle => {
                self.origin = self.place();
                self.say("ORIGIN");
            }
            23 if is_idle && self.menu.is_none() => {
                self.motion.go([0.0; 3], FAST);
                self.say("HOME");
            }
            24 if is_idle => {
                self.is_step = !self.is_step;
                let text = if self.is_step { "STEP 0.1" } else { "CONTINUOUS" };
                self.say(text);
            }
            25 | 26 => self.choose(key == 26, medium),
            27 if is_idle => self.has_spindle = !self.has_spindle,
            28 if is_idle => {
                self.is_fast = !self.is_fast;
                self.message =
                    ScreenRow::default().and_decimals(self.jog_speed(), 0, 0).and(" MM/S");
            }
            15..=20 if self.is_step && is_idle && self.menu.is_none() => self.step_jog(key),
            // A key that is down already when a job ends moves nothing.
            15..=20 if !self.is_step && !self.holds_medium() && self.menu.is_none() => {
                self.jogging = self.jogging.with(KeySet::of(key));
            }
            // SHIFT, and keys that have no effect in this mode.
            _ => {}
        }
    }

    const fn jog_speed(&self) -> f64 {
        if self.is_fast { FAST } else { SLOW }
    }

    fn ok(&mut self, medium: &mut impl Medium) {
        if let Some(index) = self.menu.take() {
            medium.open(index, self.origin);
            self.mode = Mode::Run;
            return;
        }
        if self.entry.is_empty() {
            return;
        }
        let percent = self.entry.text().parse().ok();
        match percent.filter(|n| (1..=MOST_PERCENT).contains(n)) {
            Some(percent) => {
                self.percent = percent;
                self.message = ScreenRow::of("FEED ").and_number(i64::from(percent), 0);
            }
            None => {
                self.message =
                    ScreenRow::of("1 TO ").and_number(MOST_PERCENT.into(), 0).and(" ONLY");
            }
        }
        self.entry = ScreenRow::default();
    }

    fn run_or_pause(&mut self, medium: &mut impl Medium) {
        match self.mode {
            Mode::Run => self.mode = Mode::Hold,
            Mode::Hold => self.mode = Mode::Run,
            Mode::Jog => {}
            Mode::Idle => {
                self.entry = ScreenRow::default();
                match medium.files() {
                    None => self.say("NO MEDIUM"),
                    Some(0) => self.say("NO FILES"),
                    Some(_) => self.menu = Some(0),
                }
            }
        }
    }

    fn choose(&mut self, is_next: bool, medium: &mut impl Medium) {
        let (Some(index), Some(count)) = (self.menu, medium.files()) else { return };
        let last = count.saturating_sub(1);
        self.menu = Some(match is_next {
            true if index < last => index + 1,
            true => 0,
            false if index > 0 => index - 1,
            false => last,
        });
    }

    /// Closes a menu whose medium is gone.
    pub(crate) fn check_menu(&mut self, medium: &mut impl Medium) {
        let Some(index) = self.menu else { return };
        match medium.files() {
            None | Some(0) => {
                self.menu = None;
                self.say("NO MEDIUM");
            }
            Some(count) if index >= count => self.menu = Some(0),
            Some(_) => {}
        }
    }

    fn step_jog(&mut self, key: u8) {
        let Some(at) = JOGS.iter().position(|jog| *jog == key) else { return };
        let mut to = self.place();
        if let Some(axis) = to.get_mut(at / 2) {
            *axis += if at % 2 == 0 { STEP } else { -STEP };
        }
        self.motion.go(to, self.jog_speed());
    }

    /// Moves as the keys say while no job runs.
    pub(crate) fn jog(&mut self, seconds: f64) {
        if self.motion.is_moving() {
            self.motion.follow(seconds, 1.0);
            self.mode = if self.motion.is_moving() { Mode::Jog } else { Mode::Idle };
            return;
        }
        let mut velocity = [0.0; 3];
        if self.menu.is_none() {
            let speed = self.jog_speed();
            for (axis, keys) in velocity.iter_mut().zip(JOGS.chunks_exact(2)) {
                let down = |at: usize| keys.get(at).is_some_and(|key| self.jogging.has(*key));
                *axis = f64::from(i8::from(down(0)) - i8::from(down(1))) * speed;
            }
        }
        let is_asked = velocity.iter().any(|v| *v != 0.0);
        if is_asked && !self.motion.jog(velocity, seconds) {
            self.say("LIMIT");
        }
        self.mode = if is_asked { Mode::Jog } else { Mode::Idle };
    }
}
