//! Cuts in a browser: tabs that are closed or hidden, and the browser that is killed.

use super::{FAR, PAGE_LEASE, REPEATS, Stage, WATCHED, judge::judge, unmoved};
use hal_tests::browser::{Browser, DESKTOP};

/// Cycles at a constant speed before a cut.
const BEFORE: usize = 40;

/// Ways in which a page goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tab {
    Closed,
    Hidden,
    Killed,
}

impl Tab {
    const fn name(self) -> &'static str {
        match self {
            Self::Closed => "tab closed",
            Self::Hidden => "tab hidden",
            Self::Killed => "browser killed",
        }
    }
}

impl Stage {
    /// Opens the page in a tab, takes the lease, and holds the button of X until it moves.
    fn jogging_page(&mut self, browser: &Browser) {
        for _ in 0..REPEATS {
            // A page that is there already would stay: the address differs by its token alone.
            browser.go("about:blank");
            browser.go(&self.printer.address());
            // A page that went gives up its lease when the panel sees it.
            browser.until(
                "document.querySelector('#lease-holder')?.textContent === 'nobody has control'",
            );
            browser.click("#lease");
            browser
                .until("document.querySelector('#lease').getAttribute('aria-pressed') === 'true'");
            let x = self.eye.look().map_or(0.0, |s| s.x);
            let button = if FAR < x { ".jog-X-minus" } else { ".jog-X-plus" };
            let there = format!("document.querySelector('{button}')");
            browser.until(&format!("{there} && {there}.checkVisibility() && !{there}.disabled"));
            browser.run("const v = document.querySelector('#jog-speed'); if (v) { v.value = v.max; v.dispatchEvent(new Event('input')); }");
            self.eye.forget();
            browser.press(button);
            if self.eye.moves(BEFORE) {
                return;
            }
            browser.release();
            self.repeated += 1;
        }
        panic!("no jog of the page lasts until its cut");
    }

    /// Cuts jogs in a browser so many times; without a browser none, by name.
    pub(super) fn tabs(&mut self, count: usize) {
        if !Browser::is_there() {
            return;
        }
        let mut browser = Browser::open(&self.printer.scratch, DESKTOP);
        let begun = self.rows.len();
        while self.rows.len() < begun + count {
            assert!(self.repeated < REPEATS, "jogs end before their cuts");
            let n = self.rows.len() - begun;
            let tab = [Tab::Closed, Tab::Hidden, Tab::Closed, Tab::Hidden, Tab::Killed][n % 5];
            let first = browser.tab();
            let own = browser.new_tab();
            self.jogging_page(&browser);
            self.eye.forget();
            let before = self.eye.look().unwrap();
            if before.v == 0.0 {
                self.repeated += 1;
                browser.release();
                browser.close_tab();
                browser.to_tab(&first);
                continue;
            }
            match tab {
                Tab::Closed => browser.close_tab(),
                Tab::Hidden => drop(browser.new_tab()),
                Tab::Killed => browser.kill(),
            }
            self.eye.look();
            let after = self.eye.seen.len();
            self.eye.rests();
            let row = judge(tab.name(), String::new(), self.eye.all(), after);
            self.add(row);
            self.eye.forget();
            let rest = self.eye.look().unwrap();
            match tab {
                Tab::Hidden => {
                    // The page is shown again, with its button still pressed.
                    browser.to_tab(&own);
                    browser.until("!document.hidden");
                    self.eye.pass(WATCHED);
                    browser.close_tab();
                    browser.to_tab(&first);
                }
                Tab::Closed => browser.to_tab(&first),
                Tab::Killed => browser = Browser::open(&self.printer.scratch, DESKTOP),
            }
            // A browser takes a while to begin.
            self.eye.pass(WATCHED);
            unmoved(tab.name(), rest, &self.eye.seen);
        }
    }
}

#[test]
fn a_page_that_goes_ends_its_jog() {
    if !Browser::is_there() {
        return;
    }
    let mut stage = Stage::set(2, PAGE_LEASE, None);
    stage.tabs(5);
    assert_eq!(stage.rows.len(), 5);
    stage.end("cuts-tabs.md");
}
