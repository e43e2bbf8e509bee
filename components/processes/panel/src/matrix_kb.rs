//! `matrix_kb`.
use hal_component::{
    Arg, Builder, Component, Error, In, Out, ParamRw, Period, Touch, Update,
    abi::{ArgSpec, component_flags},
};

/// Maximum number of columns.
const COLUMNS: u32 = 32;
/// Maximum number of rows.
const ROWS: u32 = 256;
/// Default number of keys that may be held.
const ROLLOVER: u32 = 2;
/// Code while nothing changes.
const IDLE: u32 = 0x40;

/// Keyboards with keys in rows and columns.
pub(crate) struct MatrixKb;

impl Component for MatrixKb {
    const NAME: &'static str = "matrix_kb";
    const DOC: &'static str = "Matrix keyboard of rows and columns, with a bit for each key.\n\n\
        `config=4x8,8x8s` makes `matrix_kb.0` with four rows of eight columns, and `matrix_kb.1` with \
        eight, which scans. There are 1 to 256 rows and 1 to 32 columns; `names=a,b` gives other names. \
        Keys are `key.r1c0` and so on, with numbers in hexadecimal, from 0.\n\n\
        Without the letter `s` a device such as a Mesa 7I73 tells codes at `keycode`: 192 and the key's \
        number as it is pressed, 128 and its number as it is released; anything else changes nothing. \
        The number is its row times the columns, rounded up to the next power of two from 2, and its \
        column: in 2 rows of 3 columns, r1c2 is 6. Above 192 numbers the 192 and the 128 \
        are doubled until they are enough. Two keys are heard at once.\n\n\
        With `s` it scans. Each run reads the columns of one row, then selects the next row. When a row is \
        read twice alike, each key in it that was otherwise the time before is reported, also at \
        `keycode`; so a key that changes while another one of its row bounces may stay unheard. While as many keys are held as `key_rollover` allows, no more are heard, and one that \
        was not heard then stays so until it is pressed again; a release counts in any case. Keys whose \
        numbers reach into the 128 are not heard: from row 8 on with eight columns and no more than 24 rows.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt matrix_kb config=2x3\n\
        loadrt threads name1=servo period1=1000000\n\
        addf matrix_kb.0 servo\n\
        start\n\
        setp matrix_kb.0.keycode 0xC6\n\
        run 1ms\n\
        getp matrix_kb.0.key.r1c2 # -> TRUE\n\
        setp matrix_kb.0.keycode 0x86\n\
        run 1ms\n\
        getp matrix_kb.0.key.r1c2 # -> FALSE\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::texts("config", "Rows and columns of each keyboard, such as 4x8; 4x8s scans.")
            .required()
            .at_most(32),
        &Arg::texts("names", "Names of the keyboards, as many as there are; without it, numbers.")
            .at_most(32),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let sizes: Result<Vec<Size>, _> =
            b.arg_texts("config").iter().map(|t| Size::read(t)).collect();
        let (sizes, names) = (sizes?, b.arg_texts("names"));
        if !names.is_empty() && names.len() != sizes.len() {
            return Err(Error::new(format!(
                "names= has {} of them, and config= {} keyboards: as many of each are needed",
                names.len(),
                sizes.len()
            )));
        }
        for (i, size) in sizes.iter().enumerate() {
            let name = names.get(i).cloned().unwrap_or_else(|| format!("matrix_kb.{i}"));
            keyboard(b, &name, size)?;
        }
        Ok(())
    }
}

/// Declares one keyboard.
fn keyboard(b: &mut Builder<'_>, name: &str, size: &Size) -> Result<(), Error> {
    let mut keys = Keys { codes: Codes::of(size), pins: Vec::new(), held: 0 };
    for row in 0..size.rows {
        for column in 0..size.columns {
            let pin = format!("{name}.key.r{row:x}c{column:x}");
            keys.pins.push(b.item(&pin, "True while the key is held.", false)?);
        }
    }
    let keycode = format!("{name}.keycode");
    if !size.scans {
        let keycode = b.item(&keycode, "Code received from the device.", 0)?;
        return b.function(name, "Receives one code.", Receiver { keycode, keys });
    }
    let doc = "Key event of this run, the last if there were several; 64 without an event.";
    let keycode = b.item(&keycode, doc, 0)?;
    let (mut rows, mut columns) = (Vec::new(), Vec::new());
    for i in 0..size.rows {
        let pin = b.item(&format!("{name}.row-{i:02}-out"), "Selects the row.", false)?;
        rows.push(Row { pin, seen: 0, before: 0 });
    }
    for i in 0..size.columns {
        let doc = "The column, in the row that is selected.";
        columns.push(b.item(&format!("{name}.col-{i:02}-in"), doc, false)?);
    }
    let scan = Scan {
        columns,
        keycode,
        negative: b.item(
            &format!("{name}.negative-logic"),
            "True: a row is selected by false, and a column is false where a key is pressed; false: both by true.",
            true,
        )?,
        rollover: b.item(
            &format!("{name}.key_rollover"),
            "Number of keys that may be held at once, from 0; more than the default only if the \
            keyboard can distinguish the keys.",
            ROLLOVER,
        )?,
        rows,
        keys,
        selected: 0,
    };
    b.function(name, "Reads one row, and selects the next.", scan)
}

/// Size of a keyboard.
#[derive(Debug, PartialEq, Eq)]
struct Size {
    rows: u32,
    columns: u32,
    scans: bool,
}

impl Size {
    /// Parses a text such as `4x8s`.
    fn read(text: &str) -> Result<Self, Error> {
        let lower = text.to_ascii_lowercase();
        let (digits, scans) = lower.strip_suffix('s').map_or((&*lower, false), |d| (d, true));
        let number = |digits: &str, most: u32| {
            let n = digits.bytes().all(|d| d.is_ascii_digit()).then(|| digits.parse().ok());
            n.flatten().filter(|n| (1..=most).contains(n))
        };
        digits
            .split_once('x')
            .and_then(|(r, c)| {
                Some(Self { rows: number(r, ROWS)?, columns: number(c, COLUMNS)?, scans })
            })
            .ok_or_else(|| {
                Error::new(format!(
                    "config={text} is not a size: it is rows (1 to {ROWS}), x, columns \
                     (1 to {COLUMNS}), and s if it shall scan, such as 4x8s"
                ))
            })
    }
}

/// Layout of a keyboard's codes.
#[derive(Clone, Copy, Debug)]
struct Codes {
    rows: u32,
    columns: u32,
    /// Number of bits of the column, below the row.
    shift: u32,
    /// Two bits that a code has set while its key is pressed.
    press: u32,
}

impl Codes {
    fn of(size: &Size) -> Self {
        let Size { rows, columns, .. } = *size;
        let shift = columns.max(2).next_power_of_two().trailing_zeros();
        let mut press = 0xC0;
        while rows << shift > press {
            press <<= 1;
        }
        Self { rows, columns, shift, press }
    }

    /// Returns the upper of the two bits, which a code has set when its key is released.
    const fn release(self) -> u32 {
        self.press / 3 * 2
    }

    const fn number(self, row: u32, column: u32) -> u32 {
        (row << self.shift) + column
    }

    /// Returns the index of the key that a code names, in the list of all keys.
    fn place(self, code: u32) -> Option<usize> {
        let number = code & !self.press;
        let (row, column) = (number >> self.shift, number & ((1 << self.shift) - 1));
        let is_key = row < self.rows && column < self.columns;
        is_key.then_some((row * self.columns + column) as usize)
    }
}

/// Keys of a keyboard.
#[derive(Touch)]
struct Keys {
    /// Pins, row by row.
    pins: Vec<Out<bool>>,
    #[state]
    codes: Codes,
    /// Number of held keys, limited by the rollover.
    #[state]
    held: u32,
}

impl Keys {
    fn press(&mut self, code: u32, most: u32) {
        let key = self.codes.place(code).and_then(|i| self.pins.get(i));
        if let Some(key) = key
            && self.held < most
        {
            key.set(true);
            self.held += 1;
        }
    }

    fn release(&mut self, code: u32) {
        if let Some(key) = self.codes.place(code).and_then(|i| self.pins.get(i)) {
            key.set(false);
            self.held = self.held.saturating_sub(1);
        }
    }
}

/// Keyboard whose device delivers codes.
#[derive(Touch)]
struct Receiver {
    keycode: In<u32>,
    keys: Keys,
}

impl Update for Receiver {
    fn update(&mut self, _: Period) {
        let (code, codes) = (self.keycode.get(), self.keys.codes);
        if code & codes.press == codes.press {
            self.keys.press(code, ROLLOVER);
        } else if code & codes.press == codes.release() {
            self.keys.release(code);
        }
    }
}

/// Row that is scanned.
#[derive(Touch)]
struct Row {
    pin: Out<bool>,
    /// Columns at the last scan, one bit each.
    #[state]
    seen: u32,
    /// Columns at the scan before.
    #[state]
    before: u32,
}

/// Keyboard that is scanned.
#[derive(Touch)]
struct Scan {
    columns: Vec<In<bool>>,
    negative: ParamRw<bool>,
    rollover: ParamRw<u32>,
    keycode: Out<u32>,
    rows: Vec<Row>,
    keys: Keys,
    /// Selected row.
    #[state]
    selected: u32,
}

impl Update for Scan {
    fn update(&mut self, _: Period) {
        let negative = self.negative.get();
        let now = self
            .columns
            .iter()
            .rev()
            .fold(0, |bits, column| bits << 1 | u32::from(column.get() != negative));
        self.keycode.set(IDLE);
        let number = self.selected;
        if let Some(row) = self.rows.get_mut(number as usize) {
            let (seen, before) = (row.seen, row.before);
            (row.seen, row.before) = (now, seen);
            if now == seen {
                self.tell(number, now, now ^ before);
            }
        }
        if let Some(row) = self.rows.get(number as usize) {
            row.pin.set(negative);
        }
        self.selected = if number + 1 < self.keys.codes.rows { number + 1 } else { 0 };
        if let Some(row) = self.rows.get(self.selected as usize) {
            row.pin.set(!negative);
        }
    }
}

impl Scan {
    /// Reports the keys of a row that have changed.
    fn tell(&mut self, row: u32, now: u32, changed: u32) {
        let codes = self.keys.codes;
        for column in (0..codes.columns).filter(|c| changed >> c & 1 != 0) {
            let number = codes.number(row, column);
            if now >> column & 1 != 0 {
                let code = codes.press + number;
                self.keycode.set(code);
                self.keys.press(code, self.rollover.get());
            } else {
                let code = codes.release() + number;
                self.keycode.set(code);
                self.keys.release(code);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::MatrixKb;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn codes() {
        let rows = "load matrix_kb config=2x3
            run matrix_kb.0
            in matrix_kb.0.keycode
            out matrix_kb.0.key.r0c0 matrix_kb.0.key.r0c1 matrix_kb.0.key.r1c0 matrix_kb.0.key.r1c2
            0    | 0 0 0 0
            0xC0 | 1 0 0 0
            0x40 | 1 0 0 0
            0x80 | 0 0 0 0
            0xC4 | 0 0 1 0
            0xC6 | 0 0 1 1
            # A third key waits for nobody, and one that is not there is none.
            0xC1 | 0 0 1 1
            0xC3 | 0 0 1 1
            0xC8 | 0 0 1 1
            0x83 | 0 0 1 1
            0xC1 | 0 0 1 1
            0x84 | 0 0 0 1
            0xC1 | 0 1 0 1
            0x1C1 | 0 1 0 1
            0x186 | 0 1 0 1
            0x86 | 0 1 0 0
            0x81 | 0 0 0 0";
        assert_eq!(replay::<MatrixKb>(&decimal(rows)), 17);
    }

    #[test]
    fn a_code_that_stays_counts_each_time() {
        let rows = "load matrix_kb config=8x8
            run matrix_kb.0
            in matrix_kb.0.keycode
            out matrix_kb.0.key.r0c0 matrix_kb.0.key.r0c1 matrix_kb.0.key.r0c2
            0xC0 | 1 0 0
            0xC0 | 1 0 0
            0xC1 | 1 0 0
            0x81 | 1 0 0
            0xC1 | 1 1 0
            0xC2 | 1 1 0
            # Below none it does not count.
            0x80 | 0 1 0
            0x80 | 0 1 0
            0x80 | 0 1 0
            0xC0 | 1 1 0
            0xC2 | 1 1 1";
        assert_eq!(replay::<MatrixKb>(&decimal(rows)), 11);
    }

    #[test]
    fn codes_of_large_keyboards() {
        for (size, press, key) in [
            ("48x4", 0xC0_u32 + 0x3F, "rfc3"),
            ("49x4", 0x180 + 0x7F, "r1fc3"),
            ("97x4", 0x300 + 0xFF, "r3fc3"),
            ("128x8", 0x600 + 0xFF, "r1fc7"),
            ("1x32", 0xC0 + 0x1F, "r0c1f"),
            ("4x1", 0xC0 + 6, "r3c0"),
        ] {
            let mut bench = Bench::new();
            bench.load::<MatrixKb>(&[&format!("config={size}")]).unwrap();
            bench.set("matrix_kb.0.keycode", press);
            bench.run("matrix_kb.0", 1_000_000);
            assert!(bench.get::<bool>(&format!("matrix_kb.0.key.{key}")), "{size}");
        }
    }

    /// Simulated keys at the crossings of rows and columns.
    struct Keyboard {
        bench: Bench,
        rows: u32,
        columns: u32,
        held: Vec<(u32, u32)>,
        negative: bool,
    }

    impl Keyboard {
        fn new(rows: u32, columns: u32, negative: bool) -> Self {
            let mut bench = Bench::new();
            bench.load::<MatrixKb>(&[&format!("config={rows}x{columns}s"), "names=kb"]).unwrap();
            bench.set("kb.negative-logic", negative);
            Self { bench, rows, columns, held: Vec::new(), negative }
        }

        fn turn(&self) {
            for c in 0..self.columns {
                let pulled = (0..self.rows).any(|r| {
                    let selected = self.bench.get::<bool>(&format!("kb.row-{r:02}-out"));
                    selected != self.negative && self.held.contains(&(r, c))
                });
                self.bench.set(&format!("kb.col-{c:02}-in"), pulled != self.negative);
            }
            self.bench.run("kb", 1_000_000);
        }

        /// Holds these keys for three scans. Returns the codes, and the keys that are on.
        fn hold(&mut self, keys: &[(u32, u32)]) -> (Vec<u32>, Vec<(u32, u32)>) {
            self.held = keys.to_vec();
            let mut codes = Vec::new();
            for _ in 0..3 * self.rows {
                self.turn();
                codes.push(self.bench.get("kb.keycode"));
            }
            codes.retain(|c| *c != 64);
            let all = (0..self.rows).flat_map(|r| (0..self.columns).map(move |c| (r, c)));
            let on = |(r, c): &(u32, u32)| self.bench.get(&format!("kb.key.r{r:x}c{c:x}"));
            (codes, all.filter(on).collect())
        }
    }

    #[test]
    fn scanning_finds_every_key() {
        for negative in [true, false] {
            let mut kb = Keyboard::new(8, 8, negative);
            assert_eq!(kb.hold(&[]), (vec![], vec![]));
            for key in (0..8).flat_map(|r| (0..8).map(move |c| (r, c))) {
                let number = key.0 * 8 + key.1;
                assert_eq!(kb.hold(&[key]), (vec![192 + number], vec![key]));
                assert_eq!(kb.hold(&[]), (vec![128 + number], vec![]));
            }
        }
    }

    #[test]
    fn rollover() {
        let mut kb = Keyboard::new(4, 4, true);
        // Of three keys in a row, only the last appears in the code.
        assert_eq!(kb.hold(&[(0, 0), (0, 1), (0, 2)]), (vec![194], vec![(0, 0), (0, 1)]));
        // Releasing the key that was ignored counts as well.
        assert_eq!(kb.hold(&[(0, 0), (0, 1)]), (vec![130], vec![(0, 0), (0, 1)]));
        let three = vec![(0, 0), (0, 1), (0, 3)];
        assert_eq!(kb.hold(&three), (vec![195], three));
        kb.hold(&[]);
        kb.bench.set("kb.key_rollover", 4_u32);
        let four = vec![(0, 0), (1, 1), (2, 2), (3, 3)];
        assert_eq!(kb.hold(&four).1, four);
        kb.hold(&[]);
        kb.bench.set("kb.key_rollover", 0_u32);
        assert_eq!(kb.hold(&[(1, 2)]), (vec![198], vec![]));
    }

    #[test]
    fn a_key_that_bounces_is_no_key() {
        let mut kb = Keyboard::new(2, 2, true);
        for i in 0..20 {
            kb.held = if i / 2 % 2 == 0 { vec![(0, 1)] } else { Vec::new() };
            kb.turn();
            assert_eq!(kb.bench.get::<u32>("kb.keycode"), 64);
        }
        assert_eq!(kb.hold(&[(0, 1)]), (vec![193], vec![(0, 1)]));
    }

    #[test]
    fn wrong_sizes_make_nothing() {
        for wrong in
            ["4", "x4", "4x", "0x4", "4x0", "4x33", "257x4", "4x4q", "-1x4", "4x4x4", "+4x4", ""]
        {
            let mut bench = Bench::new();
            let said = bench.load::<MatrixKb>(&[&format!("config=4x4,{wrong}")]).unwrap_err();
            let wanted = format!(
                "config={wrong} is not a size: it is rows (1 to 256), x, columns (1 to 32), \
                 and s if it shall scan, such as 4x8s"
            );
            assert_eq!(said, wanted);
            assert!(bench.names().is_empty());
        }
        let mut bench = Bench::new();
        let said = bench.load::<MatrixKb>(&["config=4x4,2x2", "names=a"]).unwrap_err();
        let wanted = "names= has 1 of them, and config= 2 keyboards: as many of each are needed";
        assert_eq!(said, wanted);
    }

    /// Converts the numbers of a table to decimal, as the replay reads them.
    fn decimal(rows: &str) -> String {
        let number = |w: &str| {
            let hex = w.strip_prefix("0x").map(|h| u32::from_str_radix(h, 16).unwrap());
            hex.map_or_else(|| w.to_owned(), |n| n.to_string())
        };
        let line = |l: &str| l.split(' ').map(number).collect::<Vec<_>>().join(" ");
        rows.lines().map(line).collect::<Vec<_>>().join("\n")
    }
}
