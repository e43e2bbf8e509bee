//! Tests of the chip on the bench, and of faulty ways to write it.

use crate::{
    Viagpio,
    chip::{Chip, IDENTITY, RX80, Refused},
    device::simulated,
    hardware::Hardware,
};
use hal_bench::Bench;
use hal_component::{Builder, Component, Error, In, Period, Touch, Update, abi};
use port::{Access, Lost, Simulated};
use std::fs;

const MS: i64 = 1_000_000;

/// Pins of the outputs with their registers and bits.
const OUTPUTS: [(&str, &str, u32); 4] = [
    ("viagpio.pin-05-out", "4f", 0x04),
    ("viagpio.pin-06-out", "4d", 0x10),
    ("viagpio.pin-07-out", "4e", 0x10),
    ("viagpio.pin-08-out", "4e", 0x80),
];

/// Pins of the inputs with their registers and bits.
const INPUTS: [(&str, &str, u32); 4] = [
    ("viagpio.pin-01-in", "48", 0x10),
    ("viagpio.pin-02-in", "48", 0x20),
    ("viagpio.pin-03-in", "49", 0x01),
    ("viagpio.pin-04-in", "49", 0x02),
];

fn load() -> Bench {
    let mut bench = Bench::new();
    bench.load::<Viagpio>(&[]).unwrap();
    bench
}

fn sim(bench: &Bench, name: &str) -> u32 {
    bench.get(&format!("viagpio.sim.{name}"))
}

fn registers(bench: &Bench, names: &[&str]) -> Vec<u32> {
    names.iter().map(|r| sim(bench, &format!("reg-{r}"))).collect()
}

/// Sets the outputs to the bits of `levels` and writes them.
fn write(bench: &Bench, levels: usize) {
    for (i, (pin, ..)) in OUTPUTS.iter().enumerate() {
        bench.set(pin, levels >> i & 1 == 1);
    }
    bench.run("viagpio.write", MS);
}

/// Returns the lines in the registers, as bits in the order of the pins.
fn lines(bench: &Bench) -> usize {
    let level = |(_, register, mask)| sim(bench, &format!("reg-{register}")) & mask != 0;
    OUTPUTS.into_iter().map(level).enumerate().fold(0, |sum, (i, on)| sum | usize::from(on) << i)
}

/// Returns the number of output combinations that are written correctly, and the levels that each line took.
fn right(bench: &Bench) -> (usize, [usize; 2]) {
    let (mut right, mut always, mut ever) = (0, 15, 0);
    for levels in 0..16 {
        write(bench, levels);
        right += usize::from(lines(bench) == levels);
        (always, ever) = (always & lines(bench), ever | lines(bench));
    }
    (right, [always, ever])
}

#[test]
fn pins_and_functions() {
    let bench = load();
    let mut wanted = Vec::new();
    for (pin, ..) in INPUTS {
        wanted.extend([format!("{pin} bit OUT"), format!("{pin}-not bit OUT")]);
    }
    for (pin, ..) in OUTPUTS {
        wanted.extend([format!("{pin} bit IN"), format!("{pin}-invert bit RW")]);
    }
    let mut names = bench.names();
    names.retain(|n| !n.contains(".sim."));
    assert_eq!(names, wanted);
    assert_eq!(bench.functs(), ["viagpio.read", "viagpio.write"]);
    // The library declares the same items without being run.
    let dir = |name: &String| match name.rsplit(' ').next() {
        Some("OUT") => abi::dir::OUT,
        Some("IN") => abi::dir::IN,
        _ => abi::dir::RW,
    };
    let declared: Vec<_> = Viagpio::ITEMS.iter().map(|i| (i.ty, i.dir)).collect();
    assert_eq!(declared, wanted.iter().map(|n| (abi::ty::BIT, dir(n))).collect::<Vec<_>>());
}

#[test]
fn every_combination_with_every_invert() {
    let bench = load();
    let rest = registers(&bench, &["4d", "4e", "4f"]);
    assert_eq!(rest, [0xEF, 0x6F, 0xFB]);
    for inverts in 0..16 {
        for (i, (pin, ..)) in OUTPUTS.iter().enumerate() {
            bench.set(&format!("{pin}-invert"), inverts >> i & 1 == 1);
        }
        for levels in 0..16 {
            write(&bench, levels);
            let mut wanted = rest.clone();
            for (i, (pin, register, mask)) in OUTPUTS.iter().enumerate() {
                let high = (levels ^ inverts) >> i & 1 == 1;
                let at = ["4d", "4e", "4f"].iter().position(|r| r == register).unwrap();
                wanted[at] |= if high { *mask } else { 0 };
                let bit = mask.trailing_zeros();
                let shown: bool = bench.get(&format!("viagpio.sim.reg-{register}-{bit}"));
                assert_eq!(shown, high, "{pin}: {levels} inverted by {inverts}");
            }
            let found = registers(&bench, &["4d", "4e", "4f"]);
            assert_eq!(found, wanted, "{levels} inverted by {inverts}");
        }
    }
}

#[test]
fn a_write_is_three_writes_and_a_read_two_reads() {
    let bench = load();
    let (writes, reads) = (sim(&bench, "writes"), sim(&bench, "reads"));
    assert_eq!((writes, reads), (0, 3), "opening reads the output registers");
    write(&bench, 5);
    assert_eq!((sim(&bench, "writes"), sim(&bench, "reads")), (3, 3));
    write(&bench, 5);
    assert_eq!((sim(&bench, "writes"), sim(&bench, "reads")), (6, 3));
    bench.run("viagpio.read", MS);
    assert_eq!((sim(&bench, "writes"), sim(&bench, "reads")), (6, 5));
}

#[test]
fn inputs_are_true_or_false() {
    let bench = load();
    let all = |suffix| INPUTS.map(|(pin, ..)| bench.get::<bool>(&format!("{pin}{suffix}")));
    assert_eq!((all(""), all("-not")), ([false; 4], [false; 4]), "before the first read");
    for whole in [false, true] {
        for levels in 0..16 {
            let level = |i: usize| levels >> i & 1 == 1;
            // All other bits of the registers are 1.
            let mut bytes = [0xCF, 0xFC];
            for (i, (_, register, mask)) in INPUTS.into_iter().enumerate() {
                bytes[usize::from(register == "49")] |= if level(i) { mask } else { 0 };
                let bit = format!("viagpio.sim.reg-{register}-{}", mask.trailing_zeros());
                bench.set(&bit, level(i) && !whole);
            }
            bench.set("viagpio.sim.reg-48", if whole { bytes[0] } else { 0xCF });
            bench.set("viagpio.sim.reg-49", if whole { bytes[1] } else { 0xFC });
            bench.run("viagpio.read", MS);
            assert_eq!(all(""), [0, 1, 2, 3].map(level), "{levels}");
            assert_eq!(all("-not"), [0, 1, 2, 3].map(|i| !level(i)), "{levels}");
        }
    }
}

/// The enable bits are 3 and 2 of the second byte, not of the first.
#[test]
fn gpio1_is_enabled_by_the_right_bits() {
    let mut bench = Bench::new();
    bench.create::<Viagpio>(&[]).unwrap();
    bench.set("viagpio.sim.config-94", 0x8421_3051_u32);
    bench.open().unwrap();
    assert_eq!(sim(&bench, "config-94"), 0x8421_3C51);
    assert_eq!(sim(&seed(true), "config-94"), 0x0000_000C, "the seed changes Rx94");
}

/// Only bit 6 of Rx80 is cleared.
#[test]
fn gpio12_is_enabled() {
    assert_eq!(sim(&load(), "config-80"), 0xFFFF_FFBF);
    assert_eq!(sim(&seed(true), "config-80"), 0xFFFF_FFFF, "the seed changes nothing");
}

#[test]
fn gpo12_is_enabled() {
    assert_eq!(sim(&load(), "config-98"), 0x0100_0000);
}

#[test]
fn enables_that_are_there_stay() {
    let mut bench = Bench::new();
    bench.create::<Viagpio>(&[]).unwrap();
    for (register, value) in [("80", 0xFF00_0035), ("94", 0x1234_5F00), ("98", 0xFF00_0001)] {
        bench.set::<u32>(&format!("viagpio.sim.config-{register}"), value);
    }
    bench.open().unwrap();
    let found = ["80", "94", "98"].map(|r| sim(&bench, &format!("config-{r}")));
    assert_eq!(found, [0xFF00_0035, 0x1234_5F00, 0xFF00_0001]);
}

/// A write to a byte leaves the next three unchanged.
#[test]
fn neighbours_stay_and_gpo12_rises() {
    let neighbours = ["4c", "50", "51", "52"];
    let bench = load();
    let (_, [always, ever]) = right(&bench);
    assert_eq!((always, ever), (0, 15), "every line takes both levels");
    assert_eq!(registers(&bench, &neighbours), [0xFF; 4]);

    let wide = seed(true);
    let (_, [_, ever]) = right(&wide);
    assert_eq!(ever & 1, 0, "by double words GPO12 stays low");
    assert_eq!(registers(&wide, &neighbours), [0xFF, 0, 0, 0]);
}

/// GPIO9 and GPIO12 share a register: neither changes the other.
#[test]
fn lines_of_one_register_keep_apart() {
    let bench = load();
    for (levels, byte) in [(0b0100, 0x7F), (0b1100, 0xFF), (0b1000, 0xEF), (0b0000, 0x6F)] {
        write(&bench, levels);
        assert_eq!(registers(&bench, &["4e"]), [byte]);
    }
    let (_, [_, ever]) = right(&seed(false));
    assert_eq!(ever, 0b1011, "from two copies GPIO9 never changes");
}

/// Compares three ways to write, on the same simulated registers.
#[test]
fn combinations_that_come_out_right() {
    assert_eq!(right(&load()).0, 16);
    assert_eq!(right(&seed(true)).0, 4, "by double words");
    assert_eq!(right(&seed(false)).0, 8, "by bytes, from copies");
}

#[test]
fn another_chip_is_left_alone() {
    let names = ["config-80", "config-94", "config-98", "writes"];
    for identity in [0xFFFF_FFFF, 0, 0x8409_1106, 0x8410_8086, 0x1106_8410] {
        let mut bench = Bench::new();
        bench.create::<Viagpio>(&[]).unwrap();
        bench.set::<u32>("viagpio.sim.config-00", identity);
        let before = names.map(|n| sim(&bench, n));
        let why = bench.open().unwrap_err();
        assert!(why.starts_with("viagpio: PCI device 00:11.0 is "), "{why}");
        assert!(why.contains("not the VIA VX900 (1106:8410)"), "{why}");
        bench.stop();
        write(&bench, 15);
        assert_eq!(names.map(|n| sim(&bench, n)), before, "{identity:x}");
        assert_eq!(bench.said(), ["error 6 when writing viagpio: it is tried again"]);
        assert_eq!(bench.failed_hardware(), 1);
    }
}

#[test]
fn the_base_is_cut_to_the_block() {
    for (register, right) in [
        (0x0401, true),
        (0x0400, true),
        (0x047F, true),
        (0xABCD_0401, true),
        (0x0481, false),
        (0x8401, false),
    ] {
        let mut bench = Bench::new();
        bench.create::<Viagpio>(&[]).unwrap();
        bench.set::<u32>("viagpio.sim.config-88", register);
        bench.open().unwrap();
        write(&bench, 15);
        assert_eq!(lines(&bench), if right { 15 } else { 0 }, "{register:x}");
    }
    for register in [0, 1, 0x7F, 0xFFFF_0001] {
        let mut bench = Bench::new();
        bench.create::<Viagpio>(&[]).unwrap();
        bench.set::<u32>("viagpio.sim.config-88", register);
        let why = bench.open().unwrap_err();
        assert!(why.contains("no address"), "{why}");
        assert_eq!(sim(&bench, "config-98"), 0, "nothing was written");
    }
}

#[test]
fn a_stop_rests_the_outputs() {
    let bench = load();
    bench.set("viagpio.pin-07-out-invert", true);
    write(&bench, 15);
    assert_eq!(lines(&bench), 0b1011);
    for _ in 0..2 {
        bench.stop();
        assert_eq!(lines(&bench), 0b0100);
        assert!(bench.get::<bool>("viagpio.pin-05-out"), "pins keep their values");
        assert_eq!(registers(&bench, &["4c", "50", "51", "52"]), [0xFF; 4]);
    }
    bench.run("viagpio.write", MS);
    assert_eq!(lines(&bench), 0b1011);
}

#[test]
fn functions_say_what_they_touch() {
    let bench = load();
    let write = bench.touches("viagpio.write");
    for (pin, register, mask) in OUTPUTS {
        assert!(write.contains(&format!("{pin} r")) && write.contains(&format!("{pin}-invert r")));
        let bit = format!("viagpio.sim.reg-{register}-{} w", mask.trailing_zeros());
        assert!(write.contains(&bit), "{bit}");
    }
    assert!(!write.iter().any(|t| t.contains("-in ") || t.contains("reg-48")));
    let read = bench.touches("viagpio.read");
    for (pin, register, mask) in INPUTS {
        assert!(read.contains(&format!("{pin} w")) && read.contains(&format!("{pin}-not w")));
        let bit = format!("viagpio.sim.reg-{register}-{} r", mask.trailing_zeros());
        assert!(read.contains(&bit), "{bit}");
    }
    assert!(!read.iter().any(|t| t.contains("-out") || t.contains("reg-4d")));
}

/// Makes a file in place of a PCI device's configuration.
fn config(name: &str, bytes: &[u8]) -> std::path::PathBuf {
    let path = std::env::temp_dir().join(format!("viagpio-{}-{name}", std::process::id()));
    fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn real_chips_are_looked_at_first() {
    let missing = std::env::temp_dir().join("viagpio-there-is-no-such-device");
    assert_eq!(Hardware::open(&missing).unwrap_err(), Refused::NoDevice);

    let mut bytes = [0xFF_u8; 256];
    bytes[..4].copy_from_slice(&[0x86, 0x80, 0x10, 0x84]);
    let path = config("other", &bytes);
    let hardware = Hardware::open(&path).unwrap();
    assert_eq!(Chip::bring_up(&hardware).unwrap_err(), Refused::Other(0x8410_8086));
    assert_eq!(fs::read(&path).unwrap(), bytes);
    fs::remove_file(&path).unwrap();

    bytes[..4].copy_from_slice(&IDENTITY.to_le_bytes());
    bytes[0x88..0x8A].copy_from_slice(&[0x7F, 0]);
    let path = config("unplaced", &bytes);
    let hardware = Hardware::open(&path).unwrap();
    assert_eq!(Chip::bring_up(&hardware).unwrap_err(), Refused::NoBase);
    assert_eq!(fs::read(&path).unwrap(), bytes);
    hardware.write_config(RX80 | 2, 0x0403_0201).unwrap();
    let written = fs::read(&path).unwrap();
    assert_eq!((&written[..0x80], &written[0x84..]), (&bytes[..0x80], &bytes[0x84..]));
    assert_eq!(written[0x80..0x84], [1, 2, 3, 4]);
    assert_eq!(hardware.read_config(RX80 | 1), Ok(0x0403_0201));
    fs::remove_file(&path).unwrap();

    // Configuration as a user without full permission sees it.
    let path = config("partial", &bytes[..64]);
    let hardware = Hardware::open(&path).unwrap();
    assert_eq!(Chip::bring_up(&hardware).unwrap_err(), Refused::Lost(Lost(1)));
    fs::remove_file(&path).unwrap();

    for (why, says) in [
        (Refused::NoDevice, "no PCI device 00:11.0"),
        (Refused::Forbidden, "run as root"),
        (Refused::Other(0x1234_5678), "is 5678:1234, not the VIA VX900 (1106:8410)"),
        (Refused::NoBase, "no address"),
        (Refused::Lost(Lost(1)), "run as root"),
    ] {
        let text = why.to_string();
        assert!(text.contains(says) && text.ends_with("; or run with --simulate"), "{text}");
    }
}

/// First driver of this machine, with its faults, on the same simulated registers.
enum Seed {}

/// Output of that driver: written from a copy of its register that was read before any write.
#[derive(Touch)]
struct SeedLine {
    #[state]
    address: u16,
    #[state]
    mask: u8,
    value: In<bool>,
}

#[derive(Touch)]
struct SeedWrite {
    #[state]
    file: std::sync::Arc<Simulated>,
    #[state]
    wide: bool,
    lines: Vec<SeedLine>,
}

impl Update for SeedWrite {
    fn update(&mut self, _: Period) {
        let copies: Vec<u8> =
            self.lines.iter().map(|l| self.file.read(l.address).unwrap()).collect();
        for (line, copy) in self.lines.iter().zip(copies) {
            let byte = if line.value.get() { copy | line.mask } else { copy & !line.mask };
            self.file.write(line.address, byte).unwrap();
            // A double word with the zero-extended byte.
            for next in (1..4).filter(|_| self.wide) {
                self.file.write(line.address + next, 0).unwrap();
            }
        }
    }
}

impl Component for Seed {
    const NAME: &'static str = "seed";
    const DOC: &'static str = "The driver as it was printed.";
    const FLAGS: u32 = abi::component_flags::ONCE;
    const ARGS: &'static [&'static abi::ArgSpec] =
        &[&hal_component::Arg::bit("wide", "Whether it writes double words.").required()];
    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let file = std::sync::Arc::new(simulated(b)?);
        let mut lines = Vec::new();
        for ((pin, _, mask), address) in OUTPUTS.into_iter().zip([0x44F, 0x44D, 0x44E, 0x44E]) {
            let mask = u8::try_from(mask).unwrap();
            lines.push(SeedLine { address, mask, value: b.item(pin, "Output.", false)? });
        }
        let wide = b.arg_int("wide") == Some(1);
        b.function("viagpio.write", "Writes.", SeedWrite { file: file.clone(), wide, lines })?;
        b.on_open(move |_| {
            for (register, and, or) in
                [(0x98, !0, 0x0100_0000), (0x94, !0, 0x0000_000C), (0x80, !0, 0)]
            {
                let found = file.read_config(register).unwrap();
                file.write_config(register, found & and | or).unwrap();
            }
            Ok(())
        })
    }
}

fn seed(wide: bool) -> Bench {
    let mut bench = Bench::new();
    bench.load::<Seed>(&[if wide { "wide=1" } else { "wide=0" }]).unwrap();
    bench
}
