//! `lcd_reader`.

use crate::{
    device::{self, DeviceLine, read_port},
    packed,
    readers::{self, READERS},
};
use hal_component::{
    Arg, Builder, Clock, Component, Error, In, Out, Period, Plain, Port, Snapshot, SnapshotReader,
    Touch, Update,
    abi::{ArgSpec, component_flags},
};
use hal_handheld::{
    Decode, ScreenReader, Screens, St7920, TEXT_LEN,
    screen::row,
    st7920::{COLUMNS, ROWS},
};

/// Largest number of bytes that are read in a cycle.
const BYTES: usize = 512;
/// Largest number of texts that are looked for.
const FINDS: u32 = 8;
/// Largest number of values that are read from the text.
const VALUES: u32 = 16;

/// Latest whole screen.
#[derive(Clone, Copy, Plain)]
pub(crate) struct ScreenRecord {
    /// Number of the screen, from 1.
    number: u64,
    /// Characters, eight in each word, the first in the lowest byte.
    text: [u64; TEXT_LEN / 8],
}

impl ScreenRecord {
    pub(crate) fn new(number: u64, text: &[u8; TEXT_LEN]) -> Self {
        Self { number, text: packed::words(text) }
    }

    pub(crate) const fn number(&self) -> u64 {
        self.number
    }

    pub(crate) fn text(&self) -> [u8; TEXT_LEN] {
        let mut text = [b' '; TEXT_LEN];
        for (free, byte) in text.iter_mut().zip(packed::bytes(&self.text)) {
            *free = byte;
        }
        text
    }
}

/// `loadrt lcd_reader`.
pub(crate) struct LcdReader;

impl Component for LcdReader {
    const NAME: &'static str = "lcd_reader";
    const DOC: &'static str = "\
The text on a controller's display, from the bytes that the controller sends to it.

The decoder is that of the ST7920's serial protocol, with four rows of 16 characters. Bytes may arrive in pieces of any
length at any time. A screen is whole when the bus has been quiet for `quiet` milliseconds after its last byte, so that
nobody sees a half-drawn one, also if a device is read late; it is new if its text differs from the one before. Characters outside ASCII are `?`.

The text is for readers, each with a counter of its own, and no reader can delay the bus. A record has 71 bytes: the 64
characters row by row, the reader's counter as five digits, CR and LF. A reader first gets the present screen and later only
newer ones; the counter begins again after 99999. Readers are

- programs at the socket `socket=PATH`, at most 16, such as `nc -U PATH`: each connection is a reader. A slow one
  misses screens and never a part of one;
- the command `lcd.read`, with readers 1 to 16;
- the command `lcd.show`, which prints the four rows;
- programs that read the snapshot `lcd.screen`.

`find=IDLE,RUN` makes the pins `lcd.found-0` and `lcd.found-1`, TRUE while the screen has this text. `values=X,Y` makes the pins
`lcd.value-0` and `lcd.value-1`, the number behind the `X` and the `Y` with which a row begins, and `lcd.has-0` and `lcd.has-1`,
FALSE while no row has such a number; the value is then the last one.

Bytes come from the pin `lcd.bus`, or instead from a character device (`device=PATH`), for which a kernel driver receives the bus as SPI
slave. On the virtual clock and with `--simulate` neither the device nor the socket is opened.

# Example

```hal
loadrt lcd_reader find=IDLE values=X
loadrt sim_nk105
loadrt threads name1=servo period1=1000000
addf sim-nk105.update servo
addf lcd.update servo
newsig bus port
sets bus 512
net bus sim-nk105.lcd lcd.bus
start
run 200ms
lcd.read reader=1 # -> X     0.000 IDLEY     0.000 F100Z     0.000 T  1                00000
getp lcd.found-0 # -> TRUE
getp lcd.has-0 # -> TRUE
getp lcd.value-0 # -> 0
getp lcd.errors # -> 0
```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::text("device", "Character device with the bytes of the bus.").or(""),
        &Arg::text("socket", "Path of the socket for readers.").or(""),
        &Arg::float("quiet", "Time without a byte after which a screen is whole.")
            .or("5")
            .within(0.1, 1000.0)
            .unit("ms"),
        &Arg::texts("find", "Texts that the pins `found-N` show.").at_most(FINDS),
        &Arg::texts("values", "Begins of rows whose numbers the pins `value-N` show.")
            .at_most(VALUES),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let device = b.arg_text("device").unwrap_or_default();
        let line = device::declare(b, "lcd.line", device, 115_200)?;
        let snapshot = b.snapshot("lcd.screen", 1, "Latest whole screen of the controller.")?;
        commands(b, &snapshot)?;
        let socket = b.arg_text("socket").unwrap_or_default();
        readers::declare(b, socket, snapshot.reader())?;
        let mut found = Vec::new();
        for (n, text) in texts(b, "find", TEXT_LEN)?.into_iter().enumerate() {
            let doc = format!("True while the screen has the text '{text}'.");
            found.push(FoundText { pin: b.item(&format!("lcd.found-{n}"), &doc, false)?, text });
        }
        let mut values = Vec::new();
        for (n, label) in texts(b, "values", COLUMNS)?.into_iter().enumerate() {
            let doc =
                format!("Number in the row that begins with '{label}', in units of the screen.");
            let value = b.item(&format!("lcd.value-{n}"), &doc, 0.0)?;
            let doc = format!("True while a row begins with '{label}' and a number.");
            values.push(ValueInText {
                value,
                has: b.item(&format!("lcd.has-{n}"), &doc, false)?,
                label,
            });
        }
        let quiet_ms = b.arg_float("quiet").unwrap_or(5.0);
        #[expect(clippy::cast_possible_truncation, reason = "0.1 to 1000 ms")]
        let quiet_ns = (quiet_ms * 1e6) as i64;
        let reading = Reading {
            bus: b.item("lcd.bus", "Bytes of the bus.", Port::default())?,
            frames: b.item("lcd.frames", "Number of frames: sync bytes with what they head.", 0)?,
            errors: b.item("lcd.errors", "Number of bytes that the protocol does not allow.", 0)?,
            screens: b.item("lcd.screens", "Number of whole screens so far.", 0)?,
            quiet: b.item("lcd.quiet", "True while the bus is quiet.", true)?,
            found,
            values,
            line,
            snapshot,
            clock: b.clock(),
            decoded: Screens::new(St7920::default(), quiet_ns),
            is_begun: false,
        };
        b.function("lcd.update", "Decodes the bytes of the bus.", reading)
    }
}

/// Returns the texts of an argument.
fn texts(b: &Builder<'_>, argument: &str, most: usize) -> Result<Vec<String>, Error> {
    let texts = b.arg_texts(argument);
    match texts.iter().find(|text| text.is_empty() || text.len() > most || !text.is_ascii()) {
        None => Ok(texts),
        Some(text) => {
            let why = format!("{argument}={text}: a text has 1 to {most} ASCII characters");
            Err(Error::new(why))
        }
    }
}

fn commands(b: &mut Builder<'_>, snapshot: &Snapshot<ScreenRecord>) -> Result<(), Error> {
    const READ: &[&ArgSpec] =
        &[&Arg::int("reader", "Number of the reader.").or("1").within(1.0, READERS as f64)];
    let latest = snapshot.reader();
    b.command("lcd.show", "Prints the four rows of the screen.", &[], move |call| {
        let text = screen(&latest)?.text();
        for n in 0..4 {
            call.reply(&String::from_utf8_lossy(row(&text, n)));
        }
        Ok(())
    })?;
    let latest = snapshot.reader();
    let mut readers: [ScreenReader; READERS] = core::array::from_fn(|_| ScreenReader::default());
    b.command(
        "lcd.read",
        "Prints a record if the reader has not seen the screen yet, without CR and LF.",
        READ,
        move |call| {
            let number = call.int("reader").and_then(|n| usize::try_from(n).ok()).unwrap_or(1);
            let record = screen(&latest)?;
            let Some(reader) = readers.get_mut(number.wrapping_sub(1)) else { return Ok(()) };
            let bytes = reader.next(&record.text(), record.number());
            let len = bytes.len();
            if len == 0 {
                call.reply(&format!("reader {number} has seen this screen"));
            } else {
                call.reply(String::from_utf8_lossy(bytes).trim_end_matches(['\r', '\n']));
            }
            reader.took(len);
            Ok(())
        },
    )
}

fn screen(latest: &SnapshotReader<ScreenRecord>) -> Result<ScreenRecord, Error> {
    let record = latest.get().filter(|record| record.number() > 0);
    record.ok_or_else(|| Error::new("there is no screen yet: lcd.update has not run"))
}

/// Text that is looked for.
#[derive(Touch)]
struct FoundText {
    pin: Out<bool>,
    #[state]
    text: String,
}

impl FoundText {
    /// Realtime. Searches a text.
    fn search(&self, text: &[u8; TEXT_LEN]) {
        let wanted = self.text.as_bytes();
        self.pin.set(text.windows(wanted.len()).any(|part| part == wanted));
    }
}

/// Number that is read from the text.
#[derive(Touch)]
struct ValueInText {
    value: Out<f64>,
    has: Out<bool>,
    #[state]
    label: String,
}

impl ValueInText {
    /// Realtime. Reads the number from a text.
    fn read(&self, text: &[u8; TEXT_LEN]) {
        let rows = (0..ROWS).map(|n| row(text, n));
        let mut rest = rows.filter_map(|row| row.strip_prefix(self.label.as_bytes()));
        let number = rest.find_map(|rest| {
            let word = rest.trim_ascii_start().split(|byte| *byte == b' ').next()?;
            core::str::from_utf8(word).ok()?.parse::<f64>().ok().filter(|value| value.is_finite())
        });
        self.has.set(number.is_some());
        if let Some(number) = number {
            self.value.set(number);
        }
    }
}

/// Function of the display.
#[derive(Touch)]
struct Reading {
    bus: In<Port>,
    frames: Out<u32>,
    errors: Out<u32>,
    screens: Out<u32>,
    quiet: Out<bool>,
    found: Vec<FoundText>,
    values: Vec<ValueInText>,
    line: Option<DeviceLine>,
    snapshot: Snapshot<ScreenRecord>,
    clock: Clock,
    #[state]
    decoded: Screens<St7920>,
    #[state]
    is_begun: bool,
}

impl Update for Reading {
    fn update(&mut self, _: Period) {
        let is_new = match &mut self.line {
            Some(line) => from_device(line, &mut self.decoded),
            None => {
                let mut bytes = [0; BYTES];
                let count = read_port(self.bus.get(), &mut bytes);
                self.decoded.feed(bytes.get(..count).unwrap_or_default(), self.clock.now_ns())
            }
        };
        if is_new || !self.is_begun {
            self.is_begun = true;
            self.publish();
        }
        self.quiet.set(self.decoded.is_quiet());
        self.frames.set(self.decoded.decoder().frames());
        self.errors.set(self.decoded.decoder().errors());
    }
}

/// Realtime. Takes bytes of a device. Returns whether a new screen is complete. The bus was quiet only if a look found nothing
/// in the device: a worker that is late may hold the rest of a screen.
fn from_device(line: &mut DeviceLine, decoded: &mut Screens<St7920>) -> bool {
    let empty = line.empty_at();
    let mut is_new = None;
    for _ in 0..BYTES {
        let Some((byte, at)) = line.take() else {
            // All bytes before that look are taken.
            return is_new.unwrap_or_else(|| decoded.poll(empty));
        };
        if at > empty {
            is_new.get_or_insert_with(|| decoded.poll(empty));
        }
        decoded.take(byte, at);
    }
    is_new.unwrap_or(false)
}

impl Reading {
    fn publish(&mut self) {
        let (text, number) = (self.decoded.text(), self.decoded.number());
        self.snapshot.set(&ScreenRecord::new(number, text));
        // The number of whole screens, without the blank one before them.
        self.screens.set(self.screens.get().wrapping_add(u32::from(number > 1)));
        self.found.iter().for_each(|found| found.search(text));
        self.values.iter().for_each(|value| value.read(text));
    }
}
