//! The simulated devices by themselves.

use crate::{Bus, Device as _, Faults, Inverter, Slave, Timing};
use hal_modbus::{
    Call, Exception, Miss, ModbusAnswer, ModbusRequest, ModbusTable, find_rtu, find_tcp,
    huanyang::{self, Ask},
};

const MS: i64 = 1_000_000;
const TIMING: Timing = Timing { char_ns: MS / 2, silence_ns: 6 * MS, answer_ns: 2 * MS };

fn ask(bus: &mut Bus<Inverter>, now: &mut i64, ask: Ask) -> Option<u16> {
    bus.send(&ask.frame(1));
    *now += 30 * MS;
    bus.advance(*now);
    huanyang::find(1, ask, &bus.receive(100))
}

#[test]
fn an_inverter_ramps_turns_round_and_trips() {
    let mut bus = Bus::new(Inverter::new(1), TIMING, 1);
    let mut now = 10 * MS;
    bus.advance(now);
    assert_eq!(ask(&mut bus, &mut now, Ask::Frequency(20_000)), Some(20_000));
    assert_eq!(ask(&mut bus, &mut now, Ask::Control(huanyang::RUN_FORWARD)), Some(1));
    now += 1000 * MS;
    bus.advance(now);
    assert!((100.0..105.0).contains(&bus.devices.hz()), "400 Hz in 4 s: {}", bus.devices.hz());
    now += 2000 * MS;
    bus.advance(now);
    assert_eq!(bus.devices.hz(), 200.0);
    assert_eq!(ask(&mut bus, &mut now, Ask::Measured(1)), Some(20_000));
    assert_eq!(ask(&mut bus, &mut now, Ask::Control(huanyang::RUN_REVERSE)), Some(0x0D));
    now += 5000 * MS;
    bus.advance(now);
    bus.advance(now + 5000 * MS);
    assert_eq!(bus.devices.hz(), -200.0);
    now += 5000 * MS;
    bus.devices.trip = true;
    bus.advance(now);
    ask(&mut bus, &mut now, Ask::Control(huanyang::RUN_FORWARD));
    assert_eq!((bus.devices.hz(), bus.devices.runs()), (0.0, false));
    bus.devices.trip = false;
    now += 1000 * MS;
    bus.advance(now);
    assert_eq!((bus.devices.hz(), bus.devices.runs()), (0.0, false), "a reset starts nothing");
    ask(&mut bus, &mut now, Ask::Control(huanyang::RUN_FORWARD));
    assert!(bus.devices.runs());
    assert_eq!(bus.devices.starts(), 2);
}

#[test]
fn an_inverter_stops_by_its_own_clock() {
    let mut bus = Bus::new(Inverter::new(1), TIMING, 1);
    bus.devices.timeout_ns = 500 * MS;
    let mut now = 10 * MS;
    bus.advance(now);
    ask(&mut bus, &mut now, Ask::Control(huanyang::RUN_FORWARD));
    bus.advance(now + 400 * MS);
    assert!(bus.devices.runs());
    bus.advance(now + 600 * MS);
    assert!(!bus.devices.runs());
}

#[test]
fn a_frame_that_follows_too_soon_is_not_heard() {
    let mut bus = Bus::new(Inverter::new(1), TIMING, 1);
    let mut now = 10 * MS;
    bus.advance(now);
    assert!(ask(&mut bus, &mut now, Ask::Measured(0)).is_some());
    bus.send(&Ask::Measured(0).frame(1));
    now += 2 * MS;
    bus.advance(now);
    bus.send(&Ask::Control(huanyang::RUN_FORWARD).frame(1));
    now += 100 * MS;
    bus.advance(now);
    assert_eq!((bus.receive(100).len(), bus.hasty(), bus.devices.runs()), (0, 1, false));
}

#[test]
fn each_fault_of_the_line_is_what_its_name_says() {
    let ask = Ask::Measured(0);
    for (faults, wanted) in [
        (Faults { cut: true, ..Faults::default() }, Miss::Silent),
        (Faults { noise: 1.0, ..Faults::default() }, Miss::Noise),
        (Faults { half: 1.0, ..Faults::default() }, Miss::Noise),
        (Faults { other: 1.0, ..Faults::default() }, Miss::Other(2)),
        (Faults { delay: 0.3, ..Faults::default() }, Miss::Silent),
    ] {
        let mut bus = Bus::new(Inverter::new(1), TIMING, 5);
        bus.advance(10 * MS);
        bus.faults = faults;
        bus.send(&ask.frame(1));
        bus.advance(110 * MS);
        let came = bus.receive(100);
        assert_eq!(huanyang::find(1, ask, &came), None);
        assert_eq!(huanyang::miss(1, &came), wanted, "{faults:?}");
        bus.advance(1000 * MS);
        assert_eq!(huanyang::find(1, ask, &bus.receive(100)).is_some(), faults.delay != 0.0);
    }
}

#[test]
fn a_slave_serves_each_function_and_refuses_in_the_words_of_the_standard() {
    let mut slave = Slave::new(3, 10);
    let call = |slave: &mut Slave, call: Call| {
        let request = ModbusRequest { unit: 3, call };
        let serial = slave.answered(&request.rtu().unwrap(), 0).unwrap();
        let tcp = slave.hear_tcp(&request.tcp(9).unwrap()).unwrap();
        let found = find_rtu(&request, &serial).unwrap();
        assert_eq!(find_tcp(&request, 9, &tcp), Ok(Some(found.clone())));
        found
    };
    let read = |table, first, count| Call::Read { table, first, count };
    assert_eq!(call(&mut slave, Call::WriteCoil { at: 1, on: true }), ModbusAnswer::Written);
    assert_eq!(
        call(&mut slave, Call::WriteCoils { first: 2, on: vec![true, false] }),
        ModbusAnswer::Written
    );
    let coils = call(&mut slave, read(ModbusTable::Coils, 0, 4));
    assert_eq!(coils, ModbusAnswer::Bits(vec![false, true, true, false]));
    assert_eq!(call(&mut slave, Call::WriteRegister { at: 9, value: 7 }), ModbusAnswer::Written);
    let both = Call::WriteRegisters { first: 0, values: vec![1, 2] };
    assert_eq!(call(&mut slave, both), ModbusAnswer::Written);
    assert_eq!(call(&mut slave, read(ModbusTable::Holding, 0, 2)), ModbusAnswer::Words(vec![1, 2]));
    slave.discretes[0] = true;
    slave.inputs[5] = 500;
    assert_eq!(
        call(&mut slave, read(ModbusTable::Discretes, 0, 1)),
        ModbusAnswer::Bits(vec![true])
    );
    assert_eq!(call(&mut slave, read(ModbusTable::Inputs, 5, 1)), ModbusAnswer::Words(vec![500]));
    let beyond = call(&mut slave, read(ModbusTable::Inputs, 5, 6));
    assert_eq!(beyond, ModbusAnswer::Refused(Exception(2)));
    let beyond = call(&mut slave, Call::WriteRegisters { first: 9, values: vec![1, 2] });
    assert_eq!(beyond, ModbusAnswer::Refused(Exception(2)));
    let mut unknown = vec![3, 7, 0, 0, 0, 0];
    hal_modbus::push_crc(&mut unknown);
    let answer = slave.answered(&unknown, 0).unwrap();
    assert_eq!(answer[..3], [3, 0x87, 1]);
    slave.is_silent = true;
    assert_eq!(slave.answered(&unknown, 0), None);
}
