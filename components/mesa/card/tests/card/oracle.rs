//! The boards against what LinuxCNC's own driver read in their descriptors.

use hal_card::{Board, boards};
use hal_firmware::Tag;
use std::path::Path;

/// Returns the name of a pin as the driver prints it, without the words in front of it.
fn printed(pin: &hal_firmware::Pin) -> String {
    let Some(name) = pin.name() else { return "IOPort".to_owned() };
    let n = name.index.unwrap_or(0);
    let (kind, pin_name) = match pin.kind().unwrap() {
        Tag::StepGenerator if pin.number == 1 => ("StepGen", "Step".to_owned()),
        Tag::StepGenerator if pin.number == 2 => ("StepGen", "Direction".to_owned()),
        // The driver masks the wires of a step generator beyond two, and smart serial without a remote.
        Tag::StepGenerator | Tag::SmartSerial => return "IOPort".to_owned(),
        Tag::Encoder => ("Encoder", encoder(pin.number, "")),
        Tag::MuxedEncoder => ("Muxed Encoder", encoder(pin.number, "Muxed ")),
        Tag::MuxedEncoderSelect => ("Muxed Encoder Select", format!("Mux Select {n}")),
        Tag::Pwm => {
            let names = ["Out0 (PWM or Up)", "Out1 (Dir or Down)", "Not-Enable"];
            ("PWMGen", names[usize::from(pin.number) - 1].to_owned())
        }
        Tag::Ssr if pin.number == 0x20 => ("SSR", "AC Ref (internal)".to_owned()),
        Tag::Ssr => ("SSR", format!("Out-{n:02}")),
        Tag::Outputs => ("OutM Output Module", format!("Out-{n:02}")),
        Tag::Inputs => ("InM Input Module", format!("in{n}")),
        Tag::InputMux if pin.is_output => ("InMux Input Mux", format!("addr{n}")),
        Tag::InputMux => ("InMux Input Mux", "muxdata".to_owned()),
        other => unreachable!("{other:?}"),
    };
    let way = if pin.is_output { "Output" } else { "Input" };
    format!("{kind} #{}, pin {pin_name} ({way})", pin.instance)
}

fn encoder(number: u8, muxed: &str) -> String {
    format!("{muxed}{}", ["A", "B", "Index"][usize::from(number) - 1])
}

/// A board that was changed without the oracle fails here.
#[test]
fn the_driver_reads_the_pins_that_the_boards_have() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tests/mesa/pins");
    let mut seen = 0;
    for name in boards() {
        let board = Board::named(name).unwrap();
        let text = std::fs::read_to_string(folder.join(format!("{name}.txt"))).unwrap();
        if text.starts_with("refused") {
            assert_eq!(name, "7i97t", "the driver knows version 0 of pulse width alone");
            continue;
        }
        for line in text.lines().filter_map(|line| line.strip_prefix("io ")) {
            let pin: usize = line.split(' ').next().unwrap().parse().unwrap();
            let own = printed(&board.pins[pin]);
            assert!(line.ends_with(&format!(" {own}")), "{name}: {line}: {own}");
            seen += 1;
        }
        assert!(text.lines().filter(|line| line.starts_with("pin ")).count() > 200, "{name}");
    }
    assert!(700 < seen, "{seen} pins");
}
