//! Pages of pin values: values pass without requests, a client that writes anything there harms only itself, and on
//! the virtual clock the clock waits for each client that does not sleep.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_engine::ClockKind;
use hal_protocol::{Client, Direction, Link, PinPage, PinPageInfo, Request, Type, Value};
use hal_tests::{
    machine::{Served, bit, cycles, get, says, script, status, wait},
    scratch::Scratch,
};
use std::{fs::OpenOptions, sync::atomic::AtomicU64, sync::atomic::Ordering::Relaxed};

/// A running thread, and the clock moves on request alone where it is virtual.
const MACHINE: &str = "
    loadrt threads
    loadrt boom
    addf boom.0 thread1
    start";

/// Joins as component `panel` with these pins and a page.
fn panel(served: &Served, pins: &[(&str, Type, Direction)]) -> (Client, PinPage) {
    let mut client = served.client();
    let name = "panel".to_owned();
    client.call(Request::Join { name, poll_ns: 1_000_000 }).unwrap();
    for (name, ty, direction) in pins {
        let (ty, direction) = (*ty, *direction);
        client.call(Request::NewPin { name: format!("panel.{name}"), ty, direction }).unwrap();
    }
    let page = client.share_pins(u32::try_from(pins.len()).unwrap(), None).unwrap();
    client.call(Request::Ready).unwrap();
    (client, page)
}

const PINS: &[(&str, Type, Direction)] = &[
    ("in", Type::Float, Direction::In),
    ("out", Type::S32, Direction::Out),
    ("io", Type::U32, Direction::Io),
    ("bit", Type::Bit, Direction::Out),
    ("ro", Type::S64, Direction::Ro),
    ("flag", Type::Bit, Direction::In),
];

#[test]
fn values_pass_in_both_directions_without_a_request() {
    let scratch = Scratch::new("pages");
    let served = Served::start(&scratch, "served", MACHINE);
    let mut other = served.client();
    let (mut client, mut page) = panel(&served, PINS);
    script(&mut other, "net s panel.out\nsetp panel.in 2.5\nsetp panel.io 7");
    wait(&mut other, "they arrive", |_| {
        page.get(0) == 2.5_f64.to_bits() && page.get(2) == 7 && page.own(2).is_none()
    });
    for (pin, value) in
        [(1, Value::S32(-3)), (2, Value::U32(9)), (3, Value::Bit(true)), (4, Value::S64(i64::MIN))]
    {
        assert!(page.set(pin, value.bits()));
        // A client reads what it has written, whether or not the engine has taken it.
        assert_eq!(page.get(pin), value.bits(), "{pin}");
    }
    assert!(!page.set(6, 1) && page.get(6) == 0);
    // Any request sees what was written before it.
    assert_eq!(says(&mut other, "gets s"), "-3");
    assert_eq!(says(&mut other, "getp panel.io"), "9");
    assert!(bit(&mut other, "panel.bit"));
    assert_eq!(says(&mut other, "getp panel.ro"), i64::MIN.to_string());
    // The other side has the last word on a pin of both.
    script(&mut other, "setp panel.io 11");
    wait(&mut other, "it arrives", |_| page.get(2) == 11);
    // An input is set by its program only while nothing else drives it.
    page.set(0, 8.0_f64.to_bits());
    assert_eq!(says(&mut other, "getp panel.in"), "8");
    page.set(5, 0);
    script(&mut other, "net t boom.0.line panel.flag");
    wait(&mut other, "it follows the signal", |_| page.get(5) == 1);
    page.set(5, 0);
    wait(&mut other, "it is refused", |c| bit(c, "boom.0.line") && page.get(5) == 1);

    // A larger page has the values of the one before.
    client.call(Request::Unready).unwrap();
    let (name, ty, direction) = ("panel.more".to_owned(), Type::U64, Direction::Out);
    client.call(Request::NewPin { name, ty, direction }).unwrap();
    assert!(!page.set(6, 1));
    let mut page = client.share_pins(64, Some(&page)).unwrap();
    page.set(6, u64::MAX);
    client.call(Request::Ready).unwrap();
    assert_eq!(says(&mut other, "getp panel.more"), u64::MAX.to_string());
    assert_eq!((says(&mut other, "gets s"), page.get(2)), ("-3".to_owned(), 11));

    client.call(Request::Leave).unwrap();
    assert!(says(&mut other, "getp panel.io").contains("not found"));
    assert_eq!(says(&mut other, "gets s"), "-3", "what was written last stays in the signal");
    served.end();
}

/// Returns the words of a page.
fn words(page: &PinPage, info: &PinPageInfo) -> &'static [AtomicU64] {
    // SAFETY: the page is mapped longer than the test uses the words.
    #[expect(unsafe_code, reason = "plays a client that writes anything")]
    unsafe {
        core::slice::from_raw_parts(page.address().cast::<AtomicU64>(), info.bytes() / 8)
    }
}

#[test]
fn a_client_that_writes_anything_to_its_page_harms_only_its_own_pins() {
    let scratch = Scratch::new("garbage-pages");
    let served = Served::start(&scratch, "served", MACHINE);
    let mut other = served.client();
    let (client, page) = panel(&served, PINS);
    let info = page.info().clone();
    let all = words(&page, &info);
    for round in 0_u64..200 {
        for (i, word) in (0_u32..).zip(all) {
            let n = (round + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(i % 64);
            // Every other round with an even sequence number, so that the values are taken.
            word.store(if round % 2 == 0 { n & !1 } else { n | 1 }, Relaxed);
        }
        let bit = says(&mut other, "getp panel.bit");
        assert!(["TRUE", "FALSE"].contains(&&*bit), "{bit}");
        let small = says(&mut other, "getp panel.out").parse::<i32>();
        assert!(small.is_ok());
    }
    assert!(status(&mut other).running);
    assert_eq!(says(&mut other, "getp boom.0.line"), "TRUE");
    cycles(&mut other, "thread1", 2);
    drop((client, page));
    wait(&mut other, "it goes", |c| says(c, "getp panel.bit").contains("not found"));
    served.end();
}

#[test]
fn values_of_a_client_that_dies_while_it_writes_are_not_taken() {
    let scratch = Scratch::new("half-pages");
    let served = Served::start(&scratch, "served", MACHINE);
    let mut other = served.client();
    let (client, mut page) = panel(&served, PINS);
    script(&mut other, "net s panel.out");
    page.set(1, 4);
    assert_eq!(says(&mut other, "gets s"), "4");
    let info = page.info().clone();
    let half = &words(&page, &info)[info.second() / 8..];
    let sequence = &half[2];
    assert_eq!(sequence.load(Relaxed) % 2, 0);
    sequence.fetch_add(1, Relaxed);
    // The pairs follow the header of eight words.
    half[8 + 2].store(77, Relaxed);
    half[8 + 3].fetch_add(1, Relaxed);
    assert_eq!(says(&mut other, "gets s"), "4", "the record is not complete");
    drop((client, page));
    wait(&mut other, "it goes", |c| says(c, "getp panel.out").contains("not found"));
    assert_eq!(says(&mut other, "gets s"), "4");
    served.end();
}

#[test]
fn nobody_can_cut_a_page() {
    let scratch = Scratch::new("cut-pages");
    let served = Served::start(&scratch, "served", MACHINE);
    let (_client, _page) = panel(&served, PINS);
    let mut pages = 0;
    for entry in std::fs::read_dir("/proc/self/fd").unwrap().flatten() {
        let target = std::fs::read_link(entry.path()).unwrap_or_default();
        if target.to_string_lossy().contains("memfd:hal-pins") {
            let Ok(file) = OpenOptions::new().write(true).open(entry.path()) else { continue };
            assert!(file.set_len(0).is_err());
            assert!(file.set_len(1 << 20).is_err());
            pages += 1;
        }
    }
    assert!(pages > 0);
    served.end();
}

#[test]
fn requests_about_pages_are_checked() {
    let scratch = Scratch::new("refused-pages");
    let served = Served::start(&scratch, "served", MACHINE);
    let mut client = served.client();
    let mut refused = |request| client.call(request).unwrap_err().to_string();
    let not_joined = "this client has not joined as a component";
    for request in
        [Request::SharePins { pins: 1 }, Request::Sleep { ns: 1 }, Request::Leave, Request::Unready]
    {
        assert_eq!(refused(request), not_joined);
    }
    let (mut client, _page) = panel(&served, PINS);
    let mut refused = |request| client.call(request).unwrap_err().to_string();
    for pins in [0, 32_769, u32::MAX] {
        assert_eq!(
            refused(Request::SharePins { pins }),
            format!("a page of {pins} pins is not possible; expected 1 to 32768")
        );
    }
    for ns in [1_000_000_000_001, u64::MAX] {
        assert!(refused(Request::Sleep { ns }).starts_with("a program cannot sleep for "));
    }
    served.end();
}

/// Runs a client that adds 1 to its output in every sleep, and returns the clock's time and the output after each step.
fn run() -> Vec<(u64, String)> {
    let scratch = Scratch::new("slept");
    let served = Served::on(ClockKind::Virtual, &scratch, "slept", MACHINE);
    let mut other = served.client();
    let (mut client, mut page) = panel(&served, PINS);
    let (leave, left) = std::sync::mpsc::channel::<()>();
    let program = std::thread::spawn(move || {
        for n in 1.. {
            let seen = f64::from_bits(page.get(0));
            page.set(1, n);
            page.set(4, seen.to_bits());
            let ns = 300_000 + 100_000 * (n % 3);
            if client.call(Request::Sleep { ns }).is_err()
                || left.try_recv() == Err(std::sync::mpsc::TryRecvError::Disconnected)
            {
                break;
            }
        }
    });
    let mut rows = Vec::new();
    for step in 0_u64..50 {
        script(&mut other, &format!("setp panel.in {step}"));
        other.call(Request::Run { ns: 170_000 }).unwrap();
        let out = format!("{} {}", get(&mut other, "panel.out"), get(&mut other, "panel.ro"));
        rows.push((status(&mut other).time, out));
    }
    drop(leave);
    served.end();
    program.join().unwrap();
    rows
}

/// Load of the processor plays no part: the client has worked before the clock moves on.
#[test]
fn on_the_virtual_clock_a_client_with_a_page_gets_the_same_values_every_time() {
    let first = run();
    let last: i64 = first.last().unwrap().1.split(' ').next().unwrap().parse().unwrap();
    // 50 steps of 170 µs, and sleeps of 400 µs on average.
    assert!((20..=23).contains(&last), "{first:?}");
    for _ in 0..3 {
        assert_eq!(run(), first);
    }
}
