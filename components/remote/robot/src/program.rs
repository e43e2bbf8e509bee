//! A program for the robot: its file, its lines, and what they were checked for.

use crate::{Command, FASTEST, Record, Volume, Zero, convert};
use std::{
    fs::File,
    io::Read as _,
    path::{Path, PathBuf},
};

/// Largest size of a file in bytes.
const MAX_BYTES: u64 = 256 << 20;
/// Cutting speeds that are usual, in millimetres per second.
const USUAL: core::ops::RangeInclusive<f64> = 5.0..=10.0;

/// A program whose every point is in the work volume.
#[derive(Clone, Debug)]
pub struct Program {
    /// File that it was read from.
    pub file: PathBuf,
    /// Lines to the robot.
    pub records: Vec<Record>,
    /// Remarks for the operator.
    pub warnings: Vec<String>,
    /// Part zero that it was checked for.
    pub zero: Zero,
    /// Length of the tool that it was checked for.
    pub tool: f64,
    /// Highest cutting speed, in millimetres per second.
    pub speed: f64,
}

impl Program {
    /// Reads and checks a program. `speed` is the operator's cutting speed in millimetres per second.
    ///
    /// # Errors
    /// The speed or the tool is out of range, the file cannot be read, or the robot cannot follow it; the text names the file,
    /// the line and the point.
    pub fn read(path: &Path, volume: &Volume, zero: &Zero, speed: f64) -> Result<Self, String> {
        // NaN is refused too.
        if !(0.0 < speed && speed <= FASTEST) {
            return Err(format!(
                "the cutting speed is {speed}: above 0 and at most {FASTEST} mm/s"
            ));
        }
        if !(0.0..=500.0).contains(&volume.tool) {
            let tool = volume.tool;
            return Err(format!("the length of the tool is {tool}: from 0 to 500 mm"));
        }
        let name = path.display();
        let text = read(path).map_err(|e| format!("{name}: {e}"))?;
        let (records, mut warnings) =
            convert(&text, volume, zero, speed).map_err(|e| format!("{name}: {e}"))?;
        if !USUAL.contains(&speed) {
            warnings.push(format!("the cutting speed is {speed} mm/s; 5 to 10 is usual"));
        }
        Ok(Self { file: path.to_owned(), records, warnings, zero: *zero, tool: volume.tool, speed })
    }

    /// Returns the lines to the robot.
    #[must_use]
    pub fn commands(&self) -> Vec<Command> {
        self.records.iter().map(|record| record.command).collect()
    }

    /// Checks that a part zero is that of the load, within a distance in millimetres.
    ///
    /// # Errors
    /// It is another: the points were checked for the one before, and a part that is half cut lies there. The text names it.
    pub fn check_zero(&self, zero: &Zero, within: f64) -> Result<(), String> {
        let [x, y, z] = self.zero;
        if zero.iter().zip(&self.zero).all(|(a, b)| (a - b).abs() <= within) {
            return Ok(());
        }
        let back = if within > 0.0 {
            "move the tool back to it, and robot.connect"
        } else {
            "robot.load again"
        };
        Err(format!(
            "the part zero has changed since the program was loaded: {back} (it was X{x:.3} Y{y:.3} Z{z:.3} of the robot)"
        ))
    }

    /// Checks the points of [`approach`], of which one is none of the program's.
    ///
    /// # Errors
    /// The tool must not go there; the text names the point.
    pub fn check_approach(&self, volume: &Volume, from: usize) -> Result<(), String> {
        for [x, y, z] in approach(&self.commands(), from).iter().filter_map(Command::target) {
            volume.check(Volume::robot(&self.zero, [x, y, z])).map_err(|why| {
                let file = self.file.display();
                format!("{file}: the way to line {from}: X{x:.3} Y{y:.3} Z{z:.3} is {why}")
            })?;
        }
        Ok(())
    }

    /// Returns the lines of the program and of the robot side by side, with a tab between them.
    #[must_use]
    pub fn table(&self) -> String {
        self.records.iter().map(|r| format!("{}\t{}\n", r.text, r.command)).collect()
    }
}

/// Returns the lines that precede those of a run from an index on. What was before is made good: the cutting speed, and the
/// place of the tool, which goes above the last point at the greatest height of the lines, and down to it.
#[must_use]
pub fn approach(lines: &[Command], from: usize) -> Vec<Command> {
    let before = |is: fn(&Command) -> bool| lines.iter().take(from).rev().copied().find(is);
    let speed = before(|c| matches!(c, Command::Speed(_)));
    let last = before(|c| c.target().is_some());
    let top = lines.iter().filter_map(Command::target).map(|[.., z]| z).reduce(f64::max);
    let above = last.and_then(|c| c.target()).zip(top);
    let above = above.map(|([x, y, _], z)| Command::Rapid([x, y, z]));
    [Some(Command::Start), speed, above, last].into_iter().flatten().collect()
}

/// Reads a regular file.
fn read(path: &Path) -> Result<Vec<u8>, String> {
    let reason = |e: std::io::Error| hal_output::reason(&e);
    // Before it is opened: a pipe waits for its writer.
    if std::fs::metadata(path).is_ok_and(|found| !found.is_file()) {
        return Err("this is no regular file".to_owned());
    }
    let file = File::open(path).map_err(reason)?;
    if !file.metadata().map_err(reason)?.is_file() {
        return Err("this is no regular file".to_owned());
    }
    let mut text = Vec::new();
    let size = file.take(MAX_BYTES + 1).read_to_end(&mut text).map_err(reason)?;
    if size as u64 > MAX_BYTES {
        return Err(format!("the file has more than {} MiB", MAX_BYTES >> 20));
    }
    Ok(text)
}
