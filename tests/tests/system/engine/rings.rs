//! Rings shared with programs that do not read, stop reading, or overwrite the memory in every possible manner: records
//! are counted as lost or refused, the engine is unharmed, and the next program is served.
#![expect(clippy::unwrap_used, clippy::panic, reason = "tests")]

use hal_engine::ClockKind;
use hal_protocol::{Client, Link, Stream, Value};
use hal_tests::{
    machine::{Served, count, cycles, script, status, without_fifo},
    random::Random,
    raw,
    scratch::Scratch,
};
use rustix::{
    fs::{FallocateFlags, SealFlags, fallocate, fcntl_add_seals},
    io::Errno,
};
use std::{
    fs::File,
    os::unix::{fs::FileExt, net::UnixStream},
};

/// A ring that is written in every cycle, and one that is read; each holds four records.
const MACHINE: &str = "
    loadrt threads
    loadrt tap
    loadrt feed
    addf tap.0 thread1
    addf feed.0 thread1
    start";

/// Offsets of a ring's two indices in its memory.
const WRITTEN: u64 = 64;
const TAKEN: u64 = 128;

fn run(c: &mut impl Link, cycles: u64) {
    script(c, &format!("run {}", cycles * 1_000_000));
}

/// Reads the waiting records: their numbers and first values. The second value is ten times the first.
fn read(stream: &mut Stream) -> Vec<(u64, u32)> {
    let mut record = Vec::new();
    let mut all = Vec::new();
    while let Some(number) = stream.take(&mut record) {
        let [Value::U32(first), Value::U32(second)] = record[..] else { panic!("{record:?}") };
        assert_eq!(second, first.wrapping_mul(10));
        all.push((number, first));
    }
    all
}

/// Returns a connection, and the memory of a ring that the engine passed over it.
fn handed(served: &Served, name: &str) -> (UnixStream, File) {
    raw::ring(served, &format!("{{\"attach\":{{\"name\":\"{name}\"}}}}"))
}

/// Attaches as soon as the engine has noticed that the previous program is gone.
fn attach(c: &mut Client, name: &str) -> Stream {
    loop {
        match c.attach(name, None) {
            Ok(stream) => return stream,
            Err(e) => assert!(e.to_string().contains("in use"), "{e}"),
        }
    }
}

fn virtual_one(scratch: &Scratch) -> (Served, Client) {
    let served = Served::on(ClockKind::Virtual, scratch, "rings", MACHINE);
    let client = served.client();
    (served, client)
}

#[test]
fn a_ring_without_a_reader_counts_what_it_loses() {
    let scratch = Scratch::new("lost");
    let (served, mut c) = virtual_one(&scratch);
    run(&mut c, 3);
    assert_eq!((count(&mut c, "tap.0.cycles"), count(&mut c, "tap.0.lost")), (3, 0));
    run(&mut c, 97);
    assert_eq!((count(&mut c, "tap.0.cycles"), count(&mut c, "tap.0.lost")), (100, 96));

    // A late reader finds the first four; lost records are numbered too.
    let mut reader = served.client();
    let mut stream = attach(&mut reader, "tap.0");
    assert_eq!(read(&mut stream), [(1, 1), (2, 2), (3, 3), (4, 4)]);
    run(&mut c, 2);
    assert_eq!(read(&mut stream), [(101, 101), (102, 102)]);
    assert_eq!(count(&mut c, "tap.0.lost"), 96);

    // The reader stops reading, and exits.
    run(&mut c, 10);
    assert_eq!(count(&mut c, "tap.0.lost"), 96 + 6);
    drop((stream, reader));
    run(&mut c, 10);
    assert_eq!(count(&mut c, "tap.0.lost"), 96 + 16);

    // The next reader continues where that one stopped.
    let mut reader = served.client();
    let mut stream = attach(&mut reader, "tap.0");
    assert_eq!(read(&mut stream), [(103, 103), (104, 104), (105, 105), (106, 106)]);
    served.end();
}

#[test]
fn a_ring_without_a_writer_says_that_it_is_empty() {
    let scratch = Scratch::new("empty");
    let (served, mut c) = virtual_one(&scratch);
    let mut writer = served.client();
    let mut stream = writer.attach("feed.0", None).unwrap();
    run(&mut c, 5);
    assert_eq!((count(&mut c, "feed.0.taken"), count(&mut c, "feed.0.empty")), (0, 5));
    let put = |stream: &mut Stream, n| stream.put(&[Value::U32(n), Value::U32(10 * n)]);
    let fit = (1..=10).filter(|n| put(&mut stream, *n)).count();
    assert_eq!(fit, 4);
    run(&mut c, 3);
    assert_eq!((count(&mut c, "feed.0.first"), count(&mut c, "feed.0.second")), (3, 30));
    // Waiting records are read although their writer is gone.
    drop((stream, writer));
    run(&mut c, 3);
    assert_eq!((count(&mut c, "feed.0.first"), count(&mut c, "feed.0.taken")), (4, 4));
    assert_eq!(count(&mut c, "feed.0.empty"), 7);
    served.end();
}

#[test]
fn a_ring_has_one_program_at_a_time() {
    let scratch = Scratch::new("taken");
    let (served, mut c) = virtual_one(&scratch);
    let mut first = served.client();
    let stream = first.attach("tap.0", None).unwrap();
    let mut second = served.client();
    let refused = second.attach("tap.0", None).unwrap_err().to_string();
    assert_eq!(refused, "stream 'tap.0' is in use by another program");
    let refused = second.attach("tap.1", None).unwrap_err().to_string();
    assert_eq!(refused, "stream 'tap.1' not found; did you mean tap.0?");
    drop((stream, first));
    let mut stream = attach(&mut second, "tap.0");
    run(&mut c, 2);
    assert_eq!(read(&mut stream), [(1, 1), (2, 2)]);
    // The ring is removed with its component; a program that still maps it can still read its contents.
    script(&mut c, "unloadrt tap\nloadrt tap\naddf tap.0 thread1");
    run(&mut c, 2);
    assert_eq!(read(&mut stream), []);
    served.end();
}

#[test]
fn its_memory_cannot_be_taken_away() {
    let scratch = Scratch::new("truncate");
    let (served, mut c) = virtual_one(&scratch);
    for name in ["tap.0", "feed.0"] {
        let (_socket, file) = handed(&served, name);
        let size = file.metadata().unwrap().len();
        for len in [0, 1, 192, size - 1, size + 1, 1 << 40] {
            let e = file.set_len(len).unwrap_err();
            assert_eq!(e.raw_os_error(), Some(Errno::PERM.raw_os_error()), "{len}");
        }
        for seals in [SealFlags::WRITE, SealFlags::FUTURE_WRITE, SealFlags::SEAL] {
            assert_eq!(fcntl_add_seals(&file, seals), Err(Errno::PERM), "{seals:?}");
        }
        // A permitted operation: giving back the pages, which then read as zeros.
        let hole = FallocateFlags::PUNCH_HOLE | FallocateFlags::KEEP_SIZE;
        fallocate(&file, hole, 0, size).unwrap();
        run(&mut c, 10);
        assert!(status(&mut c).running);
    }
    assert_eq!(count(&mut c, "tap.0.cycles"), 20);
    served.end();
}

/// Lets a program overwrite the memory, then checks that the engine is unharmed and serves the next.
fn scribbled(
    served: &Served,
    c: &mut Client,
    name: &str,
    scribble: impl FnOnce(&File, &mut Client),
) {
    let (socket, file) = handed(served, name);
    let before = (count(c, "tap.0.cycles"), count(c, "feed.0.taken") + count(c, "feed.0.empty"));
    scribble(&file, c);
    run(c, 7);
    let s = status(c);
    assert!(s.running && s.fault.is_none());
    let after = (count(c, "tap.0.cycles"), count(c, "feed.0.taken") + count(c, "feed.0.empty"));
    assert!(after.0 >= before.0 + 7 && after.1 >= before.1 + 7, "every cycle counted");
    drop((socket, file));

    let mut next = served.client();
    let mut stream = attach(&mut next, name);
    if name == "tap.0" {
        // Overwritten records are read as they are; records written from now on are correct.
        let mut record = Vec::new();
        for _ in 0..3 {
            while stream.take(&mut record).is_some() {}
            run(c, 4);
        }
        while stream.take(&mut record).is_some() {}
        let n = u32::try_from(count(c, "tap.0.cycles")).unwrap();
        run(c, 3);
        let values: Vec<u32> = read(&mut stream).into_iter().map(|r| r.1).collect();
        assert_eq!(values, [n + 1, n + 2, n + 3]);
    } else {
        let put = |stream: &mut Stream, n| stream.put(&[Value::U32(n), Value::U32(10 * n)]);
        while !put(&mut stream, 1) {
            run(c, 1);
        }
        run(c, 5);
        let (taken, n) = (count(c, "feed.0.taken"), 1000);
        assert!(put(&mut stream, n) && put(&mut stream, n + 1));
        run(c, 1);
        assert_eq!((count(c, "feed.0.first"), count(c, "feed.0.second")), (1000, 10_000));
        run(c, 5);
        assert_eq!((count(c, "feed.0.first"), count(c, "feed.0.second")), (1001, 10_010));
        assert_eq!(count(c, "feed.0.taken"), taken + 2);
    }
}

#[test]
fn indices_that_cannot_be_are_not_believed() {
    let scratch = Scratch::new("indices");
    let (served, mut c) = virtual_one(&scratch);
    run(&mut c, 5);
    for name in ["tap.0", "feed.0"] {
        for at in [WRITTEN, TAKEN] {
            for value in [0, 1, 4, 5, 6, 7, 1 << 31, 1 << 32, 1 << 63, u64::MAX - 4, u64::MAX] {
                scribbled(&served, &mut c, name, |file, _| {
                    file.write_all_at(&value.to_ne_bytes(), at).unwrap();
                });
                scribbled(&served, &mut c, name, |file, c| {
                    for n in 0..5 {
                        file.write_all_at(&(value.wrapping_add(n)).to_ne_bytes(), at).unwrap();
                        run(c, 1);
                    }
                });
            }
        }
    }
    served.end();
}

#[test]
fn random_words_all_over_harm_nobody() {
    let scratch = Scratch::new("scribble");
    let (served, mut c) = virtual_one(&scratch);
    let mut random = Random::new(0x5eed);
    for round in 0..60 {
        let name = if round % 2 == 0 { "tap.0" } else { "feed.0" };
        scribbled(&served, &mut c, name, |file, c| {
            let words = file.metadata().unwrap().len() / 8;
            for _ in 0..20 {
                for _ in 0..random.word() % 40 {
                    let at = random.word() % words * 8;
                    // Often values near plausible ones, sometimes random ones.
                    let word = match random.word() % 3 {
                        0 => random.word(),
                        1 => random.word() % 64,
                        _ => (random.word() % 16).wrapping_neg(),
                    };
                    file.write_all_at(&word.to_ne_bytes(), at).unwrap();
                }
                run(c, random.word() % 3);
            }
        });
    }
    served.end();
}

#[test]
fn scribbling_while_the_machine_runs_on_the_real_clock() {
    let scratch = Scratch::new("real");
    let served = Served::start(&scratch, "rings", MACHINE);
    let mut c = served.client();
    for name in ["tap.0", "feed.0"] {
        let (_socket, file) = handed(&served, name);
        let words = file.metadata().unwrap().len() / 8;
        let mut random = Random::new(7);
        let from = count(&mut c, "tap.0.cycles");
        while count(&mut c, "tap.0.cycles") < from + 200 {
            for _ in 0..1000 {
                let at = random.word() % words * 8;
                file.write_all_at(&random.word().to_ne_bytes(), at).unwrap();
            }
        }
        cycles(&mut c, "thread1", 10);
        let s = status(&mut c);
        assert!(s.running && s.fault.is_none());
    }
    script(&mut c, "unloadrt tap\nunloadrt feed");
    served.end();
}

#[test]
fn all_of_this_without_fifo() {
    without_fifo(module_path!(), "all_of_this_without_fifo");
}
