//! The integrator's page: a pin is found, watched and set.

use super::stand::Stand;
use hal_tests::{browser::DESKTOP, scratch::until};

#[test]
fn a_pin_is_watched_and_set() {
    let Some(stand) = Stand::start(DESKTOP) else { return };
    let b = &stand.browser;
    stand.ready();
    b.run("document.querySelector('[data-page=integrate]').click()");

    // The search finds a pin, the list watches it, and the dialog sets another.
    b.fill("#tree-search", "axis.0.motor-pos-cmd");
    b.until("document.querySelectorAll('[data-kind=pins] li').length === 1");
    b.click("[data-kind=pins] li button");
    let value = "document.querySelector('[data-name=\"axis.0.motor-pos-cmd\"] td')?.textContent";
    b.until(&format!("{value} === '0'"));
    stand.printer.halcmd("motion.jog joint=0 velocity=40 position=3 --wait");
    b.until(&format!("Math.abs(Number({value}) - 3) < 1e-6"));

    b.run("document.querySelector('#tree-search').value = ''");
    b.fill("#tree-search", "stepgen.0.maxaccel");
    b.until("document.querySelectorAll('[data-kind=params] li').length === 1");
    b.run("document.querySelector('[data-kind=params]').open = true");
    b.click("[data-kind=params] li button");
    b.until("document.querySelector('[data-name=\"stepgen.0.maxaccel\"] td')?.textContent !== '…'");
    b.click("[data-name=\"stepgen.0.maxaccel\"] button");
    b.run("document.querySelector('dialog input').value = ''");
    b.fill("dialog input", "1234");
    b.click("dialog button[type=submit]");
    until("the parameter is set", || {
        (stand.printer.number("getp stepgen.0.maxaccel") - 1234.0).abs() < 1e-9
    });
    stand.picture("watch");
    assert_eq!(b.errors(), Vec::<String>::new());
}
