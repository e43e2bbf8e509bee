//! A machine for tests: it answers each request, and finds files beside the programs.

use std::{collections::BTreeMap, path::PathBuf, sync::Arc};

use hal_gcode::{
    Answer, Call, Environment, Interpreter, Issued, Numbered, Request, Settings, Step, Text,
    axis::AxisMask,
    canon::Unit,
    remap::Remap,
    tool::{Tool, ToolTable},
};

/// The tool table of all tests, in inches.
pub(crate) const TABLE: &str = "T1 P1 Z1.5 D6 ;mill\nT2 P2 Z2.5 X0.5 D10 ;big mill\n\
                         T3 P3 Z0.3 X-1 D0.8 I85 J115 Q2 ;lathe\nT4 P4 Z1 D0.1 ;small\n\
                         T99999 P50 Z1 D1 ;last\n";

pub(crate) fn folder(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests").join(name)
}

/// The world of the tests.
pub(crate) struct World {
    pub(crate) tools: ToolTable,
    pub(crate) files: BTreeMap<String, Vec<u8>>,
}

impl World {
    pub(crate) fn new() -> Self {
        let mut files = BTreeMap::new();
        for entry in std::fs::read_dir(folder("programs")).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|e| e == "ngc") {
                let name = path.file_stem().unwrap().to_string_lossy().into_owned();
                files.insert(name, std::fs::read(&path).unwrap());
            }
        }
        Self { tools: ToolTable::parse(TABLE).0, files }
    }
}

impl Environment for World {
    fn open(&self, name: &str) -> Option<Text> {
        let name = name.strip_suffix(".ngc").unwrap_or(name);
        let text = self.files.get(name)?.clone();
        Some(Arc::new(text))
    }

    fn tool(&self, number: i32) -> Option<Tool> {
        self.tools.find(number).cloned()
    }
}

/// The settings that `rs274` has without an INI file.
pub(crate) fn settings() -> Settings {
    Settings {
        axes: AxisMask::XYZABC,
        unit: Unit::Inch,
        program_unit: Unit::Millimetre,
        block_delete: false,
        ..Settings::default()
    }
}

/// The INI file of the programs whose names begin with `remap-`.
pub(crate) const REMAPS: &str = "[RS274NGC]
SUBROUTINE_PATH=.
REMAP=M400 modalgroup=10 argspec=Pq ngc=lib-remap-named
REMAP=M401 modalgroup=10 argspec=@PQr ngc=lib-remap-positional
REMAP=M402 modalgroup=5 ngc=lib-remap-plain
REMAP=M403 modalgroup=7 argspec=^> ngc=lib-remap-plain
REMAP=M404 modalgroup=10 ngc=lib-remap-nested
REMAP=M405 modalgroup=10 ngc=lib-remap-missing
REMAP=M406 modalgroup=10 ngc=lib-remap-itself
REMAP=M407 modalgroup=8 argspec=N ngc=lib-remap-line
REMAP=M408 modalgroup=9 ngc=lib-remap-error
REMAP=M409 modalgroup=6 argspec=ijk ngc=lib-remap-ijk
REMAP=M411 modalgroup=10 argspec=@Pqr ngc=lib-remap-positional
REMAP=G88.6 modalgroup=1 argspec=XYzp ngc=lib-remap-move
REMAP=G88.7 modalgroup=1 argspec=a ngc=lib-remap-plain
REMAP=M6 modalgroup=6 ngc=lib-remap-change
REMAP=M0 modalgroup=10 ngc=lib-remap-stop
REMAP=F argspec=F ngc=lib-remap-feed
REMAP=S argspec=S ngc=lib-remap-speed
REMAP=T argspec=T ngc=lib-remap-tool
";

/// Returns the settings for a program.
pub(crate) fn settings_of(name: &str) -> Settings {
    let mut out = settings();
    if name.starts_with("remap-") {
        let entries = REMAPS.lines().filter_map(|l| l.strip_prefix("REMAP="));
        out.remaps = entries.map(|e| Remap::parse(e).unwrap()).collect();
    }
    out.random_changer = name.starts_with("random-");
    out.orient_offset = if name.starts_with("offset-") { 42.0 } else { 0.0 };
    out.no_fanuc_subs = name.starts_with("no-parts-");
    out.counts_arguments = name.starts_with("nargs-");
    out
}

pub(crate) fn interpreter_of(name: &str) -> Interpreter {
    Interpreter::new(settings_of(name), Numbered::default())
}

pub(crate) fn interpreter() -> Interpreter {
    Interpreter::new(settings(), Numbered::default())
}

/// The answer of a machine that has no probe and no inputs, as `rs274` has none.
pub(crate) fn answer(request: &Request, interpreter: &Interpreter) -> Answer {
    let frame = &interpreter.state.frame;
    let here = frame.machine_mm(interpreter.state.position);
    match request {
        Request::Probe => Answer::Probe { tripped_at: here, stopped_at: here, tripped: false },
        Request::ToolChange { .. } => Answer::ToolChange { position: None },
        Request::Input { .. } => Answer::Input(0.0),
        Request::Hal { .. } => Answer::Hal(Vec::new()),
        Request::Function { .. } | Request::Finish | Request::UserCode { .. } => Answer::Done,
    }
}

/// Runs a program to its end or its error; `before` sees the interpreter before each step.
pub(crate) fn run_with(
    interpreter: &mut Interpreter,
    world: &World,
    mut before: impl FnMut(&mut Interpreter),
) -> (Vec<Issued>, Option<hal_gcode::Error>) {
    let mut out = Vec::new();
    let mut asked = None;
    loop {
        before(interpreter);
        let step = match asked.take() {
            None => interpreter.next(world, &mut out),
            Some(request) => {
                let reply = answer(&request, interpreter);
                interpreter.answer(&reply, world, &mut out)
            }
        };
        match step {
            Ok(Step::Line) => {}
            Ok(Step::Ask(request)) => asked = Some(request),
            Ok(Step::Ended) => return (out, None),
            Err(error) => return (out, Some(error)),
        }
    }
}

pub(crate) fn run(name: &str, world: &World) -> (Vec<Issued>, Option<hal_gcode::Error>) {
    let mut interpreter = interpreter_of(name);
    interpreter.load(&format!("{name}.ngc"), world.open(name).unwrap());
    run_with(&mut interpreter, world, |_| {})
}

/// The calls that `rs274` prints too, in its form.
pub(crate) fn printed(calls: &[Issued]) -> Vec<String> {
    let silent = |c: &Call| matches!(c, Call::Wait { .. });
    calls.iter().filter(|i| !silent(&i.call)).map(|i| i.call.to_string()).collect()
}
