//! Pins, watchdog, outputs and filtered inputs.

use crate::bench::Bench;
use hal_firmware::registers as r;

/// Direction, source, open drain, inversion and data of a pin, by the rules that the port's page states.
#[test]
fn a_meter_reads_what_the_port_drives() {
    let pin = 10;
    for bits in 0..64_u32 {
        let bit = |nth: u32| bits >> nth & 1 == 1;
        let (out, module, drain, invert, data, world) =
            (bit(0), bit(1), bit(2), bit(3), bit(4), bit(5));
        let mut bench = Bench::new("7i92");
        let word = |on: bool| u32::from(on) << pin;
        bench.write(r::PORT_DATA, 0, word(data));
        bench.write(r::PORT_DIRECTION, 0, word(out));
        bench.write(r::PORT_SOURCE, 0, word(module));
        bench.write(r::PORT_OPEN_DRAIN, 0, word(drain));
        bench.write(r::PORT_INVERT, 0, word(invert));
        bench.card.set_input(pin, world);
        // The module of the pin is a smart-serial port, whose line is low.
        let inner = if module { false } else { data } != invert;
        let driven = out && !(drain && inner);
        let level = if driven { inner } else { world };
        assert_eq!(bench.card.is_driven(pin), driven, "{bits:06b}");
        assert_eq!(bench.card.level(pin), level, "{bits:06b}");
        let read = bench.read(r::PORT_DATA, 0) >> pin & 1 == 1;
        assert_eq!(read, level, "{bits:06b}");
        assert_eq!(bench.read(r::PORT_DIRECTION, 0), word(out));
    }
}

#[test]
fn open_pins_are_pulled_up() {
    let mut bench = Bench::new("7i76e");
    assert_eq!(bench.read(r::PORT_DATA, 1), 0x1_FFFF);
    bench.card.set_input(20, false);
    assert_eq!(bench.read(r::PORT_DATA, 1), 0x1_FFF7);
}

#[test]
fn the_watchdog_bites_after_its_time() {
    let mut bench = Bench::new("7i92");
    bench.write(r::PORT_DIRECTION, 0, 0x400);
    bench.write(r::PORT_OPEN_DRAIN, 0, 0x800);
    bench.card.advance(1_000_000_000);
    assert!(!bench.card.watchdog_has_bitten(), "off until it gets a time");
    // 1 ms and a period.
    bench.write(r::WATCHDOG_TIMEOUT, 0, 100_000);
    bench.card.advance(1_000_000);
    assert_eq!(bench.read(r::WATCHDOG_STATUS, 0), 0);
    assert!(bench.card.is_driven(10));
    bench.write(r::WATCHDOG_RESET, 0, 0x0100_0000);
    bench.card.advance(9);
    assert!(!bench.card.watchdog_has_bitten());
    bench.card.advance(1);
    assert!(bench.card.watchdog_has_bitten());
    assert_eq!(bench.read(r::WATCHDOG_STATUS, 0), 1);
    assert!(!bench.card.is_driven(10));
    assert_eq!(bench.read(r::PORT_DIRECTION, 0), 0);
    bench.write(r::PORT_DIRECTION, 0, 0x400);
    assert_eq!(bench.read(r::PORT_DIRECTION, 0), 0, "not while it holds");
    bench.write(r::WATCHDOG_STATUS, 0, 0);
    assert_eq!(bench.read(r::PORT_DIRECTION, 0), 0, "nothing begins by itself");
    bench.write(r::PORT_DIRECTION, 0, 0x400);
    assert!(bench.card.is_driven(10));
    // Fed in time it never bites.
    bench.write(r::WATCHDOG_TIMEOUT, 0, 100_000);
    for _ in 0..100 {
        bench.card.advance(1_000_000);
        bench.write(r::WATCHDOG_RESET, 0, 0x5A00_0000);
    }
    assert!(!bench.card.watchdog_has_bitten());
    // Without a running time it cannot.
    bench.write(r::WATCHDOG_STATUS, 0, 0);
    bench.write(r::WATCHDOG_TIMEOUT, 0, 0x8000_0000);
    bench.write(r::WATCHDOG_STATUS, 0, 0);
    bench.card.advance(60_000_000_000);
    assert!(!bench.card.watchdog_has_bitten());
}

#[test]
fn duty_is_value_by_width() {
    let mut bench = Bench::new("7i97");
    bench.write(r::PWM_RATE, 0, 0x1000);
    for (mode, full) in [(0, 512_u32), (1, 1024), (2, 2048), (3, 4096)] {
        bench.write(r::PWM_MODE, 2, mode);
        for value in [0, 1, full / 4, full - 1] {
            bench.write(r::PWM_VALUE, 2, value << 16);
            let duty = f64::from(value) / f64::from(full);
            assert_eq!(bench.card.duty(2), Some(duty), "{mode} {value}");
            bench.write(r::PWM_VALUE, 2, 0x8000_0000 | value << 16);
            assert_eq!(bench.card.duty(2), Some(-duty), "{mode} {value}");
        }
        let frequency = bench.card.pulse_frequency(2).unwrap();
        assert!((frequency - 200e6 / 16.0 / f64::from(full)).abs() < 1e-6, "{frequency}");
    }
    // Symmetrical pulses take twice the time.
    bench.write(r::PWM_MODE, 2, 4);
    assert_eq!(bench.card.pulse_frequency(2), Some(200e6 / 16.0 / 1024.0));
}

/// Share of the time that a pin is high, and the other form of the outputs.
#[test]
fn a_pulse_is_high_for_its_duty() {
    let mut bench = Bench::new("7i97");
    bench.write(r::PORT_SOURCE, 0, 0x1FF);
    bench.write(r::PORT_DIRECTION, 0, 0x1FF);
    bench.write(r::PWM_RATE, 0, 0xFFFF);
    for (mode, symmetrical) in [(1, false), (5, true)] {
        bench.write(r::PWM_MODE, 0, mode);
        bench.write(r::PWM_VALUE, 0, 256 << 16);
        let mut high = 0;
        for _ in 0..20_480 {
            bench.card.advance(5);
            high += i32::from(bench.card.level(0));
        }
        assert!((high - 5_120).abs() < 60, "{symmetrical}: {high}");
    }
    // Pin 8 is the enable of the first four, low when it is on.
    assert!(bench.card.level(8) && !bench.card.is_pulse_enabled(0));
    bench.write(r::PWM_ENABLE, 0, 1);
    assert!(!bench.card.level(8) && bench.card.is_pulse_enabled(0));
}

#[test]
fn relays_need_their_wave() {
    let mut bench = Bench::new("7i96s");
    bench.write(r::SSR_DATA, 0, 0b0101);
    assert!(!bench.card.relay(0));
    bench.write(r::SSR_RATE, 0, 0x1000 | 48);
    assert!(bench.card.relay(0) && !bench.card.relay(1) && bench.card.relay(2));
    bench.write(r::PORT_SOURCE, 0, 0x1_FFFF);
    bench.write(r::PORT_DIRECTION, 0, 0x1_F800);
    bench.write(r::PORT_SOURCE, 1, 1 << 16);
    bench.write(r::PORT_DIRECTION, 1, 1 << 16);
    // A closed relay's pin is against the wave, an open one's is with it. The wave turns each 50 periods.
    let mut waves = [0; 2];
    for _ in 0..1000 {
        bench.card.advance(100);
        let wave = bench.card.level(33);
        waves[usize::from(wave)] += 1;
        assert_eq!((bench.card.level(11), bench.card.level(12)), (!wave, wave));
    }
    assert!(450 < waves[0] && 450 < waves[1], "{waves:?}");
    bench.write(r::OUTPUTS_DATA, 0, 1 << 4);
    assert!(bench.card.level(15) && !bench.card.level(16));
    bench.write(r::LED_DATA, 0, 0x0500_0000);
    assert_eq!([0, 1, 2, 3].map(|n| bench.card.light(n)), [true, false, true, false]);
    bench.write(r::WATCHDOG_TIMEOUT, 0, 0);
    bench.card.advance(100);
    assert!(!bench.card.relay(0) && !bench.card.is_driven(15));
}

#[test]
fn inputs_are_seen_after_their_filters() {
    let mut bench = Bench::new("7i96s");
    assert_eq!(bench.read(r::INPUTS_CONTROL, 0) & 0x1F, 10, "eleven inputs");
    // 100 samples of 4 periods, 5 scans for short filters, 20 for long ones.
    bench.write(r::INPUTS_CONTROL, 0, 0x20 | 99 << 6 | 5 << 16 | 20 << 22);
    assert_eq!(bench.read(r::INPUTS_CONTROL, 0) & 0x1F, 10, "the width cannot be written");
    bench.write(r::INPUTS_FILTER, 0, 0b10);
    let scan = 100 * 4 * 11 * 10;
    assert_eq!(bench.read(r::INPUTS_RAW, 0), 0, "open inputs are off");
    bench.card.set_field_input(0, true);
    bench.card.set_field_input(1, true);
    assert_eq!(bench.read(r::INPUTS_RAW, 0), 3);
    assert!(!bench.card.level(0) && bench.card.level(2), "an input that is on pulls its line down");
    let mut seen = Vec::new();
    for _ in 0..25 {
        bench.card.advance(scan);
        seen.push(bench.read(r::INPUTS_FILTERED, 0));
    }
    assert_eq!(seen.iter().position(|s| s & 1 == 1), Some(4));
    assert_eq!(seen.iter().position(|s| s & 2 == 2), Some(19));
    // A pulse that is too short is not seen.
    bench.card.set_field_input(0, false);
    bench.card.advance(4 * scan);
    assert_eq!(bench.read(r::INPUTS_FILTERED, 0) & 1, 1);
    bench.card.set_field_input(0, true);
    bench.card.advance(5 * scan);
    bench.card.set_field_input(0, false);
    bench.card.advance(5 * scan);
    assert_eq!(bench.read(r::INPUTS_FILTERED, 0) & 1, 0);
}

#[test]
fn hand_wheels_count_on_filtered_inputs() {
    let mut bench = Bench::new("7i95");
    bench.write(r::INMUX_CONTROL, 0, 0x20 | 1 << 16 | 1 << 22);
    assert_eq!(bench.read(r::INMUX_CONTROL, 0) & 0x1F, 23, "24 inputs");
    let turn = |bench: &mut Bench, forward: bool| {
        let mut lines = [(true, false), (true, true), (false, true), (false, false)];
        if !forward {
            lines = [(false, true), (true, true), (true, false), (false, false)];
        }
        for (a, b) in lines {
            bench.card.set_field_input(2, a);
            bench.card.set_field_input(3, b);
            bench.card.advance(100_000);
        }
    };
    for (four, forward, wheel) in
        [(0, true, 255_u8), (0, false, 0), (0x100, true, 252), (0x100, false, 0)]
    {
        bench.write(r::INMUX_WHEELS, 0, four);
        turn(&mut bench, forward);
        let [_, second, ..] = bench.read(r::INMUX_WHEELS, 0).to_le_bytes();
        assert_eq!(second, wheel, "{four:x} {forward}");
    }
}
