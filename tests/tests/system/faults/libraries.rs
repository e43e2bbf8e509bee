//! Plugins that must be refused, and loads that fail: the engine survives each, reports it, and nothing is left of it.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_component::abi::ABI_MINOR;
use hal_engine::ClockKind;
use hal_protocol::{Kind, Link, Reply, Request};
use hal_tests::{
    machine::{Machine, says, status},
    plugins::plugins,
};

/// Returns everything that a failed load could leave behind.
fn everything(m: &mut Machine) -> String {
    let s = status(m);
    let kinds = [Kind::Components, Kind::Signals, Kind::Functs, Kind::Commands, Kind::Streams];
    let mut text = format!("{:?} {:?} {:?} {:?}", s.components, s.functs, s.threads, s.memory);
    text += &format!("{} {} {}", s.pins.active, s.params.active, s.signals.active);
    for kind in kinds {
        let list: Reply = m.call(Request::List { kind, patterns: Vec::new(), ty: None }).unwrap();
        text += &format!("\n{list:?}");
    }
    text
}

#[test]
fn what_is_no_plugin_is_refused_by_file_and_reason() {
    let mut m = Machine::new(ClockKind::Virtual);
    let folder = plugins().display().to_string();
    m.script("loadrt boom");
    let before = everything(&mut m);
    for (line, want) in [
        ("loadrt text", "<dir>/libtext.so: not a plugin: it is not a dynamic library"),
        ("loadrt empty", "<dir>/libempty.so: not a plugin: it is not a dynamic library"),
        ("loadrt half", "<dir>/libhalf.so: not a plugin: it is not a dynamic library"),
        (
            "loadrt nothing",
            "<dir>/libnothing.so: not a plugin: it exports no 'hal_library_nothing' (was the file \
             renamed?)",
        ),
        (
            "loadrt renamed",
            "<dir>/librenamed.so: not a plugin: it exports no 'hal_library_renamed' (was the file \
             renamed?)",
        ),
        (
            "loadrt major",
            "<dir>/libmajor.so: built for major version 2 of the plugin contract, this engine has 1",
        ),
        (
            "loadrt minor",
            "<dir>/libminor.so: built for minor version <next> of the plugin contract, this engine \
             has only <minor>",
        ),
        (
            "loadrt aborts",
            "<dir>/libaborts.so: built with panic=abort: a panic in it would end the machine's process",
        ),
        ("loadrt cut", "<dir>/libcut.so: not a plugin: its descriptor is cut"),
        ("loadrt mute", "<dir>/libmute.so: not a plugin: it does not say how it panics"),
        ("loadrt stub", "<dir>/libstub.so: not a plugin: a component type is cut"),
        ("loadrt nulls", "<dir>/libnulls.so: not a plugin: a component type is cut"),
        ("loadrt latin", "<dir>/liblatin.so: not a plugin: a name is not UTF-8"),
        (
            "loadrt nameless",
            "<dir>/libnameless.so: not a plugin: a component type has no name or no code",
        ),
        (
            "loadrt hollow",
            "<dir>/libhollow.so: not a plugin: a component type has no name or no code",
        ),
        ("loadrt missing", "missing: no plugin library offers this component (searched <dir>)"),
        ("loadrt bare", "bare: no plugin library offers this component (searched <dir>)"),
        ("loadrt folder", "<dir>/libfolder.so: not a plugin: it is a folder, not a regular file"),
        (
            "loadrt stucc",
            "stucc: no plugin library offers this component (searched <dir>); did you mean stuck?",
        ),
        ("loadrt ../boom", "../boom: no plugin library offers this component (searched <dir>)"),
    ] {
        let want = want.replace("<dir>", &folder).replace("<minor>", &ABI_MINOR.to_string());
        let want = want.replace("<next>", &(ABI_MINOR + 1).to_string());
        assert_eq!(says(&mut m, line), want, "{line}");
        assert_eq!(everything(&mut m), before, "{line}");
    }
    let alien = says(&mut m, "loadrt alien");
    assert!(alien.starts_with(&format!("{folder}/libalien.so: not a plugin: ")), "{alien}");
    assert_eq!(says(&mut m, "loadrt longer"), "ok", "a later minor may append");
    assert_eq!(says(&mut m, "loadrt person personality=3"), "ok");
}

#[test]
fn a_load_that_fails_leaves_nothing() {
    let mut m = Machine::new(ClockKind::Virtual);
    m.script("loadrt threads");
    let before = everything(&mut m);
    for (by, want) in [
        ("panic", "doomed: panicked: told to panic in create (faulty/src/doomed.rs:"),
        ("error", "doomed: cannot be, and says why"),
        ("open", "doomed: the device is not there"),
        ("open-panic", "doomed: panicked: told to panic when opened (faulty/src/doomed.rs:"),
        ("pin", "doomed: duplicate pin 'doomed.in'"),
        ("param", "doomed: duplicate parameter 'doomed.param'"),
        ("funct", "doomed: duplicate function 'doomed.copy'"),
        ("thread", "doomed: duplicate thread 'doomed-thread'"),
        ("command", "doomed: duplicate command 'doomed.say'"),
        ("stream", "doomed: duplicate stream 'doomed.ring'"),
        (
            "long",
            "doomed: function name 'xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx' is too long; \
             at most 55 characters",
        ),
    ] {
        // Twice: leftovers of the first would show in the second.
        for _ in 0..2 {
            let said = says(&mut m, &format!("loadrt doomed by={by}"));
            // The message continues with the legal values of the argument.
            let said = said.split("; by=: ").next().unwrap_or_default();
            let whole = if want.ends_with(".rs:") { said.starts_with(want) } else { said == want };
            assert!(whole, "{by}: {said}");
            assert_eq!(says(&mut m, "run 10000000"), "ok");
            assert_eq!(everything(&mut m), before, "{by}");
        }
    }
    m.script("loadrt doomed");
    assert_eq!(says(&mut m, "doomed.say"), "said");
    m.script("unloadrt doomed\nloadrt doomed\nunloadrt doomed");
    assert_eq!(everything(&mut m), before);
}

#[test]
fn names_ports_and_personalities_that_are_unusual_work() {
    let mut m = Machine::new(ClockKind::Virtual);
    m.script(
        "loadrt threads
         loadrt foreign
         loadrt person count=2 personality=3,12
         loadrt talker
         loadrt listener
         net line talker.0.line listener.0.line
         addf motion-controller thread1
         addf talker.0 thread1
         addf listener.0 thread1
         addf person.1 thread1
         setp machine.enable 1
         setp person.1.in-11 1
         start
         run 5000000",
    );
    for (line, want) in [
        ("getp joint.0.motor-pos-cmd", "0.005"),
        ("getp person.0.in-02", "FALSE"),
        (
            "getp person.0.in-03",
            "parameter or pin 'person.0.in-03': not found; did you mean person.0.in-00?",
        ),
        ("getp person.1.count", "1"),
        // No queue exists yet: nothing is sent, which is no fault.
        ("getp talker.0.sent", "0"),
        ("getp talker.0.refused", "5"),
        ("sets line 4", "ok"),
        ("sets line 4", "signal 'line': queue already allocated"),
        ("run 5000000", "ok"),
        ("getp talker.0.sent", "3"),
        ("getp listener.0.waiting", "3"),
        ("setp listener.0.on 1", "ok"),
        ("run 4000000", "ok"),
        // Of three waiting bytes, a pair is removed in each cycle, and one byte arrives.
        ("getp listener.0.pairs", "3"),
        ("getp listener.0.last", "1284"),
        ("getp listener.0.waiting", "0"),
        (
            "net line2 listener.0.line",
            "Pin 'listener.0.line' was already linked to signal 'line'; 'unlinkp listener.0.line' frees it",
        ),
        ("unlinkp listener.0.line", "ok"),
        ("run 1000000", "ok"),
        ("getp listener.0.waiting", "0"),
        ("delsig line", "ok"),
        ("run 5000000", "ok"),
        ("getp talker.0.line", "0"),
    ] {
        assert_eq!(says(&mut m, line), want, "{line}");
    }
}
