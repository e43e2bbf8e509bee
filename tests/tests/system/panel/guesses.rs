//! The time that a person takes to sign in while strangers guess: a measurement.
#![expect(clippy::disallowed_methods, reason = "figures of the wall clock")]

use super::{
    accounts::{add, tries},
    printer::Printer,
};
use hal_tests::{
    user::{as_user, is_root},
    web,
};
use serde_json::json;
use std::{
    sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed},
    thread,
    time::{Duration, Instant},
};

/// First user of this computer who guesses: each user is a place of their own, as an address elsewhere is.
const FIRST: u32 = 60_000;
/// Guesses in a second, from all places together.
const RATE: u32 = 100;
/// Sign-ins that are measured with each number of places.
const SIGN_INS: usize = 20;
fn place(
    user: u32,
    port: u16,
    host: &str,
    tried: &AtomicUsize,
    ended: &AtomicBool,
    every: Duration,
) {
    let guess = json!({ "user": "ana", "password": "a guess too few" }).to_string();
    as_user(user, || {
        while !ended.load(Relaxed) {
            let begun = Instant::now();
            let answer = web::request(port, "POST", "/api/v1/session", host, guess.as_bytes());
            tried.fetch_add(usize::from(answer.code() == "wrong-login"), Relaxed);
            // The rate of the guesses is what is measured against: this is the wall clock's pause, and no wait for anything.
            thread::sleep(every.saturating_sub(begun.elapsed()));
        }
    });
}

/// Signs in again and again, with a device that is known or without one. Returns the times in milliseconds, and how often the
/// person was told to wait first.
fn sign_ins(printer: &Printer, device: &str) -> (Vec<u128>, usize) {
    let mut refused = 0;
    let times = (0..SIGN_INS).map(|_| {
        let begun = Instant::now();
        while !tries(printer, device, "ana", "correct horse").0.is_empty() {
            refused += 1;
            // As long as the refusal says: a person waits so, and their wait is what is measured.
            thread::sleep(Duration::from_secs(1));
        }
        begun.elapsed().as_millis()
    });
    let mut times: Vec<_> = times.collect();
    times.sort_unstable();
    (times, refused)
}

#[test]
#[ignore = "a measurement: cargo test -p hal-tests --test system panel::guesses -- --ignored --nocapture"]
fn a_person_signs_in_while_strangers_guess() {
    if !is_root() {
        return;
    }
    let mut printer = Printer::start("viewer");
    add(&printer, "ana=operator", "correct horse");
    printer.restart("viewer", &["--accounts", ".private/people"]);
    let (_, cookies) = tries(&printer, "", "ana", "correct horse");
    let device = cookies.iter().find(|cookie| cookie.starts_with("ferrule-device-")).unwrap();
    for places in [0, 1, 10, 100_u32] {
        let (tried, ended) = (AtomicUsize::new(0), AtomicBool::new(false));
        let (port, host) = (printer.port, printer.host());
        thread::scope(|scope| {
            let every = Duration::from_secs(1) * places / RATE;
            for n in 0..places {
                let (host, tried, ended) = (&host, &tried, &ended);
                scope.spawn(move || place(FIRST + n, port, host, tried, ended, every));
            }
            for (who, cookie) in [("known device", &**device), ("new device", "")] {
                let begun = Instant::now();
                let (times, refused) = sign_ins(&printer, cookie);
                let (median, most) = (times[SIGN_INS / 2], times[SIGN_INS - 1]);
                println!(
                    "{places} places with {} guesses/s, {who}: median {median} ms, at most {most} ms; told to wait {refused} times; \
                     {} guesses were tried, in {:.1} s",
                    if places == 0 { 0 } else { RATE },
                    tried.load(Relaxed),
                    begun.elapsed().as_secs_f64()
                );
                // Guesses of others make nobody wait who has signed in there before.
                assert!(cookie.is_empty() || refused == 0, "{who}: {times:?}");
            }
            ended.store(true, Relaxed);
        });
    }
}
