//! Components in C that crash or never return: the message names the culprit, and outputs are at
//! their safe levels before the process ends.

use hal_tests::{
    foreign::{compile, component},
    plugins::plugins,
    scratch::{Scratch, until},
};
use rustix::process::Signal;
use std::process::Command;

/// A port whose first line is high, with a plugin that reports the line at the end; then the
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

/// The same machine, running, without the component.
const DRIVEN: &str = "loadrt threads name1=t period1=1000000
loadrt hal_parport cfg=\"0x378 out\"
loadrt last_words
net register parport.0.sim.data last-words.0.in
setp parport.0.pin-02-out 1
addf parport.0.write t
addf last-words.0 t
start
run 5ms
loadusr -w sh driven.sh
";

/// Waits until the port has the line, on either clock.
const DRIVEN_SH: &str = "until [ \"$(halcmd gets register)\" -gt 0 ]; do :; done";

/// A port access by processor instruction, not through the headers.
#[cfg(target_arch = "x86_64")]
const OUTB: &str =
    "__asm__ volatile(\"outb %0, %1\" :: \"a\"((char)1), \"Nd\"((unsigned short)0x278));";
#[cfg(not(target_arch = "x86_64"))]
const OUTB: &str = "*(int *volatile)0 = 1;";

const GLOBALS: &str = "#include <err.h>\n#include <signal.h>\n#include <stdlib.h>\n#include <unistd.h>\nstatic volatile int runs, zero;\n\
     static int deeper(volatile char *from)\n\
     {\n volatile char room[4096]; room[0] = *from;\n \
     return zero ? 0 : deeper(room) + room[0];\n}";

/// Returns a folder with a component that executes `does` in its third run, and the machine around
/// it.
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
    for (does, what, status) in [
        ("*(int *volatile)0 = 1;", "segmentation fault at address 0x0", None),
        ("((void (*)(void))(zero + 16L))();", "segmentation fault at address 0x10", None),
        ("deeper(\"\");", "segmentation fault at address 0x", None),
        ("runs = (int)period / zero;", "arithmetic fault", None),
        ("__builtin_trap();", "illegal instruction", None),
        ("abort();", "it gave up (abort)", None),
        ("exit(3);", "it called exit(3)", Some(3)),
        ("_exit(4);", "it called _exit(4)", Some(4)),
        ("quick_exit(5);", "it called quick_exit(5)", Some(5)),
    ] {
        let Some(scratch) = machine("crash", does) else { return };
        for clock in ["--virtual", "--simulate"] {
            let output = scratch.run(halrun(&scratch).args([clock, "--for", "60s", "m.hal"]));
            let said = format!("component 'mine', function 'mine.0', thread 't': {what}");
            assert!(output.stderr.contains(&said), "{clock} {does}: {}", output.stderr);
            let first = "last words: it was 1 and is 0\n";
            assert!(output.stderr.starts_with(first), "{clock} {does}: {}", output.stderr);
            assert_eq!(output.status, status, "{clock} {does}: none: it ends by its signal");
        }
    }
}

/// `errx` prints its message and then calls `exit` inside the C library.
#[test]
fn errx_is_named_as_the_exit_that_it_is() {
    let Some(scratch) = machine("errx", "errx(7, \"no device\");") else { return };
    for clock in ["--virtual", "--simulate"] {
        let output = scratch.run(halrun(&scratch).args([clock, "--for", "60s", "m.hal"]));
        let said = "halrun: no device\nlast words: it was 1 and is 0\n";
        assert!(output.stderr.starts_with(said), "{clock}: {}", output.stderr);
        let said = "component 'mine', function 'mine.0', thread 't': it called exit(7)";
        assert!(output.stderr.contains(said), "{clock}: {}", output.stderr);
        assert_eq!(output.status, Some(7), "{clock}");
    }
}

/// Permission for the port was not requested, and nothing is simulated.
#[cfg(target_arch = "x86_64")]
#[test]
fn a_port_that_may_not_be_used_is_named() {
    let what = "port 0x0278 may not be written: this process has no permission to use it";
    let ran = component(GLOBALS, "(void)deeper;", &format!("if (++runs == 3) {{ {OUTB} }}"));
    let set_up = component(GLOBALS, &format!("(void)deeper; {OUTB}"), "");
    for (source, whose) in [
        (ran, "component 'mine', function 'mine.0', thread 't'"),
        (set_up, "component 'mine', as it is loaded"),
    ] {
        let scratch = Scratch::new("port");
        if compile(scratch.path(), "mine", &source, &["-Wno-unused"]).is_none() {
            return;
        }
        let lines = "loadrt threads name1=t period1=1000000\nloadrt last_words\nloadrt mine\n\
                     addf mine.0 t\nstart\n";
        scratch.write("m.hal", lines);
        let output = scratch.run(halrun(&scratch).args(["--for", "60s", "m.hal"]));
        assert!(output.stderr.contains(&format!("{whose}: {what}")), "{}", output.stderr);
        assert!(output.stderr.contains("last words: it was 0 and is 0\n"), "{}", output.stderr);
        assert_eq!(output.status, None);
    }
}

/// Returns a folder with a component of this source, and a running machine that then loads it.
fn loads(name: &str, source: &str) -> Option<Scratch> {
    let scratch = Scratch::new(name);
    compile(scratch.path(), "mine", source, &["-Wno-unused"])?;
    scratch.write("driven.sh", DRIVEN_SH);
    scratch
        .write("m.hal", format!("{DRIVEN}print loading\nloadrt mine\nprint after\nloadrt and2\n"));
    Some(scratch)
}

#[test]
fn set_up_that_ends_the_process_is_named_and_outputs_are_safe() {
    for (main, what, status) in [
        ("exit(3);", "it called exit(3)", Some(3)),
        ("exit(0);", "it called exit(0)", Some(1)),
        ("errx(7, \"no device\");", "it called exit(7)", Some(7)),
        ("*(int *volatile)0 = 1;", "segmentation fault at address 0x0", None),
    ] {
        let Some(scratch) = loads("set-up", &component(GLOBALS, main, "")) else { return };
        for clock in ["--virtual", "--simulate"] {
            let output = scratch.run(halrun(&scratch).args([clock, "-kf", "m.hal"]));
            let said = format!("component 'mine', as it is loaded: {what}");
            assert!(output.stderr.contains(&said), "{clock} {main}: {}", output.stderr);
            let safe = "last words: it was 1 and is 0\n";
            assert!(output.stderr.contains(safe), "{clock} {main}: {}", output.stderr);
            assert_eq!(output.status, status, "{clock} {main}: {}", output.stderr);
            assert!(!output.stderr.contains("after"), "{clock} {main}: {}", output.stderr);
        }
    }
}

#[test]
fn set_up_that_does_not_return_is_named_at_sigterm_and_outputs_are_safe() {
    for main in ["for (;;) pause();", "for (;;) ;"] {
        let source = component(GLOBALS, &format!("warnx(\"begins\"); {main}"), "");
        let Some(scratch) = loads("set-up-hangs", &source) else { return };
        for clock in ["--virtual", "--simulate"] {
            let running = scratch.start(halrun(&scratch).args([clock, "-kf", "m.hal"]));
            until("it is set up", || running.said().1.contains("begins"));
            running.signal(Signal::TERM);
            let output = running.wait();
            for said in [
                "SIGTERM, but this does not return: component 'mine', as it is loaded",
                "last words: it was 1 and is 0\n",
            ] {
                assert!(output.stderr.contains(said), "{clock} {main}: {}", output.stderr);
            }
            assert_eq!(output.status, Some(1), "{clock} {main}");
        }
    }
}

/// A library is first opened in a separate process.
#[test]
fn a_constructor_that_ends_the_process_breaks_only_its_own_load() {
    let constructor = |does: &str| {
        format!("{GLOBALS}\n__attribute__((constructor)) static void begin(void) {{ {does} }}")
    };
    for (does, how) in [
        ("exit(3);", "the process, with status 3"),
        ("errx(7, \"no device\");", "the process, with status 7"),
        ("raise(SIGSEGV);", "(SIGSEGV)"),
        (OUTB, "(SIGSEGV)"),
        ("abort();", "(SIGABRT)"),
    ] {
        let source = component(&constructor(does), "", "");
        let Some(scratch) = loads("constructor", &source) else { return };
        for clock in ["--virtual", "--simulate"] {
            let output = scratch.run(halrun(&scratch).args([clock, "-kf", "m.hal"]));
            let said = "mine.so: opened in a process of its own first, it ended ";
            let line = output.stderr.lines().find(|line| line.contains(said));
            assert!(line.is_some_and(|line| line.contains(how)), "{does}: {}", output.stderr);
            assert!(output.stderr.contains("after"), "{clock} {does}: {}", output.stderr);
            // Only that line fails, and the instance ends in good order.
            assert_eq!(output.stderr.matches("failed").count(), 1, "{does}: {}", output.stderr);
            let safe = "last words: it was 1 and is 0\n";
            assert!(output.stderr.contains(safe), "{clock} {does}: {}", output.stderr);
            assert_eq!(output.status, Some(1), "{clock} {does}: {}", output.stderr);
        }
    }
    // A constructor that never returns does not keep the machine from ending either.
    let source = component(&constructor("for (;;) pause();"), "", "");
    let Some(scratch) = loads("constructor-hangs", &source) else { return };
    for clock in ["--virtual", "--simulate"] {
        let running = scratch.start(halrun(&scratch).args([clock, "-kf", "m.hal"]));
        until("it is opened", || running.said().1.contains("loading"));
        running.signal(Signal::TERM);
        let output = running.wait();
        assert!(output.stderr.contains("last words: it was 1 and is 0\n"), "{}", output.stderr);
        assert!(output.stderr.contains("not opened: the instance is ending"), "{}", output.stderr);
        assert_eq!(output.status, Some(1), "{clock}");
    }
}

#[test]
fn who_does_not_come_back_is_named_on_the_virtual_clock() {
    let Some(scratch) = machine("stuck-virtual", "for (;;) ;") else { return };
    let running = scratch.start(halrun(&scratch).args(["--virtual", "--for", "1s", "m.hal"]));
    let said = "function 'mine.0' of component 'mine' does not come back: thread 't' is stuck";
    until(said, || running.said().1.contains(said));
    // The control side is inside the function as well, and the process is ended nevertheless.
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
    let mut halrun = halrun(&scratch);
    let running = scratch.start(halrun.env_remove("HAL_STUCK_TIME").args(["--simulate", "m.hal"]));
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
    // Nothing restarts by itself.
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

/// In a dry run, set-up runs first in a copy of the process. Anything that it does there is
/// reported like other findings.
#[test]
fn set_up_that_ends_the_process_is_a_finding_of_check() {
    let scratch = Scratch::new("check-crash");
    for (main, exit, said) in [
        ("*(int *volatile)0 = 1;", "", "rtapi_app_main crashes: segmentation fault"),
        ("abort();", "", "rtapi_app_main crashes: it gave up (abort)"),
        ("exit(3);", "", "rtapi_app_main ends the process, with status 3"),
        ("for (;;) pause();", "", "rtapi_app_main does not return: aborted after 5 s"),
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
        // Once is enough for a test that lasts until the timeout.
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
