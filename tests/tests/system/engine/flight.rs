//! The flight recorder: its files agree with a recording over the requested time before and after an event, and no
//! failure disturbs the machine.
#![expect(clippy::unwrap_used, clippy::panic, reason = "tests")]

use hal_engine::ClockKind;
use hal_protocol::{FlightInfo, FlightSpec, KeptState, Link, Reply, Request, Value};
use hal_tests::{
    foreign::{compile, component},
    machine::{Machine, Served, cycles, script, status, wait, without_fifo},
    plugins::plugins,
    programs::root,
    scratch::Scratch,
};
use hal_trace::{Format, Trace};
use std::path::Path;

fn read(path: &Path) -> Trace {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let reading = Format::of(path).unwrap().read(&bytes);
    assert!(reading.flaw.is_none(), "{}: {:?}", path.display(), reading.flaw);
    reading.trace
}

fn info(link: &mut impl Link) -> FlightInfo {
    match link.call(Request::FlightState) {
        Ok(Reply::Flight(info)) => info,
        other => panic!("{other:?}"),
    }
}

fn on(link: &mut impl Link, spec: FlightSpec) {
    link.call(Request::Flight(spec)).unwrap();
}

#[test]
fn a_following_error_in_the_middle_of_a_move() {
    let scratch = Scratch::copy_of(&root().join("configs/printer"));
    scratch.write(
        "custom_postgui.hal",
        "flight on time=1s after=200ms file=crash.vcd
         record whole.vcd
         iocontrol.estop-reset --wait
         motion.enable --wait
         motion.home joint=all --wait
         motion.jog joint=0 velocity=50
         run 1500ms
         # The encoder is lost.
         unlinkp axis.0.motor-pos-fb
         run 500ms
         flight
         record off
         shutdown
",
    );
    let output = scratch.halrun(&["--virtual", "printer.ini"]);
    let said = "motmod: axis X following error\nflight recorder: following error: axis.0.f-errored; kept in ";
    assert!(output.stderr.starts_with(said), "{}", output.stderr);
    assert_eq!((output.stderr.lines().count(), output.status), (2, Some(0)));
    let kept = read(&scratch.path().join("crash-1.vcd"));
    let marks = kept.markers();
    let first = marks.first().unwrap();
    assert_eq!(first.text, "trigger: following error: axis.0.f-errored");
    assert!(output.stdout.contains("following error: axis.0.f-errored  "), "{}", output.stdout);

    // The second before the event, and the requested time after it.
    let (at, times) = (first.at, kept.times());
    assert_eq!((times.first(), times.last()), (Some(at - 1_000_000_000), Some(at + 200_000_000)));
    let errored = kept.find("axis.0.f-errored").unwrap();
    let fb = kept.find("stepgen.0.position-fb").unwrap();
    assert_eq!(kept.at(errored, at - 1), Some(Value::Bit(false)));
    assert_eq!(kept.at(errored, at), Some(Value::Bit(true)));
    let moved = |at: i64| match kept.at(fb, at) {
        Some(Value::Float(x)) => x,
        other => panic!("{other:?}"),
    };
    assert!(moved(at) - moved(at - 500_000_000) > 20.0, "it is in the middle of a move");

    // All of it agrees with a recording, for every pin and signal, at every moment.
    let whole = read(&scratch.path().join("whole.vcd"));
    let whole = whole.between(at - 1_000_000_000, at + 200_000_001);
    let changes = |trace: &Trace, channel: usize| -> Vec<(Option<i64>, Option<Value>)> {
        let channel = trace.channels().get(channel).unwrap();
        channel.changes().map(|c| (trace.times().get(c.sample), c.value)).collect()
    };
    let mut compared = 0;
    for (i, channel) in whole.channels().iter().enumerate() {
        let wanted = changes(&whole, i);
        for name in channel.names().iter().filter(|n| **n != "axis.0.motor-pos-fb") {
            let own = kept.find(name).unwrap_or_else(|| panic!("{name} was not kept"));
            assert_eq!(changes(&kept, own), wanted, "{name}");
            compared += 1;
        }
    }
    assert!(compared > 150, "{compared} names");
    // The unlinked pin kept its last value; the signal kept changing.
    let own = kept.find("axis.0.motor-pos-fb").unwrap();
    assert_eq!(kept.at(own, at), kept.at(own, at + 100_000_000));
    assert_ne!(kept.at(fb, at), kept.at(own, at));
    assert_eq!(kept.at(fb, at - 500_000_000), kept.at(own, at - 500_000_000));

    // The same bytes on every run.
    let before = std::fs::read(scratch.path().join("crash-1.vcd")).unwrap();
    assert_eq!(scratch.halrun(&["--virtual", "printer.ini"]).status, Some(0));
    assert!(std::fs::read(scratch.path().join("crash-1.vcd")).unwrap() == before);
}

#[test]
fn a_fault_is_kept_with_its_cause() {
    for clock in [ClockKind::Virtual, ClockKind::Real] {
        let scratch = Scratch::new("fault");
        let file = scratch.path().join("fault.fst");
        let mut m = Machine::new(clock);
        m.script(
            "loadrt threads\nloadrt boom\nloadrt and2\naddf and2.0 thread1\naddf boom.0 thread1",
        );
        let file = Some(file.display().to_string());
        on(&mut m, FlightSpec { file, ..FlightSpec::default() });
        m.script("start\nsetp and2.0.in0 1\nsetp and2.0.in1 1");
        if clock == ClockKind::Virtual {
            m.script("run 3000000\nsetp boom.0.go 1\nrun 3000000");
        } else {
            cycles(&mut m, "thread1", 3);
            m.script("setp boom.0.go 1");
        }
        wait(
            &mut m,
            "the file",
            |m| matches!(info(m).kept.as_slice(), [k] if k.state == KeptState::Written),
        );
        let kept = read(&scratch.path().join("fault-1.fst"));
        let text = &kept.markers().first().unwrap().text;
        assert!(text.starts_with("trigger: fault: boom.0 of boom: "), "{text}");
        let out = kept.find("and2.0.out").unwrap();
        assert_eq!(kept.value(out, kept.len() - 1), Some(Value::Bit(true)));
    }
}

#[test]
fn nothing_is_missed_while_components_come_and_go() {
    for clock in [ClockKind::Virtual, ClockKind::Real] {
        let scratch = Scratch::new("churn");
        let lines = "loadrt threads name1=thread1 period1=200000\nloadrt and2\naddf and2.0 thread1";
        let served = Served::on(clock, &scratch, "churn", lines);
        let mut c = served.client();
        on(&mut c, FlightSpec::default());
        script(&mut c, "start");
        let step = |c: &mut hal_protocol::Client| {
            if clock == ClockKind::Virtual {
                script(c, "run 600000");
            } else {
                cycles(c, "thread1", 3);
            }
        };
        for _ in 0..20 {
            script(&mut c, "setp and2.0.in0 1");
            step(&mut c);
            script(&mut c, "loadrt or2\naddf or2.0 thread1\nnewsig s bit\nlinkps or2.0.in0 s");
            step(&mut c);
            script(&mut c, "setp and2.0.in0 0\nsets s 1");
            step(&mut c);
            script(&mut c, "unlinkp or2.0.in0\nunloadrt or2\ndelsig s");
            step(&mut c);
        }
        let path = scratch.path().join("churn.vcd");
        let save = Request::SaveFlight { path: path.display().to_string(), last: false };
        c.call(save).unwrap();
        wait(&mut c, "the file", |c| {
            info(c).kept.last().is_some_and(|k| k.state == KeptState::Written)
        });
        assert_eq!(info(&mut c).lost, 0);
        let kept = read(&path);
        let edges = |name: &str| {
            let channel = kept.channels().get(kept.find(name).unwrap()).unwrap();
            channel.changes().filter(|c| c.value == Some(Value::Bit(true))).count()
        };
        assert_eq!((edges("and2.0.in0"), edges("s"), edges("or2.0.in0")), (20, 20, 20));
        served.end();
    }
}

#[test]
fn what_cannot_be_written_stays_in_memory_and_disturbs_nothing() {
    for clock in [ClockKind::Virtual, ClockKind::Real] {
        let scratch = Scratch::new("full");
        let lines =
            "loadrt threads name1=thread1 period1=200000\nloadrt and2\naddf and2.0 thread1\nstart";
        let served = Served::on(clock, &scratch, "full", lines);
        let mut c = served.client();
        let step = |c: &mut hal_protocol::Client| {
            if clock == ClockKind::Virtual {
                script(c, "run 1000000");
            } else {
                cycles(c, "thread1", 5);
            }
        };
        let at = |name: &str| scratch.path().join(name).display().to_string();
        // A full disk, a folder that does not exist.
        std::os::unix::fs::symlink("/dev/full", at("full-1.vcd")).unwrap();
        std::os::unix::fs::symlink("/dev/full", at("also.vcd")).unwrap();
        for (file, why) in [("full.vcd", "No space left"), ("none/x.csv", "No such file")] {
            let when = vec!["and2.0.out".to_owned()];
            on(&mut c, FlightSpec { file: Some(at(file)), when, ..FlightSpec::default() });
            step(&mut c);
            script(&mut c, "setp and2.0.in0 1\nsetp and2.0.in1 1");
            step(&mut c);
            let failed = |c: &mut hal_protocol::Client| {
                let kept = info(c).kept;
                matches!(kept.last().map(|k| k.state.clone()), Some(KeptState::Failed(e)) if e.contains(why))
            };
            wait(&mut c, why, failed);
            assert!(status(&mut c).running);
            // The event is in memory and can be written from there.
            let save = |c: &mut hal_protocol::Client, name: &str| {
                c.call(Request::SaveFlight { path: at(name), last: true })
            };
            save(&mut c, "good.json").unwrap();
            wait(&mut c, "the file", |c| {
                info(c).kept.last().is_some_and(|k| k.state == KeptState::Written)
            });
            assert_eq!(read(&scratch.path().join("good.json")).markers().len(), 1);
            let none = save(&mut c, "none/y.vcd").unwrap_err().to_string();
            assert!(none.contains("No such file"), "{none}");
            let said = save(&mut c, "also.vcd");
            wait(&mut c, "also", |c| said.is_err() || failed_at(c, "No space left"));
            script(&mut c, "setp and2.0.in0 0\nsetp and2.0.in1 0");
        }
        served.end();
    }
}

fn failed_at(c: &mut impl Link, why: &str) -> bool {
    let last = info(c).kept.last().map(|k| k.state.clone());
    matches!(last, Some(KeptState::Failed(e)) if e.contains(why))
}

#[test]
fn all_of_this_without_fifo() {
    without_fifo(module_path!(), "all_of_this_without_fifo");
}

#[test]
fn a_condition_hears_parameters_and_every_name() {
    // A parameter in a component's own memory, which is freed with it.
    let scratch = Scratch::new("params");
    let own = "static hal_u32_t *runs;";
    let main = "runs = hal_malloc(sizeof *runs); *runs = 0;
        if (hal_param_u32_newf(HAL_RO, runs, id, \"mine.runs\") < 0) return -1;";
    let source = component(own, main, "(void)period; ++*runs;");
    if compile(scratch.path(), "mine", &source, &[]).is_none() {
        return;
    }
    scratch.write(
        "m.hal",
        "loadrt threads name1=t period1=1000000
loadrt mine
loadrt updown
loadrt hal_parport cfg=\"0x378 out\"
addf mine.0 t
addf updown.0 t
addf parport.0.write t
alias pin updown.0.count ticks
flight on after=1ms when='mine.runs >= 3' when='updown.0.max = 7' when='updown.0.count > 0' \\
    when='parport.0.sim.data = 2'
start
run 5ms
setp updown.0.max 7
run 5ms
setp updown.0.countup 1
run 5ms
setp parport.0.pin-03-out 1
run 5ms
delf mine.0 t
unloadrt mine
setp updown.0.max 6
run 5ms
setp updown.0.max 7
run 5ms
flight
",
    );
    let folders = format!("{}:{}", scratch.path().display(), plugins().display());
    let mut command = scratch.command(&[], "halrun");
    let output =
        scratch.run(command.env("HAL_RTMOD_DIR", folders).args(["--virtual", "-f", "m.hal"]));
    let events: Vec<&str> = output.stderr.lines().filter(|l| l.starts_with("flight")).collect();
    assert_eq!(
        events,
        [
            "flight recorder: mine.runs >= 3; kept in memory as event 1",
            "flight recorder: updown.0.max = 7; kept in memory as event 2",
            "flight recorder: updown.0.count > 0; kept in memory as event 3",
            "flight recorder: parport.0.sim.data = 2; kept in memory as event 4",
            "flight recorder: updown.0.max = 7; kept in memory as event 5",
        ],
        "{}{}",
        output.stdout,
        output.stderr
    );
}

#[test]
fn the_hint_names_what_can_be_saved_and_nothing_that_is_lost() {
    let scratch = Scratch::new("hint");
    let event = "setp and2.0.in0 0\nrun 1ms\nsetp and2.0.in0 1\nrun 1ms\n";
    for (on, file, said) in [
        ("", "", "kept in memory as event 1\n"),
        (
            "file=none/x.csv",
            "none/x-1.csv: No such file or directory; ",
            "it is in memory: 'flight save FILE.csv last'\n",
        ),
    ] {
        let begin = format!(
            "loadrt threads name1=t period1=1000000\nloadrt and2\naddf and2.0 t\nsetp and2.0.in1 1\n\
             start\nrun 1ms\nflight on {on} when=and2.0.in0\n"
        );
        let lines = format!("{begin}{event}flight\nflight save event.csv last\nflight off\n");
        scratch.write("m.hal", lines);
        let output = scratch.halrun(&["--virtual", "-f", "m.hal"]);
        let here = format!("{}/", scratch.path().display());
        let words = output.stderr.replace(&here, "");
        assert_eq!(words, format!("flight recorder: and2.0.in0; {file}{said}"));
        // A file that could not be written is the status, wherever the event is kept.
        assert_eq!(output.status, Some(i32::from(!file.is_empty())));
        assert!(!read(&scratch.path().join("event.csv")).is_empty());
        // The event is in progress when the recorder is switched off.
        scratch.write(
            "m.hal",
            format!("{}{event}flight off\n", begin.replace("when=", "after=1s when=")),
        );
        let output = scratch.halrun(&["--virtual", "-f", "m.hal"]);
        let words = output.stderr.replace(&here, "");
        let lost = if file.is_empty() {
            "it is lost: 'flight on' was given no file="
        } else {
            "it is lost"
        };
        assert_eq!(words, format!("flight recorder: and2.0.in0; {file}{lost}\n"));
    }
}
