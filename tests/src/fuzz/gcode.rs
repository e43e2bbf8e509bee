//! Bodies of the fuzz targets for G-code: a line, and a program.

use hal_gcode::{
    Answer, Call, Environment, Interpreter, Numbered, Request, Settings, State, Step, Text,
    error::Problem,
    function::{Effect, Next, Reply},
    remap::Remap,
    state::Limits,
    text::{
        clean,
        evaluate::{Values, evaluate},
        line::Line,
    },
    tool::{Tool, ToolTable},
};
use std::sync::Arc;

/// Parameters of a line: each number is its own value.
struct Own;

impl Values for Own {
    fn numbered(&self, index: i32) -> Result<f64, Problem> {
        Ok(f64::from(index))
    }

    fn named(&self, name: &str) -> Result<f64, Problem> {
        Ok(name.len() as f64)
    }

    fn exists(&self, name: &str) -> bool {
        name.len().is_multiple_of(2)
    }
}

/// Parses each line and computes its words. Values are finite, and errors have a place on the line.
pub fn lines(bytes: &[u8]) {
    let (mut cleaned, mut line) = (Vec::new(), Line::default());
    for raw in bytes.split(|b| *b == b'\n') {
        if let Err((at, _)) = clean::clean(raw, &mut cleaned) {
            assert!(at <= raw.len());
            continue;
        }
        if let Err(fault) = line.parse(&cleaned) {
            assert!(fault.at.len() <= cleaned.len());
            let column = clean::column(raw, cleaned.len() - fault.at.len());
            assert!(usize::try_from(column).is_ok_and(|c| c <= raw.len() + 1));
            continue;
        }
        for word in &line.words {
            match evaluate(&word.value, word.at, &Own) {
                Ok(value) => assert!(value.is_finite()),
                Err((at, problem)) => {
                    assert!(usize::try_from(at).is_ok_and(|a| a <= cleaned.len()));
                    assert!(!problem.to_string().is_empty());
                }
            }
        }
    }
}

/// The world of a program: three tools, one subroutine, some values.
struct World {
    tools: ToolTable,
}

impl Environment for World {
    fn open(&self, name: &str) -> Option<Text> {
        let text: &[u8] =
            b"o<lift> sub\ng0 z#<p>\no1 if [exists[#<q>]]\nm401\no1 endif\no<lift> endsub\n";
        (name == "lift").then(|| Arc::new(text.to_vec()) as Text)
    }

    fn tool(&self, number: i32) -> Option<Tool> {
        self.tools.find(number).cloned()
    }

    fn ini(&self, _: &str, key: &str) -> Option<f64> {
        (key == "a").then_some(1.5)
    }

    fn user_code(&self, code: u16) -> bool {
        code == 101
    }
}

const LIMITS: Limits = Limits {
    levels: 10,
    open: 50,
    quiet_lines: 500,
    lines: 2000,
    line_length: 4096,
    calls: 5000,
    turns: 100,
};

/// Runs a program to its end or error. The first byte says after how many steps the state is saved, loaded, and gone
/// on from, which must change nothing.
pub fn program(bytes: &[u8]) {
    let Some((first, text)) = bytes.split_first() else { return };
    let whole = run(text, u32::MAX);
    let broken = run(text, u32::from(*first));
    let first = whole.iter().zip(&broken).find(|(a, b)| a != b);
    assert!(whole == broken, "a run that went on from its saved state differs: {first:?}");
}

fn run(text: &[u8], at: u32) -> Vec<String> {
    let table = "T1 P1 Z1.5 D6\nT2 P2 Z2.5 X0.5 D10\nT3 P3 X-1 D0.8 I85 J115 Q2\n";
    let world = World { tools: ToolTable::parse(table).0 };
    let entries = [
        "M400 argspec=Pq ngc=lift",
        "M401 modalgroup=5 ngc=lift",
        "M402 argspec=p py=lift",
        "G88.6 argspec=XYzp ngc=lift",
    ];
    let remaps = entries.iter().filter_map(|e| Remap::parse(e).ok()).collect();
    let settings = Settings { limits: LIMITS, remaps, ..Settings::default() };
    let mut it = Interpreter::new(settings, Numbered::default());
    let main: Text = Arc::new(text.to_vec());
    it.load("main.ngc", Text::clone(&main));
    let mut out = Vec::new();
    let mut log = Vec::new();
    let mut asked: Option<Request> = None;
    for step in 0..4000 {
        if step == at {
            let saved = serde_json::to_string(&it.state);
            let loaded: Option<State> = saved.ok().and_then(|s| serde_json::from_str(&s).ok());
            assert!(loaded.as_ref() == Some(&it.state), "a state saved and loaded is another");
            if let Some(state) = loaded {
                it = Interpreter::from_state(state);
                it.supply("main.ngc", Text::clone(&main));
            }
        }
        let result = match asked.take() {
            None => it.next(&world, &mut out),
            Some(request) => {
                let here = it.state.frame.machine_mm(it.state.position);
                let answer = match request {
                    Request::Probe => {
                        Answer::Probe { tripped_at: here, stopped_at: here, tripped: true }
                    }
                    Request::ToolChange { .. } => Answer::ToolChange { position: None },
                    Request::Input { .. } => Answer::Input(1.0),
                    // Some names are there.
                    Request::Hal { names } => Answer::Hal(
                        names
                            .into_iter()
                            .filter(|n| n.len() % 2 == 0)
                            .map(|n| (n, Some(1.5)))
                            .collect(),
                    ),
                    Request::Function { .. } => Answer::Function(Reply {
                        effects: vec![Effect::Number(31, f64::from(step))],
                        next: match step % 3 {
                            0 => Next::Execute("G1 X1 F100".into()),
                            1 => Next::Finish,
                            _ => Next::Done(None),
                        },
                    }),
                    Request::Finish | Request::UserCode { .. } => Answer::Done,
                };
                it.answer(&answer, &world, &mut out)
            }
        };
        for issued in out.drain(..) {
            let text = issued.call.to_string();
            // A comment may contain any word.
            let is_text = matches!(
                issued.call,
                Call::Comment(_)
                    | Call::Message(_)
                    | Call::Print(_)
                    | Call::Log(_)
                    | Call::LogOpen { .. }
                    | Call::ProbeOpen(_)
            );
            assert!(is_text || !(text.contains("NaN") || text.contains("inf")), "{text}");
            log.push(text);
        }
        match result {
            Ok(Step::Line) => {}
            Ok(Step::Ask(request)) => asked = Some(request),
            Ok(Step::Ended) => break,
            Err(error) => {
                log.push(error.to_string());
                break;
            }
        }
    }
    log
}
