//! Random tool changers and user programs: what the interpreter asks, and what it makes of the answers.

use std::sync::Arc;

use hal_gcode::{
    Answer, Call, Environment, Error, Interpreter, Issued, Numbered, Request, Settings, Step, Text,
    tool::{Tool, ToolTable},
};

/// A machine with three tools, one of them in the spindle's pocket, and the user program M110.
struct Changer(ToolTable);

impl Changer {
    fn new() -> Self {
        Self(ToolTable::parse("T0 P90\nT1 P0 Z10 D6\nT2 P20 Z20 D8\nT3 P30 Z30\n").0)
    }
}

impl Environment for Changer {
    fn open(&self, _: &str) -> Option<Text> {
        None
    }

    fn tool(&self, number: i32) -> Option<Tool> {
        self.0.find(number).cloned()
    }

    fn hal(&self, _: &str) -> Option<f64> {
        Some(1.0)
    }

    fn user_code(&self, code: u16) -> Result<bool, Box<str>> {
        Ok(code == 110)
    }
}

/// Runs a text; `reply` answers its questions. Returns its calls.
fn run(
    it: &mut Interpreter,
    text: &str,
    mut reply: impl FnMut(&Request, &[Issued]) -> Answer,
) -> Result<Vec<Issued>, Error> {
    let world = Changer::new();
    it.load("test.ngc", Arc::new(text.as_bytes().to_vec()));
    let mut out: Vec<Issued> = Vec::new();
    let mut step = it.next(&world, &mut out)?;
    loop {
        step = match step {
            Step::Line => it.next(&world, &mut out)?,
            Step::Ask(request) => it.answer(&reply(&request, &out), &world, &mut out)?,
            Step::Ended => return Ok(out),
        };
    }
}

fn changes(request: &Request, _: &[Issued]) -> Answer {
    match request {
        Request::ToolChange { .. } => Answer::ToolChange { position: None },
        _ => Answer::Done,
    }
}

fn new(random_changer: bool) -> Interpreter {
    let mut it =
        Interpreter::new(Settings { random_changer, ..Settings::default() }, Numbered::default());
    it.state.tool = Changer::new().tool(1).unwrap();
    it
}

/// The pocket of each tool after a text, as a program sees it.
fn pockets(it: &mut Interpreter, text: &str) -> Vec<String> {
    let text = format!(
        "{text}\nt1\n(print,#<_selected_pocket>)\nt2\n(print,#<_selected_pocket>)\nt3\n(print,#<_selected_pocket>)\n(print,#<_current_tool>)\nm2\n"
    );
    let calls = run(it, &text, changes).unwrap();
    let prints = calls.iter().filter(|i| matches!(i.call, Call::Print(_)));
    prints.map(|i| i.call.to_string().replace(".000000", "")).collect()
}

#[test]
fn a_random_changer_puts_the_old_tool_where_the_new_one_was() {
    // The spindle's own pocket is 0, which a program sees as none.
    assert_eq!(pockets(&mut new(true), ""), ["-1", "20", "30", "1"]);
    assert_eq!(pockets(&mut new(true), "t2 m6"), ["20", "-1", "30", "2"]);
    assert_eq!(pockets(&mut new(true), "t2 m6\nt3 m6"), ["20", "30", "-1", "3"]);
    assert_eq!(pockets(&mut new(true), "t2 m6\nt2 m6"), ["20", "-1", "30", "2"]);
    // The table is read again: the changer has told its file meanwhile.
    assert_eq!(pockets(&mut new(true), "t2 m6\ng10 l0"), ["-1", "20", "30", "2"]);
    // Tool 0 empties the spindle; the old tool goes to pocket 0, which is none.
    let mut it = new(true);
    assert_eq!(pockets(&mut it, "t0 m6"), ["-1", "20", "30", "0"]);
    let calls = run(&mut it, "t0\n(print,#<_selected_pocket>)\nm2\n", changes).unwrap();
    assert_eq!(calls[1].call.to_string(), "-1.000000");
    // Other changers put a tool back to its own pocket.
    assert_eq!(pockets(&mut new(false), "t2 m6\nt3 m6"), ["-1", "20", "30", "3"]);
}

#[test]
fn offsets_that_a_program_set_stay_with_a_tool_that_moves() {
    let mut it = new(true);
    let text = "g10 l1 p2 z25\nt2 m6\nt3 m6\nt2 m6\ng43\nm2\n";
    let calls = run(&mut it, text, changes).unwrap();
    let offset = calls.iter().find_map(|i| match i.call {
        Call::UseToolLengthOffset(p) => Some(p.z),
        _ => None,
    });
    assert_eq!(offset, Some(25.0));
}

#[test]
fn lines_behind_a_user_program_are_read_after_its_end() {
    let mut it = new(false);
    let mut seen = None;
    let text = "g0 x1\nm110 p2\n(print,#<_hal[x]>)\nm2\n";
    let calls = run(&mut it, text, |request, calls| {
        seen = Some((request.clone(), calls.len()));
        Answer::Done
    })
    .unwrap();
    assert_eq!(seen, Some((Request::UserCode { code: 110, p: 2.0, q: -1.0 }, 2)));
    assert!(calls.len() > 4, "the program went on");
    let failed = run(&mut new(false), text, |_, _| Answer::Failed("status 3".into()));
    assert_eq!(failed.unwrap_err().to_string(), "test.ngc:2: M110 failed: status 3");
}

#[test]
fn a_user_program_on_a_compensated_path_does_not_change_the_corner() {
    let path = |middle: &str| {
        let text =
            format!("f100\ng41.1 d2\ng1 x10\ng1 x20 y0\n{middle}g1 x20 y20\ng40 g1 x0 y0\nm2\n");
        let mut asked = 0;
        let calls = run(&mut new(false), &text, |_, _| {
            asked += 1;
            Answer::Done
        })
        .unwrap();
        let feeds = calls.into_iter().filter(|i| matches!(i.call, Call::StraightFeed(_)));
        (feeds.map(|i| i.call).collect::<Vec<_>>(), asked)
    };
    assert_eq!(path("m110\n"), path(""));
    assert_eq!(path("m110\n").1, 0);
}

#[test]
fn a_failed_answer_names_its_request() {
    let failed = |text: &str| {
        let out = run(&mut new(false), text, |_, _| Answer::Failed("no air".into()));
        out.unwrap_err().to_string()
    };
    assert_eq!(failed("t2 m6\nm2\n"), "test.ngc:1: toolchange failed: no air");
    assert_eq!(failed("g38.2 z-5 f10\nm2\n"), "test.ngc:1: probe failed: no air");
    assert_eq!(failed("m66 p1 l3 q1\nm2\n"), "test.ngc:1: input failed: no air");
}

#[test]
fn a_tool_offset_has_a_tool_or_words() {
    let mut it = new(false);
    let error = run(&mut it, "g43.2 h2 z1\nm2\n", changes).unwrap_err().to_string();
    assert!(
        error.starts_with("test.ngc:1:1: G43.2: Can not have both H and axis words"),
        "{error}"
    );
    let offsets = |text: &str| -> Vec<f64> {
        let calls = run(&mut new(false), text, changes).unwrap();
        let offsets = calls.iter().filter_map(|i| match i.call {
            Call::UseToolLengthOffset(p) => Some(p.z),
            _ => None,
        });
        offsets.collect()
    };
    assert_eq!(
        offsets("g43\ng43.2 h2\ng43.2 z1\ng43.2 h0\ng49\nm2\n"),
        [10.0, 30.0, 31.0, 41.0, 0.0]
    );
}

#[test]
fn a_remapped_user_program_has_the_group_of_its_remap() {
    use hal_gcode::remap::Remap;
    let remaps = vec![Remap::parse("M110 modalgroup=7 ngc=body").unwrap()];
    let mut it = Interpreter::new(Settings { remaps, ..Settings::default() }, Numbered::default());
    let error = run(&mut it, "s1 m3 m110\nm2\n", changes).unwrap_err().to_string();
    assert!(error.contains("Two m codes used from same modal group"), "{error}");
    assert!(run(&mut new(false), "s1 m3 m110\nm2\n", changes).is_ok());
}

#[test]
fn motion_from_elsewhere_ends_what_waits_for_the_next_move() {
    let mut it = new(false);
    let mut out = Vec::new();
    let world = Changer::new();
    it.load("test.ngc", Arc::new(b"f100 g41.1 d2\ng1 x10\ng1 x20\ng1 x30\n".to_vec()));
    for _ in 0..3 {
        it.next(&world, &mut out).unwrap();
    }
    assert!(!it.state.compensation.queue.is_empty());
    it.synchronise(hal_gcode::axis::Position { y: 7.0, ..Default::default() });
    let compensation = &it.state.compensation;
    assert!(compensation.queue.is_empty() && compensation.program.is_none());
    assert_eq!(it.state.position.y, 7.0);
    let mut it = new(false);
    it.load("test.ngc", Arc::new(b"f100 g5 i1 j1 p-1 q1 x5 y5\ng5 p1 q1 x9\n".to_vec()));
    it.next(&world, &mut out).unwrap();
    assert!(it.state.spline.is_some());
    it.synchronise(hal_gcode::axis::Position::default());
    assert!(it.state.spline.is_none());
}
