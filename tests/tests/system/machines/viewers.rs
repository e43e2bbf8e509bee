//! Trace files in other programs: the tools of `GTKWave`, sigrok and Python read ours, and we read theirs. Programs
//! that are not installed are skipped, and reported.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_protocol::{Type, Value};
use hal_tests::{scratch::Scratch, tools::Tool};
use hal_trace::{Trace, load, save};
use std::process::Command;

/// Runs a program on files of the folder; returns `None` if it is not installed.
fn run(scratch: &Scratch, program: &str, words: &[&str]) -> Option<String> {
    let output = Command::new(program).args(words).current_dir(scratch.path()).output();
    let Ok(output) = output else {
        Tool::of(program).skip();
        return None;
    };
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let err = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{program} {words:?}: {err}{text}");
    Some(text)
}

/// Returns a trace of steps at two speeds, and one channel of every type.
fn trace() -> Trace {
    let mut trace = Trace::default();
    for (name, ty) in [
        ("stepgen.0.step", Type::Bit),
        ("stepgen.0.dir", Type::Bit),
        ("stepgen.0.position-fb", Type::Float),
        ("stepgen.0.counts", Type::S32),
        ("n", Type::U32),
        ("far", Type::S64),
        ("farther", Type::U64),
    ] {
        trace.add(name, ty);
    }
    for i in 0..400_i32 {
        let period = if i < 200 { 4 } else { 10 };
        let n = u64::from(i.unsigned_abs());
        let float = match i % 50 {
            7 => f64::NAN,
            8 => f64::INFINITY,
            9 => f64::NEG_INFINITY,
            10 => -0.0,
            _ => f64::from(i) / 7.0,
        };
        let record = [
            u64::from(i % period < period / 2),
            u64::from(i >= 200),
            float.to_bits(),
            Value::S32(200 - i).bits(),
            u64::from(u32::MAX) - n,
            Value::S64(i64::MIN + i64::from(i)).bits(),
            u64::MAX - n,
        ];
        trace.push(i64::from(i) * 25_000, &record).unwrap();
    }
    trace.mark(5_000_000, "trigger: stepgen.0.dir rises");
    trace
}

fn written(name: &str, endings: &[&str]) -> (Scratch, Trace) {
    let (scratch, trace) = (Scratch::new(name), trace());
    for ending in endings {
        save(&scratch.path().join(format!("ours.{ending}")), &trace).unwrap();
    }
    (scratch, trace)
}

fn read(scratch: &Scratch, name: &str) -> Trace {
    let (reading, flaw) = load(&scratch.path().join(name)).unwrap();
    let bytes = std::fs::read(scratch.path().join(name)).unwrap();
    let start: String = String::from_utf8_lossy(&bytes).chars().take(300).collect();
    assert_eq!((flaw, &reading.notes[..]), (None, &[][..]), "{name}: {start}");
    reading.trace
}

/// Asserts that names, types, and the values at each time of `ours` are equal.
fn same(ours: &Trace, theirs: &Trace) {
    for (n, channel) in ours.channels().iter().enumerate() {
        let found = theirs.find(channel.name()).unwrap();
        assert_eq!(theirs.channels().get(found).unwrap().ty(), channel.ty(), "{}", channel.name());
        for (sample, time) in ours.times().iter().enumerate() {
            let (a, b) = (theirs.at(found, time), ours.value(n, sample));
            // fst2vcd writes sixteen digits of a float.
            if let (Some(Value::Float(a)), Some(Value::Float(b))) = (a, b)
                && (a - b).abs() <= b.abs() * 1e-15
                && a.is_sign_negative() == b.is_sign_negative()
            {
                continue;
            }
            assert_eq!(a, b, "{} at {time}", channel.name());
        }
    }
}

#[test]
fn gtkwave_reads_our_vcd_and_we_read_its_fst() {
    let (scratch, ours) = written("vcd", &["vcd"]);
    for (pack, name) in [("-4", "lz4.fst"), ("-Z", "zlib.fst"), ("-F", "fast.fst")] {
        if run(&scratch, "vcd2fst", &[pack, "ours.vcd", name]).is_none() {
            return;
        }
        same(&ours, &read(&scratch, name));
    }
    run(&scratch, "vcd2fst", &["-c", "ours.vcd", "packed.fst"]);
    same(&ours, &read(&scratch, "packed.fst"));
}

#[test]
fn gtkwave_reads_our_fst_and_we_read_its_vcd() {
    let (scratch, ours) = written("fst", &["fst"]);
    if let Some(text) = run(&scratch, "fst2vcd", &["ours.fst"]) {
        scratch.write("theirs.vcd", text);
        same(&ours, &read(&scratch, "theirs.vcd"));
    }
}

#[test]
fn sigrok_reads_our_vcd_and_we_read_its_own() {
    // Bits only: sigrok cannot handle NaN, which our trace contains.
    let (scratch, all) = (Scratch::new("sigrok"), trace());
    let mut ours = Trace::default();
    for (n, name) in ["stepgen.0.step", "stepgen.0.dir"].into_iter().enumerate() {
        ours.add(name, Type::Bit);
        assert_eq!(all.find(name), Some(n));
    }
    for (sample, time) in all.times().iter().enumerate() {
        let record = [0, 1].map(|n| all.value(n, sample).unwrap().bits());
        ours.push(time, &record).unwrap();
    }
    save(&scratch.path().join("ours.vcd"), &ours).unwrap();
    let words = ["-I", "vcd:downsample=25000", "-i", "ours.vcd", "-O", "vcd", "-o", "theirs.vcd"];
    if run(&scratch, "sigrok-cli", &words).is_none() {
        return;
    }
    let theirs = read(&scratch, "theirs.vcd");
    // The format supports bits; its samples are 25 microseconds long.
    for name in ["step", "dir"] {
        let found = theirs.channels().iter().position(|c| c.name().ends_with(name)).unwrap();
        let n = ours.find(&format!("stepgen.0.{name}")).unwrap();
        for (sample, time) in ours.times().iter().enumerate() {
            let at = time / theirs.base().nanoseconds(1);
            assert_eq!(theirs.at(found, at), ours.value(n, sample), "{name} at {time}");
        }
    }
}

#[test]
fn python_reads_our_csv_and_json() {
    let (scratch, _) = written("python", &["csv", "json"]);
    let script = "
import csv, json, math
rows = list(csv.reader(open('ours.csv', newline='')))
head, rows = rows[0], [r for r in rows[1:] if not r[-1]]
assert head[:2] == ['time [ns]', 'stepgen.0.step (bit)'] and head[-1] == 'marker', head
data = json.load(open('ours.json'))
assert [c['type'] for c in data['channels']] == ['bit', 'bit', 'float', 's32', 'u32', 's64', 'u64']
assert len(rows) == len(data['samples']) == 400
for i, (row, sample) in enumerate(zip(rows, data['samples'])):
    assert int(row[0]) == sample[0] == i * 25000
    assert bool(int(row[1])) == sample[1]
    a, b = float(row[3]), float(sample[3])
    assert a == b and math.copysign(1, a) == math.copysign(1, b) or a != a and b != b
    assert int(row[4]) == sample[4] == 200 - i
    assert int(row[6]) == int(sample[6]) == -2**63 + i
    assert int(row[7]) == int(sample[7]) == 2**64 - 1 - i
print('read')
";
    if let Some(text) = run(&scratch, "python3", &["-c", script]) {
        assert_eq!(text, "read\n");
    }
}

#[test]
fn a_spreadsheet_imports_our_csv() {
    let (scratch, ours) = written("sheet", &["csv"]);
    let words = ["ours.csv", "theirs.csv"];
    if run(&scratch, "ssconvert", &words).is_none() {
        return;
    }
    // It rounds large integers for display; times and small numbers survive the round trip.
    let text = scratch.read("theirs.csv");
    let mut rows = text.lines().skip(1).filter(|line| !line.contains("trigger"));
    for time in ours.times().iter() {
        let row = rows.next().unwrap();
        assert_eq!(row.split(',').next(), Some(time.to_string().as_str()), "{row}");
    }
}
