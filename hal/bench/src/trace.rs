//! Tables of inputs and outputs, replayed on a [`Bench`].
//!
//! A table is text, so that the same numbers can be tested here and measured elsewhere:
//!
//! ```text
//! # What the block shows.
//! load limit2 count=1
//! period 1000000
//! set limit2.0.maxv 100
//! run limit2.0
//! in limit2.0.in limit2.0.load
//! out limit2.0.out
//! 1 0 | 0.1
//! 1 . | .
//! expect limit2.0.out 0.2
//! ```
//!
//! `load` starts a block with its own bench. A row sets its inputs, runs the functions of `run`
//! once in their order, and compares its outputs. `.` leaves an input unchanged and an output
//! unchecked. `set` and `expect` act at their position in the table. `link PIN` links a pin to a
//! signal, which `set` then sets. Numbers must be equal, or differ by no more than `within`. Bits
//! are 0 and 1. `nan` equals itself.

use crate::Bench;
use hal_component::Component;

/// Replays every block of `table` with component type `C`. Returns the number of compared rows.
///
/// Panics at the first difference and names its line, as a test should.
#[track_caller]
#[expect(clippy::panic, reason = "a table for tests")]
pub fn replay<C: Component>(table: &str) -> usize {
    let (mut block, mut rows) = (Block::default(), 0);
    for (i, line) in table.lines().enumerate() {
        let line = line.trim();
        match block.line::<C>(line) {
            Ok(row) => rows += usize::from(row),
            Err(why) => panic!("line {}, `{line}`: {why}", i + 1),
        }
    }
    rows
}

struct Block {
    bench: Bench,
    period: i64,
    within: f64,
    run: Vec<String>,
    inputs: Vec<String>,
    outputs: Vec<String>,
}

impl Default for Block {
    fn default() -> Self {
        Self {
            bench: Bench::new(),
            period: 1_000_000,
            within: 0.0,
            run: Vec::new(),
            inputs: Vec::new(),
            outputs: Vec::new(),
        }
    }
}

impl Block {
    /// Executes a line. Returns true if it was a row.
    fn line<C: Component>(&mut self, line: &str) -> Result<bool, String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            [] => {}
            [first, ..] if first.starts_with('#') => {}
            ["load", name, args @ ..] => {
                *self = Self::default();
                if *name != C::NAME {
                    return Err(format!("this is a table of {}", C::NAME));
                }
                self.bench.load::<C>(args)?;
            }
            ["period", ns] => self.period = ns.parse().map_err(|_| "not a period")?,
            ["within", far] => self.within = number(far)?,
            ["run", names @ ..] => self.run = owned(names),
            ["in", names @ ..] => self.inputs = owned(names),
            ["out", names @ ..] => self.outputs = owned(names),
            ["link", name] => self.bench.link(name),
            ["set", name, value] => self.set(name, value)?,
            ["expect", name, value] => self.expect(name, value)?,
            _ => return self.row(line).map(|()| true),
        }
        Ok(false)
    }

    fn row(&self, line: &str) -> Result<(), String> {
        let (given, wanted) = line.split_once('|').ok_or("neither a command nor a row")?;
        for (name, value) in pairs(&self.inputs, given)? {
            self.set(name, value)?;
        }
        for name in &self.run {
            self.bench.try_run(name, self.period)?;
        }
        pairs(&self.outputs, wanted)?.iter().try_for_each(|(name, value)| self.expect(name, value))
    }

    fn set(&self, name: &str, value: &str) -> Result<(), String> {
        if value == "." {
            return Ok(());
        }
        match self.ty(name)?.as_str() {
            "bit" => self.bench.set(name, integer::<u8>(value)? != 0),
            "float" => self.bench.set(name, number(value)?),
            "s32" => self.bench.set(name, integer::<i32>(value)?),
            "u32" => self.bench.set(name, integer::<u32>(value)?),
            "s64" => self.bench.set(name, integer::<i64>(value)?),
            "u64" => self.bench.set(name, integer::<u64>(value)?),
            ty => return Err(format!("{name} is {ty}")),
        }
        Ok(())
    }

    fn expect(&self, name: &str, value: &str) -> Result<(), String> {
        if value == "." {
            return Ok(());
        }
        let is = match self.ty(name)?.as_str() {
            "bit" => u8::from(self.bench.get::<bool>(name)).to_string(),
            "float" => return self.expect_float(name, number(value)?),
            "s32" => self.bench.get::<i32>(name).to_string(),
            "u32" => self.bench.get::<u32>(name).to_string(),
            "s64" => self.bench.get::<i64>(name).to_string(),
            "u64" => self.bench.get::<u64>(name).to_string(),
            ty => return Err(format!("{name} is {ty}")),
        };
        if is == value { Ok(()) } else { Err(format!("{name} is {is}")) }
    }

    fn expect_float(&self, name: &str, value: f64) -> Result<(), String> {
        let is = self.bench.get::<f64>(name);
        // The first comparison is for infinities, whose difference is NaN.
        let near = is == value || (is - value).abs() <= self.within;
        if near || (is.is_nan() && value.is_nan()) {
            return Ok(());
        }
        Err(format!("{name} is {is:?}"))
    }

    fn ty(&self, name: &str) -> Result<String, String> {
        let names = self.bench.names();
        let mut lines = names.iter().filter_map(|line| line.strip_prefix(name));
        let ty = lines.find_map(|rest| rest.strip_prefix(' ')).and_then(|r| r.split(' ').next());
        ty.map(str::to_owned).ok_or_else(|| format!("no pin {name}"))
    }
}

fn owned(words: &[&str]) -> Vec<String> {
    words.iter().map(|w| (*w).to_owned()).collect()
}

fn pairs<'a>(names: &'a [String], values: &'a str) -> Result<Vec<(&'a str, &'a str)>, String> {
    let values: Vec<&str> = values.split_whitespace().collect();
    if values.len() != names.len() {
        return Err(format!("{} values for {} pins", values.len(), names.len()));
    }
    Ok(names.iter().map(String::as_str).zip(values).collect())
}

fn number(word: &str) -> Result<f64, String> {
    word.parse().map_err(|_| format!("`{word}' is not a number"))
}

fn integer<T: core::str::FromStr>(word: &str) -> Result<T, String> {
    word.parse().map_err(|_| format!("`{word}' is not a whole number in range"))
}

#[cfg(test)]
mod tests {
    use super::Block;
    use hal_component::{Builder, Component, Error, In, Out, Period, Touch, Update, Uses};

    struct Twice {
        from: In<f64>,
        to: Out<f64>,
    }

    impl Touch for Twice {
        fn touch(&self, uses: &mut Uses) {
            self.from.touch(uses);
            self.to.touch(uses);
        }
    }

    impl Update for Twice {
        fn update(&mut self, _: Period) {
            self.to.set(2.0 * self.from.get());
        }
    }

    impl Component for Twice {
        const NAME: &'static str = "twice";
        const DOC: &'static str = "Doubles.";
        fn create(b: &mut Builder<'_>) -> Result<(), Error> {
            let from = b.item("in", "Input.", 0.0)?;
            let to = b.item("out", "Output.", 0.0)?;
            b.function("", "Doubles.", Self { from, to })
        }
    }

    #[test]
    fn rows_are_compared() {
        let mut block = Block::default();
        for (line, wanted) in [
            ("# a comment", Ok(false)),
            ("load twice", Ok(false)),
            ("run twice.0", Ok(false)),
            ("in twice.0.in", Ok(false)),
            ("out twice.0.out", Ok(false)),
            ("3 | 6", Ok(true)),
            ("inf | inf", Ok(true)),
            ("nan | nan", Ok(true)),
            ("1 | 3", Err("twice.0.out is 2.0")),
            ("1 | nan", Err("twice.0.out is 2.0")),
            ("nan | 2", Err("twice.0.out is NaN")),
            ("4 | .", Ok(true)),
            ("expect twice.0.out 8", Ok(false)),
            ("expect twice.0.out 9", Err("twice.0.out is 8.0")),
            ("within 0.5", Ok(false)),
            (". | 8.5", Ok(true)),
            (". | 8.6", Err("twice.0.out is 8.0")),
            ("1 2 | 2", Err("2 values for 1 pins")),
            ("x | 2", Err("`x' is not a number")),
            ("set twice.0.nothing 1", Err("no pin twice.0.nothing")),
            ("nonsense", Err("neither a command nor a row")),
            ("load thrice", Err("this is a table of twice")),
        ] {
            assert_eq!(block.line::<Twice>(line), wanted.map_err(str::to_owned), "{line}");
        }
    }
}
