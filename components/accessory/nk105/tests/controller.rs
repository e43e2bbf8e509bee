//! The closed loop without HAL: keys in frames, a screen from the bytes to the display.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use hal_handheld::{
    Decode, FrameFormat, FrameReader, KeySet, Keypad, Press, Screens, St7920,
    frame::Received,
    keys::number_of,
    screen::{QUIET_NS, row},
};
use hal_nk105::{
    Controller, JobStep, JobStop, Medium, Mode,
    controller::Next,
    job::{WrongJob, read},
    panel::ScreenRow,
};
use std::collections::VecDeque;

/// Medium with files in memory.
#[derive(Default)]
struct Files {
    files: Vec<(&'static str, &'static str)>,
    is_gone: bool,
    open: Option<VecDeque<JobStep>>,
    trouble: Option<JobStop>,
}

impl Medium for Files {
    fn files(&mut self) -> Option<u32> {
        (!self.is_gone).then(|| u32::try_from(self.files.len()).unwrap())
    }
    fn name(&mut self, index: u32) -> ScreenRow {
        ScreenRow::of(self.files[index as usize].0)
    }
    fn open(&mut self, index: u32, origin: [f64; 3]) {
        self.trouble = None;
        match read(self.files[index as usize].1.as_bytes(), origin, 500.0) {
            Ok(steps) => self.open = Some(steps.into()),
            Err(why @ WrongJob::Travel(_)) => self.trouble = Some(JobStop::Travel(why.line())),
            Err(why) => self.trouble = Some(JobStop::Line(why.line())),
        }
    }
    fn next(&mut self) -> Next {
        if let Some(why) = self.trouble {
            return Next::Failed(why);
        }
        if self.is_gone {
            return Next::Failed(JobStop::NoMedium);
        }
        self.open.as_mut().unwrap().pop_front().map_or(Next::End, Next::Step)
    }
    fn close(&mut self) {
        self.open = None;
    }
}

struct Rig {
    keypad: Keypad,
    waiting: VecDeque<Press>,
    held: KeySet,
    format: FrameFormat,
    reader: FrameReader,
    keys: Option<KeySet>,
    since: u32,
    is_cut: bool,
    controller: Controller,
    medium: Files,
    screens: Screens<St7920>,
    ms: u32,
}

impl Rig {
    fn new(files: &[(&'static str, &'static str)]) -> Self {
        let format = FrameFormat::default();
        let mut rig = Self {
            keypad: Keypad::default(),
            waiting: VecDeque::new(),
            held: KeySet::NONE,
            format,
            reader: FrameReader::new(format),
            keys: None,
            since: 0,
            is_cut: false,
            controller: Controller::default(),
            medium: Files { files: files.to_vec(), ..Files::default() },
            screens: Screens::new(St7920::default(), QUIET_NS),
            ms: 0,
        };
        rig.run(200);
        rig
    }

    /// Runs for some milliseconds.
    fn run(&mut self, ms: u32) {
        for _ in 0..ms {
            self.ms += 1;
            self.since += 1;
            if self.ms.is_multiple_of(20) && !self.is_cut {
                let keys = self.keypad.period(self.held, || self.waiting.pop_front());
                let (bytes, len) = self.format.encode(keys);
                for byte in &bytes[..len] {
                    if let Some(Received::Keys(keys)) = self.reader.feed(*byte) {
                        (self.keys, self.since) = (Some(keys), 0);
                    }
                }
            }
            if self.since > 60 {
                self.keys = None;
            }
            self.controller.cycle(0.001, self.keys, &mut self.medium);
            let mut bytes = Vec::new();
            if let Some(burst) = self.controller.panel().next() {
                bytes.extend_from_slice(burst.bytes());
                self.controller.panel().sent();
            }
            self.screens.feed(&bytes, i64::from(self.ms) * 1_000_000);
        }
    }

    fn keys(&mut self, names: &str) {
        let keys = names.split_whitespace().map(|name| Press::short(number_of(name).unwrap()));
        self.waiting.extend(keys);
        let count = u32::try_from(self.waiting.len()).unwrap();
        self.run(count * 100 + 160);
    }

    fn row(&self, n: usize) -> String {
        String::from_utf8(row(self.screens.text(), n).to_vec()).unwrap().trim_end().to_owned()
    }

    fn screen(&self) -> String {
        (0..4).map(|n| self.row(n)).collect::<Vec<_>>().join("/")
    }
}

#[test]
fn power_on_shows_zero() {
    assert_eq!(Rig::new(&[]).screen(), "X     0.000 IDLE/Y     0.000 F100/Z     0.000 T  1/");
}

#[test]
fn numbers_that_are_typed_appear_on_the_screen() {
    for text in ["1 2 3 4", "1 1 1 1", "- 0 . 5"] {
        let mut rig = Rig::new(&[]);
        rig.keys(text);
        assert_eq!(rig.row(3), text.replace(' ', ""));
        assert_eq!(rig.screens.decoder().errors(), 0);
    }
}

#[test]
fn the_feed_is_set_by_a_number_and_ok() {
    let mut rig = Rig::new(&[]);
    rig.keys("8 0 OK");
    assert_eq!((rig.row(1), rig.row(3)), ("Y     0.000 F80".to_owned(), "FEED 80".to_owned()));
    for wrong in
        ["0 OK", "1 5 1 OK", "- 5 OK", "1 . 5 OK", "9 9 9 9 9 9 9 9 9 9 9 9 9 9 9 9 9 9 OK"]
    {
        rig.keys(wrong);
        assert_eq!(
            (rig.row(1), rig.row(3)),
            ("Y     0.000 F80".to_owned(), "1 TO 150 ONLY".to_owned())
        );
    }
}

#[test]
fn a_held_key_jogs_and_its_release_stops() {
    let mut rig = Rig::new(&[]);
    rig.held = KeySet::of(15);
    rig.run(500);
    assert!(rig.row(0).ends_with("JOG"), "{}", rig.row(0));
    rig.held = KeySet::NONE;
    rig.run(200);
    let at = rig.controller.place()[0];
    assert!((24.0..26.0).contains(&at), "{at}");
    assert_eq!(rig.row(0), format!("X{at:10.3} IDLE"));
    rig.run(500);
    assert_eq!(rig.controller.place()[0], at);
}

#[test]
fn steps_speeds_origin_and_home() {
    let mut rig = Rig::new(&[]);
    rig.keys("MODE");
    assert_eq!(rig.row(3), "STEP 0.1");
    rig.keys("X+ X+ Y- Z+");
    assert_eq!(rig.screen(), "X     0.200 IDLE/Y    -0.100 F100/Z     0.100 T  1/");
    rig.keys("ORIGIN");
    assert_eq!(rig.screen(), "X     0.000 IDLE/Y     0.000 F100/Z     0.000 T  1/ORIGIN");
    rig.keys("HIGH");
    assert_eq!(rig.row(3), "5 MM/S");
    rig.keys("HOME");
    assert_eq!((rig.controller.place(), rig.row(0)), ([0.0; 3], "X    -0.200 IDLE".to_owned()));
    rig.keys("SPINDLE SHIFT");
    assert!(rig.controller.has_spindle());
}

#[test]
fn a_jog_ends_at_the_travel() {
    let mut rig = Rig::new(&[]);
    rig.held = KeySet::of(16);
    rig.run(11_000);
    assert_eq!((rig.row(0), rig.row(3)), ("X  -500.000 JOG".to_owned(), "LIMIT".to_owned()));
}

#[test]
fn without_frames_a_jog_ends_and_a_job_is_held() {
    let mut rig = Rig::new(&[("LONG.NC", "G1 X100 F600\nM30\n")]);
    rig.held = KeySet::of(15);
    rig.run(200);
    rig.is_cut = true;
    rig.run(200);
    let at = rig.controller.place();
    rig.run(200);
    assert_eq!((rig.controller.place(), rig.row(3)), (at, "NO HANDHELD".to_owned()));
    // The key that was held moves nothing when frames come again.
    rig.is_cut = false;
    rig.run(20);
    rig.held = KeySet::NONE;
    rig.run(100);
    rig.keys("RUN OK");
    assert_eq!(rig.controller.mode(), Mode::Run);
    rig.is_cut = true;
    rig.run(200);
    assert_eq!(rig.controller.mode(), Mode::Hold);
    rig.is_cut = false;
    rig.run(1000);
    assert_eq!(rig.controller.mode(), Mode::Hold, "nothing goes on by itself");
    rig.keys("RUN");
    assert_eq!(rig.controller.mode(), Mode::Run);
}

const SQUARE: &str = "G21 G90 G17\nT2 M6\nM3 S1000\nG0 X0 Y0 Z1\nG1 Z-1 F600\nX20\nY20\nG3 X0 Y20 I-10 J0\nG1 Y0\nG4 P0.5\nG0 Z1\nM5\nM30\n";

#[test]
fn a_job_is_chosen_and_runs_in_its_time() {
    let mut rig = Rig::new(&[("A.NC", "G0 X1\nM30\n"), ("SQUARE.NC", SQUARE), ("Z.NC", "M30\n")]);
    rig.keys("RUN");
    assert_eq!(rig.row(3), ">A.NC");
    rig.keys("UP");
    assert_eq!(rig.row(3), ">Z.NC");
    rig.keys("UP OK");
    rig.run(100);
    assert_eq!((&rig.row(0)[11..], rig.row(2).as_str()), (" RUN", "Z    -1.000 T  2"));
    let begin = rig.ms;
    while rig.controller.mode() == Mode::Run {
        rig.run(1);
    }
    // 91.4 mm at 10 mm/s, of which half a circle is 31.4 mm; half a second of rest.
    let took = rig.ms - begin;
    assert!((9_000..10_000).contains(&took), "{took} ms");
    rig.run(100);
    assert_eq!(rig.screen(), "X     0.000 IDLE/Y     0.000 F100/Z     1.000 T  2/DONE");
    assert!(!rig.controller.has_spindle());
}

#[test]
fn a_job_is_held_goes_on_and_is_stopped() {
    let mut rig = Rig::new(&[("A.NC", "G1 X50 F600\nM30\n")]);
    rig.keys("RUN OK");
    rig.run(1000);
    rig.keys("RUN");
    let at = rig.controller.place();
    assert_eq!(rig.row(0), format!("X{:10.3} HOLD", at[0]));
    rig.run(1000);
    assert_eq!(rig.controller.place(), at);
    rig.keys("RUN");
    assert_eq!(rig.controller.mode(), Mode::Run);
    // A jog key that is held while the job ends moves nothing afterwards.
    rig.held = KeySet::of(15);
    rig.run(100);
    rig.keys("STOP");
    let at = rig.controller.place();
    rig.run(1000);
    assert_eq!((rig.controller.place(), rig.controller.mode()), (at, Mode::Idle));
}

#[test]
fn m0_holds_until_run() {
    let mut rig = Rig::new(&[("A.NC", "G0 X1\nM0\nG0 X2\nM30\n")]);
    rig.keys("RUN OK");
    rig.run(500);
    assert_eq!(rig.row(0), "X     1.000 HOLD");
    rig.keys("RUN");
    assert_eq!((rig.row(0), rig.row(3)), ("X     2.000 IDLE".to_owned(), "DONE".to_owned()));
}

#[test]
fn jobs_that_cannot_run_say_why() {
    let check = |file: &'static str, expected: &str| {
        let mut rig = Rig::new(&[("A.NC", file)]);
        rig.keys("RUN OK");
        assert_eq!((rig.row(3).as_str(), rig.controller.place()), (expected, [0.0; 3]));
    };
    check("G0 X1\nG1 X2 F100\nG99999 X1\n", "ERR LINE 3");
    check("G21\nG0 X501\n", "LIMIT LINE 2");
    check("G38.2 X10 F100\n", "ERR LINE 1");
    check("G0 A10\n", "ERR LINE 1");
    check("\u{0}\u{1}garbage\n", "ERR LINE 1");
    let mut rig = Rig::new(&[]);
    rig.keys("RUN");
    assert_eq!(rig.row(3), "NO FILES");
    rig.medium.is_gone = true;
    rig.keys("RUN");
    assert_eq!(rig.row(3), "NO MEDIUM");
}

#[test]
fn a_medium_that_goes_ends_the_job() {
    let mut rig = Rig::new(&[("A.NC", "G1 X1 F60\nX2\nX3\nM30\n")]);
    rig.keys("RUN OK");
    rig.medium.is_gone = true;
    rig.run(5000);
    assert_eq!((rig.row(0), rig.row(3)), ("X     1.000 IDLE".to_owned(), "NO MEDIUM".to_owned()));
    // A menu closes, too.
    rig.medium.is_gone = false;
    rig.keys("RUN");
    rig.medium.is_gone = true;
    rig.run(200);
    assert_eq!(rig.row(3), "NO MEDIUM");
}

#[test]
fn the_origin_is_the_zero_of_the_job() {
    let mut rig = Rig::new(&[("A.NC", "G0 X1 Y2\nM30\n"), ("B.NC", "G0 X499.95\nM30\n")]);
    rig.keys("MODE X+ Y- ORIGIN RUN OK");
    rig.run(500);
    let [x, y, z] = rig.controller.place();
    assert!((x - 1.1).abs() < 1e-9 && (y - 1.9).abs() < 1e-9 && z == 0.0, "{x} {y} {z}");
    assert_eq!(rig.row(0), "X     1.000 IDLE");
    rig.keys("RUN DOWN OK");
    assert_eq!(rig.row(3), "LIMIT LINE 1");
}

/// Calls that make no step of a job, such as F, are no progress.
#[test]
fn a_program_without_an_end_is_refused() {
    for endless in ["F#1", "#2=1"] {
        let text = format!("o1 while [1]\n#1=[#1+1]\n{endless}\no1 endwhile\n");
        let why = read(text.as_bytes(), [0.0; 3], 500.0).unwrap_err();
        assert!(matches!(why, WrongJob::Endless(_)), "{why}");
    }
    let long =
        "o1 repeat [100]\no2 repeat [10000]\n#1=[#1+1]\no2 endrepeat\nG4 P1\no1 endrepeat\nM2\n";
    // The end stops the spindle, which is a step, too.
    assert_eq!(read(long.as_bytes(), [0.0; 3], 500.0).unwrap().len(), 101);
}
