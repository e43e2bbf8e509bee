//! Byte queues: capacity, all-or-nothing transfers, wrap-around.
#![expect(unsafe_code, clippy::cast_possible_truncation, reason = "queues over memory")]

use core::sync::atomic::AtomicU8;
use hal_abi::PortQueue;

struct Made {
    queue: PortQueue,
    _data: Box<[AtomicU8]>,
}

fn queue(size: usize) -> Made {
    let data: Box<[AtomicU8]> = (0..size).map(|_| AtomicU8::new(0)).collect();
    // SAFETY: both live in the returned value, and moving a box does not move its contents.
    let queue = unsafe { PortQueue::new(data.as_ptr(), size as u64) };
    Made { queue, _data: data }
}

#[test]
fn a_queue_holds_one_byte_less_than_its_size() {
    for size in [1_u64, 2, 3, 7, 64] {
        let q = &queue(usize::try_from(size).unwrap_or(0)).queue;
        assert_eq!((q.size(), q.readable(), q.writable()), (size, 0, size - 1));
        for _ in 0..3 * size {
            assert!((1..size).all(|n| q.write(&[n as u8])), "{size}");
            assert_eq!((q.readable(), q.writable()), (size - 1, 0));
            assert!(!q.write(&[0]), "{size}: it is full");
            let mut byte = [0];
            assert!((1..size).all(|n| q.read(&mut byte) && byte == [n as u8]), "{size}");
            assert!(!q.read(&mut byte), "{size}: it is empty");
        }
    }
}

#[test]
fn bytes_go_in_and_out_whole_or_not_at_all() {
    let q = &queue(8).queue;
    assert!(q.write(b"hello"));
    assert!(!q.write(b"you"), "two fit");
    assert_eq!((q.readable(), q.writable()), (5, 2));
    let mut six = [b'-'; 6];
    assert!(!q.read(&mut six) && !q.peek(&mut six));
    assert_eq!((&six, q.readable()), (b"------", 5), "untouched");
    let mut two = [0; 2];
    assert!(q.peek(&mut two) && q.peek(&mut two));
    assert_eq!((&two, q.readable()), (b"he", 5), "left there");
    assert!(q.read(&mut two));
    assert_eq!((&two, q.readable()), (b"he", 3));
    // Around the end of the memory.
    assert!(q.write(b"worl"));
    let mut seven = [0; 7];
    assert!(q.read(&mut seven));
    assert_eq!(&seven, b"lloworl");
    assert!(q.write(b"") && q.read(&mut []), "nothing always fits");
    assert!(q.write(b"1234567"));
    q.clear();
    assert_eq!((q.readable(), q.writable()), (0, 7));
}

#[test]
fn bytes_keep_their_order_between_threads() {
    let made = queue(16);
    let q = &made.queue;
    let total = 30_000_u32;
    std::thread::scope(|scope| {
        scope.spawn(move || {
            for n in 0..total {
                while !q.write(&n.to_le_bytes()) {
                    core::hint::spin_loop();
                }
            }
        });
        let mut word = [0; 4];
        for n in 0..total {
            while !q.read(&mut word) {
                core::hint::spin_loop();
            }
            assert_eq!(u32::from_le_bytes(word), n);
        }
    });
    assert_eq!(q.readable(), 0);
}
