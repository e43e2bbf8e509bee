//! `lcd`.
mod field;
mod format;

use field::{Field, Line};
use format::{Kind, Part};
use hal_component::{
    Arg, Builder, Component, Error, In, Out, ParamRw, Period, Touch, Update, Uses,
    abi::{ArgSpec, component_flags},
};

/// Maximum number of displays.
const MAX: u32 = 16;
/// Number of turns over the displays before the first character.
const WAIT: u32 = 100;
/// First characters for a display: four empty lines, and cursor off.
const BEGIN: [u8; 13] = *b"\r\n\x18\r\n\x18\r\n\x18\r\n\x18\x11";
/// Sequence that clears the display.
const CLEAR: [u8; 3] = *b"\x11\x1E\x1A";
/// Sequence that begins the next line.
const NEW_LINE: [u8; 3] = *b"\x18\n\r";
/// Sequence that moves the cursor to the first character.
const HOME: [u8; 4] = *b"\x1B=  ";

/// Displays that show texts with values in them.
pub(crate) struct Lcd;

impl Component for Lcd {
    const NAME: &'static str = "lcd";
    const DOC: &'static str = "Text with values for a character display, sent one character per \
        run.\n\n\
        It was made for the display at a Mesa 7I73. `fmt_strings=` has a text for each display, \
        separated by commas, and `|` between its pages; `page_num` selects one, and one that is not there \
        stops the stream. After 100 runs, or 50 with two displays, a display is cleared; then the page is sent again \
        and again. Texts may have:\n\n\
        - `\\n`, the rest of the line is cleared and the next begins; `\\t`, four blanks; `\\\\`; `\\2C`, \
        the character of this code in hexadecimal, here the comma; `%%`;\n\
        - `%f`, a float; `%i` or `%d`, an s32; `%u`, `%x`, `%o`, a u32 in base 10, 16 and 8; `%c`, a u32 that is \
        the code of a character, repeated over the field, blanks below 32; `%bXY`, a bit, X if it is \
        true, else Y.\n\n\
        Each of them is a pin, `page.PP.arg.AA`. After the `%` there may be `0`, to fill up with zeros, and `+`, \
        for a sign in any case (a blank and `-` change nothing); the width, 1 to 20; a point and the number of decimals, \
        4 if none is given, at most the width less 1. A number that does not fit is asterisks; without a width a \
        field is as wide as it must be.\n\n\
        Characters from 128 on come as negative numbers: `\\FF` is 4294967295, as in LinuxCNC. Other than there, \
        `%%` and `\\\\` give what they say, `%c` needs no width, and the second character of `%b` may be an escape.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt lcd fmt_strings=\"X%7.2f\"\n\
        loadrt threads name1=servo period1=1000000\n\
        addf lcd servo\n\
        setp lcd.00.page.00.arg.00 12.5\n\
        start\n\
        run 117ms\n\
        getp lcd.00.out # -> 88\n\
        run 3ms\n\
        getp lcd.00.out # -> 49\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[&Arg::texts(
        "fmt_strings",
        "A text for each display, separated by commas, such as `X%6.2f`.",
    )
    .required()
    .at_most(MAX)];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let texts = b.arg_texts("fmt_strings");
        let mut displays = Vec::new();
        for text in &texts {
            let pages = format::read(text)
                .map_err(|why| Error::new(format!("fmt_strings={text}: {why}")))?;
            displays.push(pages);
        }
        let displays: Result<Vec<_>, _> = displays
            .into_iter()
            .enumerate()
            .map(|(i, pages)| Display::declare(b, i, pages))
            .collect();
        b.function(
            "lcd",
            "Sends the next character of each display.",
            Displays { all: displays?, turns: 0 },
        )
    }
}

/// All displays.
#[derive(Touch)]
struct Displays {
    all: Vec<Display>,
    /// Turns over the displays so far, counted up to the first character.
    #[state]
    turns: u32,
}

/// Display.
#[derive(Touch)]
struct Display {
    out: Out<u32>,
    page_num: In<u32>,
    contrast: In<f64>,
    separator: ParamRw<u32>,
    pages: Vec<Page>,
    /// Characters to be sent before anything else.
    #[state]
    line: Line,
    /// Page that is shown.
    #[state]
    shown: Option<usize>,
    /// Contrast that was sent.
    #[state]
    contrast_sent: f64,
    /// Next part of the page; the index after the last part stands for the page's end.
    #[state]
    part: usize,
}

/// Parts of a page.
#[derive(Touch)]
struct Page {
    parts: Vec<Shown>,
}

/// Part of a page, with its pin.
enum Shown {
    Byte(u8),
    Text(&'static [u8]),
    Float(In<f64>, Field),
    Signed(In<i32>, Field),
    Unsigned(In<u32>, u64, Field),
    Character(In<u32>, Field),
    Bit(In<bool>, u8, u8),
}

impl Touch for Shown {
    fn touch(&self, uses: &mut Uses) {
        match self {
            Self::Byte(_) | Self::Text(_) => {}
            Self::Float(pin, _) => pin.touch(uses),
            Self::Signed(pin, _) => pin.touch(uses),
            Self::Unsigned(pin, ..) | Self::Character(pin, _) => pin.touch(uses),
            Self::Bit(pin, ..) => pin.touch(uses),
        }
    }
}

impl Display {
    fn declare(b: &mut Builder<'_>, i: usize, pages: Vec<Vec<Part>>) -> Result<Self, Error> {
        let name = format!("lcd.{i:02}");
        let mut list = Vec::new();
        for (p, parts) in pages.into_iter().enumerate() {
            let (mut page, mut arg) = (Vec::new(), 0);
            for part in parts {
                page.push(match part {
                    Part::Byte(byte) => Shown::Byte(byte),
                    Part::NewLine => Shown::Text(&NEW_LINE),
                    Part::Tab => Shown::Text(b"    "),
                    Part::Value(kind, field) => {
                        arg += 1;
                        let pin = format!("{name}.page.{p:02}.arg.{:02}", arg - 1);
                        Shown::declare(b, &pin, kind, field)?
                    }
                });
            }
            list.push(Page { parts: page });
        }
        let doc = "The character, by its code; from 128 on it is that less 256. 0 ends each turn of the page.";
        let out = b.item(&format!("{name}.out"), doc, 0)?;
        let doc = "The page that is shown, from 0.";
        let page_num = b.item(&format!("{name}.page_num"), doc, 0)?;
        let doc = "The display's contrast, from 0 to 1; it is sent when it changes, as ESC, C, and 32 to 191.";
        let contrast = b.item(&format!("{name}.contrast"), doc, 0.0)?;
        let doc = "Code of the decimal separator; 46 is a point.";
        let separator = b.item(&format!("{name}.decimal-separator"), doc, u32::from(b'.'))?;
        Ok(Self {
            out,
            page_num,
            contrast,
            separator,
            pages: list,
            line: Line::of(&BEGIN),
            shown: None,
            contrast_sent: 0.0,
            part: 0,
        })
    }

    /// Returns the next character, or `None` while there is nothing to send.
    fn next(&mut self) -> Option<u8> {
        if let Some(byte) = self.line.next() {
            return Some(byte);
        }
        let number = self.page_num.get() as usize;
        let page = self.pages.get(number)?;
        let contrast = self.contrast.get();
        let is_new =
            contrast != self.contrast_sent && !(contrast.is_nan() && self.contrast_sent.is_nan());
        if self.shown != Some(number) {
            self.shown = Some(number);
            self.part = 0;
            self.line = Line::of(&CLEAR);
        } else if self.part > page.parts.len() {
            self.part = 0;
            self.line = Line::of(&HOME);
        } else if is_new {
            self.contrast_sent = contrast;
            self.line = Line::of(&[0x1B, b'C', level(contrast)]);
        } else {
            self.part += 1;
            match page.parts.get(self.part - 1) {
                None => return Some(0),
                Some(Shown::Byte(byte)) => return Some(*byte),
                Some(value) => self.line = value.line(self.separator.get()),
            }
        }
        self.line.next()
    }
}

impl Shown {
    fn declare(b: &mut Builder<'_>, pin: &str, kind: Kind, field: Field) -> Result<Self, Error> {
        Ok(match kind {
            Kind::Float => Self::Float(b.item(pin, "A number to show, in any unit.", 0.0)?, field),
            Kind::Signed => Self::Signed(b.item(pin, "An integer to show.", 0)?, field),
            Kind::Unsigned(base) => {
                Self::Unsigned(b.item(pin, "An integer to show.", 0)?, base, field)
            }
            Kind::Character => {
                Self::Character(b.item(pin, "The code of a character to show.", 0)?, field)
            }
            Kind::Bit(yes, no) => Self::Bit(b.item(pin, "A bit to show.", false)?, yes, no),
        })
    }

    /// Returns the characters to send for this part now.
    fn line(&self, separator: u32) -> Line {
        match self {
            Self::Byte(byte) => Line::of(&[*byte]),
            Self::Text(text) => Line::of(text),
            Self::Float(pin, field) => field.float(pin.get(), low(separator)),
            Self::Signed(pin, field) => field.signed(pin.get()),
            Self::Unsigned(pin, base, field) => field.unsigned(pin.get(), *base),
            Self::Character(pin, field) => {
                Line::repeated(low(pin.get()).max(b' '), field.width.max(1))
            }
            Self::Bit(pin, yes, no) => Line::repeated(if pin.get() { *yes } else { *no }, 1),
        }
    }
}

impl Update for Displays {
    fn update(&mut self, _: Period) {
        for display in &mut self.all {
            if self.turns < WAIT {
                self.turns += 1;
                continue;
            }
            if let Some(byte) = display.next() {
                let signed = i32::from(byte.cast_signed());
                display.out.set(signed.cast_unsigned());
            }
        }
    }
}

/// Returns the lowest byte.
const fn low(code: u32) -> u8 {
    let [low, ..] = code.to_le_bytes();
    low
}

/// Returns the display's code of a contrast.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it is 0 to 159")]
fn level(contrast: f64) -> u8 {
    let inside = if contrast > 1.0 { 1.0 } else { contrast.max(0.0) };
    0x20 + (inside * 159.0) as u8
}

#[cfg(test)]
mod tests {
    use super::Lcd;
    use hal_bench::Bench;

    const BEGIN: &str = "\r\n^\r\n^\r\n^\r\n^<";
    const CLEAR: &str = "<-!";
    const HOME: &str = "$=  ";

    fn bench(texts: &str) -> Bench {
        let mut bench = Bench::new();
        bench.load::<Lcd>(&[&format!("fmt_strings={texts}")]).unwrap();
        bench
    }

    /// Returns the characters sent in this number of cycles, with symbols for control sequences.
    fn sent(bench: &Bench, display: usize, runs: usize) -> String {
        let send = |_| {
            bench.run("lcd", 1_000_000);
            match bench.get::<u32>(&format!("lcd.{display:02}.out")) {
                0 => '0',
                0x11 => '<',
                0x18 => '^',
                0x1A => '!',
                0x1B => '$',
                0x1E => '-',
                code => char::from_u32(code).unwrap_or('?'),
            }
        };
        (0..runs).map(send).collect()
    }

    #[test]
    fn a_page_again_and_again() {
        let bench = bench(r"X%5.1f\nY%b\41-");
        assert_eq!(sent(&bench, 0, 100), "0".repeat(100));
        assert_eq!(sent(&bench, 0, 16), format!("{BEGIN}{CLEAR}"));
        bench.set("lcd.00.page.00.arg.00", -12.25);
        bench.set("lcd.00.page.00.arg.01", true);
        assert_eq!(sent(&bench, 0, 16), format!("X-12.3^\n\rYA0{HOME}"));
        bench.set("lcd.00.page.00.arg.01", false);
        bench.set("lcd.00.decimal-separator", u32::from(b','));
        assert_eq!(sent(&bench, 0, 16), format!("X-12,3^\n\rY-0{HOME}"));
    }

    #[test]
    fn pages_and_contrast() {
        let bench = bench("ab%3i|cd||");
        sent(&bench, 0, 116);
        assert_eq!(sent(&bench, 0, 3), "ab ");
        // A part that has begun is completed first; then the page, then the contrast.
        bench.set("lcd.00.page_num", 1_u32);
        bench.set("lcd.00.contrast", 0.5);
        assert_eq!(sent(&bench, 0, 15), format!(" 0{CLEAR}$Cocd0{HOME}"));
        bench.set("lcd.00.contrast", 7.0);
        assert_eq!(sent(&bench, 0, 5), "$C?cd");
        bench.set("lcd.00.page_num", 4_u32);
        assert_eq!(sent(&bench, 0, 3), "ddd");
        bench.set("lcd.00.page_num", 2_u32);
        bench.set("lcd.00.contrast", -1.0);
        assert_eq!(sent(&bench, 0, 11), format!("{CLEAR}$C 0{HOME}"));
        // NaN is sent once, as the minimum.
        bench.set("lcd.00.contrast", f64::NAN);
        assert_eq!(sent(&bench, 0, 8), format!("$C 0{HOME}"));
    }

    #[test]
    fn every_value() {
        let bench = bench(r"%i,%u,%04x,%o,%3c,%c,%b10,\FF\2C\7C%%\\\t");
        for (display, value) in [(1, 42_u32), (2, 0xBEEF), (3, 8), (4, 0x141), (5, 7)] {
            bench.set(&format!("lcd.{display:02}.page.00.arg.00"), value);
        }
        bench.set("lcd.00.page.00.arg.00", i32::MIN);
        bench.set("lcd.06.page.00.arg.00", true);
        // The displays share the turns before the first character.
        for (display, text) in
            ["-2147483648", "42", "BEEF", "10", "AAA", " ", "1", "?,|%\\    "].iter().enumerate()
        {
            let mut seen = String::new();
            if display == 0 {
                sent(&bench, 0, 12 + 16);
            }
            while !seen.ends_with(&format!("{HOME}{text}0")) {
                seen.push_str(&sent(&bench, display, 1));
                assert!(seen.len() < 200, "{text}: {seen}");
            }
        }
    }

    /// A page sequence ends within the longest output of its field, its end and the start of the next page.
    #[test]
    fn no_value_makes_a_page_longer() {
        let odd =
            [f64::NAN, f64::INFINITY, -f64::INFINITY, f64::MAX, f64::MIN, 1e15, -1e19, 5e-324];
        for text in
            ["%f", "%.1f", "%+9.3f", "%2.1f", "%i", "%+05i", "%u", "%x", "%o", "%20c", "%b10"]
        {
            for n in 0..8_u32 {
                let bench = bench(text);
                let pin = "lcd.00.page.00.arg.00";
                match text.trim_matches(|c: char| !c.is_ascii_lowercase()) {
                    "f" => bench.set(pin, odd[n as usize]),
                    "i" => bench.set(pin, i32::MIN.wrapping_add_unsigned(n).wrapping_sub(4)),
                    "b" => bench.set(pin, n % 2 == 0),
                    _ => bench.set(pin, u32::MAX.wrapping_add(n).wrapping_sub(4)),
                }
                bench.set("lcd.00.decimal-separator", [46, 0, 1 << 31, u32::MAX][n as usize % 4]);
                bench.set("lcd.00.contrast", odd[n as usize]);
                sent(&bench, 0, 116);
                let shown = sent(&bench, 0, 300);
                let turns = shown.matches(&format!("0{HOME}")).count();
                assert!(turns >= 300 / (20 + 1 + 4 + 3), "{text}: {shown}");
            }
        }
    }

    /// As in LinuxCNC, 0 ends a field, except as its first character.
    #[test]
    fn a_separator_of_0() {
        for (text, shown) in [("a%2.1fb", "a00b0"), ("a%4.1fb", "a 0b0")] {
            let bench = bench(text);
            bench.set("lcd.00.decimal-separator", 1_u32 << 31);
            sent(&bench, 0, 116);
            let runs = shown.len() + HOME.len();
            assert_eq!(sent(&bench, 0, runs), format!("{shown}{HOME}"));
        }
    }

    #[test]
    fn a_wrong_text_makes_nothing() {
        for (text, why) in [
            ("a,%q", "fmt_strings=%q: 'q' is no format; there are f, i, d, u, x, o, c and b"),
            ("%21i", "fmt_strings=%21i: a width is 1 to 20, and 21 is not"),
            ("a|b%3.3f", "fmt_strings=a|b%3.3f: 3 decimals are too many: here there is room for 2"),
        ] {
            let mut bench = Bench::new();
            let said = bench.load::<Lcd>(&[&format!("fmt_strings={text}")]).unwrap_err();
            assert_eq!(said, why);
            assert!(bench.names().is_empty());
        }
    }
}
