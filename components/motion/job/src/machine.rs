//! The machine that a program is for: its INI file, tool table and parameter file.

use crate::number::{self, count, is_one, number};
use crate::places::Places;
use crate::spindle::{self, Spindle};
use crate::travel::{coordinates, joint_axes, mask};
use crate::user_programs::UserPrograms;
use crate::world::{Version, version};
use hal_gcode::{
    Dialect, Numbered, Settings,
    axis::Axis,
    canon::Unit,
    function::Hook,
    parameters::file::{Finding, ParameterFile},
    remap::{self, Remap},
    state::modal::MAX_SPINDLES,
    tool::{self, ToolTable},
};
use hal_ini::Ini;
use hal_remap::{Functions, Setup};
use std::{
    collections::BTreeSet,
    fmt::Write as _,
    path::{Path, PathBuf},
};

/// The end of an axis's travel in millimetres or degrees, either side if it is stated.
pub type Limit = (Option<f64>, Option<f64>);

/// Highest speed, acceleration and jerk of an axis, in units per second, second squared and second cubed; `None` if not stated.
pub type Rates = [Option<f64>; 3];

/// Facts of a machine.
pub struct Machine {
    /// The interpreter's settings.
    pub settings: Settings,
    /// The tool table.
    pub tools: ToolTable,
    /// The file of the tool table.
    pub table: Option<PathBuf>,
    /// Size and time of change of that file when it was read or written last; `None` if there was none.
    pub table_version: Option<Version>,
    /// The tool in the spindle.
    pub spindle: Spindle,
    /// The file of the tool in the spindle.
    pub spindle_file: Option<PathBuf>,
    /// The numbered parameters at the start.
    pub numbered: Numbered,
    /// The parameter file and its values, to be written again after a run.
    pub parameters: Option<(PathBuf, ParameterFile)>,
    /// The folders of subroutines, in the order of the search.
    pub folders: Vec<PathBuf>,
    /// The folders of user programs M100 to M199.
    pub codes: UserPrograms,
    /// The folders of programs, uploads and output; `None` without an INI file.
    pub places: Option<Places>,
    /// The axes in the order of their joints.
    pub(crate) letters: Vec<Axis>,
    /// The ends of travel.
    pub limits: [Limit; 9],
    /// The lowest speeds, accelerations and jerks of the axes and of their joints.
    pub rates: [Rates; 9],
    /// The highest speeds along the path, in millimetres and in degrees per second; infinity if none is stated.
    pub top_speed: (f64, f64),
    /// The servo period in seconds.
    pub period: f64,
    /// The code that is run before the first program.
    pub startup: Option<String>,
    /// The INI file.
    pub ini: Option<Ini>,
    /// The folder of the INI file.
    pub folder: PathBuf,
    /// Remarks about the files: `file:line: text`.
    pub remarks: Vec<String>,
    /// The INI file's entries about functions in Python.
    pub python: Option<Setup>,
    /// The names of the functions that O-words call, once the functions have been started.
    pub words: BTreeSet<Box<str>>,
    /// The kinematics if joints are not axes: their limits are not those of a place.
    pub kinematics: Option<String>,
}

/// The files of a machine as the options name them.
#[derive(Default)]
pub struct Files<'a> {
    /// The INI file.
    pub ini: Option<&'a Path>,
    /// The tool table; that of the INI file if it is `None`.
    pub table: Option<&'a Path>,
    /// The parameter file; that of the INI file if it is `None`.
    pub parameters: Option<&'a Path>,
    /// The letters of the axes where the INI file has no `COORDINATES`; XYZ if it is `None`.
    pub letters: Option<&'a str>,
    /// The begin of the names of files that a machine without a section `RS274NGC` keeps: its parameters end with `var`, the
    /// record of its spindle with `spindle`. Without it, such a machine keeps none.
    pub state: Option<&'a Path>,
}

impl Machine {
    /// Reads the files. What can be read is read; the rest becomes a remark.
    ///
    /// # Errors
    /// A file that an option names cannot be read, or the INI file has an error.
    pub fn read(files: &Files<'_>) -> Result<Self, String> {
        let here = PathBuf::from(".");
        let mut out = Self {
            settings: Settings::default(),
            tools: ToolTable::default(),
            table: None,
            table_version: None,
            spindle: Spindle::Holds(0),
            spindle_file: None,
            numbered: Numbered::default(),
            parameters: None,
            folders: vec![here.clone()],
            codes: UserPrograms::new(vec![here.clone()], None),
            places: None,
            letters: Vec::new(),
            limits: [(None, None); 9],
            rates: [[None; 3]; 9],
            top_speed: (f64::INFINITY, f64::INFINITY),
            period: 1e-3,
            startup: None,
            ini: None,
            folder: here,
            remarks: Vec::new(),
            python: None,
            words: BTreeSet::new(),
            kinematics: None,
        };
        let (mut table, mut parameters) = (None, None);
        if let Some(path) = files.ini {
            let ini = Ini::read(path).map_err(|e| e.to_string())?;
            out.folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
            out.apply(&ini, files.letters.unwrap_or("XYZ"))?;
            let beside = |name: &str| hal_ini::beside(&out.folder, name);
            table = ini.get("EMCIO", "TOOL_TABLE").map(beside);
            let named = ini.get("EMCIO", "SPINDLE_FILE").map(beside);
            out.spindle_file = named.or_else(|| spindle::file(table.as_deref()?, files.state));
            parameters = ini.get("RS274NGC", "PARAMETER_FILE").map(beside);
            if ini.section("RS274NGC").next().is_none() {
                // Nothing is written beside an INI file that says nothing of programs.
                parameters = files.state.map(|state| state.with_extension("var"));
                let spindle = files.state.map(|state| state.with_extension("spindle"));
                out.spindle_file = out.spindle_file.and(spindle);
            }
            out.ini = Some(ini);
        }
        let asked = files.table.map(Path::to_path_buf);
        if let Some(path) = table.take_if(|path| asked.is_none() && !path.exists()) {
            let shown = path.display();
            out.remarks.push(format!("{shown}: the tool table is missing: there are no tools"));
            out.table = Some(path);
        }
        if let Some(path) = asked.or(table) {
            out.read_table(&path)?;
            out.table = Some(path);
        }
        out.read_spindle();
        let asked = files.parameters.map(Path::to_path_buf);
        if let Some(path) = asked.or(parameters) {
            out.read_parameters(path)?;
        }
        Ok(out)
    }

    fn apply(&mut self, ini: &Ini, letters: &str) -> Result<(), String> {
        let is_inch = ini.is_inch().map_err(number::not_a_unit)?;
        let unit = if is_inch { Unit::Inch } else { Unit::Millimetre };
        self.settings.unit = unit;
        self.settings.program_unit = unit;
        self.letters = coordinates(ini, letters);
        let letters = self.letters.clone();
        self.settings.axes = mask(&letters);
        let most = u8::try_from(MAX_SPINDLES).unwrap_or(u8::MAX);
        self.settings.spindles = count(ini, "TRAJ", "SPINDLES", most)?.unwrap_or(1);
        number::of_language(ini, &mut self.settings)?;
        let kinematics = ini.get("KINS", "KINEMATICS").unwrap_or("trivkins");
        let name = kinematics.split_whitespace().next().unwrap_or("trivkins");
        self.kinematics = (name != "trivkins").then(|| name.to_owned());
        for axis in Axis::ALL {
            self.axis(ini, axis, &letters)?;
        }
        self.speeds(ini, &letters)?;
        let places = Places::read(ini, &self.folder)?;
        self.folders = places.searched(ini, "SUBROUTINE_PATH", &self.folder);
        let codes = places.searched(ini, "USER_M_PATH", &self.folder);
        self.codes = UserPrograms::new(codes, Some(places.clone()));
        self.places = Some(places);
        self.startup = ini.get("RS274NGC", "RS274NGC_STARTUP_CODE").map(str::to_owned);
        self.settings.random_changer = is_one(ini, "EMCIO", "RANDOM_TOOLCHANGER");
        self.language(ini)?;
        self.python = Setup::read(ini, &self.folder)?;
        for entry in ini.all("RS274NGC", "REMAP") {
            let at = format!("{}:{}", entry.file, entry.line);
            let remap = match Remap::parse(&entry.value) {
                Ok(remap) => remap,
                // LinuxCNC keeps its own meaning of the code, too, and starts.
                Err(error @ remap::Error::Fixed { .. }) => {
                    self.remarks.push(format!("{at}: {error}: this line is ignored"));
                    continue;
                }
                Err(error) => return Err(format!("{at}: {error}")),
            };
            for hook in [Hook::Body, Hook::Prolog, Hook::Epilog] {
                if let Some(name) = remap.hook(hook).filter(|_| self.python.is_none()) {
                    let (code, option) = (remap.code, hook.option());
                    self.remarks.push(format!(
                        "{at}: REMAP {code}: {option}={name} is a function in Python, and there is no section [PYTHON]: {code} will be refused"
                    ));
                }
            }
            self.settings.remaps.push(remap);
        }
        Ok(())
    }

    /// Takes the language of programs, and the feed of programs that state none.
    fn language(&mut self, ini: &Ini) -> Result<(), String> {
        if let Some(entry) = ini.all("RS274NGC", "DIALECT").next() {
            let dialect = Dialect::named(&entry.value);
            self.settings.dialect = dialect.ok_or_else(|| number::wrong(entry, Dialect::NAMES))?;
        }
        if let Some(entry) = ini.all("RS274NGC", "DEFAULT_FEED").next() {
            let feed = number(ini, "RS274NGC", "DEFAULT_FEED")?;
            let feed = feed.filter(|f| *f > 0.0 && f.is_finite());
            let wanted = "a feed above 0 in the machine's units per minute";
            let feed = feed.ok_or_else(|| number::wrong(entry, wanted))?;
            self.settings.default_feed = feed * self.settings.unit.millimetres();
        }
        Ok(())
    }

    /// Takes the speeds of the path, and the speeds, accelerations and jerks of axes and joints.
    fn speeds(&mut self, ini: &Ini, letters: &[Axis]) -> Result<(), String> {
        let unit = self.settings.unit.millimetres();
        // Those that are not above 0 set no limit.
        let positive =
            |section: &str, name: &str| number(ini, section, name).map(|n| n.filter(|n| *n > 0.0));
        let lower = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => Some(a.min(b)),
            _ => a.or(b),
        };
        const NAMES: [&str; 3] = ["MAX_VELOCITY", "MAX_ACCELERATION", "MAX_JERK"];
        // The joints of other kinematics are no axes.
        let joints = if self.kinematics.is_none() { joint_axes(ini, letters) } else { Vec::new() };
        for axis in letters {
            let k = if axis.is_rotary() { 1.0 } else { unit };
            let own = format!("AXIS_{}", axis.letter().to_ascii_uppercase());
            let numbers = joints.iter().enumerate().filter(|(_, a)| *a == axis);
            let prefix = if ini.is_old() { "AXIS" } else { "JOINT" };
            let sections = numbers.map(|(n, _)| format!("{prefix}_{n}"));
            for section in core::iter::once(own).chain(sections) {
                let Some(rates) = self.rates.get_mut(usize::from(axis.index())) else { continue };
                for (rate, name) in rates.iter_mut().zip(NAMES) {
                    *rate = lower(*rate, positive(&section, name)?.map(|v| v * k));
                }
            }
        }
        let (first, second) =
            (positive("TRAJ", "MAX_LINEAR_VELOCITY")?, positive("TRAJ", "MAX_VELOCITY")?);
        self.top_speed.0 = first.or(second).map_or(f64::INFINITY, |v| v * unit);
        self.top_speed.1 = positive("TRAJ", "MAX_ANGULAR_VELOCITY")?.unwrap_or(f64::INFINITY);
        self.period = positive("EMCMOT", "SERVO_PERIOD")?.map_or(1e-3, |ns| ns * 1e-9);
        Ok(())
    }

    /// Starts the functions in Python of the machine, if the INI file has any. What is wrong with them is a remark, and an
    /// error of each line that calls one.
    ///
    /// `stands_still`: the instance answers nothing while a function works.
    pub fn start_functions(&mut self, stands_still: bool) -> Option<Functions> {
        let mut setup = self.python.clone()?;
        setup.stands_still = stands_still;
        setup.task = u8::from(self.settings.task);
        let (functions, result) = Functions::start(setup);
        self.words.clone_from(functions.words());
        if let Err(why) = result {
            self.remarks.push(format!("[PYTHON]: {why}"));
        }
        Some(functions)
    }

    /// Reads the tool table again.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn reload_tools(&mut self) -> Result<(), String> {
        let table = self.table.clone();
        table.map_or(Ok(()), |path| self.read_table(&path))
    }

    /// Reads which tool is in the spindle. Without a record, a fixed changer starts without a tool.
    fn read_spindle(&mut self) {
        if self.settings.random_changer {
            let tool = self.tools.tools.iter().find(|t| t.pocket == 0);
            self.spindle = Spindle::Holds(tool.map_or(0, |t| t.number));
        }
        let Some(path) = self.spindle_file.as_ref().filter(|path| path.exists()) else { return };
        let record = text(path).map(|text| spindle::parse(&text));
        match record {
            // The table of a random changer has the tool in the spindle, unless a change was cut off.
            Ok(Some(Spindle::Holds(tool)))
                if self.settings.random_changer && tool != spindle::UNKNOWN => {}
            Ok(Some(record)) => self.spindle = record,
            Ok(None) => {
                self.spindle = Spindle::Holds(spindle::UNKNOWN);
                let name = path.display();
                self.remarks
                    .push(format!("{name}: the record of the tool in the spindle is damaged"));
            }
            Err(why) => {
                self.spindle = Spindle::Holds(spindle::UNKNOWN);
                self.remarks.push(why);
            }
        }
    }

    /// Checks that nobody has edited the file of the tool table since it was read.
    ///
    /// # Errors
    /// The file has changed.
    pub fn check_table(&self) -> Result<(), String> {
        let Some((path, known)) = self.table.as_ref().zip(self.table_version) else {
            return Ok(());
        };
        if version(path).is_ok_and(|now| now == known) {
            return Ok(());
        }
        let name = path.display();
        Err(format!("{name}: the tool table has changed since it was read: G10 L0 reads it again"))
    }

    /// Takes the file of the tool table as it is now for the one that is known.
    pub fn note_table(&mut self) {
        self.table_version = self.table.as_deref().and_then(|path| version(path).ok());
    }

    fn read_table(&mut self, path: &Path) -> Result<(), String> {
        let (table, findings) = ToolTable::parse(&text(path)?);
        for finding in findings {
            let (line, what) = match finding {
                tool::Finding::Malformed { line } => {
                    (line, "no tool: the line begins with T and a number")
                }
                tool::Finding::Duplicate { line } => {
                    (line, "the tool's number came before; the first one counts")
                }
            };
            self.remarks.push(format!("{}:{line}: {what}", path.display()));
        }
        self.tools = table;
        self.table_version = version(path).ok();
        Ok(())
    }

    fn read_parameters(&mut self, path: PathBuf) -> Result<(), String> {
        // A parameter file that is not there yet is made at the end.
        let file = if path.exists() {
            ParameterFile::parse(&text(&path)?)
        } else {
            ParameterFile::default()
        };
        let name = path.display();
        for finding in &file.findings {
            let mut remark = format!("{name}");
            let what = match finding {
                Finding::Malformed { line } => (Some(line), "not a number and a value"),
                Finding::OutOfRange { line } => {
                    (Some(line), "there is no parameter of this number")
                }
                Finding::Duplicate { line } => {
                    (Some(line), "the parameter came before; the last value counts")
                }
                Finding::NoLineEnd => {
                    (None, "the last line has no end: the file may have been cut off")
                }
            };
            if let Some(line) = what.0 {
                write!(remark, ":{line}").map_err(|e| e.to_string())?;
            }
            self.remarks.push(format!("{remark}: {}", what.1));
        }
        file.apply(&mut self.numbered);
        number::forget_g92(self.ini.as_ref(), &mut self.numbered);
        self.parameters = Some((path, file));
        Ok(())
    }
}

fn text(path: &Path) -> Result<String, String> {
    let bytes = hal_ini::file::whole(path);
    let bytes = bytes.map_err(|e| format!("{}: {}", path.display(), hal_output::reason(&e)))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
