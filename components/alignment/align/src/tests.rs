//! Jobs that are refused, and the bench without a machine.

use crate::{
    bench::{Bench, Failure, Look},
    eye::Station,
    job::MarkJob,
    pins::Results,
};
use hal_align::Vector;
use std::{fs, path::PathBuf};

/// Folder that is removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path =
            std::env::temp_dir().join(format!("ferrule-align-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn write(&self, name: &str, text: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        fs::write(&path, text).unwrap();
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).unwrap_or_default();
    }
}

#[test]
fn wrong_jobs_are_refused_with_their_place() {
    let folder = Folder::new("jobs");
    let job = "[JOB]\nMARK = 1 2\n";
    for (text, wanted) in [
        ("[JOB]\n", "[JOB] has no MARK = X Y"),
        ("[JOB]\nMARK = 1\n", ":2: [JOB]MARK = 1: 2 finite numbers are needed"),
        ("[JOB]\nSIZE = 0.5\n", ":2: [JOB]SIZE = 0.5: must be between 1 and 10"),
        ("[JOB]\nFRAMES = nan\n", ":2: [JOB]FRAMES = nan: 1 finite numbers are needed"),
        ("[JOB]\nKIND = star\n", ":2: [JOB]KIND = star: must be circle or square"),
        ("[JOB]\nCOLOUR = 1\n", ":2: [JOB]COLOUR = 1: has no meaning: MARK"),
        ("[CAMERA]\nSOURCE = eye\n", ":2: [CAMERA]SOURCE = eye: must be 'sim FILE'"),
        ("[CAMERA]\nSOURCE = files nowhere\n", "nowhere: No such file or directory"),
        ("[CAMERA]\nSOURCE = sim nowhere\n", "Could not open INI file"),
        ("[CAMERA]\nMATRIX = 1 1 1 1\n", ":2: [CAMERA]MATRIX = 1 1 1 1: the matrix has no inverse"),
    ] {
        let text =
            if text.starts_with("[CAMERA]") { format!("{text}{job}") } else { text.to_owned() };
        let path = folder.write("job.ini", text);
        let error = MarkJob::read(&path).err().unwrap();
        assert!(error.contains(wanted), "{error}, must contain {wanted}");
    }
}

const DEFAULT_STATION: Station =
    Station { x: 0.0, y: 0.0, light: 1.0, part_x: 0.0, part_y: 0.0, stalls: false };

const fn station(at: Vector) -> Station {
    Station { x: at.x, y: at.y, ..DEFAULT_STATION }
}

/// Takes the next picture of a look, as the worker does.
fn picture(bench: &mut Bench, look: &mut Look, station: &Station) -> Result<Option<bool>, Failure> {
    let mut camera = bench.lend();
    let searched = camera.search(station);
    bench.give_back(camera, searched, look)
}

#[test]
fn a_mark_is_measured_on_the_simulated_table() {
    let folder = Folder::new("table");
    folder.write(
        "table.conf",
        "[TABLE]\nMARK = circle 10 20 4\nNOISE = 3\nBLUR = 1\nOFFSET = -35.2 12.4\n",
    );
    let job = "[JOB]\nMARK = 10 20\nSIZE = 4\nFRAMES = 3\n[CAMERA]\nSOURCE = sim table.conf\nOFFSET = -35.2 12.4\n";
    let mut bench = Bench::default();
    bench.open(&folder.write("job.ini", job)).unwrap();
    let mut look = Look::default();
    let at = Vector::new(45.0, 8.0);
    let mut pictures = 0;
    while picture(&mut bench, &mut look, &station(at)).unwrap() == Some(false) {
        pictures += 1;
    }
    assert_eq!(pictures, 2);
    let mut results = Results::default();
    assert_eq!(bench.measure(&look, 2, at, &mut results), Err(Failure::NoSuchMark));
    bench.measure(&look, 1, at, &mut results).unwrap();
    assert!((results.x - 10.0).abs() < 1e-3 && (results.y - 20.0).abs() < 1e-3, "{results:?}");
    assert!((results.dx - 0.2).abs() < 1e-3 && (results.dy + 0.4).abs() < 1e-3, "{results:?}");
    bench.solve().unwrap();
    bench.report(1, &mut results);
    assert!(results.valid && results.live && results.marks == 1);
    assert!((results.aim_x - 45.2).abs() < 1e-3 && (results.aim_y - 7.6).abs() < 1e-3);
    // A dark table, a stalled camera, a wrong place.
    let mut look = Look::default();
    let dark = Station { light: 0.0, ..station(at) };
    assert_eq!(picture(&mut bench, &mut look, &dark), Err(Failure::NoMark));
    let stalled = Station { stalls: true, ..station(at) };
    assert_eq!(picture(&mut bench, &mut look, &stalled), Ok(None));
    assert_eq!(picture(&mut bench, &mut look, &DEFAULT_STATION), Err(Failure::NoMark));
    assert!(
        bench
            .status()
            .last()
            .unwrap()
            .contains("a circle of 200 pixels was expected: there is no mark")
    );
}

#[test]
fn pictures_of_a_folder_are_taken_in_their_order_and_garbage_is_named() {
    let folder = Folder::new("files");
    let table = b"[TABLE]\nMARK = circle 0 0 4\nPICTURE = 320 240\n";
    let table = hal_marks::Table::parse("t", table).unwrap();
    for n in 0..2_u32 {
        let at = Vector::new(0.1 * f64::from(n), 0.0);
        folder.write(&format!("{n}.png"), table.picture(at, Vector::ZERO, 1.0, 1).png());
    }
    folder.write("2.jpg", b"\xff\xd8\xff garbage");
    folder.write("notes.txt", b"no picture");
    let job = format!(
        "[JOB]\nMARK = 0 0\nSIZE = 4\nFRAMES = 1\n[CAMERA]\nSOURCE = files {}\n",
        folder.0.display()
    );
    let mut bench = Bench::default();
    bench.open(&folder.write("job.ini", job)).unwrap();
    let mut results = Results::default();
    for n in 0..2_u32 {
        let mut look = Look::default();
        assert_eq!(picture(&mut bench, &mut look, &DEFAULT_STATION), Ok(Some(true)));
        bench.measure(&look, 1, Vector::ZERO, &mut results).unwrap();
        assert!((results.x + 0.1 * f64::from(n)).abs() < 1e-3, "{}", results.x);
    }
    let mut look = Look::default();
    assert_eq!(picture(&mut bench, &mut look, &DEFAULT_STATION), Err(Failure::NoPicture));
    assert!(bench.status().last().unwrap().ends_with("2.jpg: the picture is cut off or broken"));
    assert_eq!(picture(&mut bench, &mut look, &DEFAULT_STATION), Ok(None));
}

/// Pictures for people come while they are asked for, from where the machine is, and change nothing that is measured.
#[test]
fn a_view_shows_the_marks_at_the_present_position_and_measures_nothing() {
    let folder = Folder::new("view");
    folder.write("table.conf", "[TABLE]\nMARK = square 10 20 4 0 12\nNOISE = 3\nBLUR = 1\n");
    let job = "[JOB]\nMARK = 10 20\nMARK = 60 20\nKIND = square\nSIZE = 4\nFRAMES = 3\n[CAMERA]\nSOURCE = sim table.conf\n";
    let file = folder.0.join("view");
    let measured = |watches: bool| {
        let mut bench = hal_bench::Bench::new();
        let job = format!("job={}", folder.write("job.ini", job).display());
        bench.load::<crate::Align>(&[&job]).unwrap();
        bench.set("align.pos-x", 10.5);
        bench.set("align.pos-y", 20.25);
        let pass = || {
            bench.pass(100_000_000);
            bench.run("align", 1_000_000);
            bench.work("align", 1).unwrap();
        };
        pass();
        assert!(!file.exists(), "nobody watches");
        let watch = [format!("file={}", file.display()), "seconds=0.5".to_owned()];
        for command in ["align.watch", "align.save"] {
            let why = bench.command_from_afar(command, &[&watch[0]]).unwrap_err();
            assert!(why.contains("not from afar"), "{command}: {why}");
        }
        if watches {
            bench.command("align.watch", &[&watch[0], &watch[1]]).unwrap();
            pass();
            pass();
        }
        bench.command("align.look", &["mark=1"]).unwrap();
        for _ in 0..8 {
            pass();
        }
        let status: serde_json::Value =
            serde_json::from_str(&bench.command("align.status", &["json=TRUE"]).unwrap()[0])
                .unwrap();
        status["marks"][0].clone()
    };
    let mark = measured(true);
    let view = fs::read(&file).unwrap();
    let end = view.iter().position(|b| *b == b'\n').unwrap();
    let head: serde_json::Value = serde_json::from_slice(&view[..end]).unwrap();
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    assert_eq!((&head["kind"], number(&head["at"][0])), (&"image/png".into(), 10.5));
    // The mark lies half a millimetre to the left and a quarter below the middle, at 0.02 mm to the pixel.
    let seen = &head["marks"][0];
    assert!((number(&seen["x"]) - 295.0).abs() < 0.1 && (number(&seen["y"]) - 252.5).abs() < 0.1);
    assert!((number(&seen["size"]) - 200.0).abs() < 1.0 && seen["is_chosen"] == true, "{seen}");
    assert!(number(&seen["uncertainty"]) < 0.02);
    let to: Vec<f64> = head["to_picture"].as_array().unwrap().iter().map(number).collect();
    let (x, y) = (to[0] * 10.0 + to[1] * 20.0 + to[4], to[2] * 10.0 + to[3] * 20.0 + to[5]);
    assert!((x - 295.0).abs() < 1e-6 && (y - 252.5).abs() < 1e-6, "{x} {y}");
    assert_eq!(hal_marks::Picture::decode(&view[end + 1..]).unwrap().width(), 640);
    // Five pictures at most in half a second, and the same measurement without them.
    assert!((2..=5).contains(&head["number"].as_u64().unwrap()), "{head}");
    fs::remove_file(&file).unwrap();
    assert_eq!(measured(false), mark);
}

/// Pictures that come within the camera's delay show the place before: they are skipped.
#[test]
fn live_pictures_of_the_time_before_are_skipped() {
    let folder = Folder::new("live");
    let table = b"[TABLE]\nMARK = circle 0 0 4\nPICTURE = 320 240\n";
    let table = hal_marks::Table::parse("t", table).unwrap();
    let pictures = folder.0.join("pictures");
    fs::create_dir(&pictures).unwrap();
    let job = "[JOB]\nMARK = 0 0\nSIZE = 4\nFRAMES = 5\n[CAMERA]\nSOURCE = live pictures\nTIMEOUT = 0.5\n";
    let job = format!("job={}", folder.write("job.ini", job).display());
    let mut bench = hal_bench::Bench::new();
    bench.load::<crate::Align>(&[&job]).unwrap();
    bench.set("align.still", true);
    // 25 pictures in a second; the camera is a second behind the machine, which stood 0.5 mm to the left.
    let pass = |n: u32| {
        let place = Vector::new(if n < 25 { -0.5 } else { 0.0 }, 0.0);
        let png = table.picture(place, Vector::ZERO, 1.0, u64::from(n)).png();
        fs::write(pictures.join(format!("{n:04}.png")), png).unwrap();
        bench.run("align", 1_000_000);
        bench.work("align", 1).unwrap();
        bench.pass(40_000_000);
    };
    bench.command("align.look", &["mark=1"]).unwrap();
    (0..40).for_each(pass);
    bench.run("align", 1_000_000);
    assert!(bench.get::<bool>("align.found") && !bench.get::<bool>("align.busy"));
    let x = bench.get::<f64>("align.x");
    assert!(x.abs() < 0.01, "{x}");
}

/// The bench is free while a picture is searched: status and touch do not wait for it.
#[test]
fn the_camera_is_lent_while_a_picture_is_searched() {
    let folder = Folder::new("lent");
    folder.write("table.conf", "[TABLE]\nMARK = circle 10 20 4\n");
    let job = "[JOB]\nMARK = 10 20\nSIZE = 4\nFRAMES = 1\n[CAMERA]\nSOURCE = sim table.conf\n";
    let bench = std::sync::Mutex::new(Bench::default());
    bench.lock().unwrap().open(&folder.write("job.ini", job)).unwrap();
    let mut camera = bench.lock().unwrap().lend();
    let searched = camera.search(&station(Vector::new(10.0, 20.0)));
    let state = bench.try_lock().unwrap().json();
    assert_eq!(state["camera"]["source"], "sim");
    let mark = hal_align::Mark { file: Vector::ZERO, machine: Vector::new(1.0, 2.0) };
    bench.try_lock().unwrap().touch(mark).unwrap();
    let mut look = Look::default();
    assert_eq!(bench.lock().unwrap().give_back(camera, searched, &mut look), Ok(Some(true)));
}

/// The expected place of a mark changes with each mark before it.
#[test]
fn the_guess_follows_the_marks() {
    let folder = Folder::new("guess");
    let job = "[JOB]\nMARK = 0 0\nMARK = 100 0\n";
    let mut bench = Bench::default();
    bench.open(&folder.write("job.ini", job)).unwrap();
    let aim = |bench: &mut Bench| {
        let mut results = Results::default();
        bench.report(2, &mut results);
        let aim = (results.aim_x, results.aim_y);
        assert_eq!(bench.json()["marks"][1]["aim"], serde_json::json!([aim.0, aim.1]));
        aim
    };
    let touch = |bench: &mut Bench, file: Vector, machine: Vector| {
        bench.touch(hal_align::Mark { file, machine }).unwrap();
    };
    assert_eq!(aim(&mut bench), (100.0, 0.0));
    touch(&mut bench, Vector::ZERO, Vector::new(5.0, 6.0));
    assert_eq!(aim(&mut bench), (105.0, 6.0));
    touch(&mut bench, Vector::new(0.0, 50.0), Vector::new(5.0, 106.0));
    let (x, y) = aim(&mut bench);
    assert!((x - 205.0).abs() < 1e-9 && (y - 6.0).abs() < 1e-9, "{x} {y}");
    bench.clear();
    assert_eq!(aim(&mut bench), (100.0, 0.0));
}

/// The worker has not run yet.
#[test]
fn results_begin_with_the_values_of_their_pins() {
    let mut bench = hal_bench::Bench::new();
    bench.load::<crate::Align>(&[]).unwrap();
    let scales = || (bench.get::<f64>("align.sx"), bench.get::<f64>("align.sy"));
    assert_eq!(scales(), (1.0, 1.0));
    bench.run("align", 1_000_000);
    assert_eq!(scales(), (1.0, 1.0));
    bench.work("align", 1).unwrap();
    bench.run("align", 1_000_000);
    assert_eq!(scales(), (1.0, 1.0));
}

/// A look whose machine moves already takes no picture from the next one.
#[test]
fn a_look_of_a_moving_machine_takes_no_picture() {
    let folder = Folder::new("moves");
    let table = b"[TABLE]\nMARK = circle 0 0 4\nPICTURE = 320 240\n";
    let table = hal_marks::Table::parse("t", table).unwrap();
    let pictures = folder.0.join("pictures");
    fs::create_dir(&pictures).unwrap();
    let png = table.picture(Vector::ZERO, Vector::ZERO, 1.0, 1).png();
    fs::write(pictures.join("only.png"), png).unwrap();
    let job = "[JOB]\nMARK = 0 0\nSIZE = 4\nFRAMES = 1\n[CAMERA]\nSOURCE = files pictures\n";
    let job = format!("job={}", folder.write("job.ini", job).display());
    let mut bench = hal_bench::Bench::new();
    bench.load::<crate::Align>(&[&job]).unwrap();
    let error = |is_still: bool| {
        bench.set("align.still", is_still);
        bench.command("align.look", &["mark=1"]).unwrap();
        for _ in 0..3 {
            bench.run("align", 1_000_000);
            bench.work("align", 1).unwrap();
            bench.pass(10_000_000);
        }
        bench.get::<i32>("align.error")
    };
    assert_eq!(error(false), Failure::Moved as i32);
    assert_eq!(error(true), 0);
    assert!(bench.get::<bool>("align.found"));
}
