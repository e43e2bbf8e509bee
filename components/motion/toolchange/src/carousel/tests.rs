use super::Carousel;
use hal_bench::{Bench, trace::replay};

#[test]
fn as_recorded() {
    assert!(replay::<Carousel>(include_str!("../../traces/carousel.txt")) > 90);
}

/// Each magazine has its own encoding; LinuxCNC 2.9 takes gray after another for that other one.
#[test]
fn gray_after_another() {
    let rows = "load carousel pockets=8,8 encoding=counts,gray
        run carousel.1
        in carousel.1.sense-0 carousel.1.sense-1 carousel.1.sense-2
        out carousel.1.current-position
        1 1 1 | 5
        0 1 1 | 4";
    assert_eq!(replay::<Carousel>(rows), 2);
}

/// Six pockets in binary code: the shorter way, across the end, and what a script may ask for.
#[test]
fn the_shorter_way() {
    let rows = "load carousel pockets=6 encoding=binary
        set carousel.0.fwd-dc 0.5
        set carousel.0.rev-dc -0.5
        set carousel.0.hold-dc 0.1
        run carousel.0
        in carousel.0.enable carousel.0.pocket-number carousel.0.sense-0 carousel.0.sense-1 carousel.0.sense-2
        out carousel.0.motor-fwd carousel.0.motor-rev carousel.0.motor-vel carousel.0.active carousel.0.ready carousel.0.current-position
        0 0 1 0 0 | 0 0 0.1 0 0 1
        # Back across the end.
        1 5 1 0 0 | 0 1 -0.5 1 0 1
        1 5 0 1 1 | 0 1 -0.5 1 0 6
        1 5 1 0 1 | 0 0 0.1 0 1 5
        # What comes next waits until enable has fallen.
        1 1 1 0 1 | 0 0 0.1 0 1 5
        0 1 1 0 1 | 0 0 0.1 0 1 5
        1 1 1 0 1 | 1 0 0.5 1 0 5
        # Half of the way round: forwards from a lower number, in reverse from a higher.
        0 1 1 0 1 | 0 0 0.1 0 0 5
        0 1 1 0 1 | 0 0 0.1 0 0 5
        1 2 1 0 1 | 0 1 -0.5 1 0 5
        1 2 0 1 0 | 0 0 0.1 0 1 2
        0 2 0 1 0 | 0 0 0.1 0 1 2
        1 5 0 1 0 | 1 0 0.5 1 0 2
        1 8 0 1 0 | 0 0 0.1 0 1 2
        0 8 0 1 0 | 0 0 0.1 0 1 2
        # Below 1 it is pocket 1.
        1 -3 0 1 0 | 0 1 -0.5 1 0 2
        1 -3 1 0 0 | 0 0 0.1 0 1 1";
    assert_eq!(replay::<Carousel>(rows), 17);
}

#[test]
fn each_code() {
    for (encoding, code, pocket) in
        [("gray", 0b1_1101, 22), ("binary", 0b1_1101, 29), ("bcd", 0b1_1001, 19)]
    {
        let mut b = Bench::new();
        let arg = format!("encoding={encoding}");
        b.load::<Carousel>(&["pockets=30", &arg, "num_sense=5", "parity=1"]).unwrap();
        for i in 0..5 {
            b.set(&format!("carousel.0.sense-{i}"), code >> i & 1 == 1);
        }
        b.set("carousel.0.strobe", false);
        b.run("carousel.0", 1_000_000);
        assert_eq!(b.get::<i32>("carousel.0.current-position"), 0, "not yet valid");
        b.set("carousel.0.strobe", true);
        b.run("carousel.0", 1_000_000);
        assert_eq!(b.get::<i32>("carousel.0.current-position"), pocket, "{encoding}");
        assert_eq!(b.get::<bool>("carousel.0.parity-error"), encoding != "bcd", "{encoding}");
    }
}

/// A switch in each pocket; more than one: the last counts; none: between pockets.
#[test]
fn single_switches() {
    let rows = "load carousel pockets=5 encoding=single dir=1
        run carousel.0
        in carousel.0.enable carousel.0.pocket-number carousel.0.sense-0 carousel.0.sense-3 carousel.0.sense-4
        out carousel.0.current-position carousel.0.motor-fwd carousel.0.ready
        0 1 0 1 0 | 4 0 0
        1 1 0 1 0 | 4 1 0
        1 1 0 0 0 | 0 1 0
        1 1 0 0 1 | 5 1 0
        1 1 1 0 1 | 5 1 0
        1 1 1 0 0 | 1 0 1";
    assert_eq!(replay::<Carousel>(rows), 6);
}

/// Searches for home first, then counts pulses; enable may fall during the search.
#[test]
fn home_and_pulses() {
    let rows = "load carousel pockets=4 encoding=index
        run carousel.0
        in carousel.0.enable carousel.0.pocket-number carousel.0.sense-0 carousel.0.sense-1
        out carousel.0.state carousel.0.homing carousel.0.homed carousel.0.current-position carousel.0.motor-fwd carousel.0.motor-rev
        1 3 0 0 | 10 0 0 0 0 0
        1 3 0 0 | 11 1 0 0 1 0
        0 3 0 1 | 11 1 0 0 1 0
        0 3 0 0 | 11 1 0 0 1 0
        0 3 1 1 | 0 0 1 1 0 0
        1 3 1 1 | 2 0 1 1 1 0
        1 3 0 0 | 2 0 1 1 1 0
        1 3 0 1 | 2 0 1 2 1 0
        1 3 0 0 | 2 0 1 2 1 0
        1 3 0 1 | 9 0 1 3 0 0
        0 3 0 1 | 0 0 1 3 0 0
        1 2 0 1 | 2 0 1 3 0 1
        1 2 0 0 | 2 0 1 3 0 1
        1 2 0 1 | 9 0 1 2 0 0";
    assert_eq!(replay::<Carousel>(rows), 14);
}

/// Both ends of a pulse are pockets.
#[test]
fn edges() {
    let rows = "load carousel pockets=4 encoding=edge dir=1
        run carousel.0
        in carousel.0.enable carousel.0.pocket-number carousel.0.sense-0 carousel.0.sense-1
        out carousel.0.state carousel.0.current-position
        1 4 1 1 | 10 0
        1 4 1 1 | 0 1
        1 4 1 1 | 2 1
        1 4 0 0 | 2 2
        1 4 0 1 | 2 3
        1 4 0 0 | 9 4";
    assert_eq!(replay::<Carousel>(rows), 6);
}

/// An encoder: home at its index, offset, width, and the signals for a position loop.
#[test]
fn counts() {
    let rows = "load carousel pockets=6 encoding=counts
        set carousel.0.home-offset 30
        run carousel.0
        in carousel.0.enable carousel.0.pocket-number carousel.0.index-enable carousel.0.counts
        out carousel.0.state carousel.0.current-position carousel.0.counts-target
        1 6 . 300 | 10 0 0
        1 6 . 340 | 11 0 0
        expect carousel.0.index-enable 1
        1 6 0 0 | 0 1 0
        expect carousel.0.base-counts -30
        1 6 . -30 | 2 1 -130
        expect carousel.0.motor-rev 1
        1 6 . -124 | 2 1 -130
        1 6 . -125 | 9 6 -130
        0 6 . -130 | 0 6 -130
        1 2 . -130 | 2 6 70
        1 2 . -30 | 2 1 70
        1 2 . 64 | 2 1 70
        1 2 . 65 | 9 2 70
        set carousel.0.scale 0
        0 2 . 200 | 0 2 70";
    assert_eq!(replay::<Carousel>(rows), 12);
}

/// A ratchet: pulled back against its stop for 2.5 ms, though enable falls.
#[test]
fn pull_back() {
    let rows = "load carousel pockets=2 encoding=binary dir=1
        set carousel.0.rev-pulse 0.0025
        set carousel.0.fwd-dc 1
        set carousel.0.rev-dc -0.3
        set carousel.0.hold-dc -0.1
        within 1e-12
        run carousel.0
        in carousel.0.enable carousel.0.pocket-number carousel.0.sense-0 carousel.0.sense-1
        out carousel.0.state carousel.0.motor-rev carousel.0.motor-vel carousel.0.timer carousel.0.ready
        1 2 1 0 | 2 0 1 0 0
        1 2 0 1 | 3 1 -0.3 0.0025 0
        1 2 0 1 | 3 1 -0.3 0.0015 0
        1 2 0 1 | 3 1 -0.3 0.0005 0
        1 2 0 1 | 9 0 -0.1 -0.0005 1
        # What is no time is none.
        set carousel.0.rev-pulse nan
        0 2 0 1 | 0 0 -0.1 -0.0005 1
        1 1 0 1 | 2 0 1 -0.0005 0
        1 1 1 0 | 9 0 -0.1 -0.0005 1";
    assert_eq!(replay::<Carousel>(rows), 8);
}

/// Slows down, backs onto the mark and off it, and comes onto it forwards.
#[test]
fn alignment() {
    let rows = "load carousel pockets=4 encoding=gray
        set carousel.0.align-dc 0.2
        set carousel.0.decel-time 0.001
        set carousel.0.fwd-dc 1
        within 1e-12
        run carousel.0
        in carousel.0.enable carousel.0.pocket-number carousel.0.sense-0 carousel.0.sense-1 carousel.0.strobe
        out carousel.0.state carousel.0.motor-vel carousel.0.ready
        1 2 1 0 1 | 2 1 0
        1 2 1 1 1 | 5 0 0
        1 2 1 1 0 | 6 -0.2 0
        1 2 1 1 0 | 6 -0.2 0
        1 2 1 1 1 | 7 -0.2 0
        1 2 1 1 0 | 8 0.2 0
        1 2 1 1 1 | 9 0 1";
    assert_eq!(replay::<Carousel>(rows), 7);
}

/// Moves one pocket, across the end as well; backwards only if the magazine turns both ways.
#[test]
fn jogs() {
    let rows = "load carousel pockets=3 encoding=binary
        run carousel.0
        in carousel.0.jog-fwd carousel.0.jog-rev carousel.0.sense-0 carousel.0.sense-1
        out carousel.0.state carousel.0.motor-fwd carousel.0.motor-rev carousel.0.active
        1 0 1 1 | 20 1 0 1
        1 0 1 0 | 20 0 0 0
        0 0 1 0 | 0 0 0 0
        0 1 1 0 | 20 0 1 1
        0 0 1 1 | 0 0 0 0
        load carousel pockets=3 encoding=binary dir=1
        run carousel.0
        in carousel.0.jog-rev
        out carousel.0.state
        1 | 0";
    assert_eq!(replay::<Carousel>(rows), 6);
}

/// A code counts once it has persisted.
#[test]
fn bouncing() {
    let rows = "load carousel pockets=3 encoding=binary
        set carousel.0.debounce 2
        run carousel.0
        in carousel.0.sense-0 carousel.0.sense-1
        out carousel.0.current-position
        1 0 | 0
        1 1 | 0
        1 0 | 0
        1 0 | 0
        1 0 | 1
        1 1 | 1
        1 1 | 1
        1 1 | 3";
    assert_eq!(replay::<Carousel>(rows), 8);
}

#[test]
fn lists() {
    let mut b = Bench::new();
    b.load::<Carousel>(&["pockets=4,3,9", "encoding=single,bcd", "num_sense=2,5"]).unwrap();
    let has = |name: &str| b.names().iter().any(|n| n.starts_with(&format!("{name} ")));
    assert!(has("carousel.0.sense-3") && !has("carousel.0.sense-4"));
    assert!(has("carousel.1.sense-4") && !has("carousel.1.sense-5"));
    assert!(has("carousel.2.sense-4") && !has("carousel.2.sense-5"));
    let mut b = Bench::new();
    b.load::<Carousel>(&[]).unwrap();
    assert!(b.names().iter().any(|n| n == "carousel.0.sense-3 bit IN"));
}

/// Sensors of each magazine, as LinuxCNC 2.9 makes them for these words.
#[test]
fn unknown_encodings_count_as_gray_or_as_the_word_that_they_begin_with() {
    let words = ["", "grey", "Index", "SINGLE", "edgy", "indexes", "singles", "binar"];
    let mut b = Bench::new();
    let list = format!("encoding={}", words.join(","));
    b.load::<Carousel>(&["pockets=8,8,8,8,8,8,8,8", &list]).unwrap();
    let sensors = |i: usize| {
        b.names().iter().filter(|n| n.starts_with(&format!("carousel.{i}.sense-"))).count()
    };
    let all: Vec<_> = (0..words.len()).map(sensors).collect();
    assert_eq!(all, [4, 4, 4, 4, 4, 2, 8, 4]);
    // An empty word is none; each other one is named by the magazine that has it.
    let said = b.said();
    assert_eq!(said.len(), 7, "{said:?}");
    assert!(said[0].contains("magazine 1: the encoding is no known word"), "{said:?}");
}

/// Each refusal names the argument and its range, and leaves nothing behind.
#[test]
fn refusals() {
    for (args, said) in [
        (&["pockets=0"][..], "pockets is 0, and must be 1 to 2147483647"),
        (&["pockets=4,-1"], "pockets is -1"),
        (&["num_sense=33"], "num_sense is 33, and must be 1 to 32"),
        (&["encoding=edge", "num_sense=1"], "num_sense with encoding=edge is 1, and must be 2"),
        (&["encoding=single", "pockets=33"], "pockets with encoding=single is 33, and must be 1"),
        (&["dir=3"], "dir is 3, and must be 0 to 2"),
        (&["parity=2"], "parity is 2, and must be 0 to 1"),
    ] {
        let mut b = Bench::new();
        let why = b.load::<Carousel>(args).unwrap_err();
        assert!(why.contains(said), "{args:?}: {why}");
        assert!(b.names().is_empty(), "{args:?}");
    }
}
