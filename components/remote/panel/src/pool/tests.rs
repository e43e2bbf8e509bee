//! Work that never ends beside work that is short, in a time of the test's own.

use super::{
    Code, Duration, Limit, MAX_MEMORY, MAX_OWN_SEATS, MAX_SEATS, MAX_TIME, OWN_MEMORY, Pool, TURN,
    Work,
};
use crate::error::Error;
use std::sync::{
    Arc,
    atomic::{AtomicBool, AtomicU64, Ordering::Relaxed},
};
use tokio::runtime;

/// Returns a pool whose clock shows these milliseconds.
fn pool() -> (Pool, Arc<AtomicU64>) {
    let time = Arc::new(AtomicU64::new(0));
    let shown = time.clone();
    (Pool::on(Box::new(move || Duration::from_millis(shown.load(Relaxed)))), time)
}

/// Runs a future; its end waits for all work.
fn run<T>(work: impl Future<Output = T>) -> T {
    runtime::Builder::new_current_thread().enable_all().build().unwrap().block_on(work)
}

fn is_empty(pool: &Pool) -> bool {
    let state = pool.0.lock();
    state.seats.is_empty() && state.memory == 0 && state.turn.is_none() && state.line.is_empty()
}

/// Works until it is ended, a millisecond from look to look, and notes a turn that has lasted on though others waited for theirs.
fn endless(
    time: Arc<AtomicU64>,
    kept: Arc<AtomicBool>,
) -> impl FnOnce(&mut Work) -> Result<(), Error> {
    move |work| {
        loop {
            time.fetch_add(1, Relaxed);
            // Far from the limit of time.
            work.taken = Duration::ZERO;
            let (others_wait, since) = (!work.shared.lock().line.is_empty(), work.since);
            let now = (work.shared.clock)();
            let is_long = since.is_some_and(|since| now.saturating_sub(since) > TURN);
            work.look(1000)?;
            if others_wait && is_long && work.since == since {
                kept.store(true, Relaxed);
            }
        }
    }
}

#[test]
fn work_that_never_ends_lets_others_pass_and_ends_with_its_request() {
    let ((pool, time), kept) = (pool(), Arc::new(AtomicBool::new(false)));
    run(async {
        let all = async {
            let each = (0..MAX_OWN_SEATS)
                .map(|_| pool.run("mallory", endless(time.clone(), kept.clone())));
            let mut each: Vec<_> = each.map(Box::pin).collect();
            for one in &mut each {
                let began =
                    core::future::poll_fn(|cx| core::task::Poll::Ready(one.as_mut().poll(cx)));
                assert!(began.await.is_pending());
            }
            core::future::pending::<()>().await;
            drop(each);
        };
        let short = async {
            for n in 0..20 {
                let done = pool.run("ana", move |work| {
                    work.look(n)?;
                    Ok(n)
                });
                assert_eq!(done.await.unwrap().0, n);
            }
            // Before the others go, and their turns with them.
            assert!(!kept.load(Relaxed), "a turn lasts while others wait");
        };
        tokio::select! {
            biased;
            () = all => unreachable!(),
            () = short => {}
        }
    });
    assert!(is_empty(&pool), "{pool:?}");
}

#[test]
fn work_that_waits_for_its_turn_ends_with_its_request() {
    let (pool, _) = pool();
    run(async {
        let first = pool.run("ana", |work| {
            // Until the other one has gone.
            while work.shared.lock().numbers < 2 || !work.shared.lock().line.is_empty() {
                work.look(0)?;
            }
            Ok(())
        });
        let second = async {
            // It would never end, even if its turn comes at once.
            let endless = |work: &mut Work| -> Result<(), Error> {
                loop {
                    work.look(0)?;
                }
            };
            let mut waits = Box::pin(pool.run("eva", endless));
            let state =
                core::future::poll_fn(|cx| core::task::Poll::Ready(waits.as_mut().poll(cx)));
            assert!(state.await.is_pending());
            drop(waits);
        };
        let (done, ()) = tokio::join!(first, second);
        done.unwrap();
    });
    assert!(is_empty(&pool), "{pool:?}");
}

#[test]
fn nobody_takes_the_seats_of_others() {
    let (pool, _) = pool();
    let code = |user: &str| pool.seat(user).err().map(|e| e.code);
    let own: Vec<_> = (0..MAX_OWN_SEATS).map(|_| pool.seat("mallory").unwrap()).collect();
    assert_eq!((code("mallory"), code("ana")), (Some(Code::TooMany), None));
    let others: Vec<_> = (0..MAX_SEATS - MAX_OWN_SEATS)
        .map(|n| pool.seat(&format!("user {}", n / MAX_OWN_SEATS)).unwrap())
        .collect();
    assert_eq!(code("ana"), Some(Code::TooMany));
    drop((own, others));
    assert!(is_empty(&pool), "{pool:?}");
}

#[test]
fn time_counts_in_turns_and_memory_in_all() {
    let (pool, time) = pool();
    let most = u64::try_from(MAX_TIME.as_millis()).unwrap();
    let clock = time.clone();
    let waits = run(pool.run("ana", move |work| {
        for _ in 0..3 {
            work.apart(|| clock.fetch_add(most, Relaxed))?;
            work.look(0)?;
        }
        Ok(())
    }));
    assert!(waits.is_ok(), "time outside its turns is not its own");
    drop(waits);
    let clock = time.clone();
    let long = run(pool.run("ana", move |work| {
        clock.fetch_add(most + 1, Relaxed);
        work.look(0)?;
        Ok(())
    }));
    assert_eq!(long.err().map(|e| e.code), Some(Code::TooLarge));

    let mut large = pool.seat("ana").unwrap();
    large.take(MAX_MEMORY).unwrap();
    let mut small = pool.seat("eva").unwrap();
    small.take(OWN_MEMORY).unwrap();
    assert_eq!(small.take(OWN_MEMORY + 1), Err(Limit::Memory));
    large.take(OWN_MEMORY).unwrap();
    small.take(MAX_MEMORY - OWN_MEMORY).unwrap();
    assert_eq!(large.take(OWN_MEMORY + 1), Err(Limit::Memory));
    drop((large, small));
    assert!(is_empty(&pool), "{pool:?}");
}
