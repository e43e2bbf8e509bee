//! Bodies of the fuzz targets for G-code: a line, and a program.

use hal_gcode::{
    Answer, Call, Dialect, Environment, Interpreter, Numbered, Request, Settings, State, Step,
    Text,
    error::Problem,
    function::{CallWord, Effect, Next, Reply, Wanted},
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

    fn user_code(&self, code: u16) -> Result<bool, Box<str>> {
        Ok(code == 101)
    }

    fn function(&self, name: &str) -> bool {
        name == "bend"
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

/// Runs a program to its end or error, in each language. The first byte says after how many steps the state is saved,
/// loaded, and gone on from, which must change nothing.
pub fn program(bytes: &[u8]) {
    let Some((first, text)) = bytes.split_first() else { return };
    for dialect in [Dialect::LinuxCnc, Dialect::Rs274d] {
        let whole = run(dialect, text, u32::MAX);
        let broken = run(dialect, text, u32::from(*first));
        let first = whole.iter().zip(&broken).find(|(a, b)| a != b);
        assert!(whole == broken, "a run that went on from its saved state differs: {first:?}");
    }
}

/// Names of parameters that functions read and set.
const NAMES: [&str; 6] = ["a", "_a", "p", "_feed", "_x", "_hal[b]"];
/// Fields that functions set.
const FIELDS: [&str; 15] = [
    "feed_rate",
    "return_value",
    "value_returned",
    "selected_tool",
    "current_tool",
    "motion_mode",
    "distance_mode",
    "ijk_distance_mode",
    "retract_mode",
    "feed_mode",
    "plane",
    "speed.0",
    "speed.9",
    "current_x",
    "",
];
/// Canonical calls of functions.
const CALLS: [&str; 32] = [
    "MESSAGE",
    "LOG",
    "LOGOPEN",
    "DWELL",
    "STRAIGHT_TRAVERSE",
    "STRAIGHT_FEED",
    "STRAIGHT_PROBE",
    "ARC_FEED",
    "SET_FEED_RATE",
    "SET_SPINDLE_SPEED",
    "SET_SPINDLE_MODE",
    "SET_FEED_MODE",
    "START_SPINDLE_CLOCKWISE",
    "STOP_SPINDLE_TURNING",
    "MIST_ON",
    "FLOOD_OFF",
    "DISABLE_FEED_OVERRIDE",
    "ENABLE_SPEED_OVERRIDE",
    "ENABLE_ADAPTIVE_FEED",
    "DISABLE_FEED_HOLD",
    "SET_MOTION_OUTPUT_BIT",
    "SET_AUX_OUTPUT_VALUE",
    "SELECT_TOOL",
    "START_CHANGE",
    "CHANGE_TOOL",
    "CHANGE_TOOL",
    "CHANGE_TOOL_NUMBER",
    "SELECT_PLANE",
    "PROGRAM_STOP",
    "OPTIONAL_PROGRAM_STOP",
    "COMMENT",
    "NOTHING",
];
/// Lines that functions execute, beside those of the program.
const LINES: [&str; 12] = [
    "G1 X1 F100",
    "G2 X3 I1 F100",
    "M6 T2",
    "M402 P1",
    "M403",
    "o<bend> call [1]",
    "o<lift> call [2]",
    "G41.1 D1",
    "G40",
    "#1=#<_hal[c]>",
    "G38.2 X9 F10",
    "G",
];

/// The choices of a function, made of the program's bytes.
struct Choices<'a> {
    text: &'a [u8],
    at: usize,
}

impl Choices<'_> {
    fn byte(&mut self) -> u8 {
        self.at = self.at.wrapping_mul(31).wrapping_add(17);
        let index = self.at.checked_rem(self.text.len()).unwrap_or(0);
        self.text.get(index).copied().unwrap_or(0)
    }

    fn below(&mut self, bound: usize) -> usize {
        usize::from(self.byte()).wrapping_add(self.at >> 7) % bound.max(1)
    }

    fn of<'b>(&mut self, all: &[&'b str]) -> &'b str {
        all.get(self.below(all.len())).copied().unwrap_or_default()
    }

    fn value(&mut self) -> f64 {
        match self.below(4) {
            0 => 0.0,
            1 => f64::from(self.byte() % 4),
            _ => (f64::from(self.byte()) - 128.0) / 8.0,
        }
    }

    fn effect(&mut self) -> Effect {
        match self.below(5) {
            0 => Effect::Number(i32::from(self.byte()) * 23 - 20, self.value()),
            1 => Effect::Name(self.of(&NAMES).into(), self.value()),
            2 => Effect::Field(self.of(&FIELDS).into(), self.value()),
            _ => {
                let name = self.of(&CALLS);
                let is_move = ["STRAIGHT", "ARC"].iter().any(|m| name.starts_with(m));
                let count = if is_move { 13 } else { self.below(4) };
                let mut words: Vec<CallWord> =
                    (0..count).map(|_| CallWord::Number(self.value())).collect();
                if ["MESSAGE", "LOG", "COMMENT"].iter().any(|m| name.starts_with(m)) {
                    words = vec![CallWord::Text("text".into())];
                }
                Effect::Call(name.into(), words)
            }
        }
    }

    fn next(&mut self) -> Next {
        match self.below(8) {
            0..3 => Next::Execute(self.of(&LINES).into()),
            3 => {
                let index = self.below(self.text.len());
                let rest = self.text.get(index..).unwrap_or_default();
                let line = rest.split(|b| *b == b'\n').next().unwrap_or_default();
                Next::Execute(String::from_utf8_lossy(line).into())
            }
            4 => Next::Finish,
            5 => Next::Ask(match self.below(2) {
                0 => Wanted::Name(self.of(&NAMES).into()),
                _ => Wanted::Slot(i32::from(self.byte() % 5)),
            }),
            6 => Next::Done(Some(self.value())),
            _ => Next::Fail("no air".into()),
        }
    }

    fn answer(&mut self) -> Answer {
        if self.below(16) == 0 {
            return Answer::Failed("the process has ended".into());
        }
        let effects = (0..self.below(4)).map(|_| self.effect()).collect();
        Answer::Function(Reply { effects, next: self.next() })
    }
}

fn run(dialect: Dialect, text: &[u8], at: u32) -> Vec<String> {
    let table = "T1 P1 Z1.5 D6\nT2 P2 Z2.5 X0.5 D10\nT3 P3 X-1 D0.8 I85 J115 Q2\n";
    let world = World { tools: ToolTable::parse(table).0 };
    let entries = [
        "M400 argspec=Pq ngc=lift",
        "M401 modalgroup=5 ngc=lift",
        "M402 argspec=p py=bend",
        "M403 prolog=bend ngc=lift epilog=bend",
        "M6 modalgroup=6 prolog=bend py=bend",
        "G88.7 modalgroup=1 py=bend",
        "G88.6 argspec=XYzp ngc=lift",
    ];
    let remaps = entries.iter().filter_map(|e| Remap::parse(e).ok()).collect();
    let settings = Settings { limits: LIMITS, remaps, dialect, ..Settings::default() };
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
                    Request::Function { .. } => {
                        let at = usize::try_from(step).unwrap_or(0);
                        Choices { text, at }.answer()
                    }
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
