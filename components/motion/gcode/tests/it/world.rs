//! Answers of the environment: probes, inputs, tools, values of INI and HAL, user codes; and the frame of the calls.

use std::sync::Arc;

use hal_gcode::{
    Answer, Call, Environment, Error, Interpreter, Issued, Numbered, Request, Settings, Step, Text,
    axis::{AxisMask, Position},
    canon::Frame,
    function::{CallWord, Effect, Next, Reply, Turn, Wanted},
    parameters::number,
    remap::Remap,
    state::State,
    tool::Tool,
};

use crate::support::{World, interpreter_of, run_with};

/// A machine in millimetres with one tool, one user code, an INI value and a HAL value.
struct Machine;

impl Environment for Machine {
    fn open(&self, _: &str) -> Option<Text> {
        None
    }

    fn tool(&self, number: i32) -> Option<Tool> {
        let offset = Position { z: 10.0, ..Position::default() };
        (number == 1).then(|| Tool { number, pocket: 1, offset, diameter: 6.0, ..Tool::default() })
    }

    fn ini(&self, section: &str, key: &str) -> Option<f64> {
        (section == "traj" && key == "speed").then_some(42.0)
    }

    fn hal(&self, name: &str) -> Option<f64> {
        (name == "motion.a-b").then_some(1.5)
    }

    fn user_code(&self, code: u16) -> Result<bool, Box<str>> {
        Ok(code == 101)
    }
}

fn at(x: f64, y: f64, z: f64) -> Position {
    Position { x, y, z, ..Position::default() }
}

/// Runs a text; `reply` answers its questions.
fn run(
    it: &mut Interpreter,
    text: &str,
    reply: impl Fn(&Request) -> Answer,
) -> Result<Vec<String>, Error> {
    it.load("test.ngc", Arc::new(text.as_bytes().to_vec()));
    let mut out: Vec<Issued> = Vec::new();
    let mut step = it.next(&Machine, &mut out)?;
    loop {
        step = match step {
            Step::Line => it.next(&Machine, &mut out)?,
            Step::Ask(request) => it.answer(&reply(&request), &Machine, &mut out)?,
            Step::Ended => break,
        };
    }
    Ok(out.iter().map(|i| i.call.to_string()).collect())
}

fn new(settings: Settings) -> Interpreter {
    Interpreter::new(settings, Numbered::default())
}

#[test]
fn a_probe_gives_its_place_in_program_coordinates() {
    let mut it = new(Settings::default());
    let reply = |_: &Request| Answer::Probe {
        tripped_at: at(100.0, 0.0, 12.5),
        stopped_at: at(100.0, 0.0, 12.0),
        tripped: true,
    };
    let text = "g10 l2 p1 x100 z10\ng38.2 z-50 f10\n(print,#5061 #5063 #5070 #5422)\ng0 x1\nm2\n";
    let calls = run(&mut it, text, reply).unwrap();
    assert!(calls.contains(&"0.000000 2.500000 1.000000 2.000000".to_owned()), "{calls:?}");
    assert!(calls.iter().any(|c| c.starts_with("STRAIGHT_TRAVERSE(1.0000, 0.0000, 2.0000")));
}

#[test]
fn a_line_goes_on_after_its_answer() {
    let mut it = new(Settings::default());
    let reply = |request: &Request| match request {
        Request::Input { index: 3, analog: true, .. } => Answer::Input(0.25),
        _ => Answer::ToolChange { position: Some(at(0.0, 0.0, 77.0)) },
    };
    let calls = run(&mut it, "t1 m6 g43 m66 e3 l0\ng0 x[#5399*4]\nm2\n", reply).unwrap();
    // After the change, the machine is at Z 77; the tool takes 10 of it.
    assert!(calls.iter().any(|c| c.starts_with("USE_TOOL_LENGTH_OFFSET(0.0000 0.0000 10.0000")));
    let moved = "STRAIGHT_TRAVERSE(1.0000, 0.0000, 67.0000, 0.0000, 0.0000, 0.0000)";
    assert!(calls.contains(&moved.to_owned()), "{calls:?}");
}

#[test]
fn a_wrong_or_failed_answer_is_an_error() {
    let wrong = run(&mut new(Settings::default()), "t1 m6\nm2\n", |_| Answer::Input(1.0));
    assert!(wrong.unwrap_err().to_string().contains("the answer does not fit"));
    let failed =
        run(&mut new(Settings::default()), "t1\nm6\nm2\n", |_| Answer::Failed("no air".into()));
    let text = failed.unwrap_err().to_string();
    assert!(text.starts_with("test.ngc:2: toolchange failed: no air"), "{text}");
    let mut it = new(Settings::default());
    it.load("a", Arc::new(b"t1 m6\n".to_vec()));
    let mut out = Vec::new();
    assert!(matches!(it.next(&Machine, &mut out), Ok(Step::Ask(_))));
    assert!(it.next(&Machine, &mut out).is_err(), "a question is open");
}

#[test]
fn values_of_ini_and_hal_and_user_codes() {
    let none = |_: &Request| Answer::Done;
    let text = "#1=[#<_ini[TRAJ]Speed>+#<_hal[motion.a-b]>]\n(print,#1)\nm101 p2 q3\nm2\n";
    let calls = run(&mut new(Settings::default()), text, none).unwrap();
    assert_eq!(calls[0], "43.500000");
    assert_eq!(calls[1], "USER_CODE(M101, 2.0000, 3.0000)");
    let unknown = run(&mut new(Settings::default()), "m102\nm2\n", none);
    assert!(unknown.unwrap_err().to_string().contains("Unknown m code used: M102"));
}

/// Programs that read values of HAL: the names that each question asks for, and what the calls begin with or the error.
#[test]
fn a_line_that_reads_values_of_hal_asks_for_them_before_it_runs() {
    let known = |names: &[Box<str>]| {
        let value = |name: &str| match name {
            "low" | "b.0.out" => Some(0.0),
            "high" => Some(7.5),
            _ => None,
        };
        Answer::Hal(names.iter().map(|name| (name.clone(), value(name))).collect())
    };
    for (text, asked, wanted) in [
        ("#1=#<_HAL[High]>\n(print,#1)\n", "high", "7.500000"),
        ("#1=[#< _hal [ high ] > - #<_hal[low]>]\n(print,#1)\n", "high low", "7.500000"),
        // Both sides of the question are read in one line, and a line asks again each time that it is run.
        (
            "o1 repeat [2]\n#1=[#1+#<_hal[high]>]\no1 endrepeat\n(print,#1)\n",
            "high|high",
            "15.000000",
        ),
        ("(print,is #<_hal[High]>)\n", "high", "is 7.500000"),
        ("(print,is #<_hal[none]>)\n", "none", "is ######"),
        ("(a comment with #<_hal[high]> means nothing)\ng0 x1\n", "", "COMMENT"),
        (
            "#1=EXISTS[#<_hal[high]>]\n#2=EXISTS[#<_hal[none]>]\n(print,#1 #2)\n",
            "high|none",
            "1.000000 0.000000",
        ),
        ("#1=#<_hal[none]>\n", "none", "test.ngc:1:4: Named parameter #<_hal[none]> not defined"),
        ("g0 x#<_hal[high]>\n", "high", "STRAIGHT_TRAVERSE(7.5"),
        // Conditions, also those behind a branch that is not taken, and lines that are left out.
        (
            "o1 if [#<_hal[low]>]\ng0 x#<_hal[none]>\no1 else\ng0 x3\no1 endif\n",
            "low",
            "STRAIGHT_TRAVERSE(3",
        ),
        (
            "o1 if [0]\no1 elseif [#<_hal[low]>]\no1 elseif [#<_hal[high]>]\ng0 x4\no1 endif\n",
            "low|high",
            "STRAIGHT_TRAVERSE(4",
        ),
        (
            "o1 if [0]\no1 elseif [EXISTS[#<_hal[none]>]]\ng0 x1\no1 else\ng0 x5\no1 endif\n",
            "none",
            "STRAIGHT_TRAVERSE(5",
        ),
        ("/g0 x#<_hal[none]>\ng0 x6\n", "", "STRAIGHT_TRAVERSE(6"),
        (
            "o<s> sub\ng0 x#1\no<s> endsub\no<s> call [#<_hal[high]>]\n",
            "high",
            "STRAIGHT_TRAVERSE(7.5",
        ),
        ("#<_hal[high]>=3\n(print,#<_hal[high]>)\n", "high|high", "7.500000"),
    ] {
        let asks = core::cell::RefCell::new(Vec::new());
        let settings = Settings { block_delete: true, ..Settings::default() };
        let result = run(&mut new(settings), &format!("{text}m2\n"), |request| {
            let Request::Hal { names } = request else { panic!("{request:?}") };
            asks.borrow_mut().push(names.join(" "));
            known(names)
        });
        assert_eq!(asks.borrow().join("|"), asked, "{text}");
        let found = result.map_or_else(|error| error.to_string(), |calls| calls[0].clone());
        assert!(found.starts_with(wanted), "{text}: {found}");
    }
    let failed = |_: &Request| Answer::Failed("a.b is NaN, which is not a finite number".into());
    let error = run(&mut new(Settings::default()), "g0 x1\n#1=#<_hal[a.b]>\nm2\n", failed);
    let text = error.unwrap_err().to_string();
    assert_eq!(text, "test.ngc:2: HAL: a.b is NaN, which is not a finite number");
    let wrong = run(&mut new(Settings::default()), "#1=#<_hal[a]>\nm2\n", |_| Answer::Done);
    assert!(wrong.unwrap_err().to_string().contains("the answer does not fit"));
}

#[test]
fn block_delete_and_axes_are_settings() {
    let none = |_: &Request| Answer::Input(0.0);
    let text = "/g0 x1\n / g0 x2\ng0 x3\nm2\n";
    let calls = run(&mut new(Settings::default()), text, none).unwrap();
    assert!(calls[0].starts_with("STRAIGHT_TRAVERSE(3"));
    let lathe = Settings { axes: AxisMask(0b101), ..Settings::default() };
    let error = run(&mut new(lathe), "g0 x1 y2\nm2\n", none).unwrap_err();
    assert!(error.to_string().contains("Bad character 'y' used"));
}

/// A machine whose O-word `twice` is a function.
struct Hooks;

impl Environment for Hooks {
    fn open(&self, name: &str) -> Option<Text> {
        let text: &[u8] = match name {
            "body" => b"o<body> sub\n(print,#<given>)\no<body> endsub [7]\n",
            "deep" => b"o<deep> sub\n#1=5\ng1 q3\no<deep> endsub\n",
            _ => return None,
        };
        Some(Arc::new(text.to_vec()) as Text)
    }

    fn tool(&self, number: i32) -> Option<Tool> {
        (number == 3).then(|| Tool { number, pocket: 9, ..Tool::default() })
    }

    fn function(&self, name: &str) -> bool {
        name == "twice" || name == "itself"
    }
}

/// Answers as the functions `first`, `last`, `alone`, `twice`, `itself` and `busy` would.
fn function(state: &State) -> Answer {
    let call = state.function().unwrap();
    let reply = |effects: Vec<Effect>, next| Answer::Function(Reply { effects, next });
    let execute = |line: &str| reply(Vec::new(), Next::Execute(line.into()));
    let print = |text: &str| Effect::Call("MESSAGE".into(), vec![CallWord::Text(text.into())]);
    match (&*call.name, &call.turn) {
        ("first", _) => reply(vec![Effect::Name("given".into(), 42.0)], Next::Done(None)),
        ("last", _) => {
            let result = state.returned.unwrap() + 1.0;
            reply(vec![Effect::Name("_result".into(), result)], Next::Done(None))
        }
        ("twice", Turn::Begin) => execute("g0 x[#1+1]"),
        ("twice", _) => reply(Vec::new(), Next::Done(Some(2.0 * call.arguments.first().unwrap()))),
        ("itself", Turn::Begin) => execute("o<itself> call"),
        ("busy", Turn::Begin) => execute("g1 q3"),
        ("busy", Turn::Executed(Some(failure))) if &*failure.text == "g1 q3" => {
            reply(vec![print(&failure.message)], Next::Execute("o<deep> call [8]".into()))
        }
        ("busy", Turn::Executed(Some(failure))) if failure.text.starts_with("o<deep>") => {
            let one = print(&format!("#1={}", state.numbered.get(1)));
            reply(vec![one], Next::Ask(Wanted::Name("_hal[a.b]".into())))
        }
        ("busy", Turn::Value(Some(4.5))) => reply(Vec::new(), Next::Ask(Wanted::Slot(3))),
        ("busy", Turn::Value(Some(9.0))) => execute("o1 if [1]"),
        ("busy", Turn::Executed(Some(failure))) => {
            reply(vec![print(&failure.message)], Next::Finish)
        }
        ("busy", Turn::Finished) => {
            let change = Effect::Call("CHANGE_TOOL".into(), vec![CallWord::Number(3.0)]);
            reply(vec![change], Next::Done(None))
        }
        ("wrong", Turn::Begin) => {
            reply(vec![Effect::Field("current_x".into(), 1.0)], Next::Done(None))
        }
        (_, _) => Answer::Failed("no air".into()),
    }
}

/// Runs a program with these functions, and writes down questions that are none of theirs.
fn with_functions(text: &str) -> Result<Vec<String>, Error> {
    let entries = [
        "M400 prolog=first ngc=body epilog=last",
        "M401 py=alone",
        "M402 py=busy",
        "M403 py=wrong",
    ];
    let remaps: Vec<Remap> = entries.iter().map(|e| Remap::parse(e).unwrap()).collect();
    let mut it = new(Settings { remaps, ..Settings::default() });
    it.load("test.ngc", Arc::new(text.as_bytes().to_vec()));
    let (mut out, mut asked) = (Vec::new(), Vec::new());
    let mut step = it.next(&Hooks, &mut out)?;
    while step != Step::Ended {
        step = match step {
            Step::Ask(Request::Function { .. }) => {
                // The state is a value: a run goes on from a copy.
                it = Interpreter::from_state(it.state.clone());
                it.supply("test.ngc", Arc::new(text.as_bytes().to_vec()));
                let answer = function(&it.state);
                it.answer(&answer, &Hooks, &mut out)?
            }
            Step::Ask(request) => {
                asked.push(format!("{request:?}"));
                let answer = match request {
                    Request::Hal { names } => {
                        Answer::Hal(names.into_iter().map(|n| (n, Some(4.5))).collect())
                    }
                    Request::ToolChange { .. } => Answer::ToolChange { position: None },
                    _ => Answer::Done,
                };
                it.answer(&answer, &Hooks, &mut out)?
            }
            _ => it.next(&Hooks, &mut out)?,
        };
    }
    let calls = out.iter().map(|i| format!("{}: {}", i.line, i.call));
    Ok(calls.take_while(|c| !c.contains("SET_G5X_OFFSET")).chain(asked).collect())
}

#[test]
fn functions_of_a_remap_run_around_its_subroutine_or_fail_at_the_line() {
    let calls = with_functions("m400 g0 x1\n(print,#<_result>)\nm2\n").unwrap();
    assert_eq!(calls[0], "2: 42.000000");
    assert!(calls[1].starts_with("1: STRAIGHT_TRAVERSE(1.0000"), "{calls:?}");
    assert_eq!(calls[2], "2: 8.000000");
    let failed = with_functions("g0\nm401\nm2\n").unwrap_err().to_string();
    assert_eq!(failed, "test.ngc:2: alone: no air");
    let failed = with_functions("m403\nm2\n").unwrap_err().to_string();
    assert_eq!(failed, "test.ngc:1: wrong: self.current_x cannot be set");
}

#[test]
fn an_o_word_calls_a_function_with_its_values_and_gets_one() {
    let calls = with_functions("#1=5\no<twice> call [21]\n(print,#<_value> #1)\nm2\n").unwrap();
    assert!(calls[0].starts_with("2: STRAIGHT_TRAVERSE(6.0000"), "{calls:?}");
    assert_eq!(calls[1], "3: 42.000000 5.000000");
    let endless = with_functions("o<itself> call\nm2\n").unwrap_err().to_string();
    assert!(endless.starts_with("test.ngc:1: itself: no air"), "{endless}");
}

#[test]
fn a_function_gets_errors_values_and_ends_of_its_lines() {
    let calls = with_functions("#1=7\nm402\ng0 x1\nm2\n").unwrap();
    let wanted = [
        "2: MESSAGE(\"Q word with no G5, G10, G64, G73, G76, G83, M19, M66, M67, M68 or user M code that uses it\")",
        // The subroutine that has failed is gone, and the parameters are those of before.
        "2: MESSAGE(\"#1=7\")",
        "2: MESSAGE(\"a function can execute",
        "2: CHANGE_TOOL(3)",
        "3: STRAIGHT_TRAVERSE(1.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000)",
    ];
    for (got, wanted) in calls.iter().zip(wanted) {
        assert!(got.starts_with(&wanted[..20.min(wanted.len())]), "{calls:#?}");
    }
    assert_eq!(calls[1], wanted[1]);
    let asked: Vec<&String> = calls.iter().skip(5).collect();
    let wanted = ["Hal { names: [\"a.b\"] }", "Finish", "ToolChange { tool: 3 }"];
    assert_eq!(asked, wanted, "{calls:#?}");
}

#[test]
fn a_wrapped_axis_turns_by_the_sign_of_its_word() {
    let none = |_: &Request| Answer::Input(0.0);
    let wrapped = Settings { wrapped: AxisMask(0b1000), ..Settings::default() };
    let mut it = new(wrapped.clone());
    let calls =
        run(&mut it, "g0 a350\ng0 a10\ng0 a-350\ng0 a-0\ng0 a10\ng0 a-10\ng0 a10\nm2\n", none)
            .unwrap();
    let angle = |c: &String| c.split(", ").nth(3).unwrap().parse::<f64>().unwrap();
    let angles: Vec<f64> = calls.iter().take(7).map(angle).collect();
    assert_eq!(angles, [350.0, 370.0, 350.0, 0.0, 10.0, 10.0, 10.0]);
    let error = run(&mut new(wrapped), "g0 a361\nm2\n", none).unwrap_err();
    assert!(error.to_string().contains("Invalid absolute position"));
}

#[test]
fn the_parameters_of_the_last_session_are_in_force() {
    let mut numbered = Numbered::default();
    numbered.put(number::SYSTEM, 2.0);
    numbered.put(number::G54 + 20, 5.0);
    numbered.put(number::G92_APPLIES, 1.0);
    numbered.put(number::G92, 1.0);
    let it = Interpreter::new(Settings::default(), numbered);
    assert_eq!(it.state.frame.machine(at(0.0, 0.0, 0.0)).x, 6.0);
    assert_eq!(it.state.position.x, -6.0);
    let mut frame = Frame::new(it.state.frame.unit);
    it.preamble().iter().for_each(|c| frame.apply(c));
    assert_eq!(frame, it.state.frame);
}

#[test]
fn the_frame_of_the_calls_is_that_of_the_interpreter() {
    let world = World::new();
    for name in world.files.keys().filter(|n| !n.starts_with("lib-")) {
        let mut it = interpreter_of(name);
        it.load(&format!("{name}.ngc"), world.open(name).unwrap());
        let mut frame = Frame::new(it.state.frame.unit);
        let (calls, error) = run_with(&mut it, &world, |_| {});
        let last = calls.iter().rposition(|i| moves(&i.call));
        for (index, issued) in calls.iter().enumerate() {
            frame.apply(&issued.call);
            if Some(index) == last {
                assert!(frame.machine_mm(end(&issued.call)).is_finite(), "{name}");
            }
        }
        if error.is_none() {
            assert_eq!(frame, it.state.frame, "{name}");
        }
    }
}

fn moves(call: &Call) -> bool {
    matches!(call, Call::StraightFeed(_) | Call::StraightTraverse(_) | Call::ArcFeed { .. })
}

fn end(call: &Call) -> Position {
    match call {
        Call::StraightFeed(p) | Call::StraightTraverse(p) | Call::ArcFeed { end: p, .. } => *p,
        _ => Position::default(),
    }
}
