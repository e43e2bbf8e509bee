//! `keypad`.

use crate::{
    device::{self, DeviceLine, read_port},
    format::{CHECK, HEADER, MAP, PERIOD, SIZE, format},
    pipe::{self, Lines},
    presses::{PressQueue, Presses, STOPPED},
};
use hal_component::{
    Arg, Builder, Call, Clock, Component, Error, In, Out, Period, Port, TicketHandle, Touch,
    Update,
    abi::{ArgSpec, component_flags},
};
use hal_handheld::{
    FrameFormat, FrameReader, KeySet, Keypad, Press,
    frame::Received,
    keypad::STALE,
    keys::{STOP, number_of},
    line::press_for,
};

/// Largest number of bytes that are read in a cycle.
const BYTES: usize = 64;
/// Time without a byte after which a frame that has begun is lost, in nanoseconds.
const SILENCE_NS: i64 = 10_000_000;

/// `loadrt keypad`.
pub(crate) struct KeypadComponent;

impl Component for KeypadComponent {
    const NAME: &'static str = "keypad";
    const DOC: &'static str = "\
A virtual keypad in a handheld's cable: keys of the handheld and keys of programs are down together.

The handheld sends the state of its keys in frames, several times a second: a header, a bitmap, a check byte. The
component sits in that line. In every period it sends one frame to the controller: the keys of the handheld's last good
frame, if that is younger than three periods; the virtual key; and the keys whose pin `key-NN` is TRUE. A frame with
a wrong check byte, one without its end, and as many bytes without a header are dropped and counted in `bad-frames`.

A virtual key is down for three periods, or for a time in milliseconds, and then up for two, so that the controller tells
equal keys apart: four keys take 400 ms. At most 64 presses wait. STOP waits for none of them: it releases another virtual
key, forgets the presses that came before it, also those in the pipe, and is down in the next frame; the commands of forgotten
presses fail. Presses come from

- the commands `keypad.press` and `keypad.type`, which are refused as a whole if not all of it has room;
- a named pipe (`pipe=PATH`, made if it does not exist): each line is `N`, the number of a key, or `N MS`, at most 32
  bytes. Any number of programs may write, each line in one write. While 64 presses wait, later lines wait, too,
  but STOP among the first 16384 of them does not; behind those, writers wait. A wrong line presses nothing: it is counted in
  `bad-lines`, and a message says why.

FALSE at `enable` releases the virtual key and forgets what waits; the handheld's own keys always pass.

`device=PATH` is the serial line: frames are read from the handheld and written to the controller, without handshake. Neither
passes late: keys older than three periods are dropped, and a frame that could not leave gives way to the next. A line that
fails for a second, such as an adapter that was pulled, is reported, and opened again when it is there. On the virtual clock and
with `--simulate` neither the device nor the pipe is opened; the bytes come and go through the pins of type port, which
serve in any case.

Keys of the NK105 have names for `keypad.press`: 0 to 9, `.`, `-`, OK, STOP, X+, X-, Y+, Y-, Z+, Z-, RUN, ORIGIN, HOME,
MODE, UP, DOWN, SPINDLE, HIGH, SHIFT. Any other key is its number, 1 to 48.

# Example

```hal
loadrt keypad
loadrt threads name1=servo period1=1000000
addf keypad.update servo
start
keypad.type text=12
run 30ms
getp keypad.down-01 # -> TRUE
getp keypad.queue # -> 1
run 100ms
getp keypad.down-02 # -> TRUE
```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::text("device", "Serial line between handheld and controller, such as `/dev/ttyS1`.")
            .or(""),
        &Arg::text("pipe", "Named pipe whose lines press keys.").or(""),
        &Arg::int("baud", "Speed of the serial line.")
            .or("115200")
            .within(1200.0, 4_000_000.0)
            .unit("Bd"),
        &PERIOD,
        &HEADER,
        &SIZE,
        &CHECK,
        &MAP,
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let format = format(b)?;
        let period_ms = b.arg_float("period").unwrap_or(20.0);
        let lines = Lines { keys: format.keys(), period_ms };
        let (presses, queue) = Presses::make(b);
        commands(b, lines, &presses)?;
        let device = b.arg_text("device").unwrap_or_default();
        let baud = b.arg_int("baud").and_then(|n| u32::try_from(n).ok()).unwrap_or(115_200);
        let frame_ms = 10_000.0 * format.size() as f64 / f64::from(baud);
        if !device.is_empty() && frame_ms > period_ms {
            let size = format.size();
            return Err(Error::new(format!(
                "a frame of {size} bytes takes {frame_ms:.1} ms at {baud} Bd, and period is {period_ms} ms"
            )));
        }
        let line = device::declare(b, "keypad.line", device, baud)?;
        let pipe = b.arg_text("pipe").unwrap_or_default();
        pipe::declare(b, pipe, lines, presses)?;
        let mut keys = Vec::new();
        let mut downs = Vec::new();
        for key in 1..=format.keys() {
            let doc = format!("Holds key {key} down while TRUE.");
            keys.push(b.item(&format!("keypad.key-{key:02}"), &doc, false)?);
            let doc = format!("True while key {key} is down for the controller.");
            downs.push(b.item(&format!("keypad.down-{key:02}"), &doc, false)?);
        }
        let multiplexer = Multiplexer {
            keys,
            downs,
            enable: b.item(
                "keypad.enable",
                "FALSE releases the virtual key and forgets what waits.",
                true,
            )?,
            frames_in: b.item("keypad.frames-in", "Bytes from the handheld.", Port::default())?,
            frames_out: b.item("keypad.frames-out", "Bytes to the controller.", Port::default())?,
            bad_frames: b.item("keypad.bad-frames", "Number of frames that were dropped.", 0)?,
            waiting: b.item("keypad.queue", "Number of presses that wait.", 0)?,
            physical: b.item(
                "keypad.physical",
                "True while good frames arrive from the handheld.",
                false,
            )?,
            line,
            queue,
            reader: FrameReader::new(format),
            format,
            keypad: Keypad::default(),
            clock: b.clock(),
            ticket: None,
            #[expect(clippy::cast_possible_truncation, reason = "2 to 1000 ms")]
            period_ns: (period_ms * 1e6) as i64,
            elapsed_ns: 0,
            silent_ns: 0,
        };
        b.function("keypad.update", "Reads frames, and sends one in every period.", multiplexer)
    }
}

fn commands(b: &mut Builder<'_>, lines: Lines, queue: &Presses) -> Result<(), Error> {
    const PRESS: &[&ArgSpec] = &[
        &Arg::text("key", "Name of the key, or its number.").required(),
        &Arg::int("hold", "Time for which it is down; three periods without it.")
            .within(1.0, 10_000.0)
            .unit("ms"),
    ];
    const TYPE: &[&ArgSpec] =
        &[&Arg::text("text", "Digits, points and minus signs, at most 64.").required()];
    let sender = queue.clone();
    b.command(
        "keypad.press",
        "Presses a virtual key. With --wait it ends when the key is up.",
        PRESS,
        move |call| {
            let key = key_number(&call.text("key").unwrap_or_default(), lines.keys)?;
            let press = match call.int("hold") {
                None => Press::short(key),
                Some(ms) => press_for(key, u32::try_from(ms).unwrap_or(0), lines.period_ms)
                    .map_err(|why| Error::new(why.to_string()))?,
            };
            put(call, &sender, &[press])
        },
    )?;
    let sender = queue.clone();
    b.command(
        "keypad.type",
        "Types a number. With --wait it ends when the last key is up.",
        TYPE,
        move |call| {
            let text = call.text("text").unwrap_or_default();
            let mut presses = Vec::new();
            for character in text.chars() {
                let known = matches!(character, '0'..='9' | '.' | '-');
                let key =
                    number_of(&character.to_string()).filter(|key| known && *key <= lines.keys);
                let key = key.ok_or_else(|| {
                    Error::new(format!(
                        "there is no key '{character}': digits, points and minus signs"
                    ))
                })?;
                presses.push(Press::short(key));
            }
            put(call, &sender, &presses)
        },
    )
}

fn key_number(name: &str, keys: u8) -> Result<u8, Error> {
    let number = number_of(name).or_else(|| name.parse().ok());
    number.filter(|key| (1..=keys).contains(key)).ok_or_else(|| {
        Error::new(format!("there is no key '{name}': 1 to {keys}, or a name such as OK or X+"))
    })
}

/// Puts all presses in the queue, or none.
fn put(call: &Call<'_>, queue: &Presses, presses: &[Press]) -> Result<(), Error> {
    if presses.is_empty() {
        return Ok(());
    }
    let mut queue = queue.lock();
    let (count, free) = (presses.len(), queue.room(presses));
    if count > free {
        return Err(Error::new(format!("{count} keys, and there is room for {free}")));
    }
    queue.send(presses, Some(call.ticket()?));
    Ok(())
}

/// Function of the keypad.
#[derive(Touch)]
struct Multiplexer {
    keys: Vec<In<bool>>,
    downs: Vec<Out<bool>>,
    enable: In<bool>,
    frames_in: In<Port>,
    frames_out: Out<Port>,
    bad_frames: Out<u32>,
    waiting: Out<u32>,
    physical: Out<bool>,
    line: Option<DeviceLine>,
    clock: Clock,
    queue: PressQueue,
    #[state]
    reader: FrameReader,
    #[state]
    format: FrameFormat,
    #[state]
    keypad: Keypad,
    /// Ticket of the command whose last key is down.
    #[state]
    ticket: Option<TicketHandle>,
    #[state]
    period_ns: i64,
    #[state]
    elapsed_ns: i64,
    #[state]
    silent_ns: i64,
}

impl Update for Multiplexer {
    fn update(&mut self, period: Period) {
        self.receive(period.ns());
        if !self.enable.get() {
            self.forget("keypad.enable is FALSE");
            self.queue.forget("keypad.enable is FALSE");
        }
        // STOP itself is never cut short: a second press of it comes after the first.
        if self.queue.look_for_stop() && self.keypad.virtual_key() != Some(STOP) {
            self.forget(STOPPED);
        }
        self.elapsed_ns = self.elapsed_ns.saturating_add(period.ns());
        if self.elapsed_ns >= self.period_ns {
            // After a long period no frames are made up for.
            self.elapsed_ns = (self.elapsed_ns - self.period_ns) % self.period_ns;
            self.send();
        }
        self.waiting.set(self.queue.waiting());
    }
}

impl Multiplexer {
    fn receive(&mut self, ns: i64) {
        let mut bytes = [0; BYTES];
        let mut count = match &mut self.line {
            // Keys that were pressed before a pause of this function are no longer those under the fingers.
            Some(line) => {
                let stale = self.period_ns.saturating_mul(i64::from(STALE));
                line.read_since(self.clock.now_ns().saturating_sub(stale), &mut bytes)
            }
            None => 0,
        };
        count += read_port(self.frames_in.get(), bytes.get_mut(count..).unwrap_or_default());
        self.silent_ns = if count > 0 { 0 } else { self.silent_ns.saturating_add(ns) };
        let mut bad = u32::from(self.silent_ns >= SILENCE_NS && self.reader.silence());
        for byte in bytes.iter().take(count) {
            match self.reader.feed(*byte) {
                Some(Received::Keys(keys)) => self.keypad.physical(keys),
                Some(Received::Bad) => bad += 1,
                None => {}
            }
        }
        self.bad_frames.set(self.bad_frames.get().wrapping_add(bad));
    }

    /// Releases the virtual key; its command fails for this reason.
    fn forget(&mut self, why: &'static str) {
        self.keypad.release();
        if let Some(ticket) = self.ticket.take() {
            ticket.fail(why);
        }
    }

    fn send(&mut self) {
        self.physical.set(self.keypad.has_physical());
        let numbered = (1..).zip(&self.keys);
        let held = numbered
            .filter(|(_, pin)| pin.get())
            .fold(KeySet::NONE, |set, (key, _)| set.with(KeySet::of(key)));
        if self.keypad.is_free()
            && let Some(ticket) = self.ticket.take()
        {
            ticket.done();
        }
        let mut taken = None;
        let keys = self.keypad.period(held, || {
            taken = self.queue.take();
            taken.map(|entry| entry.press)
        });
        if let Some(entry) = taken {
            self.ticket = entry.ticket;
        }
        for (key, pin) in (1..).zip(&self.downs) {
            pin.set(keys.has(key));
        }
        let (bytes, len) = self.format.encode(keys);
        let frame = bytes.get(..len).unwrap_or_default();
        // Without a reader there is nobody who could miss it.
        let _: bool = self.frames_out.get().write(frame);
        if let Some(line) = &mut self.line {
            line.write(frame);
        }
    }
}
