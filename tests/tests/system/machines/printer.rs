//! The printer: its own INI and HAL files, unchanged; its pulses measured from recordings.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use hal_tests::{programs::root, scratch::Scratch, vcd::Vcd};
use std::fmt::Write;

const SECOND: i64 = 1_000_000_000;

/// Creates a folder with the printer's files, and the script that runs once it is up.
fn printer(postgui: &str) -> Scratch {
    let scratch = Scratch::copy_of(&root().join("tests/hal/printer"));
    scratch.write("custom_postgui.hal", postgui);
    scratch
}

/// Runs the printer on the virtual clock and returns its output. Everything must succeed.
fn run(scratch: &Scratch) -> Vec<String> {
    let output = scratch.halrun(&["--virtual", "--for", "10ms", "impresora3D.ini"]);
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)));
    output.stdout.lines().map(str::to_owned).collect()
}

#[test]
fn its_own_files_make_the_machine() {
    let scratch =
        printer("list sig\nlist thread\nshow thread\nsave linka links\nstatus instance\n");
    for clock in ["--virtual", "--simulate"] {
        let output = scratch.halrun(&[clock, "--for", "10ms", "impresora3D.ini"]);
        assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)), "{clock}");
        let lines: Vec<&str> = output.stdout.lines().collect();
        assert_eq!(lines[0].split_whitespace().count(), 27, "{clock}: signals: {}", lines[0]);
        assert_eq!(lines[1], "servo-thread base-thread ");
        let links = scratch.read("links");
        let links = links.lines().filter(|l| l.starts_with("linkps ")).count();
        assert_eq!(links, 43, "{clock}: pin links");
        let text = &output.stdout;
        for part in [
            "   100000  NO            base-thread ",
            "1 viagpio.read\n                  2 stepgen.make-pulses\n                  3 viagpio.write\n",
            "  1000000  YES          servo-thread ",
            "1 stepgen.capture-position\n                  2 motion-command-handler\n                  \
             3 motion-controller\n                  4 stepgen.update-freq\n",
            "  threads:    running",
            "  hardware:   simulated",
        ] {
            assert!(text.contains(part), "{clock}: no {part:?} in\n{text}");
        }
    }
}

/// Programs with a page of offsets (`QtDragon`) fail if they do not find the file at their start.
#[test]
fn the_parameter_file_is_there_before_any_job() {
    let scratch = Scratch::copy_of(&root().join("configs/printer"));
    let file = scratch.path().join("linuxcnc.var");
    // Machines that ran in their own folder have left it there.
    drop(std::fs::remove_file(&file));
    assert_eq!(scratch.halcmd(&["check", "printer.ini"]).status, Some(0));
    assert!(!file.exists(), "a check writes nothing");
    let output = scratch.halrun(&["--virtual", "--for", "1s", "printer.ini"]);
    assert_eq!(output.status, Some(0), "{output:?}");
    assert!(scratch.read("linuxcnc.var").contains("\n5221\t0.0"));
    // The next start keeps what the file says.
    scratch.write("linuxcnc.var", "5221\t7.5\n");
    let output = scratch.halrun(&["--virtual", "--for", "1s", "printer.ini"]);
    assert_eq!(output.status, Some(0), "{output:?}");
    assert_eq!(scratch.read("linuxcnc.var"), "5221\t7.5\n");
}

#[test]
fn the_file_with_its_broken_lines_is_refused() {
    let scratch = printer("");
    let broken = scratch.read("annex-e.printed.hal");
    scratch.write("impresora3D.hal", broken);
    let output = scratch.halrun(&["--virtual", "--for", "10ms", "impresora3D.ini"]);
    let first = "impresora3D.hal:3: Unknown command 'servo_period_nsec=1000000'\n";
    assert_eq!((output.stderr.as_str(), output.status), (first, Some(1)));
    let output = scratch.halrun(&["-k", "--virtual", "--for", "10ms", "impresora3D.ini"]);
    let all = format!(
        "{first}\
         impresora3D.hal:59: Unknown command 'hal_manualtoolchange.change'\n\
         impresora3D.hal:61: Unknown command 'hal_manualtoolchange.changed'\n\
         impresora3D.hal:63: Unknown command 'hal_manualtoolchange.number'\n\
         impresora3D.hal:65: Unknown command 'iocontrol.0.tool-prepared'\n"
    );
    assert_eq!((output.stderr.as_str(), output.status), (all.as_str(), Some(1)));
    assert!(scratch.left().is_empty(), "{:?}", scratch.left());
}

#[test]
fn it_does_not_move_in_estop_although_nothing_of_it_is_wired_to_motion() {
    let scratch = printer(
        "getp motion.enable
         motion.enable --wait
         motion.jog joint=0 velocity=50
         run 100ms
         getp stepgen.0.counts
         iocontrol.estop-reset --wait
         motion.enable --wait
         motion.jog joint=0 velocity=50
         run 500ms
         getp stepgen.0.frequency
         iocontrol.estop
         run 1ms
         getp joint.0.amp-enable-out
         getp stepgen.0.counts
         motion.enable --wait
         iocontrol.estop-reset --wait
         run 500ms
         getp joint.0.amp-enable-out
         getp stepgen.0.counts
",
    );
    let output = scratch.halrun(&["-k", "--virtual", "--for", "10ms", "impresora3D.ini"]);
    let (stdout, stderr) = (output.stdout.as_str(), output.stderr.as_str());
    let lines: Vec<&str> = stdout.lines().collect();
    let [wired, before, speed, off, there, still_off, still_there] = lines[..] else {
        panic!("{stdout}{stderr}")
    };
    assert_eq!((wired, before), ("TRUE", "0"), "{stderr}");
    assert_eq!((speed, off, still_off), ("200", "FALSE", "FALSE"), "{stderr}");
    assert_eq!(there, still_there, "{stderr}");
    assert_ne!(there, "0");
    for part in [
        "custom_postgui.hal:2: motion.enable: can't enable motion, the machine is in e-stop",
        "motmod: cannot jog: the machine is not enabled",
        "motmod: motion stopped by e-stop: it was commanded by iocontrol.estop",
        "custom_postgui.hal:15: motion.enable: can't enable motion, the machine is in e-stop",
    ] {
        assert!(stderr.contains(part), "{part}: {stderr}");
    }
}

/// Jogs in both directions, each recorded into a file of its own: `NAME-right` and `NAME-left`.
fn there_and_back(script: &mut String, name: &str, joint: u32, velocity: f64, distance: f64) {
    writeln!(script, "getp stepgen.{joint}.counts").unwrap();
    for (way, distance) in [("right", distance), ("left", -distance)] {
        writeln!(
            script,
            "record {name}-{way} viagpio.pin-0 viagpio.sim.reg-4 stepgen.{joint}.\n\
             motion.jog joint={joint} velocity={velocity} distance={distance} --wait\n\
             run 10ms\nrecord off\ngetp stepgen.{joint}.counts"
        )
        .unwrap();
    }
}

/// Returns the times of a pin's rising edges in the second in the middle of a move.
fn middle(vcd: &Vcd, pin: &str) -> Vec<i64> {
    let all = vcd.rises(pin);
    let middle = all[all.len() / 2];
    let near = |t: &i64| (t - middle).abs() <= SECOND / 2;
    let part: Vec<i64> = all.iter().copied().filter(near).collect();
    assert!(part.len() < all.len(), "{pin}: the move is shorter than a second");
    part
}

fn intervals(times: &[i64]) -> Vec<i64> {
    times.windows(2).map(|w| w[1] - w[0]).collect()
}

#[test]
fn the_pulses_are_as_fast_as_the_axes() {
    let mut script = "iocontrol.estop-reset --wait\nmotion.enable --wait\n".to_owned();
    there_and_back(&mut script, "x50", 0, 50.0, 80.0);
    there_and_back(&mut script, "x90", 0, 90.0, 150.0);
    there_and_back(&mut script, "z10", 2, 10.0, 20.0);
    let scratch = printer(&script);
    let counts = run(&scratch);
    assert_eq!(counts, ["0", "320", "0", "0", "600", "0", "0", "5714", "0"]);

    for (name, hertz) in [("x50", 200.0), ("x90", 360.0)] {
        for (way, direction) in [("right", 0.0), ("left", 1.0)] {
            let vcd = Vcd::parse(&scratch.read(&format!("{name}-{way}")));
            let pulses = middle(&vcd, "viagpio.pin-06-out");
            let mean = (pulses[pulses.len() - 1] - pulses[0]) as f64 / (pulses.len() - 1) as f64;
            let measured = SECOND as f64 / mean;
            assert!((measured - hertz).abs() < hertz * 1e-3, "{name}-{way}: {measured} Hz");
            for i in intervals(&pulses) {
                let off = (i as f64 - SECOND as f64 / hertz).abs();
                assert!(off < 100_000.0, "{name}-{way}: an interval of {i} ns");
            }
            // The register's bit equals the pin: pulses on 0x4D, direction on 0x4F.
            assert_eq!(middle(&vcd, "viagpio.sim.reg-4d-4"), pulses);
            for pin in ["viagpio.pin-05-out", "viagpio.sim.reg-4f-2"] {
                for t in &pulses {
                    assert_eq!(vcd.at(pin, *t), direction, "{name}-{way}: {pin} at {t}");
                }
            }
        }
    }
    for way in ["right", "left"] {
        let vcd = Vcd::parse(&scratch.read(&format!("z10-{way}")));
        let pulses = middle(&vcd, "stepgen.2.step");
        let odd: Vec<i64> =
            intervals(&pulses).into_iter().filter(|i| ![300_000, 400_000].contains(i)).collect();
        assert!(odd.is_empty(), "intervals of Z: {odd:?}");
        let mean = (pulses[pulses.len() - 1] - pulses[0]) as f64 / (pulses.len() - 1) as f64;
        assert!((mean - 350_000.0).abs() < 50.0, "mean interval of Z: {mean} ns");
    }
}

#[test]
fn every_combination_of_outputs_and_inverts_is_right() {
    let pins = ["05", "06", "07", "08"];
    let config = ["00", "80", "94", "98"];
    let registers = ["4c", "4d", "4e", "4f", "50", "51", "52"];
    let mut script = "loadrt threads name1=t period1=100000\nloadrt hal_viagpio\n\
                      addf viagpio.write t\nstart\n"
        .to_owned();
    let mut wanted = Vec::new();
    for case in 0..256_u32 {
        let (out, invert) = (case & 15, case >> 4);
        for (i, pin) in pins.iter().enumerate() {
            let (out, invert) = (out >> i & 1, invert >> i & 1);
            writeln!(script, "setp viagpio.pin-{pin}-out {out}").unwrap();
            writeln!(script, "setp viagpio.pin-{pin}-out-invert {invert}").unwrap();
        }
        script.push_str("run 100us\n");
        for register in registers {
            writeln!(script, "getp viagpio.sim.reg-{register}").unwrap();
        }
        let bit = |i: u32| (out ^ invert) >> i & 1;
        let (gpo12, gpio1, gpio9, gpio12) = (bit(0), bit(1), bit(2), bit(3));
        // Only the bits of the outputs change; the other bits stay as the firmware left them.
        wanted.extend([
            0xff,
            0xef | gpio1 << 4,
            0x6f | gpio9 << 4 | gpio12 << 7,
            0xfb | gpo12 << 2,
        ]);
        wanted.extend([0xff; 3]);
    }
    // The enables that the outputs need, and no others.
    for register in config {
        writeln!(script, "getp viagpio.sim.config-{register}").unwrap();
    }
    wanted.extend([0x8410_1106, 0xffff_ffbf, 0x0000_0c00, 0x0100_0000]);
    let scratch = Scratch::new("combinations");
    scratch.write("all.hal", script);
    let output = scratch.halrun(&["--virtual", "-f", "all.hal"]);
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)));
    let got: Vec<u32> = output.stdout.lines().map(|l| l.parse().unwrap()).collect();
    assert_eq!(got.len(), wanted.len());
    for (case, (got, wanted)) in got.chunks(7).zip(wanted.chunks(7)).enumerate() {
        assert_eq!(got, wanted, "outputs {:04b}, inverts {:04b}", case & 15, case >> 4);
    }
}

#[test]
fn the_demonstration_tells_where_each_axis_went() {
    let scratch = Scratch::new("demo");
    let ini = root().join("configs/printer/demo.ini");
    let output =
        scratch.halrun(&["--virtual", "--record", "printer.vcd", &ini.display().to_string()]);
    assert_eq!(output.status, Some(0), "{}", output.stderr);
    let table = "\
         Value  Name
     7  float OUT              99.99998  X.mm ==> xpos-fb
     7  s32   OUT                   400  X.steps
     7  float OUT              59.99998  Y.mm ==> ypos-fb
     7  s32   OUT                   240  Y.steps
     7  float OUT                   -20  Z.mm ==> zpos-fb
     7  s32   OUT                 -5714  Z.steps
";
    assert!(output.stdout.trim_end().ends_with(table.trim_end()), "{}", output.stdout);
    let vcd = Vcd::parse(&scratch.read("printer.vcd"));
    // 400 steps of X in all, each a pulse on its line; the names are those of the script.
    assert_eq!(vcd.rises("xstep").len(), 400);
    assert_eq!(vcd.rises("viagpio.pin-06-out").len(), 400);
    assert_eq!(vcd.rises("zstep").len(), 5714);
    assert_eq!(vcd.at("stepgen.1.counts", vcd.end()), 240.0);
}
