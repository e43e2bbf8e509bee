//! The stops of the page in a browser, by buttons and by keys, while a machine moves on the virtual clock.

use super::{
    cell,
    clients::Panel,
    data::{Control, Effect, Machine, Motion, controls, machines},
    judge, motion,
    rig::Rig,
};
use hal_protocol::{Link as _, Request};
use hal_tests::{
    browser::{Browser, DESKTOP},
    scratch::{Running, until},
};

/// Cycles for which nothing may move behind a stop.
const STAYS: usize = 500;
/// Keys, as the driver of the browser names them.
const F1: &str = "\u{e031}";
const ESCAPE: &str = "\u{e00c}";

/// Press of a person.
#[derive(Clone, Copy, Debug)]
enum Way {
    Button(&'static str),
    Key(&'static str),
}

/// Stops of the page: its name, what a person does, and the command of the panel whose rules count.
const WAYS: [(&str, Way, &str); 6] = [
    ("button E-STOP", Way::Button("#estop"), "estop"),
    ("button Abort", Way::Button("#abort"), "abort"),
    ("button Off", Way::Button("#power-off"), "off"),
    ("button Pause", Way::Button("#run-pause"), "pause"),
    ("key F1", Way::Key(F1), "estop"),
    ("key Escape", Way::Key(ESCAPE), "abort"),
];

/// A machine with its panel, and a browser that shows it.
struct Desk {
    rig: Rig,
    browser: Browser,
    _panel: Running,
}

impl Desk {
    fn of(machine: &Machine) -> Self {
        let mut rig = Rig::start(machine);
        let (panel, address) = {
            let Rig { scratch, client, machine, .. } = &mut rig;
            Panel::serve(scratch, machine.is_ini(), &mut || {
                client.call(Request::Run { ns: 10_000_000 }).unwrap();
            })
        };
        rig.skip();
        let browser = Browser::open(&rig.scratch, DESKTOP);
        browser.go(&address);
        let mut desk = Self { rig, browser, _panel: panel };
        desk.until("document.querySelector('#machine-state')?.textContent");
        desk
    }

    /// Waits until an expression of the page is true, while machine time passes as slowly as the computer's.
    fn until(&mut self, expression: &str) {
        let Self { rig, browser, .. } = self;
        until(expression, || {
            rig.run(1);
            browser.run(&format!("return Boolean({expression})")) == true
        });
    }

    /// Stops by the page; returns false where the page offers no such stop now.
    fn stop(&self, way: Way) -> bool {
        let b = &self.browser;
        match way {
            Way::Button(selector) => {
                let can = format!(
                    "const b = document.querySelector('{selector}'); if (b.disabled || b.hidden) return false; b.click(); return true"
                );
                b.run(&can) == true
            }
            Way::Key(key) => {
                b.key(key, true);
                b.key(key, false);
                true
            }
        }
    }

    /// Judges a stop of a motion; returns false where the page offers no such stop of it.
    fn cell(&mut self, way: Way, control: &Control, kind: Motion) -> Result<bool, String> {
        cell::ready(&mut self.rig)?;
        let moving = motion::begin(&mut self.rig, kind, false)?;
        // The page has seen that it moves.
        self.until("document.querySelector('#machine-state').dataset.state === 'on'");
        self.rig.forget();
        let is_offered = self.stop(way);
        if is_offered {
            let effect = control.effect(kind);
            let is_off = matches!(effect, Effect::Off(_));
            let rig = &mut self.rig;
            // How soon the press arrives is a matter of the computer's time, and not of the machine's.
            until("the stop has an effect", || {
                rig.run(1);
                let speed = moving.speeds(&rig.seen).pop().unwrap_or(moving.speed);
                if is_off { !rig.last().on } else { speed < moving.speed * 0.99 }
            });
            let keep = rig.seen.len().saturating_sub(3);
            rig.seen.drain(..keep);
            rig.run(STAYS);
            let seen = rig.seen.clone();
            if is_off {
                judge::off(&moving, &seen, 3)
            } else {
                judge::brake(&moving, &seen, 3, false)
            }?;
            rig.forget();
            rig.run(STAYS);
            judge::stays(&rig.seen, "behind the stop")?;
        }
        cell::clear_all(&mut self.rig)?;
        Ok(is_offered)
    }
}

/// Walks machines, stops of the page and motions.
fn walk(takes: impl Fn(&Machine, &str, Motion) -> bool) {
    if !Browser::is_there() {
        return;
    }
    let controls = controls();
    let (mut good, mut other, mut bad) = (0, Vec::new(), Vec::new());
    for machine in machines().into_iter().filter(|m| m.no_lease.is_none()) {
        let mut desk = None;
        for (name, way, command) in WAYS {
            let control = controls.iter().find(|c| c.panel.as_deref() == Some(command)).unwrap();
            for kind in Motion::ALL.into_iter().filter(|kind| takes(&machine, name, *kind)) {
                let cell = format!("{}, {name}, {}", machine.name, kind.name());
                match desk.get_or_insert_with(|| Desk::of(&machine)).cell(way, control, kind) {
                    Ok(true) => good += 1,
                    Ok(false) => other.push(cell),
                    Err(why) => {
                        bad.push(format!("{cell}: {why}"));
                        desk = None;
                    }
                }
                if machine.needs_fresh {
                    desk = None;
                }
            }
        }
    }
    println!("{good} stops by the page, {} that it does not offer, {} bad", other.len(), bad.len());
    println!("{}", other.join("\n"));
    assert!(bad.is_empty(), "{} cells are not as their rules say:\n{}", bad.len(), bad.join("\n"));
}

#[test]
fn keys_and_buttons_of_the_page_stop_machines_with_and_without_a_task() {
    walk(|machine, name, kind| {
        let is_mine = ["mill", "rs03n"].contains(&machine.name.as_str());
        is_mine
            && (kind == Motion::Jog) == name.starts_with("key")
            && kind != Motion::Homing
            && kind != Motion::Line
    });
}

#[test]
fn escape_that_closes_a_question_stops_nothing_and_f1_stops_while_somebody_types() {
    if !Browser::is_there() {
        return;
    }
    let machine = machines().into_iter().find(|m| m.name == "mill").unwrap();
    let mut desk = Desk::of(&machine);
    cell::ready(&mut desk.rig).unwrap();
    let moving = motion::begin(&mut desk.rig, Motion::Jog, false).unwrap();
    desk.until("document.querySelector('#machine-state').dataset.state === 'on'");
    desk.rig.forget();
    desk.browser.run(
        "const asks = document.createElement('dialog'); asks.id = 'asks'; asks.textContent = '?'; \
         document.body.append(asks); asks.showModal()",
    );
    assert!(desk.stop(Way::Key(ESCAPE)));
    desk.until("!document.querySelector('#asks').open");
    judge::on(&moving, &desk.rig.seen).unwrap();
    desk.browser.run(
        "const typed = document.createElement('input'); typed.id = 'typed'; \
         document.body.append(typed); typed.focus()",
    );
    assert!(desk.stop(Way::Key(F1)));
    desk.until("document.querySelector('#machine-state').dataset.state === 'estop'");
    assert!(!desk.rig.last().on);
    assert_eq!(desk.browser.errors(), Vec::<String>::new());
}

#[test]
#[ignore = "takes minutes: cargo test -p hal-tests --test system stops::page -- --ignored --nocapture"]
fn full_page() {
    walk(|_, _, _| true);
}
