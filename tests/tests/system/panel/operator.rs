//! The operator's page: a whole job by buttons and by keys, and the ends of jogs.

use super::fixture::Fixture;
use hal_tests::{browser::DESKTOP, scratch::until};

/// A program with two tools and moves of some seconds.
const PART: &str = "\
G21 G90 G94 G54
T1 M6
G0 X10 Y10 Z5
G1 Z-2 F300
G1 X60 F1200
Y60
X10
Y10
G0 Z5
T2 M6
G1 X100 Y100 F3000
G0 X0 Y0
M2
";

/// Uploads a program and opens it.
pub(super) fn open(fixture: &Fixture, name: &str, text: &str) {
    let b = &fixture.browser;
    fixture.printer.scratch.write(name, text);
    b.fill("#upload", fixture.printer.scratch.path().join(name).to_str().unwrap());
    choose(fixture, &format!("uploads/{name}"));
    assert_eq!(fixture.printer.scratch.read(&format!("programs/uploads/{name}")), text);
    b.until(&format!("document.querySelector('.file').textContent === 'uploads/{name}'"));
}

/// Presses a name in the list of programs as soon as it is there.
pub(super) fn choose(fixture: &Fixture, name: &str) {
    let b = &fixture.browser;
    let found = format!(
        "[...document.querySelectorAll('.files .plain')].find((f) => f.textContent === '{name}')"
    );
    b.until(&found);
    b.run(&format!("{found}.click()"));
}

/// Sets the override of feeds or of rapid moves in the page, and waits until the task has it.
fn override_to(fixture: &Fixture, kind: &str, percent: u32) {
    let script = format!(
        "const f = document.querySelector('#{kind}-override'); f.value = {percent}; \
         f.dispatchEvent(new Event('input'))"
    );
    until_override(fixture, kind, percent, &script);
}

/// Runs a script in the page, and waits until the task has the override.
fn until_override(fixture: &Fixture, kind: &str, percent: u32, script: &str) {
    // Receives changes only.
    let mut viewer = fixture.printer.sign_in().socket();
    fixture.browser.run(script);
    let field = format!("{kind}_override");
    let is_set = |m: &serde_json::Value| m["task"][&field] == f64::from(percent) / 100.0;
    assert!(viewer.wait(is_set).is_some(), "the {kind} override is {percent} %");
}

#[test]
fn a_desk_runs_a_job() {
    let Some(fixture) = Fixture::start(DESKTOP) else { return };
    let b = &fixture.browser;
    fixture.ready();

    // A short touch moves nothing; a hold moves until the release.
    b.until(
        "document.querySelector('.jog-X-plus') && !document.querySelector('.jog-X-plus').disabled",
    );
    let x = || fixture.printer.number("getp joint.0.pos-cmd");
    fixture.tap(".jog-X-plus");
    assert_eq!(x(), 0.0, "a short touch");
    fixture.jog(".jog-X-plus", 0, 2.0);
    fixture.picture("job-jog");
    fixture.end_jog(".jog-X-plus");
    fixture.rests();

    // Rapid moves have an override of their own, up to 100 %.
    b.until("document.querySelector('#rapid-override').max === '100'");
    override_to(&fixture, "rapid", 25);
    b.until("document.querySelector('output[for=rapid-override]').textContent === '25 %'");
    b.until("document.querySelector('#feed-override').value === '100'");
    b.run("document.querySelector('#rapid-override').scrollIntoView({ block: 'center' })");
    fixture.picture("job-rapid");
    let full =
        "document.querySelector('#rapid-override').parentElement.querySelector('button').click()";
    until_override(&fixture, "rapid", 100, full);

    open(&fixture, "part.ngc", PART);
    fixture.picture("job-path");
    let (prompt, no_prompt) = (
        "!document.querySelector('#tool-prompt').hidden",
        "document.querySelector('#tool-prompt').hidden",
    );
    fixture.hold("#run-start", prompt);

    // The change of tool: the job waits until a person confirms. So slow a feed lasts until the pause, however busy the
    // computer is.
    fixture.picture("job-tool");
    override_to(&fixture, "feed", 2);
    fixture.hold("#tool-changed", no_prompt);

    // The pause, its end, and the override.
    fixture.in_job("document.querySelector('.listing .current')");
    b.click("#run-pause");
    fixture.in_job("!document.querySelector('#run-resume').hidden");
    until("motion rests", || fixture.printer.number("getp motion.current-vel") == 0.0);
    fixture.picture("job-paused");
    fixture.hold("#run-resume", "document.querySelector('#run-resume').hidden");
    override_to(&fixture, "feed", 100);

    // The second tool, then the end of the program.
    fixture.in_job(prompt);
    fixture.hold("#tool-changed", no_prompt);
    fixture.printer.job_ends();
    // A person at the machine may answer too.
    fixture.printer.halcmd("setp hal_manualtoolchange.change_button FALSE");
    b.until("document.querySelector('#run-state').textContent.length > 0 && document.querySelector('#run-start').disabled === false");

    // A second run that is stopped.
    fixture.hold("#run-start", "!document.querySelector('#run-stop').disabled");
    b.click("#run-stop");
    until("the job is aborted", || {
        fixture.printer.halcmd("task.status").contains("jobs=2 failed=1")
    });
    fixture.picture("job-stopped");
    assert_eq!(b.errors(), Vec::<String>::new());
}

#[test]
fn a_start_in_the_middle_is_shown_and_confirmed() {
    let Some(fixture) = Fixture::start(DESKTOP) else { return };
    let b = &fixture.browser;
    fixture.ready();
    let text = "G21 G90\nG1 X20 F3000\nY20\nX0\nY5\nM2\n";
    open(&fixture, "middle.ngc", text);
    b.run("document.querySelector('#run-start-at').open = true");
    let propose = |line: u32| {
        b.run(&format!("document.querySelector('#run-from-line').value = {line}"));
        b.click("#run-from");
        b.until("document.querySelector('#run-from-state').textContent === '' || !document.querySelector('#run-from-state').textContent.includes('nothing')");
    };
    // A line that is not there is refused in words, and offers nothing to confirm.
    propose(99);
    b.until("document.querySelector('#run-from-state').textContent.includes('99')");
    assert_eq!(b.run("return document.querySelector('#run-from-confirm').hidden"), true);

    propose(4);
    b.until("document.querySelector('#run-from-shown').textContent.includes('G21')");
    let shown = b.text("#run-from-shown");
    assert!(shown.contains("line 4 of middle.ngc") && shown.contains("Y 20.000"), "{shown}");
    let (x, y) = ("getp joint.0.pos-cmd", "getp joint.1.pos-cmd");
    assert_eq!((fixture.printer.number(x), fixture.printer.number(y)), (0.0, 0.0), "nothing moves");
    fixture.picture("start-at-line");
    // A file that is shown and is not the task's takes the proposal away, and none is made while it is.
    let confirm = "document.querySelector('#run-from-confirm')";
    open(&fixture, "plate.apt", "CUTTER/8\nGOTO/1,2,3\nFINI\n");
    b.until(&format!("{confirm}.hidden && {confirm}.disabled"));
    for button in ["#run-from", "#run-recover", "#run-start", "#run-step"] {
        assert_eq!(b.run(&format!("return document.querySelector('{button}').disabled")), true);
    }
    open(&fixture, "middle.ngc", text);
    b.until("!document.querySelector('#run-from').disabled && !document.querySelector('#run-recover').disabled");
    assert_eq!(b.run(&format!("return {confirm}.hidden")), true, "it does not come back");
    propose(4);
    b.until(&format!("!{confirm}.hidden && !{confirm}.disabled"));
    fixture.tap("#run-from-confirm");
    assert_eq!((fixture.printer.number(x), fixture.printer.number(y)), (0.0, 0.0), "a short touch");
    fixture.hold("#run-from-confirm", "document.querySelector('#run-from-confirm').hidden");
    fixture.printer.job_ends();
    assert_eq!((fixture.printer.number(x), fixture.printer.number(y)), (0.0, 5.0));
    assert_eq!(b.errors(), Vec::<String>::new());
}

#[test]
fn a_program_is_written_and_edited_in_the_page() {
    let Some(fixture) = Fixture::start(DESKTOP) else { return };
    let b = &fixture.browser;
    let file = || fixture.printer.scratch.read("programs/uploads/own.ngc");
    b.click("#program-new");
    b.fill("#editor-name", "own.ngc");
    b.fill("#editor-text", "G21 G90\nG1 X5 F600\nM2\n");
    fixture.picture("editor");
    b.click("#editor-save");
    b.until("!document.querySelector('dialog') && document.querySelector('.files .edit')");
    assert_eq!(file(), "G21 G90\nG1 X5 F600\nM2\n");
    // What is not saved is discarded the second time only.
    b.click(".files .edit");
    b.until("document.querySelector('#editor-text')?.value.startsWith('G21')");
    b.fill("#editor-text", "G0 Z1\n");
    b.click("#editor-cancel");
    b.until("document.querySelector('#editor-note').textContent.length > 0");
    b.click("#editor-cancel");
    b.until("!document.querySelector('dialog')");
    assert_eq!(file(), "G21 G90\nG1 X5 F600\nM2\n");
    // A wrong name is refused in words; ends of lines stay.
    fixture.printer.scratch.write("programs/uploads/own.ngc", "G21\r\nM2\r\n");
    b.click(".files .edit");
    b.until("document.querySelector('#editor-text')?.value === 'G21\\nM2\\n'");
    b.run("document.querySelector('#editor-name').value = '../own'");
    b.click("#editor-save");
    b.until("document.querySelector('#editor-note').textContent.includes('no name of a program')");
    b.run("document.querySelector('#editor-name').value = 'own.ngc'; document.querySelector('#editor-text').value = 'G20\\nM2\\n'");
    b.click("#editor-save");
    b.until("!document.querySelector('dialog')");
    assert_eq!(file(), "G20\r\nM2\r\n");
    // The machine's own program stays: what is edited of it is an upload.
    fixture.printer.scratch.write("programs/mine.ngc", "G21\nM2\n");
    b.run("[...document.querySelectorAll('#programs button')].at(-1).click()");
    b.until("document.querySelectorAll('.files .edit').length === 2");
    b.run("document.querySelector('.files .edit').click()");
    b.until("document.querySelector('#editor-text')?.value === 'G21\\nM2\\n'");
    b.run("document.querySelector('#editor-text').value = 'G20\\nM2\\n'");
    b.click("#editor-save");
    b.until("!document.querySelector('dialog')");
    let read = |name: &str| fixture.printer.scratch.read(&format!("programs/{name}"));
    assert_eq!((&*read("mine.ngc"), &*read("uploads/mine.ngc")), ("G21\nM2\n", "G20\nM2\n"));
    // What programs have written is listed, and stored on this computer by a press.
    std::fs::create_dir_all(fixture.printer.scratch.path().join("output/probes")).unwrap();
    fixture.printer.scratch.write("output/probes/a.txt", "1 2 3\n");
    b.click("#output-open");
    b.until("document.querySelector('#output .plain')?.textContent === 'probes/a.txt'");
    b.click("#output .plain");
    assert_eq!(b.errors(), Vec::<String>::new());
}

#[test]
fn an_open_program_is_reloaded_after_a_save_and_after_a_rebuild() {
    let Some(fixture) = Fixture::start(DESKTOP) else { return };
    let b = &fixture.browser;
    fixture.ready();
    open(&fixture, "again.ngc", "G21 G90\nG1 X5 F600\nM2\n");
    let shows = |line: &str| {
        b.until(&format!("document.querySelector('.listing').textContent.includes('{line}')"));
    };
    shows("X5");
    b.until("Number(document.querySelector('.view').dataset.points) > 0");
    let points = b.run("return Number(document.querySelector('.view').dataset.points)");
    let file = fixture.printer.scratch.path().join("again.ngc");
    fixture.printer.scratch.write("again.ngc", "G21 G90\nG1 X7 F600\nY7\nX0\nY0\nM2\n");
    b.fill("#upload", file.to_str().unwrap());
    shows("X7");
    b.until(&format!("Number(document.querySelector('.view').dataset.points) > {points}"));
    b.run("document.querySelector('.view').id = 'before'");
    b.click("#theme");
    b.until("!document.querySelector('#before')");
    shows("X7");
    b.until("Number(document.querySelector('.view').dataset.points) > 0");
    assert_eq!(b.errors(), Vec::<String>::new());
}

#[test]
fn offsets_are_in_units_of_the_page_whatever_those_of_the_program() {
    let Some(fixture) = Fixture::start(DESKTOP) else { return };
    let b = &fixture.browser;
    fixture.ready();
    // The program's unit is the inch, the machine's and the page's the millimetre.
    b.fill("#mdi-line", "G20\u{e007}");
    until("G20 is in force", || fixture.printer.halcmd("task.status").contains("G20"));
    b.run("document.querySelector('#touch-off-value').value = 10");
    let mut viewer = fixture.printer.sign_in().socket();
    fixture.hold(
        "[aria-label=\"Touch off X\"]",
        "document.querySelector('#offsets td')?.textContent === '-10.000'",
    );
    let is_set = |m: &serde_json::Value| {
        m["task"]["g5x_offset"][0].as_f64().is_some_and(|x| (x + 10.0).abs() < 1e-9)
    };
    assert!(viewer.wait(is_set).is_some());

    // The tool table is changed by the machine, and the file has it.
    b.run("document.querySelector('#tools details').open = true");
    b.until("document.querySelector('#tools [data-tool] button')");
    let too_wide =
        "return document.documentElement.scrollWidth - document.documentElement.clientWidth";
    assert_eq!(b.run(too_wide), 0, "the table is wider than its card");
    b.click("#tools [data-tool='1'] button");
    b.run("document.querySelector('dialog [name=z]').value = 12.5; document.querySelector('dialog [name=diameter]').value = 6");
    fixture.picture("tool-edit");
    b.click("dialog button[type=submit]");
    let cell = |n: u32| {
        format!("document.querySelectorAll('#tools [data-tool=\"1\"] td')[{n}].textContent")
    };
    b.until(&format!("{} === '12.500' && {} === '6.000'", cell(2), cell(4)));
    assert_eq!(b.errors(), Vec::<String>::new());
}

#[test]
fn the_keyboard_alone_runs_a_job() {
    let Some(fixture) = Fixture::start(DESKTOP) else { return };
    let b = &fixture.browser;
    let space = " ";
    // Space is held on an element that Tab reaches.
    let hold = |selector: &str, done: &str| {
        fixture.reach(selector);
        b.key(space, true);
        b.until(done);
        b.key(space, false);
    };
    fixture.reach("#lease");
    b.key(space, true);
    b.key(space, false);
    b.until("document.querySelector('#lease').getAttribute('aria-pressed') === 'true'");
    hold("#estop-reset", "document.querySelector('#machine-state').dataset.state === 'off'");
    hold("#power-on", "document.querySelector('#machine-state').dataset.state === 'on'");
    hold("#home-all", "document.querySelector('.jog-X-plus').checkVisibility()");

    // Keys jog while their mode is on; Escape ends it.
    fixture.reach("#jog-keys");
    b.key(space, true);
    b.key(space, false);
    b.until("document.body.classList.contains('keys-jog')");
    let x = || fixture.printer.number("getp joint.0.pos-cmd");
    let before = x();
    until("the key moves X", || {
        b.key("\u{e014}", true);
        let has_moved = before < x();
        b.key("\u{e014}", false);
        has_moved
    });
    fixture.rests();
    b.key("\u{e00c}", true);
    b.key("\u{e00c}", false);
    b.until("!document.body.classList.contains('keys-jog')");

    open(&fixture, "short.ngc", "G21 G90\nG1 X5 Y5 F600\nM2\n");
    hold("#run-start", "!document.querySelector('#run-stop').disabled");
    fixture.printer.job_ends();
}

#[test]
fn a_jog_ends_with_what_held_it() {
    let Some(fixture) = Fixture::start(DESKTOP) else { return };
    let b = &fixture.browser;
    fixture.ready();
    let cuts = [
        ("blur", "window.dispatchEvent(new Event('blur'))"),
        (
            "a hidden page",
            "Object.defineProperty(document, 'hidden', { value: true, configurable: true }); document.dispatchEvent(new Event('visibilitychange')); delete document.hidden",
        ),
        (
            "pointercancel",
            "document.querySelector('.jog-X-plus').dispatchEvent(new PointerEvent('pointercancel', { pointerId: window.lastPointer }))",
        ),
        (
            "the other face of the page",
            "document.querySelector('[data-page=integrate]').click(); document.querySelector('[data-page=operate]').click()",
        ),
    ];
    b.run(
        "window.addEventListener('pointerdown', (e) => { window.lastPointer = e.pointerId }, true); \
         const send = WebSocket.prototype.send; window.sent = []; \
         WebSocket.prototype.send = function (text) { window.sent.push(JSON.parse(text).name); send.call(this, text) }",
    );
    for (name, cut) in cuts {
        // Where the computer is too busy, the dead man ends the jog before the cut: then once more.
        until("a jog lasts until its cut", || {
            b.run("window.sent = []");
            b.press(".jog-X-plus");
            b.until("window.sent.includes('jog')");
            let ended =
                b.run(&format!("const e = window.sent.includes('jog-stop'); {cut}; return e"));
            if ended == true {
                b.release();
            }
            ended == false
        });
        b.until("window.sent.includes('jog-stop')");
        fixture.rests();
        let x = fixture.printer.number("getp joint.0.pos-cmd");
        // What still holds the button begins nothing again.
        b.release();
        b.run("window.sent = []");
        fixture.tap(".jog-Y-plus");
        assert_eq!(b.run("return window.sent.includes('jog')"), false, "{name}");
        assert_eq!(fixture.printer.number("getp joint.0.pos-cmd").to_bits(), x.to_bits(), "{name}");
    }
}
