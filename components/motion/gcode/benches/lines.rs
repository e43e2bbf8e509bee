//! Lines per second of a program of straight lines and arcs, beside `rs274` in the same run.
#![expect(clippy::print_stdout, clippy::unwrap_used, reason = "a benchmark")]
#![expect(clippy::disallowed_methods, reason = "a benchmark measures time")]

use std::{
    fmt::Write as _,
    io::Write as _,
    process::{Command, Stdio},
    sync::Arc,
    time::Instant,
};

use hal_gcode::{Environment, Interpreter, Numbered, Settings, Step, Text, tool::Tool};

const LINES: u32 = 500_000;

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

/// Runs the program into a sink that prints each call as `rs274` does.
fn ours(text: &str) -> f64 {
    let mut sink = std::io::BufWriter::new(std::fs::File::create("/dev/null").unwrap());
    let mut it = Interpreter::new(Settings::default(), Numbered::default());
    let start = Instant::now();
    it.load("bench.ngc", Arc::new(text.as_bytes().to_vec()));
    let mut out = Vec::new();
    let mut n = 0u64;
    while it.next(&Nothing, &mut out).unwrap() != Step::Ended {
        for issued in out.drain(..) {
            n += 1;
            writeln!(sink, "{n:5} N..... {}", issued.call).unwrap();
        }
    }
    sink.flush().unwrap();
    start.elapsed().as_secs_f64()
}

/// Runs the program without printing.
fn bare(text: &str) -> f64 {
    let mut it = Interpreter::new(Settings::default(), Numbered::default());
    let start = Instant::now();
    it.load("bench.ngc", Arc::new(text.as_bytes().to_vec()));
    let mut out = Vec::new();
    while it.next(&Nothing, &mut out).unwrap() != Step::Ended {
        out.clear();
    }
    start.elapsed().as_secs_f64()
}

fn theirs(text: &str) -> Option<f64> {
    let room = std::env::temp_dir().join("hal-gcode-bench");
    std::fs::create_dir_all(&room).ok()?;
    std::fs::write(room.join("bench.ngc"), text).ok()?;
    std::fs::write(room.join("v.var"), "5161 0\n").ok()?;
    std::fs::write(room.join("t.tbl"), "T1 P1\n").ok()?;
    Command::new("chmod").args(["-R", "a+rwX"]).arg(&room).status().ok()?;
    let mut command = Command::new("runuser");
    command.args(["-u", "nobody", "--", "env"]).arg(format!("HOME={}", room.display()));
    command.args(["rs274", "-g", "-t", "t.tbl", "-v", "v.var", "bench.ngc"]);
    command.current_dir(&room).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let start = Instant::now();
    let done = command.status().ok()?;
    done.success().then(|| start.elapsed().as_secs_f64())
}

fn main() {
    let text = program();
    let best = |f: &dyn Fn() -> f64| (0..3).map(|_| f()).fold(f64::INFINITY, f64::min);
    let rate = |seconds: f64| f64::from(LINES) / seconds;
    let printing = best(&|| ours(&text));
    println!("hal-gcode, printing: {:.0} lines/s", rate(printing));
    println!("hal-gcode, calls only: {:.0} lines/s", rate(best(&|| bare(&text))));
    match theirs(&text) {
        Some(seconds) => {
            let seconds = seconds.min(theirs(&text).unwrap_or(seconds));
            println!("rs274, printing: {:.0} lines/s", rate(seconds));
            println!("ratio with printing: {:.2}", seconds / printing);
        }
        None => println!("rs274 is not installed: no ratio"),
    }
}
