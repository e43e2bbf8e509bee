//! Drivers in C on simulated ports: an old-style driver, whose mistakes all appear in the recording, and a corrected
//! version, whose recording shows none.
//!
//! Three mistakes do not appear in a recording: the old driver claims no ports and shares the configuration address
//! with the kernel, it reports another product's name, and it has variables that it never reads.
//! the kernel, what it says under another product's name, and the variables that it never reads.
#![expect(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "tests; registers have 32 bits at most"
)]

use hal_tests::{
    programs::root,
    scratch::{Output, Scratch},
    tools,
    vcd::Vcd,
};
use std::fs;

const PERIOD_NS: i64 = 100_000;

/// Output lines: pin, register and bit.
const LINES: [(&str, &str); 4] =
    [("05", "044f-2"), ("06", "044d-4"), ("07", "044e-4"), ("08", "044e-7")];

/// Returns a folder with the compiled drivers and the board that they find; `None`, reported as skipped, if there is no
/// C compiler.
fn bench(name: &str) -> Option<Scratch> {
    let scratch = Scratch::new(name);
    let from = root().join("tests/compat/drivers");
    let board = fs::read_to_string(from.join("viagpio.sim")).unwrap();
    for driver in ["viagpio_old", "viagpio_mended", "rawbyte"] {
        let file = format!("{driver}.c");
        fs::copy(from.join(&file), scratch.path().join(&file)).unwrap();
        let made = scratch.run(scratch.command(&[], "halcompile").args(["--compile", &file]));
        if made.stderr.contains("apt-get install gcc") {
            tools::COMPILER.skip();
            return None;
        }
        assert_eq!((made.status, made.stderr.as_str()), (Some(0), ""));
        scratch.write(&format!("{driver}.sim"), &board);
    }
    Some(scratch)
}

fn halrun(scratch: &Scratch, script: &str) -> Output {
    scratch.write("test.hal", script);
    let mut command = scratch.command(&[], "halrun");
    command.env("HAL_RTMOD_DIR", scratch.path());
    scratch.run(command.args(["--virtual", "-f", "test.hal"]))
}

/// Records a driver: its four inputs one after the other, then every combination of its outputs, one period each.
fn recorded(scratch: &Scratch, driver: &str, arguments: &str) -> Vcd {
    let mut script = format!(
        "loadrt threads name1=base period1={PERIOD_NS}\nloadrt {driver} {arguments}\n\
         loadrt rawbyte\naddf viagpio.read base\naddf rawbyte base\naddf viagpio.write base\n\
         net seen viagpio.pin-01-in rawbyte.in\nrecord out.vcd viagpio.* rawbyte.* *.sim.*\nstart\n"
    );
    for bit in ["0448-in-4", "0448-in-5", "0449-in-0", "0449-in-1"] {
        script.push_str(&format!("setp {driver}.sim.{bit} 1\nrun {PERIOD_NS}ns\n"));
    }
    for combination in 0..16 {
        for (i, (pin, _)) in LINES.iter().enumerate() {
            let level = combination >> i & 1;
            script.push_str(&format!("setp viagpio.pin-{pin}-out {level}\n"));
        }
        script.push_str(&format!("run {PERIOD_NS}ns\n"));
    }
    let output = halrun(scratch, &script);
    assert_eq!((output.status, output.stderr.as_str()), (Some(0), ""), "{}", output.stdout);
    Vcd::parse(&scratch.read("out.vcd"))
}

/// Returns the end of each period of the 16 combinations.
fn combinations(vcd: &Vcd) -> impl Iterator<Item = i64> {
    let end = vcd.end();
    (0..16).map(move |i| end - (15 - i) * PERIOD_NS)
}

/// Returns the number of the 16 combinations that are output correctly, and the lines that never change.
fn right(vcd: &Vcd, driver: &str) -> (usize, Vec<&'static str>) {
    let line = |bit: &str, at: i64| vcd.at(&format!("{driver}.sim.{bit}"), at) != 0.0;
    let asked = |pin: &str, at: i64| vcd.at(&format!("viagpio.pin-{pin}-out"), at) != 0.0;
    let good = |at: &i64| LINES.iter().all(|(pin, bit)| line(bit, *at) == asked(pin, *at));
    let never = |(_, bit): &&(&str, &str)| combinations(vcd).all(|at| !line(bit, at));
    let dead = LINES.iter().filter(never).map(|(pin, _)| *pin).collect();
    (combinations(vcd).filter(good).count(), dead)
}

/// Returns the value of a register or a pin at the end.
fn last(vcd: &Vcd, driver: &str, name: &str) -> u32 {
    vcd.at(&format!("{driver}.sim.{name}"), vcd.end()) as u32
}

/// Returns the number of port accesses in the last period.
fn accesses(vcd: &Vcd, driver: &str) -> u32 {
    let count = |name: &str, at| vcd.at(&format!("{driver}.sim.{name}"), at) as u32;
    let all = |at| count("reads", at) + count("writes", at);
    all(vcd.end()) - all(vcd.end() - PERIOD_NS)
}

#[test]
fn the_recorder_shows_every_mistake_of_the_old_driver() {
    let Some(scratch) = bench("driver-old") else { return };
    let old = "viagpio_old";
    let vcd = recorded(&scratch, old, "");
    // Two of three enables miss: Rx94[3:2] is set instead of Rx95[3:2], and Rx80[6] stays.
    assert_eq!(last(&vcd, old, "config-94"), 0x0000_000C);
    assert_eq!(last(&vcd, old, "config-80") & 0x40, 0x40);
    assert_eq!(last(&vcd, old, "config-98"), 0x0100_0000);
    // Double-word writes to byte registers also overwrite the registers that follow: GPO12 and three registers that do
    // not belong to the driver. With GPIO9, two of the four lines never rise.
    assert_eq!(right(&vcd, old), (4, vec!["05", "07"]));
    for neighbour in ["0450", "0451", "0452"] {
        let name = format!("{old}.sim.{neighbour}");
        assert_eq!(vcd.at(&name, 0), 255.0, "{neighbour}");
        assert_eq!(last(&vcd, old, neighbour), 0, "{neighbour}");
    }
    // Twelve accesses per period, for eight lines in five registers.
    assert_eq!(accesses(&vcd, old), 12);
    // A bit that is neither 0 nor 1.
    assert_eq!(vcd.at("rawbyte.byte", vcd.end()), 16.0);
    assert_eq!(vcd.at("viagpio.pin-01-in", vcd.end()), 1.0);
}

#[test]
fn two_copies_of_one_register_lose_a_line_also_by_bytes() {
    let Some(scratch) = bench("driver-bytes") else { return };
    let vcd = recorded(&scratch, "viagpio_old", "bytes=1");
    assert_eq!(right(&vcd, "viagpio_old"), (8, vec!["07"]));
    assert_eq!(last(&vcd, "viagpio_old", "0450"), 255);
}

#[test]
fn the_mended_driver_shows_none_of_them() {
    let Some(scratch) = bench("driver-mended") else { return };
    let mended = "viagpio_mended";
    let vcd = recorded(&scratch, mended, "");
    assert_eq!(last(&vcd, mended, "config-94"), 0x0000_0C00);
    assert_eq!(last(&vcd, mended, "config-80"), 0xFFFF_FFBF);
    assert_eq!(last(&vcd, mended, "config-98"), 0x0100_0000);
    assert_eq!(right(&vcd, mended), (16, vec![]));
    for (register, beside) in [("044d", 0xEF), ("044e", 0x6F), ("044f", 0xFB)] {
        assert_eq!(last(&vcd, mended, register) & beside, beside, "{register}");
    }
    for neighbour in ["044c", "0450", "0451", "0452", "0453"] {
        assert_eq!(vcd.of(&format!("{mended}.sim.{neighbour}")), [(0, 255.0)], "{neighbour}");
    }
    assert_eq!(accesses(&vcd, mended), 5);
    assert_eq!(vcd.at("rawbyte.byte", vcd.end()), 1.0);
    // Both follow their inputs, from the period after they were driven.
    for vcd in [vcd, recorded(&scratch, "viagpio_old", "")] {
        for (i, pin) in (1..).zip(["01", "02", "03", "04"]) {
            let rises = vcd.rises(&format!("viagpio.pin-{pin}-in"));
            assert_eq!(rises, [i * PERIOD_NS], "{pin}");
            assert_eq!(vcd.at(&format!("viagpio.pin-{pin}-in-not"), vcd.end()), 0.0, "{pin}");
        }
    }
}

/// The low bits of the base address are flags, and the chip may be another one.
#[test]
fn the_old_driver_takes_the_board_for_granted() {
    let Some(scratch) = bench("driver-board") else { return };
    let board = scratch.read("viagpio_old.sim");
    let drivers = ["viagpio_old", "viagpio_mended"];
    let board = |from: &str, to: &str| {
        assert!(board.contains(from), "{from}");
        for driver in drivers {
            scratch.write(&format!("{driver}.sim"), board.replace(from, to));
        }
    };
    board("0x00000401", "0x00000405");
    let old = recorded(&scratch, "viagpio_old", "bytes=1");
    assert_eq!(old.of("viagpio_old.sim.044d-4"), [(0, 0.0)], "it writes elsewhere");
    assert!(old.of("viagpio_old.sim.0451-4").len() > 2, "here");
    let mended = recorded(&scratch, "viagpio_mended", "");
    assert_eq!(right(&mended, "viagpio_mended"), (16, vec![]));

    board("0x84101106", "0x84091106");
    let old = recorded(&scratch, "viagpio_old", "");
    assert_eq!(last(&old, "viagpio_old", "config-98"), 0x0100_0000, "another chip is configured");
    let output = halrun(&scratch, "loadrt viagpio_mended\n");
    assert_eq!(output.status, Some(1));
    for said in ["device 00:11.0 is 1106:8409, not the VX900", "No such device (-19)"] {
        assert!(output.stderr.contains(said), "{}", output.stderr);
    }

    board("port 0x044c 0xff", "port 0x044c 0x100");
    let output = halrun(&scratch, "loadrt viagpio_mended\n");
    let said = "viagpio_mended.sim:9: '0x100' is not a byte, 0 to 0xff";
    assert!(output.stderr.contains(said), "{}", output.stderr);
}
