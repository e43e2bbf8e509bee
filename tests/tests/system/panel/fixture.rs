//! The printer, and a browser that shows its panel.

use super::printer::{LASTING, Printer};
use hal_tests::{
    browser::{Browser, Screen},
    scratch::until,
};
use std::path::PathBuf;

/// Looks at a joint that stands still, 10 ms and more apart, before its button is pressed again: many times the 150 ms
/// for which it is held before the jog begins.
const STILL: u32 = 100;

/// Looks in a second, where they take no time.
const SECOND: u32 = 100;

/// The browser with the page, and the machine that it shows.
#[derive(Debug)]
pub(super) struct Fixture {
    pub(super) browser: Browser,
    pub(super) printer: Printer,
}

impl Fixture {
    /// Starts the printer and its panel, and opens the page. `None` where there is no browser.
    pub(super) fn start(screen: Screen) -> Option<Self> {
        Self::of("printer", screen)
    }

    /// Starts another machine of `configs` and its panel, and opens the page. `None` where there is no browser.
    pub(super) fn of(machine: &str, screen: Screen) -> Option<Self> {
        Self::with(screen, || Printer::of(machine, "integrator"))
    }

    /// Opens the page of a machine and its panel. `None` where there is no browser.
    pub(super) fn with(screen: Screen, machine: impl FnOnce() -> Printer) -> Option<Self> {
        // First, because without it nothing else is of use.
        Browser::is_there().then_some(())?;
        let printer = machine();
        let browser = Browser::open(&printer.scratch, screen);
        browser.go(&printer.address());
        browser.until("document.querySelector('#machine-state')?.textContent");
        Some(Self { browser, printer })
    }

    /// Starts the robot behind its own controller and its panel, and opens the page. `None` where there is no browser.
    pub(super) fn robot(screen: Screen) -> Option<Self> {
        Browser::is_there().then_some(())?;
        let printer = Printer::robot("integrator", LASTING);
        let browser = Browser::open(&printer.scratch, screen);
        browser.go(&printer.address());
        browser.until("document.querySelector('#robot-state')?.textContent");
        Some(Self { browser, printer })
    }

    /// Waits until something is so.
    ///
    /// # Panics
    /// It is not in time, or a job has failed.
    fn wait(&self, what: &str, mut look: impl FnMut() -> bool) {
        let mut looks = 0;
        until(what, || {
            looks += 1;
            look() || {
                // Each time a program is started.
                if looks % SECOND == 0 {
                    let status = self.printer.scratch.halcmd(&["task.status"]).stdout;
                    assert!(!status.contains("failed=1"), "{what}: the job has failed: {status}");
                }
                false
            }
        });
    }

    /// Waits until an expression of the page is true while a job runs.
    pub(super) fn in_job(&self, expression: &str) {
        self.wait(expression, || {
            self.browser.run(&format!("return Boolean({expression})")) == true
        });
    }

    /// Waits until motion is at its end.
    pub(super) fn rests(&self) {
        self.wait("the machine stands", || {
            self.printer.halcmd("getp motion.in-position").trim() == "TRUE"
        });
    }

    /// Presses Tab until an element has the focus.
    pub(super) fn reach(&self, selector: &str) {
        let (b, tab) = (&self.browser, "\u{e004}");
        b.until(&format!("!document.querySelector('{selector}').disabled"));
        let is_there =
            format!("return document.activeElement === document.querySelector('{selector}')");
        for _ in 0..200 {
            if b.run(&is_there) == true {
                return;
            }
            b.key(tab, true);
            b.key(tab, false);
        }
        panic!("Tab does not reach {selector}");
    }

    /// Takes control, leaves e-stop, switches on and homes, all in the page.
    pub(super) fn ready(&self) {
        let b = &self.browser;
        b.click("#lease");
        b.until("document.querySelector('#lease').getAttribute('aria-pressed') === 'true'");
        let is =
            |state| format!("document.querySelector('#machine-state').dataset.state === '{state}'");
        self.hold("#estop-reset", &is("off"));
        self.hold("#power-on", &is("on"));
        self.hold("#home-all", "document.querySelector('.jog-X-plus')?.checkVisibility()");
        until("all joints are homed", || {
            self.printer.halcmd("getp motion.is-all-homed").trim() == "TRUE"
        });
    }

    /// Holds a button until what it does is `done`. Where the computer is so busy that the page sees the hold end before
    /// its time, the page itself begins it again: the button may vanish at any moment.
    pub(super) fn hold(&self, selector: &str, done: &str) {
        let b = &self.browser;
        let look = format!(
            "if ({done}) return true; \
             const to = document.querySelector('{selector}'); \
             if (to.checkVisibility() && !to.disabled && !to.classList.contains('holding')) \
                 for (const kind of ['pointerup', 'pointerdown']) \
                     to.dispatchEvent(new PointerEvent(kind, {{ pointerId: 9, button: 0, bubbles: true }})); \
             return false"
        );
        b.press(selector);
        self.wait(done, || b.run(&look) == true);
        b.release();
        b.run(&format!(
            "document.querySelector('{selector}') \
                 .dispatchEvent(new PointerEvent('pointerup', {{ pointerId: 9, button: 0, bubbles: true }}))"
        ));
    }

    /// Presses a jog button until a joint has moved so far. The dead man ends a jog where the computer is too busy to
    /// answer within its time; a person who sees it stand still for a while presses again.
    pub(super) fn jog(&self, button: &str, joint: u32, far: f64) {
        let x = || self.printer.number(&format!("getp joint.{joint}.pos-cmd"));
        let from = x();
        let (mut seen, mut looks) = (from, 0);
        self.browser.press(button);
        until("the jog moves", || {
            let now = x();
            looks = if now.to_bits() == seen.to_bits() { looks + 1 } else { 0 };
            seen = now;
            if looks == STILL {
                looks = 0;
                self.browser.run(&format!(
                    "const to = document.querySelector('{button}'); \
                     to.dispatchEvent(new Event('blur')); \
                     if (to.checkVisibility() && !to.disabled) \
                         to.dispatchEvent(new PointerEvent('pointerdown', {{ pointerId: 9, button: 0, bubbles: true }}))"
                ));
            }
            from + far < now
        });
    }

    /// Ends a jog: of the pointer, and of the press that the page repeated.
    pub(super) fn end_jog(&self, button: &str) {
        self.browser.release();
        self.browser
            .run(&format!("document.querySelector('{button}').dispatchEvent(new Event('blur'))"));
    }

    /// Touches an element for less time than any button is held, however busy the computer is.
    pub(super) fn tap(&self, selector: &str) {
        self.browser.run(&format!(
            "const to = document.querySelector('{selector}'); \
             for (const kind of ['pointerdown', 'pointerup']) \
             to.dispatchEvent(new PointerEvent(kind, {{ pointerId: 9, button: 0, bubbles: true }}))"
        ));
    }

    /// Keeps a picture of the page where `FERRULE_PICTURES` names a folder.
    pub(super) fn picture(&self, name: &str) {
        let Some(folder) = std::env::var_os("FERRULE_PICTURES") else { return };
        self.browser.picture(&PathBuf::from(folder).join(format!("{name}.png")));
    }
}
