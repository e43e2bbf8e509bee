//! The command `hm2.card`.

use super::card;

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
