//! The client's page of pin values beside an engine that this test plays.
#![expect(unsafe_code, reason = "the test plays the engine, which writes the page")]
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_abi::{PAGE_MAGIC, Page};
use hal_protocol::{PinPage, PinPageInfo};
use rustix::fs::{MemfdFlags, SealFlags, fcntl_add_seals, ftruncate, memfd_create};
use std::sync::atomic::{AtomicU64, Ordering::SeqCst};

const INFO: PinPageInfo = PinPageInfo { pins: 2, is_virtual: false };

fn page() -> PinPage {
    let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
    let fd = memfd_create("hal-test", flags).unwrap();
    ftruncate(&fd, INFO.bytes() as u64).unwrap();
    fcntl_add_seals(&fd, SealFlags::SHRINK).unwrap();
    rustix::io::pwrite(&fd, &PAGE_MAGIC.to_ne_bytes(), 0).unwrap();
    PinPage::map(&fd, INFO, None).unwrap()
}

/// Returns the sequence number and the words of the engine's half.
fn engine(page: &PinPage) -> (&AtomicU64, &[AtomicU64]) {
    let half = page.address().cast::<Page>();
    // SAFETY: the page stays mapped while it is borrowed.
    let sequence = unsafe { &(*half).sequence };
    // SAFETY: as above; each pin has two words.
    (sequence, unsafe { Page::words(half, INFO.pins * 2) })
}

#[test]
fn a_value_is_read_whole_while_the_engine_replaces_it_for_long() {
    let page = page();
    let (sequence, words) = engine(&page);
    words[2].store(7, SeqCst);
    sequence.store(2, SeqCst);
    assert_eq!((page.get(0), page.get(1)), (0, 7));
    // Odd: the engine was stopped in the middle of a record.
    sequence.store(3, SeqCst);
    assert_eq!(page.get(1), 7);
    words[2].store(8, SeqCst);
    assert_eq!(page.get(1), 8);
    assert_eq!(page.get(2), 0, "the page has no such pin");
}

#[test]
fn the_clients_own_value_stands_until_the_engine_has_taken_it() {
    let mut page = page();
    assert!(page.set(1, 5));
    assert!(!page.set(2, 5), "the page has no such pin");
    let value = |page: &PinPage, sequence: u64, bits: u64, count: u64| {
        let (number, words) = engine(page);
        words[2].store(bits, SeqCst);
        words[3].store(count, SeqCst);
        number.store(sequence, SeqCst);
        page.get(1)
    };
    assert_eq!(value(&page, 1, 4, 0), 5);
    assert_eq!(value(&page, 2, 4, 0), 5);
    assert_eq!(
        value(&page, 2, 6, 1),
        6,
        "the engine has taken the value, and a link has replaced it"
    );
    assert!(page.set(1, 9));
    assert_eq!(value(&page, 3, 6, 1), 9);
    assert_eq!(page.own(1), Some(9));
    assert_eq!(page.own(0), None);
}
