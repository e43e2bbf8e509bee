//! Components in C that crash or never come back: who it was is said, and outputs are at their
//! safe levels before the process ends.

use hal_tests::{
    foreign::{compile, component},
    plugins::plugins,
    scratch::{Scratch, until},
};
use rustix::process::Signal;
use std::process::Command;

/// A port whose first line is high, watched by a plugin that says at the end what it saw; then the
/// component that crashes in its third cycle.
const MACHINE: &str = "loadrt threads name1=t period1=1000000
loadrt hal_parport cfg=\"0x378 out\"
loadrt last_words
net register parport.0.sim.data last-words.0.in
setp parport.0.pin-02-out 1
loadrt mine
addf parport.0.write t
addf last-words.0 t
addf mine.0 t
start
";

const GLOBALS: &str = "#include <stdlib.h>\nstatic volatile int runs, zero;\n\
     static int deeper(volatile char *from)\n\
     {\n volatile char room[4096]; room[0] = *from;\n \
     return zero ? 0 : deeper(room) + room[0];\n}";

/// A folder with a component that does this in its third run, and the machine around it.
fn machine(name: &str, does: &str) -> Option<Scratch> {
    let scratch = Scratch::new(name);
    let main = "(void)deeper;";
    let source = component(GLOBALS, main, &format!("if (++runs == 3) {{ {does} }}"));
    compile(scratch.path(), "mine", &source, &["-Wno-infinite-recursion"])?;
    scratch.write("m.hal", MACHINE);
    Some(scratch)
}

fn halrun(scratch: &Scratch) -> Command {
    let mut command = scratch.command(&[], "halrun");
    let folders = format!("{}:{}", scratch.path().display(), plugins().display());
    command.env("HAL_RTMOD_DIR", folders);
    command
}

#[test]
fn a_crash_is_named_and_outputs_are_safe_before_the_process_ends() {
    for (does, what) in [
        ("*(int *volatile)0 = 1;", "segmentation fault at address 0x0"),
        ("((void (*)(void))(zero + 16L))();", "segmentation fault at address 0x10"),
        ("deeper(\"\");", "segmentation fault at address 0x"),
        ("runs = (int)period / zero;", "arithmetic fault"),
        ("__builtin_trap();", "illegal instruction"),
        ("abort();", "it gave up (abort)"),
    ] {
        let Some(scratch) = machine("crash", does) else { return };
        for clock in ["--virtual", "--simulate"] {
            let output = scratch.run(halrun(&scratch).args([clock, "--for", "60s", "m.hal"]));
            let said = format!("component 'mine', function 'mine.0', thread 't': {what}");
            assert!(output.stderr.contains(&said), "{clock} {does}: {}", output.stderr);
            let first = "last words: it was 1 and is 0\n";
            assert!(output.stderr.starts_with(first), "{clock} {does}: {}", output.stderr);
            assert_eq!(output.status, None, "{clock} {does}: it ends by its signal");
        }
    }
}

#[test]
fn who_does_not_come_back_is_named_on_the_virtual_clock() {
    let Some(scratch) = machine("stuck-virtual", "for (;;) ;") else { return };
    let running = scratch.start(halrun(&scratch).args(["--virtual", "--for", "1s", "m.hal"]));
    let said = "function 'mine.0' of component 'mine' does not come back: thread 't' is stuck";
    until(said, || running.said().1.contains(said));
    // The control side is inside the function as well: it is ended all the same.
    running.signal(Signal::TERM);
    let output = running.wait();
    assert!(output.stderr.contains("last words: it was 1 and is 0\n"), "{}", output.stderr);
    assert_eq!(output.status, Some(1));
}

#[test]
fn who_does_not_come_back_is_named_on_the_real_clock_until_it_does() {
    let scratch = Scratch::new("stuck-real");
    let globals = "#include <unistd.h>\nstatic hal_bit_t **hold;";
    let main = "hold = hal_malloc(sizeof *hold);\n \
                if (hal_pin_bit_newf(HAL_IN, hold, id, \"mine.0.hold\")) return -EINVAL;";
    let source = component(globals, main, "while (**hold) usleep(1000);");
    if compile(scratch.path(), "mine", &source, &[]).is_none() {
        return;
    }
    let lines = "loadrt threads name1=t period1=1000000\nloadrt mine\naddf mine.0 t\nstart\n";
    scratch.write("m.hal", format!("{lines}print ready\n"));
    let running = scratch.start(halrun(&scratch).args(["--simulate", "m.hal"]));
    until("it runs", || running.said().1.contains("ready"));
    let status = || scratch.halcmd(&["status", "instance"]).stdout;
    assert!(!status().contains("stuck:"));
    assert_eq!(scratch.halcmd(&["setp", "mine.0.hold", "1"]).status, Some(0));
    let stuck =
        "  stuck:      component 'mine', function 'mine.0' in thread 't': it does not come back";
    until("it is stuck", || status().contains(stuck));
    let fault = "  fault:      component 'mine', function 'mine.0' in thread 't': it did not come \
                 back within 2 ms";
    until("the machine has stopped for it", || status().contains(fault));
    let refused = scratch.halcmd(&["unloadrt", "mine"]);
    assert!(refused.stderr.contains("thread 't' is stuck in its cycle, in function 'mine.0'"));
    assert_eq!(scratch.halcmd(&["setp", "mine.0.hold", "0"]).status, Some(0));
    until("it has come back", || !status().contains("stuck:"));
    // Nothing begins again by itself.
    assert!(status().contains(fault) && status().contains("threads:    stopped"), "{}", status());
    let start = scratch.halcmd(&["start"]);
    let said = "function 'mine.0' has failed: threads stay stopped";
    assert!(start.stderr.contains(said), "{}", start.stderr);
    let ended = scratch.halrun(&["-U"]);
    let said = "halrun: instance 'default' had a fault: function 'mine.0' of component 'mine' in \
                thread 't': it did not come back within 2 ms\n";
    assert_eq!((ended.stderr.as_str(), ended.status), (said, Some(1)));
    let output = running.wait();
    assert_eq!(output.status, Some(1), "{}", output.stderr);
}

/// On trial, set-up runs in a copy of the process first: whatever it does there is a finding among
/// the others.
#[test]
fn set_up_that_ends_the_process_is_a_finding_of_check() {
    let scratch = Scratch::new("check-crash");
    for (main, exit, said) in [
        ("*(int *volatile)0 = 1;", "", "rtapi_app_main crashes: segmentation fault"),
        ("abort();", "", "rtapi_app_main crashes: it gave up (abort)"),
        ("exit(3);", "", "rtapi_app_main ends the process, with status 3"),
        ("for (;;) pause();", "", "rtapi_app_main does not return: given up after 5 s"),
        ("", "*(int *volatile)0 = 1;", "rtapi_app_exit crashes: segmentation fault"),
    ] {
        let source = component("#include <stdlib.h>\n#include <unistd.h>", main, "");
        let source = source.replace("hal_exit(id); }", &format!("hal_exit(id); {exit} }}"));
        if compile(scratch.path(), "mine", &source, &[]).is_none() {
            return;
        }
        let lines = "loadrt threads name1=t period1=1000000\nloadrt mine\naddf mine.0 t\n\
                     loadrt and2\nnet x mine.0.out and2.0.in0\nsetp and2.0.in2 1\nstart\n";
        scratch.write("m.hal", lines);
        // Once is enough where it takes as long as patience lasts.
        let looks = if main.contains("pause") { 1 } else { 3 };
        for command in ["check", "order", "graph"].into_iter().take(looks) {
            let mut halcmd = scratch.command(&[], "halcmd");
            let output =
                scratch.run(halcmd.env("HAL_RTMOD_DIR", scratch.path()).args([command, "m.hal"]));
            let all = output.stdout + &output.stderr;
            assert!(all.contains(said), "{command} {main}{exit}: {all}");
            if command == "check" {
                assert_eq!(output.status, Some(2), "{all}");
                assert!(all.contains("m.hal:2: error[H206]"), "{all}");
                assert!(all.contains("m.hal:6: error[H202]"), "{all}");
                assert!(!all.contains("m.hal:3:") && !all.contains("m.hal:5: error"), "{all}");
            }
        }
    }
}
