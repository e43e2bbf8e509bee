//! Rates, faults of the line and of devices.

use super::{MS, Modbus, THREE, loaded, pass};
use hal_bench::Bench;

fn answers(bench: &Bench) -> [u32; 3] {
    ["fast", "middle", "slow"].map(|name| bench.get(&format!("mb2hal.{name}.answers")))
}

fn faults(bench: &Bench) -> [bool; 3] {
    ["fast", "middle", "slow"].map(|name| bench.get(&format!("mb2hal.{name}.fault")))
}

#[test]
fn three_devices_on_one_line_have_their_rates() {
    let bench = loaded(THREE);
    bench.set("mb2hal.sim.fast.03", 4711_u32);
    bench.set("mb2hal.sim.middle.05", true);
    bench.set("mb2hal.slow.speed.float", 12.7);
    bench.set("mb2hal.slow.torque.int", -5);
    pass(&bench, 10_000);
    let [fast, middle, slow] = answers(&bench);
    assert!((199..=201).contains(&fast), "{fast}");
    assert!((99..=101).contains(&middle), "{middle}");
    assert!((49..=51).contains(&slow), "{slow}");
    assert_eq!(bench.get::<i32>("mb2hal.fast.03.int"), 4711);
    assert_eq!(bench.get::<f64>("mb2hal.fast.03.float"), 4711.0);
    assert!(
        bench.get::<bool>("mb2hal.middle.05.bit") && !bench.get::<bool>("mb2hal.middle.05.bit-inv")
    );
    assert_eq!(bench.get::<u32>("mb2hal.sim.slow.speed"), 12);
    assert_eq!(bench.get::<u32>("mb2hal.sim.slow.torque"), 65531);
    assert_eq!((faults(&bench), bench.get::<u32>("mb2hal.fast.num_errors")), ([false; 3], 0));
}

#[test]
fn a_silent_device_starves_none_and_comes_back() {
    for (silent, name) in ["fast", "middle", "slow"].iter().enumerate() {
        let bench = loaded(THREE);
        bench.set(&format!("mb2hal.sim.{name}.silent"), true);
        pass(&bench, 10_000);
        // The first seconds, in which the device is asked more often.
        let before = answers(&bench);
        pass(&bench, 20_000);
        let after = answers(&bench);
        for (n, rate) in [20, 10, 5].iter().enumerate() {
            let count = after[n] - before[n];
            match n == silent {
                true => assert_eq!(count, 0),
                // It costs 0.5 s of each 8.5 s.
                false => assert!(rate * 18 <= count, "{name} silent: {count} of {}", rate * 20),
            }
        }
        let mut wanted = [false; 3];
        wanted[silent] = true;
        assert_eq!(faults(&bench), wanted);
        let said = bench.said().join("\n");
        let unit = silent + 1;
        let text = format!("mb2hal.{name}: device {unit} on /dev/ttyUSB0 does not answer");
        assert!(said.contains(&text), "{said}");
        assert_eq!(bench.failed_hardware(), 0, "motion has nothing to do with it");
        bench.set(&format!("mb2hal.sim.{name}.silent"), false);
        pass(&bench, 9000);
        assert_eq!(faults(&bench), [false; 3]);
        assert!(bench.said().join("\n").contains("answers again"));
    }
}

#[test]
fn faults_of_the_line_are_counted_by_their_kind_and_end() {
    for (fault, kind) in
        [("noise", "noise"), ("half", "noise"), ("other", "other"), ("cut", "silent")]
    {
        let bench = loaded(THREE);
        pass(&bench, 1000);
        let pin = format!("mb2hal.line.0.sim.{fault}");
        match fault {
            "cut" => bench.set(&pin, true),
            _ => bench.set(&pin, 1.0),
        }
        pass(&bench, 5000);
        assert_eq!(faults(&bench), [true; 3], "{fault}");
        for other in ["noise", "other", "silent", "wrong"] {
            let count: u32 = bench.get(&format!("mb2hal.fast.errors-{other}"));
            assert_eq!(0 < count, other == kind, "{fault}: errors-{other} {count}");
        }
        assert!(0 < bench.get::<u32>("mb2hal.fast.num_errors"));
        assert!(4.0 < bench.get::<f64>("mb2hal.fast.since-answer"));
        match fault {
            "cut" => bench.set(&pin, false),
            _ => bench.set(&pin, 0.0),
        }
        pass(&bench, 10_000);
        assert_eq!(faults(&bench), [false; 3], "{fault}");
    }
}

#[test]
fn single_losses_keep_the_values_right() {
    let bench = loaded(THREE);
    for (pin, share) in [("noise", 0.2), ("half", 0.1), ("other", 0.1)] {
        bench.set(&format!("mb2hal.line.0.sim.{pin}"), share);
    }
    for n in 0..60_u32 {
        bench.set("mb2hal.sim.fast.00", n);
        // A broken answer takes its time of 0.5 s, and has others behind it.
        let is_read = (0..100).any(|_| {
            pass(&bench, 100);
            bench.get::<i32>("mb2hal.fast.00.int") == n.cast_signed()
        });
        assert!(is_read, "{n}");
    }
    assert!(20 < bench.get::<u32>("mb2hal.fast.num_errors"));
}

/// Two requests of the same form to one device, whose answers come after the time for them.
#[test]
fn a_late_answer_is_not_taken_for_that_to_another_request() {
    let text = "
[MB2HAL_INIT]
VERSION=1.1
TOTAL_TRANSACTIONS=2
[TRANSACTION_00]
LINK_TYPE=serial
SERIAL_PORT=/dev/ttyUSB0
SERIAL_BAUD=19200
MB_SLAVE_ID=1
MB_TX_CODE=fnct_03_read_holding_registers
FIRST_ELEMENT=0
NELEMENTS=1
HAL_TX_NAME=a
MB_RESPONSE_TIMEOUT_MS=100
[TRANSACTION_01]
MB_TX_CODE=fnct_03_read_holding_registers
FIRST_ELEMENT=1
NELEMENTS=1
HAL_TX_NAME=b
";
    for delay in [0.05, 0.09, 0.11, 0.15, 0.2, 0.3, 0.4] {
        let bench = loaded(text);
        bench.set("mb2hal.sim.a.00", 1_u32);
        bench.set("mb2hal.sim.b.00", 2_u32);
        pass(&bench, 500);
        bench.set("mb2hal.line.0.sim.delay", delay);
        for _ in 0..200 {
            pass(&bench, 50);
            let both = ["a", "b"].map(|name| bench.get::<i32>(&format!("mb2hal.{name}.00.int")));
            assert_eq!(both, [1, 2], "delay {delay}");
        }
    }
}

#[test]
fn scale_and_offset_and_limits() {
    let mut bench = Bench::new();
    bench.load::<Modbus>(&["transactions=in:04:0:1,out:06:5:1"]).unwrap();
    bench.set("mb2hal.sim.in.00", 200_u32);
    bench.set("mb2hal.in.00.scale", 0.1);
    bench.set("mb2hal.in.00.offset", -273.0);
    pass(&bench, 200);
    assert_eq!(bench.get::<f64>("mb2hal.in.00.float"), -253.0);
    assert_eq!(bench.get::<i32>("mb2hal.in.00.int"), 200);
    for (float, int, wanted) in [
        (1.6, 3, 4_u32),
        (-5.0, 0, 65531),
        (70_000.0, 0, 65535),
        (-1e9, 0, 32768),
        (f64::NAN, 7, 0),
        (f64::INFINITY, 0, 65535),
        (0.0, i32::MAX, 65535),
    ] {
        bench.set("mb2hal.out.00.float", float);
        bench.set("mb2hal.out.00.int", int);
        pass(&bench, 200);
        assert_eq!(bench.get::<u32>("mb2hal.sim.out.00"), wanted, "{float} {int}");
    }
}

/// An answer of 205 characters takes 1.7 s, more than the time after which it must begin.
#[test]
fn a_long_answer_on_a_slow_line_has_its_time() {
    let mut bench = Bench::new();
    bench.load::<Modbus>(&["rate=1200", "transactions=all:03:0:100,one:04:0:1"]).unwrap();
    for n in 0..100_u32 {
        bench.set(&format!("mb2hal.sim.all.{n:02}"), n);
    }
    for _ in 0..200 {
        pass(&bench, 100);
        let faults = ["all", "one"].map(|name| bench.get::<bool>(&format!("mb2hal.{name}.fault")));
        assert_eq!(faults, [false; 2], "a slow line is no fault");
    }
    assert_eq!(bench.get::<i32>("mb2hal.all.99.int"), 99);
    assert!(5 < bench.get::<u32>("mb2hal.all.answers"));
    for name in ["all", "one"] {
        assert_eq!(bench.get::<u32>(&format!("mb2hal.{name}.num_errors")), 0);
    }
}

/// The log keeps a limited number of different texts.
#[test]
fn many_probes_leave_room_for_the_loss_of_a_device() {
    let bench = loaded(THREE);
    for n in 0..600_u32 {
        bench.set("mb2hal.sim.fast.00", n);
        bench.command("modbus.probe", &["unit=1"]).unwrap();
        pass(&bench, 50);
    }
    assert!(bench.said().iter().any(|text| text.contains("device 1 answers: 400")));
    bench.set("mb2hal.sim.fast.silent", true);
    pass(&bench, 5000);
    let said = bench.said().join("\n");
    assert!(said.contains("mb2hal.fast: device 1 on /dev/ttyUSB0 does not answer"), "{said}");
}

#[test]
fn a_refusal_is_said_in_words() {
    let mut bench = Bench::new();
    bench.load::<Modbus>(&["transactions=in:04:0:1"]).unwrap();
    pass(&bench, 100);
    // The simulated device has one register of each kind.
    bench.command("modbus.probe", &["table=inputs", "first=9"]).unwrap();
    pass(&bench, 100);
    let why = bench.failure().unwrap();
    assert_eq!(why, "device 1: the device refuses: it has no such address (exception 2)");
}

#[test]
fn a_probe_tries_a_device_between_the_requests() {
    let bench = loaded(THREE);
    bench.set("mb2hal.sim.fast.02", 99_u32);
    pass(&bench, 200);
    bench.command("modbus.probe", &["unit=1", "first=1", "count=2"]).unwrap();
    pass(&bench, 100);
    assert_eq!(bench.failure(), None);
    assert!(bench.said().iter().any(|text| text.contains("device 1 answers: 0 99")));
    bench.command("modbus.probe", &["unit=9"]).unwrap();
    pass(&bench, 700);
    assert_eq!(bench.failure().unwrap(), "device 9: the device does not answer");
    let refused = bench.command("modbus.probe", &["line=1"]).unwrap_err();
    assert_eq!(refused, "line=1: the lines are 0 to 0");
    let refused = bench.command("modbus.probe", &["table=all"]).unwrap_err();
    assert_eq!(refused, "table=all: coils, discretes, holding or inputs");
}

#[test]
fn motion_is_off_while_a_critical_device_is_lost() {
    let mut bench = Bench::new();
    bench.load::<Modbus>(&["critical=TRUE", "transactions=in:04:0:1"]).unwrap();
    pass(&bench, 2000);
    assert_eq!(bench.failed_hardware(), 0);
    bench.set("mb2hal.sim.in.silent", true);
    pass(&bench, 3000);
    assert_eq!(bench.failed_hardware(), 1);
    bench.set("mb2hal.sim.in.silent", false);
    pass(&bench, 9000);
    assert_eq!(bench.failed_hardware(), 0);
}

/// Nothing is asked while a device closes its connection.
#[test]
fn the_end_of_a_connection_is_noticed_between_two_requests() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let device = listener.local_addr().unwrap().to_string();
    let mut bench = Bench::new().with_hardware();
    bench.load::<Modbus>(&[&format!("device={device}")]).unwrap();
    bench.work("mb2hal.line.0", 1).unwrap();
    drop(listener.accept().unwrap());
    let mut said = String::new();
    while !said.contains(&format!("{device} is lost")) {
        bench.work("mb2hal.line.0", 1).unwrap();
        said += &bench.said().join("\n");
    }
}

/// A device in the network: a socket of this computer, with the simulated slave behind it.
#[test]
fn a_device_over_tcp_is_read_lost_and_found_again() {
    use std::{
        io::{Read as _, Write as _},
        net::TcpListener,
    };
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let device = listener.local_addr().unwrap().to_string();
    let mut slave = hal_modbus_devices::Slave::new(1, 4);
    slave.holding[2] = 321;
    let mut bench = Bench::new().with_hardware();
    let args = [&format!("device={device}"), "update_rate=0", "transactions=hold:03:0:4"];
    bench.load::<Modbus>(&args).unwrap();
    for round in 1..=2_u32 {
        let work = || {
            // So little that no answer is too late.
            bench.pass(10_000);
            bench.work("mb2hal.line.0", 1).unwrap();
        };
        work();
        let (mut stream, _) = listener.accept().unwrap();
        for n in 1..=20 {
            let mut frame = [0; 12];
            stream.read_exact(&mut frame).unwrap();
            stream.write_all(&slave.hear_tcp(&frame).unwrap()).unwrap();
            while bench.get::<u32>("mb2hal.hold.answers") < 20 * (round - 1) + n {
                work();
            }
        }
        assert_eq!(bench.get::<i32>("mb2hal.hold.02.int"), 321);
        slave.holding[2] = 322;
        drop(stream);
        while bench.get::<u32>("mb2hal.hold.num_errors") < round {
            work();
        }
        assert!(bench.said().join("\n").contains(&format!("{device} is lost")));
        slave.holding[2] = 321;
        bench.pass(1100 * MS);
    }
    // Nobody accepts any more.
    drop(listener);
    bench.work("mb2hal.line.0", 1).unwrap();
    let said = bench.said().join("\n");
    assert!(said.contains("nobody accepts there"), "{said}");
}
