//! A snapshot beside a component that this test plays.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_abi::PAGE_MAGIC;
use hal_protocol::{FieldInfo, Snapshot, SnapshotInfo, Type, Value};
use rustix::fs::{MemfdFlags, SealFlags, fcntl_add_seals, ftruncate, memfd_create};
use std::{os::fd::OwnedFd, thread};

/// Offset of the sequence number, and of the first word.
const SEQUENCE: u64 = 16;
const FIRST: u64 = 64;

fn put(page: &OwnedFd, at: u64, word: u64) {
    rustix::io::pwrite(page, &word.to_ne_bytes(), at).unwrap();
}

#[test]
fn a_record_is_awaited_whose_component_is_suspended_in_the_middle() {
    let page = memfd_create("hal-test", MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING).unwrap();
    ftruncate(&page, FIRST + 8).unwrap();
    fcntl_add_seals(&page, SealFlags::SHRINK).unwrap();
    put(&page, 0, PAGE_MAGIC);
    // Version 1, with one word.
    put(&page, 8, 1 | 1 << 32);
    let text = String::new;
    let fields = vec![FieldInfo { name: text(), ty: Type::U64, count: 1, doc: text() }];
    let info = SnapshotInfo { name: text(), owner_name: text(), version: 1, doc: text(), fields };
    let snapshot = Snapshot::map(&page, info).unwrap();

    let mut out = Vec::new();
    assert_eq!((snapshot.wait(&mut out), &*out), (Some(0), &[Value::U64(0)][..]));
    // Odd: the component is in the middle of a record.
    put(&page, FIRST, 6);
    put(&page, SEQUENCE, 3);
    assert_eq!((snapshot.read(&mut out), &*out), (None, &[][..]));
    assert_eq!(
        (snapshot.wait(&mut out), &*out),
        (None, &[][..]),
        "it ends the wait after a second"
    );
    let component = thread::spawn(move || {
        put(&page, FIRST, 7);
        put(&page, SEQUENCE, 4);
    });
    assert_eq!((snapshot.wait(&mut out), &*out), (Some(2), &[Value::U64(7)][..]));
    component.join().unwrap();
}
