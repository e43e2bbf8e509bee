//! Processor time of a program of straight lines and arcs, beside that of `rs274` for the same file and sink.
#![expect(clippy::print_stdout, clippy::unwrap_used, reason = "a benchmark")]

use std::{
    fmt::Write as _,
    io::Write as _,
    process::{Command, Stdio},
    sync::Arc,
};

use hal_gcode::{Environment, Interpreter, Numbered, Settings, Step, Text, tool::Tool};

const LINES: u32 = 600_000;

struct Nothing;

impl Environment for Nothing {
    fn open(&self, _: &str) -> Option<Text> {
        None
    }

    fn tool(&self, _: i32) -> Option<Tool> {
        None
    }
}

fn program() -> String {
    let mut text = String::from("G21 G90 G17 F1000\n");
    for i in 0..LINES {
        let t = f64::from(i) * 0.001;
        let (x, y, z) = (t.sin() * 50.0, t.cos() * 50.0, t * 0.01);
        match i % 10 {
            0 => writeln!(text, "N{i} G1 X{x:.4} Y{y:.4} Z{z:.4} F1200").unwrap(),
            1 => writeln!(text, "G2 X{:.4} Y{y:.4} R5", x + 2.0).unwrap(),
            2 => writeln!(text, "#1=[{x:.4}*2]").unwrap(),
            3 => writeln!(text, "G1 X#1 Y[{y:.4}+1]").unwrap(),
            4 => writeln!(text, "G1 X{x:.4} Y{y:.4} (a comment)").unwrap(),
            9 => writeln!(text, "G1 X{x:.4} Y{y:.4}").unwrap(),
            _ => writeln!(text, "X{x:.4} Y{y:.4} Z{z:.4}").unwrap(),
        }
    }
    text.push_str("M2\n");
    text
}

/// Runs a file into standard output, each call as `rs274` prints it.
fn print(path: &str) {
    let text = std::fs::read(path).unwrap();
    let mut sink = std::io::BufWriter::with_capacity(1 << 16, std::io::stdout().lock());
    let mut it = Interpreter::new(Settings::default(), Numbered::default());
    it.load("bench.ngc", Arc::new(text));
    let mut out = Vec::new();
    let mut n = 0u64;
    while it.next(&Nothing, &mut out).unwrap() != Step::Ended {
        for issued in out.drain(..) {
            n += 1;
            writeln!(sink, "{n:5} N..... {}", issued.call).unwrap();
        }
    }
    sink.flush().unwrap();
}

/// Returns the processor time, user's and system's, of all children that have ended, in seconds.
fn children() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap();
    // The name in brackets may contain blanks; the times are fields 16 and 17, in hundredths of a second.
    let fields: Vec<&str> = stat.rsplit_once(')').unwrap().1.split_whitespace().collect();
    let ticks = |n: usize| fields.get(n).unwrap().parse::<f64>().unwrap();
    (ticks(13) + ticks(14)) / 100.0
}

/// Runs a command into `/dev/null` and returns its processor time.
fn time(command: &mut Command) -> Option<f64> {
    let before = children();
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let done = command.status().ok()?;
    done.success().then(|| children() - before)
}

fn main() {
    // The benchmark is its own child, so that both are measured alike.
    let mut words = std::env::args().skip(1);
    if let (Some("--print"), Some(path)) = (words.next().as_deref(), words.next()) {
        return print(&path);
    }
    let room = std::env::temp_dir().join("hal-gcode-bench");
    std::fs::create_dir_all(&room).unwrap();
    let path = room.join("bench.ngc");
    std::fs::write(&path, program()).unwrap();
    std::fs::write(room.join("v.var"), "5161 0\n").unwrap();
    std::fs::write(room.join("t.tbl"), "T1 P1\n").unwrap();
    // The reference links its parameter file to a second name, which only its owner may do, and it refuses root.
    let owned = Command::new("chown").args(["-R", "nobody"]).arg(&room).status().unwrap();
    assert!(owned.success(), "only root can run rs274 as another user");
    let mut ours = Vec::new();
    let mut theirs = Vec::new();
    for _ in 0..5 {
        let mut command = Command::new(std::env::current_exe().unwrap());
        ours.extend(time(command.arg("--print").arg(&path)));
        let mut command = Command::new("runuser");
        command.args(["-u", "nobody", "--", "env"]).arg(format!("HOME={}", room.display()));
        command.args(["rs274", "-g", "-t", "t.tbl", "-v", "v.var", "bench.ngc"]).current_dir(&room);
        theirs.extend(time(&mut command));
    }
    let least = |times: &[f64]| times.iter().copied().fold(f64::INFINITY, f64::min);
    let report = |name: &str, times: &[f64]| {
        let least = least(times);
        println!("{name}: {least:.2} s of processor time, {:.0} lines/s", f64::from(LINES) / least);
    };
    println!("{LINES} lines, the least of {} runs, interleaved", ours.len());
    report("hal-gcode", &ours);
    if theirs.is_empty() {
        println!("rs274 is not installed: no ratio");
        return;
    }
    report("rs274", &theirs);
    println!("ratio: {:.2}", least(&theirs) / least(&ours));
}
