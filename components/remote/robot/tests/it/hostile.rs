//! Each end of the protocol against one that says anything at any time, from fixed seeds.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_bench::Random;
use robot::{Command, Controller, Driver, Faults, Output, State, Volume, approach};

const ZERO: [f64; 3] = [-400.0, 0.0, -30.0];

/// Texts of a controller: right ones, wrong ones, and none.
const ANSWERS: &[&[u8]] = &[
    b"-400 0 -30\r\n",
    b"Esperando inicio\r\n",
    b"done\r\n",
    b"done\r\ndone\r\n",
    b"error unknown\r\n",
    b"error format\r\n",
    b"error range\r\n",
    b"done",
    b"\r\n",
    b"NaN inf 1e309\r\n",
    b"1e999 0 0\r\n",
    b"9999999 0 0\r\n",
    b"1 2 3 4\r\n",
    b"\xff\xfe\x00d\x00o\r\n",
    b"d\xc3\xb6ne\n",
    b"\0\x1b[2J",
];

/// Lines of a client.
const LINES: &[&[u8]] = &[
    b"inicio\r\n",
    b"JMOVE,0,0,10\r\n",
    b"LMOVE,10,-5,0\r\n",
    b"LMOVE,1e9,0,0\r\n",
    b"LMOVE,999999,0,0\r\n",
    b"LMOVE,nan,0,0\r\n",
    b"LMOVE,0,0\r\n",
    b"LMOVE,0,0,0,0,0\r\n",
    b"SPEED,15\r\n",
    b"SPEED,-1\r\n",
    b"SPEED,0.000001\r\n",
    b"JMOVE,0,0,",
    b"\n\n\r",
    b"\xff\xfe\0\0",
    b"\r\nEXIT\r\n",
    b"inicio\0\r\n",
];

/// Returns a text of the list, or bytes by chance, or more of them than a line may have.
fn garbage(random: &mut Random, list: &[&[u8]]) -> Vec<u8> {
    match random.below(20) {
        0 => (0..random.below(40)).map(|_| u8::try_from(random.below(256)).unwrap()).collect(),
        1 => vec![b'x'; 1000],
        _ => random.one(list).to_vec(),
    }
}

#[test]
fn no_answers_make_the_driver_send_a_line_twice_out_of_its_order_or_after_a_stop() {
    let lines = [
        Command::Speed(5.0),
        Command::Rapid([0.0, 0.0, 10.0]),
        Command::Cut([10.0, -5.0, 0.0]),
        Command::Cut([20.0, -5.0, 0.0]),
    ];
    let mut whole: Vec<String> = approach(&lines, 0).iter().map(Command::to_string).collect();
    whole.extend(lines.iter().map(Command::to_string));
    let (mut ends, mut runs) = (0, 0);
    for seed in 0..2000 {
        let mut random = Random::new(seed);
        let mut driver = Driver::new(1.0);
        let (mut now, mut sent, mut right) = (0.0, Vec::new(), Vec::new());
        driver.connected(now);
        for step in 0..400 {
            // Some controllers begin as they should.
            let bytes = match step {
                0 if seed % 4 != 0 => b"-400 0 -30\r\nEsperando inicio\r\n".to_vec(),
                // And some go on so, but for one answer in a hundred.
                _ if seed % 4 == 1 && random.below(100) > 0 => core::mem::take(&mut right),
                _ => garbage(&mut random, ANSWERS),
            };
            for piece in bytes.chunks(random.pick(&[1, 3, 256])) {
                driver.receive(piece, now);
            }
            runs += u32::from(driver.run(lines.to_vec(), 0, now));
            now += random.pick(&[0.0, 0.01, 0.06, 1.0, 10.0]);
            driver.poll(now);
            let was_over = sent.last().is_some_and(|line: &String| line == "EXIT");
            let output = String::from_utf8(driver.output()).unwrap();
            assert!(!was_over || output.is_empty(), "seed {seed}: {output} after EXIT");
            assert!(output.len() < 4096, "seed {seed}: {} bytes at once", output.len());
            for line in output.lines() {
                right.extend_from_slice(match line {
                    "?" => b"error unknown\r\n",
                    "SPEED" => b"error format\r\n",
                    _ => b"done\r\n",
                });
            }
            let probes = ["?", "SPEED"];
            sent.extend(output.lines().filter(|l| !probes.contains(l)).map(str::to_owned));
            drop(driver.events());
        }
        let moves: Vec<_> = sent.iter().filter(|line| *line != "EXIT").collect();
        assert!(moves.iter().copied().eq(whole.iter().take(moves.len())), "seed {seed}: {sent:?}");
        let is_whole = moves.len() == whole.len();
        assert!(driver.state() != State::Ended || is_whole, "seed {seed}: {sent:?}");
        ends += u32::from(driver.state() == State::Ended);
    }
    assert!(ends > 100 && runs > 500, "{ends} runs of {runs} to their end");
}

#[test]
fn no_lines_take_the_simulated_robot_out_of_its_volume() {
    let volume = Volume::default();
    let mut moves = 0;
    for seed in 0..500 {
        let mut random = Random::new(seed);
        let mut robot = Controller::new(volume, ZERO, Faults::default());
        let mut now = 0.0;
        for _ in 0..200 {
            if robot.connect(now).is_some() && random.below(50) == 0 {
                robot.disconnect(now);
            }
            let bytes = garbage(&mut random, LINES);
            let before = robot.place(now);
            robot.receive(&bytes, now);
            if bytes.starts_with(b"\r\nEXIT") {
                assert!(!robot.is_moving(), "seed {seed}: EXIT stops at once");
                assert_eq!(robot.place(now), before, "seed {seed}");
            }
            now += random.pick(&[0.0, 0.01, 0.06, 1.0, 10.0]);
            let bytes = robot.poll(now).into_iter().map(|output| match output {
                Output::Bytes(bytes) => bytes.len(),
                Output::Close => 0,
            });
            assert!(bytes.sum::<usize>() < 100_000, "seed {seed}");
            assert!(robot.place(now).iter().all(|at| at.abs() < 1000.0), "seed {seed}");
        }
        moves += robot.moves().len();
    }
    assert!(moves > 100, "{moves} moves");
}
