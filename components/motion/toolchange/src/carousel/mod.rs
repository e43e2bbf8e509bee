//! `carousel`.
mod magazine;
mod pocket;

use hal_component::{
    Arg, Builder, Component, Error,
    abi::{ArgSpec, component_flags},
};
use magazine::Magazine;
use pocket::{Encoding, Pocket};

/// Maximum number of tool changers in one load.
const MAX: u32 = 8;
/// Maximum number of pins in a list of sensors.
const MAX_SENSORS: i64 = 32;

/// Message about a word of `encoding`.
const UNKNOWN: &str = "magazine {}: the encoding is no known word: as in LinuxCNC, the known word that it begins with \
                       counts, else gray";

/// A rotary tool magazine.
pub(crate) struct Carousel;

impl Component for Carousel {
    const NAME: &'static str = "carousel";
    const DOC: &'static str = "\
A rotary tool magazine: turns to a pocket, by the shorter way.

`pockets=6,12` makes `carousel.0` with 6 pockets and `carousel.1` with 12. `encoding`, `num_sense`,
`dir` and `parity` are lists beside it; where one ends, its last value goes on.

| `encoding` | where the magazine is |
|---|---|
| `gray`, `binary`, `bcd` | the code on the `sense` pins, lowest bit first, read while `strobe` is TRUE |
| `single` | a sensor for each pocket: `sense-0` is TRUE in pocket 1 |
| `index` | pulses of `sense-1`, one for each pocket, counted from home, where `sense-0` is TRUE as well |
| `edge` | as `index`, with a pocket at each end of a pulse |
| `counts` | `counts` of an encoder or stepper, from home, where `sense-0` rises or `index-enable` is cleared |

`enable` begins a change: unless the magazine is there, the motor runs (`dir=1`: always forwards) until
the position is that of `pocket-number`; `ready` tells that it is there. Then, if `rev-pulse` is set,
the magazine is pulled back against its stop for so long; else, if `align-dc` is set, it waits
`decel-time`, runs slowly back onto the mark and off it again, and forwards to its edge. The mark is `sense-1`
with `index`, else `strobe`. `enable` must fall before the next change; when it falls during a turn,
the motor stops. With `index`, `edge` and `counts` the first change or jog looks for home, forwards;
that goes on though `enable` falls.

`state`: 0 idle, 2 turns, 3 is pulled back, 5 slows down, 6 backs onto the mark, 7 backs off it, 8 comes onto
it forwards, 9 waits for `enable` to fall, 10 and 11 look for home, 20 jogs.

# Example

```hal
loadrt carousel pockets=6 encoding=binary
loadrt threads name1=servo period1=1000000
addf carousel.0 servo
setp carousel.0.fwd-dc 0.8
setp carousel.0.rev-dc -0.8
setp carousel.0.sense-0 1
setp carousel.0.pocket-number 6
start
setp carousel.0.enable 1
run 5ms
getp carousel.0.motor-vel # -> -0.8
setp carousel.0.sense-0 0
setp carousel.0.sense-1 1
setp carousel.0.sense-2 1
run 5ms
getp carousel.0.ready # -> TRUE
getp carousel.0.motor-rev # -> FALSE
```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::ints("pockets", "Pockets of each magazine, 1 or more; 8 without it.").at_most(MAX),
        &Arg::texts(
            "encoding",
            "One of `gray`, `binary`, `bcd`, `single`, `index`, `edge` or `counts`; `gray` without it, if empty, and, with \
             a message, for any other word.",
        )
        .at_most(MAX)
        .or("gray"),
        &Arg::ints(
            "num_sense",
            "Sensors, 1 to 32; 4 without it. `single` has at least one for each pocket, `index` two.",
        )
        .at_most(MAX),
        &Arg::ints("dir", "1: turns forwards alone, 2 or 0: both ways; 2 without it.").at_most(MAX),
        &Arg::ints("parity", "What the parity of a code must be, 0 even or 1 odd.").at_most(MAX),
        &Arg::ints("personality", "Accepted for scripts that give it: the others are what counts."),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let mut pockets = b.arg_ints("pockets");
        if pockets.is_empty() {
            pockets.push(8);
        }
        let mut all = Vec::new();
        for (i, pockets) in pockets.into_iter().enumerate() {
            let word = at(&b.arg_texts("encoding"), i, "gray".to_owned());
            let (encoding, is_named) = Encoding::of_word(&word);
            if !is_named {
                b.messages().notice(UNKNOWN, &[i as f64]);
            }
            let pockets = within("pockets", pockets, 1, i64::from(i32::MAX))?;
            let given = at(&b.arg_ints("num_sense"), i, 4);
            let sensors = match encoding {
                Encoding::Single => {
                    let given = within("num_sense", given, 1, MAX_SENSORS)?;
                    within("pockets with encoding=single", pockets.into(), 1, MAX_SENSORS)?
                        .max(given)
                }
                Encoding::Index => 2,
                Encoding::Edge => within("num_sense with encoding=edge", given, 2, MAX_SENSORS)?,
                _ => within("num_sense", given, 1, MAX_SENSORS)?,
            };
            let both = within("dir", at(&b.arg_ints("dir"), i, 2), 0, 2)? != 1;
            let odd = within("parity", at(&b.arg_ints("parity"), i, 0), 0, 1)? == 1;
            all.push((encoding, pockets, sensors, both, odd));
        }
        for (i, (encoding, pockets, sensors, both, odd)) in all.into_iter().enumerate() {
            let name = format!("carousel.{i}");
            let pocket = Pocket::new(b, &name, encoding, pockets, sensors, odd)?;
            let magazine = Magazine::new(b, &name, pocket, both)?;
            b.function(&name, "Looks where the magazine is, and turns it.", magazine)?;
        }
        Ok(())
    }
}

/// Returns the value for the magazine of this number; the last value applies to all further magazines.
fn at<T: Clone>(list: &[T], i: usize, without: T) -> T {
    list.get(i).or(list.last()).cloned().unwrap_or(without)
}

fn within(what: &str, value: i64, low: i64, high: i64) -> Result<i32, Error> {
    let fits = (low..=high).contains(&value).then(|| i32::try_from(value).ok()).flatten();
    fits.ok_or_else(|| Error::new(format!("{what} is {value}, and must be {low} to {high}")))
}

#[cfg(test)]
mod tests;
