//! The command `hm2.card`.

use super::card;

/// Files name modules that only some firmwares of a card have: the simulated card has what is asked of it.
#[test]
fn a_simulated_card_has_the_modules_that_its_file_counts() {
    for (kind, config, pin) in [
        ("7i92", "num_pwmgens=1 num_stepgens=4", "hm2_7i92.0.pwmgen.00.value float IN"),
        ("7i96s", "num_encoders=4", "hm2_7i96s.0.encoder.03.count s32 OUT"),
        ("7i80", "num_stepgens=10", "hm2_7i80.0.stepgen.09.counts s32 OUT"),
        ("7i76", "num_leds=4", "hm2_7i76.0.led.CR04 bit IN"),
    ] {
        let names = card(kind, config).names();
        assert!(names.iter().any(|name| name == pin), "{kind} {config}: {pin}");
    }
    // A 7I77 on the header of a card whose usual firmware has no channels for it.
    for kind in ["7i96s", "7i98", "7i92"] {
        let names = card(&format!("{kind} 0.0=7i77 0.1=7i77-analog"), "").names().join("\n");
        assert!(names.contains(".7i77.0.1.analogout0 float IN"), "{kind}");
    }
    // The names of pins count as well, unless the file limits them.
    for (config, has) in [("", true), ("num_pwmgens=1", false)] {
        let names = card("7i92 pwmgen=2", config).names();
        let pin = "hm2_7i92.0.pwmgen.01.value float IN";
        assert_eq!(names.iter().any(|name| name == pin), has, "{config}");
    }
}

#[test]
fn a_card_tells_its_firmware_modules_and_pins() {
    let bench = card("7i92", "num_stepgens=3 num_encoders=1");
    let lines = bench.command("hm2.card", &[]).unwrap();
    for line in [
        "hm2_7i92.0: 7I92 at 192.168.1.121",
        "  firmware of MESA7I92, 34 I/O pins in 2 ports, clocks 100 and 200 MHz",
        "  module stepgen      version 2, 10 there, 3 used",
        "  io 000 P2-01        stepgen 00 Dir/Table2, output",
        "  io 014 P2-11        encoder 00 Quad-IDX, input",
        "  io 017 P1-01        free",
    ] {
        assert!(lines.iter().any(|found| found == line), "{line}: {lines:#?}");
    }
    let pins = lines.iter().filter(|line| line.starts_with("  io ")).count();
    assert_eq!(pins, 34);
    let refused = bench.command("hm2.card", &["name=hm2_7i92.1"]).unwrap_err();
    assert_eq!(refused, "no card 'hm2_7i92.1': hm2_7i92.0");
}
