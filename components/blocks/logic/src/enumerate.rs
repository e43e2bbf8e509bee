//! `enum`.
use hal_component::{
    Arg, Builder, Component, Error, In, Out, Period, Touch, Update,
    abi::{ArgSpec, component_flags},
};

/// Maximum number of lists.
const LISTS: u32 = 16;

/// Lists of names for numbers.
pub(crate) struct Enum;

impl Component for Enum {
    const NAME: &'static str = "enum";
    const DOC: &'static str = "Named bits from a number, or a number from named bits.\n\n\
        `enums=` is a list of texts, each a letter and names, with semicolons between them: `E` \
        makes a number of bits (`enum-encode.00`), `D` bits of a number (`enum-decode.00`). The \
        names count from 0, and an empty one is a number without a bit: `\"E;;go;stop\"` has \
        `enum-encode.00.go-in`, which is 1, and `enum-encode.00.stop-in`, which is 2. Each number \
        can be changed by the pin `-val` of its name.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt enum enums=\"E;;go;stop,D;idle;run;;fault\"\n\
        loadrt threads name1=servo period1=1000000\n\
        addf enum-encode.00 servo\n\
        addf enum-decode.00 servo\n\
        start\n\
        setp enum-encode.00.stop-in 1\n\
        setp enum-decode.00.input 3\n\
        run 1ms\n\
        getp enum-encode.00.output # -> 2\n\
        getp enum-decode.00.fault-out # -> TRUE\n\
        getp enum-decode.00.idle-out # -> FALSE\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[&Arg::texts(
        "enums",
        "Lists of names, such as `E;off;on`: `E` or `D` first, then names, with semicolons.",
    )
    .required()
    .at_most(LISTS)];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let (mut encoders, mut decoders) = (0, 0);
        for list in b.arg_texts("enums") {
            let list = list.trim_matches('"');
            match list.split_once(';') {
                Some(("E" | "e", names)) => {
                    encode(b, &format!("enum-encode.{encoders:02}"), names)?;
                    encoders += 1;
                }
                Some(("D" | "d", names)) => {
                    decode(b, &format!("enum-decode.{decoders:02}"), names)?;
                    decoders += 1;
                }
                _ => {
                    let text = format!("enums={list} does not begin with 'E;' or 'D;'");
                    return Err(Error::new(text));
                }
            }
        }
        Ok(())
    }
}

/// Returns the names of a list with their numbers.
fn named(names: &str) -> Result<Vec<(u32, &str)>, Error> {
    let list: Vec<_> = (0..).zip(names.split(';')).filter(|(_, n)| !n.is_empty()).collect();
    if list.is_empty() {
        return Err(Error::new(format!("enums={names} has no names")));
    }
    Ok(list)
}

fn value(b: &mut Builder<'_>, prefix: &str, name: &str, number: u32) -> Result<In<u32>, Error> {
    b.item(&format!("{prefix}.{name}-val"), "The number that this name stands for.", number)
}

fn encode(b: &mut Builder<'_>, prefix: &str, names: &str) -> Result<(), Error> {
    let mut bits = Vec::new();
    for (number, name) in named(names)? {
        let bit = b.item(&format!("{prefix}.{name}-in"), "Chooses its number.", false)?;
        bits.push((bit, value(b, prefix, name, number)?));
    }
    let doc = "The number of the bit that is true, of several the last; 0 if none is.";
    let output = b.item(&format!("{prefix}.output"), doc, 0)?;
    b.function(prefix, "Makes a number of the bits.", Encode { bits, output })
}

fn decode(b: &mut Builder<'_>, prefix: &str, names: &str) -> Result<(), Error> {
    let input = b.item(&format!("{prefix}.input"), "The number.", 0)?;
    let mut bits = Vec::new();
    for (number, name) in named(names)? {
        let doc = "True while the number is that of this name.";
        let bit = b.item(&format!("{prefix}.{name}-out"), doc, false)?;
        bits.push((bit, value(b, prefix, name, number)?));
    }
    b.function(prefix, "Makes bits of the number.", Decode { input, bits })
}

#[derive(Touch)]
struct Encode {
    bits: Vec<(In<bool>, In<u32>)>,
    output: Out<u32>,
}

impl Update for Encode {
    fn update(&mut self, _: Period) {
        let chosen = self.bits.iter().rfind(|(bit, _)| bit.get());
        self.output.set(chosen.map_or(0, |(_, value)| value.get()));
    }
}

#[derive(Touch)]
struct Decode {
    input: In<u32>,
    bits: Vec<(Out<bool>, In<u32>)>,
}

impl Update for Decode {
    fn update(&mut self, _: Period) {
        let number = self.input.get();
        for (bit, value) in &self.bits {
            bit.set(value.get() == number);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Enum;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn both_ways() {
        let rows = replay::<Enum>(
            "load enum enums=E;;go;stop
             run enum-encode.00
             in enum-encode.00.go-in enum-encode.00.stop-in
             out enum-encode.00.output
             0 0 | 0
             1 0 | 1
             0 1 | 2
             1 1 | 2
             set enum-encode.00.go-val 77
             1 0 | 77
             load enum enums=D;idle;run;;fault
             run enum-decode.00
             in enum-decode.00.input
             out enum-decode.00.idle-out enum-decode.00.run-out enum-decode.00.fault-out
             0 | 1 0 0
             1 | 0 1 0
             2 | 0 0 0
             3 | 0 0 1
             set enum-decode.00.idle-val 3
             3 | 1 0 1
             4294967295 | 0 0 0",
        );
        assert_eq!(rows, 11);
    }

    #[test]
    fn names_as_the_catalogue_has_them() {
        let mut bench = Bench::new();
        bench.load::<Enum>(&["enums=E;;a;b;D;;c;d"]).unwrap();
        let names = bench.names();
        assert!(names.contains(&"enum-encode.00.D-in bit IN".to_owned()), "{names:?}");
        assert_eq!(bench.get::<u32>("enum-encode.00.d-val"), 6);
        for wrong in ["enums=X;a", "enums=E", "enums=D;;", "enums=a;b"] {
            assert!(Bench::new().load::<Enum>(&[wrong]).is_err(), "{wrong}");
        }
    }
}
