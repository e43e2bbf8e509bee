//! Round trips of random traces through every format, compared bit for bit.
#![expect(clippy::unwrap_used, clippy::panic, reason = "tests")]

use hal_protocol::{Type, Value};
use hal_trace::{Format, TimeBase, Trace};

/// Pseudo-random numbers, the same on every run.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ x >> 31
    }

    fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    fn of<T: Copy>(&mut self, list: &[T]) -> T {
        let n = usize::try_from(self.below(list.len() as u64)).unwrap();
        *list.get(n).unwrap()
    }

    fn value(&mut self, ty: Type) -> u64 {
        let odd = [0, 1, u64::MAX, 1 << 63, (1 << 63) - 1, 1 << 31, (1 << 31) - 1, 1 << 53 | 1];
        let floats = [
            0.0,
            -0.0,
            f64::NAN,
            -f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::MIN_POSITIVE / 3.0,
            f64::MAX,
            0.1 + 0.2,
            -1e-300,
            1e22,
            5.0,
        ];
        match (ty, self.below(3)) {
            (Type::Bit, _) => self.below(2),
            (Type::Float, 0) => self.of(&floats).to_bits(),
            (_, 0) => self.of(&odd),
            (_, 1) => self.below(5),
            _ => self.next(),
        }
    }
}

const TYPES: [Type; 6] = [Type::Bit, Type::Float, Type::S32, Type::U32, Type::S64, Type::U64];
const NAMES: [&str; 14] = [
    "a",
    "stepgen.0.step",
    "stepgen.0.dir",
    "stepgen.0",
    "x-pos",
    "joint.1.motor-pos-cmd",
    "..b",
    "c..d",
    "Ünï.cöde",
    "lost",
    "marker",
    "time",
    "x[3]",
    "comma,quote\"",
];
const TEXTS: [&str; 7] = [
    "trigger: a rises",
    "$end",
    "two\nlines",
    "a, \"b\"",
    "ü€𝄞",
    " blank at both ends ",
    "\u{1}control \\ and back",
];

fn random(chance: &mut Chance) -> Trace {
    let mut trace = Trace::new(TimeBase::power(chance.of(&[-9, -9, -12, -4, 0])).unwrap());
    let mut names: Vec<&str> = NAMES.to_vec();
    for _ in 0..chance.below(9) {
        let name = names.remove(usize::try_from(chance.below(names.len() as u64)).unwrap());
        let n = trace.add(name, chance.of(&TYPES));
        if chance.below(4) == 0 {
            // In the order in which VCD and FST return the names.
            trace.also(n, "ÿ.alias");
        }
    }
    let kind = chance.below(4);
    let mut time =
        if chance.below(2) == 0 { 0 } else { i64::try_from(chance.below(1 << 40)).unwrap() };
    for _ in 0..chance.below(200) {
        trace.sample(time).unwrap();
        if chance.below(20) == 0 {
            trace.mark(time - i64::try_from(chance.below(3)).unwrap(), chance.of(&TEXTS));
        }
        for n in 0..trace.channels().len() {
            let ty = trace.channels().get(n).unwrap().ty();
            match chance.below(12) {
                0 => trace.set_bits(n, None).unwrap(),
                1..=5 => trace.set_bits(n, Some(chance.value(ty))).unwrap(),
                _ => {}
            }
        }
        if chance.below(15) == 0 {
            trace.lose(1 + chance.below(1 << 40));
        }
        time += match kind {
            0 => 25_000,
            1 => 1 + i64::try_from(chance.below(1 << 45)).unwrap(),
            _ => 1 + i64::try_from(chance.below(3)).unwrap(),
        };
    }
    trace
}

fn back(format: Format, trace: &Trace) -> Trace {
    let mut bytes = Vec::new();
    format.write(&mut bytes, trace).unwrap();
    let reading = format.read(&bytes);
    assert_eq!(reading.notes, [""; 0], "{format:?}");
    match reading.whole() {
        Ok(trace) => trace,
        Err((place, flaw)) => {
            panic!("{format:?}: {place:?}: {flaw}\n{}", String::from_utf8_lossy(&bytes))
        }
    }
}

#[test]
fn random_traces_come_back_from_every_format() {
    for format in Format::ALL {
        let mut chance = Chance(7);
        for round in 0..300 {
            let trace = random(&mut chance);
            let got = back(format, &trace);
            assert_eq!(
                got.times().iter().collect::<Vec<_>>(),
                trace.times().iter().collect::<Vec<_>>(),
                "{format:?} {round}"
            );
            assert_eq!(got, trace, "{format:?} {round}");
        }
    }
}

#[test]
fn the_smallest_traces_come_back() {
    for format in Format::ALL {
        let mut trace = Trace::default();
        assert_eq!(back(format, &trace), trace, "{format:?}: nothing");
        for ty in TYPES {
            trace.add(ty.name(), ty);
        }
        assert_eq!(back(format, &trace), trace, "{format:?}: no samples");
        for first in [0, 5] {
            let mut trace = trace.clone();
            trace.sample(first).unwrap();
            assert_eq!(back(format, &trace), trace, "{format:?}: nothing known at {first}");
            for (n, ty) in TYPES.iter().enumerate() {
                trace.set(n, Value::from_bits(*ty, 1)).unwrap();
            }
            assert_eq!(back(format, &trace), trace, "{format:?}: one sample at {first}");
            trace.sample(first + 1).unwrap();
            assert_eq!(back(format, &trace), trace, "{format:?}: nothing changes");
        }
    }
}

#[test]
fn what_a_format_cannot_hold_is_said() {
    let mut trace = Trace::default();
    trace.add("x", Type::Bit);
    trace.push(-5, &[1]).unwrap();
    trace.push(5, &[0]).unwrap();
    for format in [Format::Csv, Format::Json] {
        assert_eq!(back(format, &trace), trace);
    }
    for format in [Format::Vcd, Format::Fst] {
        let e = format.write(Vec::new(), &trace).unwrap_err().to_string();
        assert!(e.ends_with("has no times before zero; CSV and JSON have"), "{e}");
    }
}

#[test]
fn a_long_trace_is_written_in_blocks_and_read_to_where_it_is_cut_off() {
    let mut chance = Chance(3);
    let mut trace = Trace::default();
    let channels = 8;
    for n in 0..channels {
        trace.add(&format!("f{n}"), Type::Float);
    }
    let mut record = vec![0; channels];
    for i in 0..150_000 {
        for cell in &mut record {
            *cell = chance.next();
        }
        trace.push(i * 1000, &record).unwrap();
    }
    assert_eq!(back(Format::Fst, &trace), trace);
    let mut bytes = Vec::new();
    Format::Fst.write(&mut bytes, &trace).unwrap();
    let got = Format::Fst.read(&bytes[..bytes.len() - 100]);
    let (_, flaw) = got.flaw.unwrap();
    assert_eq!(flaw.to_string(), "the file ends too early");
    assert!(got.trace.len() > 50_000, "{}", got.trace.len());
    let end = got.trace.times().last().unwrap() + 1;
    assert_eq!(got.trace, trace.between(0, end));
}

/// Damaged files cause no panic and no excessive allocation.
#[test]
fn damaged_files_are_refused_or_read() {
    let mut chance = Chance(11);
    for format in Format::ALL {
        for _ in 0..40 {
            let trace = random(&mut chance);
            let mut bytes = Vec::new();
            format.write(&mut bytes, &trace).unwrap();
            for _ in 0..40 {
                let mut bytes = bytes.clone();
                for _ in 0..=chance.below(4) {
                    let at = usize::try_from(chance.below(bytes.len() as u64)).unwrap();
                    match chance.below(3) {
                        0 => bytes[at] = u8::try_from(chance.below(256)).unwrap(),
                        1 => bytes[at] ^= 1 << chance.below(8),
                        _ => drop(bytes.drain(at..(at + 9).min(bytes.len()))),
                    }
                }
                for any in Format::ALL {
                    drop(any.read(&bytes));
                }
            }
        }
    }
}
