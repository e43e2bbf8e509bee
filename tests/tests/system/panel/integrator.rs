//! The integrator's page: a pin is found, watched, set and scoped; the wiring shows live values.

use super::fixture::Fixture;
use hal_tests::{
    browser::{DESKTOP, PHONE},
    scratch::until,
};

#[test]
fn a_pin_is_watched_and_set() {
    let Some(fixture) = Fixture::start(DESKTOP) else { return };
    let b = &fixture.browser;
    fixture.ready();
    b.run("document.querySelector('[data-page=integrate]').click()");

    // The search finds a pin, the list watches it, and the dialog sets another.
    b.fill("#tree-search", "axis.0.motor-pos-cmd");
    b.until("document.querySelectorAll('[data-kind=pins] li').length === 1");
    b.click("[data-kind=pins] li button");
    let value = "document.querySelector('[data-name=\"axis.0.motor-pos-cmd\"] td')?.textContent";
    b.until(&format!("{value} === '0'"));
    fixture.printer.halcmd("motion.jog joint=0 velocity=40 position=3 --wait");
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
        (fixture.printer.number("getp stepgen.0.maxaccel") - 1234.0).abs() < 1e-9
    });
    fixture.picture("watch");
    assert_eq!(b.errors(), Vec::<String>::new());
}

#[test]
fn the_order_of_functions_and_the_flight_recorder_are_shown() {
    let Some(fixture) = Fixture::start(DESKTOP) else { return };
    let b = &fixture.browser;
    fixture.ready();
    b.run("document.querySelector('[data-page=integrate]').click()");
    b.until("document.querySelector('#order')");
    b.run("document.querySelector('#order').scrollIntoView()");
    // In a thread the functions stand as addf put them; a path says how long a value takes.
    b.until("document.querySelectorAll('#order ol li').length > 6");
    let functs = b.run("return [...document.querySelectorAll('#order > .answer > details')].map((d) => [...d.querySelector('ol').children].map((l) => l.firstChild.textContent).join(' ')).join('; ')");
    assert_eq!(
        functs,
        "viagpio.read stepgen.make-pulses viagpio.write; \
         stepgen.capture-position motion-command-handler remote motion-controller stepgen.update-freq"
    );
    b.until("document.querySelector('#order').textContent.includes('motion-controller → viagpio.write 100 µs')");
    fixture.picture("order");
    // An e-stop is an event that the flight recorder keeps.
    fixture.printer.halcmd("flight on size=1M");
    fixture.printer.halcmd("task.estop");
    b.run("document.querySelector('#flight').scrollIntoView()");
    // The card may have been seen, and have asked, before the recorder was on.
    b.until(
        "document.querySelector('#flight button').click() || \
         document.querySelector('#flight li')?.textContent.includes('in memory')",
    );
    assert_eq!(b.run("return document.querySelectorAll('#flight td').length"), 4);
    assert_ne!(b.text("#flight td"), "0");
    fixture.picture("flight");
    assert_eq!(b.errors(), Vec::<String>::new());
}

#[test]
fn a_pin_is_scoped_with_a_trigger_and_the_wiring_lives() {
    let pin = "axis.0.motor-pos-cmd";
    let Some(fixture) = Fixture::start(DESKTOP) else { return };
    let b = &fixture.browser;
    fixture.ready();
    b.run("document.querySelector('[data-page=integrate]').click()");
    b.until("document.querySelector('#scope-thread').options.length > 1");

    // A trigger that cannot be read is refused in words.
    b.fill("#scope-names", pin);
    b.fill("#scope-trigger", "rises rises");
    b.click("#scope-start");
    b.until("document.querySelector('#scope-state').textContent.length > 10");
    b.run("document.querySelector('#scope-trigger').value = ''");

    // The move passes 1 mm in the middle of the capture.
    b.run("document.querySelector('#scope-seconds').value = 0.1; document.querySelector('#scope-before').value = 0.05");
    b.fill("#scope-trigger", &format!("{pin} rises through 1"));
    b.click("#scope-start");
    b.until("!document.querySelector('#scope-stop').disabled && document.querySelector('.plot').dataset.captures === '0'");
    fixture.printer.halcmd("motion.jog joint=0 velocity=40 position=3 --wait");
    b.until("Number(document.querySelector('.plot').dataset.captures) > 0");
    let cell = |n: u32| {
        let script = format!(
            "return Number(document.querySelectorAll('#scope tr[data-name] td')[{n}].textContent)"
        );
        b.run(&script).as_f64().unwrap()
    };
    assert!(cell(0) < 1.0 && 1.0 < cell(1), "from {} to {}", cell(0), cell(1));

    // Two cursors by the keyboard, on both sides of the middle: their values stand in the table.
    b.run("document.querySelector('.plot').focus()");
    b.key("\u{e012}", true);
    b.key("\u{e012}", false);
    b.key("\u{e008}", true);
    b.key("\u{e014}", true);
    b.key("\u{e014}", false);
    b.key("\u{e008}", false);
    b.until("/\\d s \\(.*Hz\\)/.test(document.querySelector('#scope caption').textContent)");
    assert!(cell(6) < cell(7), "A {} B {}", cell(6), cell(7));
    fixture.picture("scope-desktop");

    // The capture is exported as it is shown.
    b.run("window.saved = null; URL.createObjectURL = (blob) => { blob.text().then((text) => { window.saved = text; }); return 'blob:none'; }");
    b.run("HTMLAnchorElement.prototype.click = () => {}");
    b.click("#scope-export");
    b.until(&format!(
        "window.saved?.startsWith('time,{pin}\\n') && window.saved.split('\\n').length > 90"
    ));
    b.click("#scope-stop");
    b.until("!document.querySelector('#scope-start').disabled");

    // The name of a wire carries the value of its signal.
    b.fill("#graph-pattern", "xpos-*");
    b.run("document.querySelector('#graph').scrollIntoView(); document.querySelector('#graph-pattern').dispatchEvent(new Event('change'))");
    b.until("[...document.querySelectorAll('#graph text.label')].some((x) => / = -?\\d/.test(x.textContent))");
    fixture.picture("wiring-desktop");
    assert_eq!(b.errors(), Vec::<String>::new());
}

#[test]
fn a_phone_shows_a_stream_and_the_wiring() {
    let Some(fixture) = Fixture::start(PHONE) else { return };
    let b = &fixture.browser;
    b.run("document.querySelector('[data-page=integrate]').click()");
    b.run("document.querySelector('#scope-names').value = 'remote.pulse sig:xpos-cmd'; document.querySelector('#scope-start').click()");
    b.until("Number(document.querySelector('.plot').dataset.captures) > 3");
    b.run("document.querySelector('#scope-start').scrollIntoView()");
    fixture.picture("scope-phone");
    b.run("document.querySelector('#graph').scrollIntoView()");
    b.until("document.querySelector('#graph text.label')");
    fixture.picture("wiring-phone");
    b.run("document.querySelector('#scope-stop').click()");
    b.until("!document.querySelector('#scope-start').disabled");
    let too_wide =
        "return document.documentElement.scrollWidth - document.documentElement.clientWidth";
    assert_eq!(b.run(too_wide), 0);
    assert_eq!(b.errors(), Vec::<String>::new());
}
