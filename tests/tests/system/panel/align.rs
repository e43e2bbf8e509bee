//! The page of alignment: live pictures with marks and the path, marks that are measured, a program that is rewritten.

use super::{fixture::Fixture, printer::Printer};
use hal_tests::{
    browser::{DESKTOP, PHONE},
    programs::root,
    schema::Document,
};
use serde_json::{Value, json};
use std::fs;

/// Waits until the page's picture is one that was taken after now.
const NEXT: &str = "window.seen = document.querySelector('canvas.camera').dataset.number";
const NEW: &str = "document.querySelector('canvas.camera').dataset.number !== window.seen";

/// Brightest and darkest dots of the picture near its middle, and whether one is of a colour that only the overlay has.
const DOTS: &str = "\
const c = document.querySelector('canvas.camera'); \
const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; \
const found = { pink: 0, green: 0, blue: 0, dark: 0, bright: 0 }; \
for (let i = 0; i < d.length; i += 4) { \
  const [r, g, b] = [d[i], d[i + 1], d[i + 2]]; \
  if (r > 230 && g < 130 && b > 130 && b < 200) found.pink++; \
  if (r < 90 && g > 200 && b < 160) found.green++; \
  if (r < 100 && g > 150 && g < 200 && b > 230) found.blue++; \
  if (r === g && g === b && r < 90) found.dark++; \
  if (r === g && g === b && r > 160) found.bright++; \
} \
return found";

/// Returns the status of the component.
fn status(fixture: &Fixture) -> Value {
    serde_json::from_str(&fixture.printer.halcmd("align.status json=TRUE")).unwrap()
}

#[test]
fn marks_are_found_measured_and_a_program_is_laid_on_them() {
    let Some(fixture) = Fixture::of("fiducial", DESKTOP) else { return };
    let b = &fixture.browser;
    fixture.ready();
    b.run("document.querySelector('[data-page=align]').click()");
    b.until("document.querySelectorAll('#marks-table tbody tr').length === 4");
    b.until("document.querySelector('canvas.camera').dataset.number");

    // Each mark is approached by a button that is held, centred by its picture, and measured.
    for mark in 1..=4 {
        let row = format!("#marks-table tr[data-mark=\"{mark}\"]");
        let aim = status(&fixture)["marks"][mark - 1]["aim"][0].as_f64().unwrap();
        let goes = format!(
            "Math.abs(Number(document.querySelector('#camera-state').textContent.match(/X (\\S+)/)[1]) - {aim:.3}) < 0.01"
        );
        fixture.hold(&format!("{row} button.hold"), &goes);
        fixture.rests();
        b.run(NEXT);
        b.until(NEW);
        b.until("document.querySelector('canvas.camera').dataset.marks !== '0'");
        if mark == 1 {
            fixture.picture("align-found");
        }
        b.click(&format!("{row} button:not(.hold)"));
        b.until(&format!("document.querySelectorAll('{row} td')[1].textContent !== '—'"));
    }
    let dots = b.run(DOTS);
    let count = |of: &str| dots[of].as_u64().unwrap();
    assert!(count("green") > 100, "the mark found is marked: {dots}");
    assert!(count("blue") > 50, "the mark expected is marked: {dots}");
    assert!(
        count("dark") > 10_000 && count("bright") > 100_000,
        "the picture is the plate's: {dots}"
    );

    // The place of the part, with its residuals.
    b.click("#marks-solve");
    b.until("document.querySelectorAll('#marks-fit tr').length === 7");
    let fit = b.text("#marks-fit");
    assert!(fit.contains("affine") && fit.contains("cannot hold it"), "{fit}");
    let status = status(&fixture);
    for (name, wanted, within) in [
        ("theta", 10.0, 0.005),
        ("sx", 1.2, 1e-4),
        ("sy", 1.1, 1e-4),
        ("shear", 0.5, 0.01),
        ("tx", 100.0, 0.01),
        ("ty", 50.0, 0.01),
    ] {
        let got = status["fit"][name].as_f64().unwrap();
        assert!((got - wanted).abs() <= within, "{name} is {got}");
    }
    for mark in status["marks"].as_array().unwrap() {
        let off =
            mark["residual"][0].as_f64().unwrap().hypot(mark["residual"][1].as_f64().unwrap());
        let within = mark["uncertainty"].as_f64().unwrap();
        assert!(off < 0.005 && 0.0 < within && within < 0.002, "{mark}");
    }

    // The program's path lies over the picture, on the printed outline: at the corner where it begins.
    let part = fs::read_to_string(root().join("configs/fiducial/part.ngc")).unwrap();
    fixture.printer.scratch.write("programs/part.ngc", part);
    b.run("[...document.querySelectorAll('#programs button')].at(-1).click()");
    b.until(
        "[...document.querySelectorAll('.files .plain')].some((f) => f.textContent === 'part.ngc')",
    );
    b.run("[...document.querySelectorAll('.files .plain')].find((f) => f.textContent === 'part.ngc').click()");
    b.until("document.querySelector('.file').textContent === 'part.ngc'");
    let place = |x: f64, y: f64| {
        let m: Vec<f64> =
            status["place"].as_array().unwrap().iter().map(|n| n.as_f64().unwrap()).collect();
        (m[0] * x + m[1] * y + m[4] + 35.2, m[2] * x + m[3] * y + m[5] - 12.4)
    };
    let (x, y) = place(30.0, 30.0);
    fixture.printer.halcmd("task.mode mode=mdi --wait");
    fixture.printer.halcmd(&format!("task.mdi text=G53G0X{x:.4}Y{y:.4} --wait"));
    b.until(&format!("document.querySelector('#camera-state').textContent.includes('X {x:.3}')"));
    b.until("document.querySelector('.listing li')");
    b.run(NEXT);
    b.until(NEW);
    fixture.picture("align-path");
    let dots = b.run(DOTS);
    assert!(dots["pink"].as_u64().unwrap() > 500, "the path is drawn: {dots}");
    b.run("document.querySelector('#camera-path').value = 'none'; document.querySelector('#camera-path').dispatchEvent(new Event('change'))");
    b.run(NEXT);
    b.until(NEW);
    let dots = b.run(DOTS);
    assert_eq!(dots["pink"], 0, "the path is hidden: {dots}");
    b.run("document.querySelector('#camera-path').value = 'auto'; document.querySelector('#camera-path').dispatchEvent(new Event('change'))");

    // The program is rewritten, stored and opened.
    b.click("#rewrite");
    b.until("document.querySelector('.file').textContent === 'uploads/aligned-part.ngc'");
    let text = fixture.printer.scratch.read("programs/uploads/aligned-part.ngc");
    assert!(text.contains("(aligned: turn 10.0") && text.contains("source part.ngc"), "{text}");
    assert!(b.text("#rewritten").contains("arcs became lines"));
    b.run("document.querySelector('#rewrite-arcs').value = 'refuse'");
    b.run("[...document.querySelectorAll('.files .plain')].find((f) => f.textContent === 'part.ngc').click()");
    b.until("document.querySelector('.file').textContent === 'part.ngc'");
    b.click("#rewrite");
    b.until("document.querySelector('#rewritten').textContent.includes('line 8')");

    // In Spanish and light, without an error.
    b.run("localStorage.setItem('ferrule-panel', JSON.stringify({ language: 'es', theme: 'light', page: 'align' })); location.reload()");
    b.until("document.querySelector('canvas.camera')?.dataset.number && document.querySelectorAll('#marks-fit tr').length === 7");
    assert_eq!(b.text("#camera-title").to_uppercase(), "CÁMARA");
    fixture.picture("align-es-light");
    assert_eq!(b.errors(), Vec::<String>::new());
}

#[test]
fn the_keyboard_alone_measures_a_mark_and_a_phone_shows_all() {
    let Some(fixture) = Fixture::of("fiducial", PHONE) else { return };
    let b = &fixture.browser;
    fixture.ready();
    b.run("document.querySelector('[data-page=align]').click()");
    b.until("document.querySelector('canvas.camera').dataset.number");
    let wide = "return document.documentElement.scrollWidth - document.documentElement.clientWidth";
    assert_eq!(b.run(wide), 0, "the page is wider than the screen");
    let space = " ";
    let row = "#marks-table tr[data-mark=\"1\"]";
    fixture.reach(&format!("{row} button.hold"));
    b.key(space, true);
    b.until("document.querySelector('canvas.camera').dataset.marks === '1'");
    b.key(space, false);
    fixture.rests();
    fixture.reach(&format!("{row} button:not(.hold)"));
    b.key(space, true);
    b.key(space, false);
    b.until(&format!("document.querySelectorAll('{row} td')[1].textContent !== '—'"));
    b.run("document.querySelector('#camera').scrollIntoView()");
    fixture.picture("align-phone");
    // Dark, and a camera that takes no picture: the page says so, and shows the last one as an old one.
    fixture.printer.halcmd("setp align.sim.stall TRUE");
    b.until("document.querySelector('#camera-state').textContent.includes('takes no picture')");
    let is_old = "return document.querySelector('canvas.camera').classList.contains('stale')";
    assert_eq!(b.run(is_old), true);
    fixture.printer.halcmd("setp align.sim.stall FALSE");
    fixture.printer.halcmd("setp align.sim.light 0");
    b.until("document.querySelector('#camera-state').textContent.includes('there is no mark')");
    assert_eq!(b.run(is_old), false);
    assert_eq!(b.errors(), Vec::<String>::new());
}

#[test]
fn pictures_come_through_the_panel_alone_and_by_rights() {
    let mut printer = Printer::of("fiducial", "viewer");
    let document = Document(
        serde_json::from_str(
            &fs::read_to_string(root().join("components/remote/panel/openapi.json")).unwrap(),
        )
        .unwrap(),
    );
    let viewer = printer.sign_in().headers();
    let get = |path: &str, headers: &str| printer.request("GET", path, headers, b"");
    let state = get("/api/v1/align", &viewer);
    assert_eq!(document.check(document.schema("Alignment"), &state.json()), Ok(()));
    let first = get("/api/v1/align/picture", &viewer);
    assert_eq!((first.status, first.header("content-type")), (200, Some("image/png")));
    let head = |answer: &hal_tests::web::Answer| -> Value {
        let text = answer.header("x-ferrule-view").unwrap();
        let mut bytes = Vec::new();
        let mut rest = text.bytes();
        while let Some(byte) = rest.next() {
            let hex: String = if byte == b'%' {
                rest.by_ref().take(2).map(char::from).collect()
            } else {
                String::new()
            };
            bytes.push(if hex.is_empty() { byte } else { u8::from_str_radix(&hex, 16).unwrap() });
        }
        serde_json::from_slice(&bytes).unwrap()
    };
    let number = head(&first)["number"].as_u64().unwrap();
    assert_eq!(
        (head(&first)["width"].clone(), head(&first)["height"].clone()),
        (json!(640), json!(480))
    );
    let second = get(&format!("/api/v1/align/picture?after={number}"), &viewer);
    assert!(head(&second)["number"].as_u64().unwrap() != number);
    assert_eq!(get("/api/v1/align/picture?after=-1", &viewer).status, 400);
    assert_eq!(get("/api/v1/align/picture", &printer.host()).status, 401);
    // A viewer rewrites nothing; an operator not without a place, and only programs.
    let post = |printer: &Printer, path: &str, headers: &str, body: &str| {
        let headers = format!("{headers}Content-Type: application/json\r\n");
        printer.request("POST", path, &headers, body.as_bytes())
    };
    printer.scratch.write("programs/a.ngc", "G21 G90 G1 X1 Y1 F100\nG2 X2 Y1 I0.5\nM2\n");
    let path = "/api/v1/programs/a.ngc/align";
    assert_eq!(post(&printer, path, &viewer, "{}").status, 403);
    printer.restart("operator", &[]);
    let operator = printer.sign_in().headers();
    assert_eq!(post(&printer, path, &operator, "{}").status, 409);
    for mark in [
        "x=0 y=0 machine-x=2 machine-y=1",
        "x=100 y=0 machine-x=112 machine-y=1",
        "x=0 y=50 machine-x=2 machine-y=51",
    ] {
        printer.halcmd(&format!("align.touch {mark}"));
    }
    printer.halcmd("align.solve --wait");
    for (path, body, status) in [
        (path, "{\"arcs\": \"bent\"}", 400),
        (path, "{", 400),
        ("/api/v1/programs/none.ngc/align", "{}", 404),
        ("/api/v1/programs/..%2Fa.ngc/align", "{}", 400),
        (path, "{\"arcs\": \"refuse\"}", 422),
        (path, "{\"arcs\": \"lines\"}", 200),
    ] {
        let answer = post(&printer, path, &operator, body);
        assert_eq!(answer.status, status, "{path} {body}: {answer:?}");
        if status == 200 {
            assert_eq!(document.check(document.schema("Rewritten"), &answer.json()), Ok(()));
        }
    }
    assert!(
        printer.scratch.read("programs/uploads/aligned-a.ngc").contains("G1 X3.1000 Y2.0000 F100")
    );
}
