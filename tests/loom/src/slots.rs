//! The slots between a trajectory's planner and its follower.

#[path = "../../../components/motion/trajectory/src/slots.rs"]
mod real;

use loom::{sync::Arc, thread};
use real::{Order, Slots};

/// A raised word is seen only together with the slots that it needs.
#[test]
fn a_raised_end_shows_the_cells_behind_it() {
    loom::model(|| {
        let shared = Arc::new((Order::new(), Slots::<2>::new(4)));
        let (order, slots) = &*shared;
        slots.fill(0, &[10, 0]);
        order.publish(1);
        let writer = {
            let shared = Arc::clone(&shared);
            thread::spawn(move || {
                let (order, slots) = &*shared;
                slots.fill(1, &[11, 0]);
                order.publish(2);
                slots.set(0, 1, 1);
            })
        };
        if slots.read::<1>(0) == Some([10, 1]) {
            assert_eq!(order.count(), 2);
        }
        if order.count() == 2 {
            assert_eq!(slots.read::<1>(1), Some([11, 0]));
        }
        writer.join().unwrap();
    });
}

/// A slot is filled again only after the reader has let it go.
#[test]
fn no_slot_is_overwritten_in_use() {
    loom::model(|| {
        let shared = Arc::new((Order::new(), Slots::<1>::new(2)));
        let (order, slots) = &*shared;
        slots.fill(0, &[10]);
        slots.fill(1, &[11]);
        order.publish(2);
        let writer = {
            let shared = Arc::clone(&shared);
            thread::spawn(move || {
                let (order, slots) = &*shared;
                if order.oldest() >= 1 {
                    order.give_up(1);
                    slots.fill(2, &[12]);
                    order.publish(3);
                }
            })
        };
        assert!(slots.words(0).eq([10]));
        order.release(1);
        assert!(slots.words(1).eq([11]));
        if order.count() == 3 {
            assert!(slots.words(2).eq([12]));
        }
        writer.join().unwrap();
    });
}

/// While the reader may move backward, the limits of that motion do not change.
#[test]
fn reverse_motion_sees_settled_limits() {
    loom::model(|| {
        let shared = Arc::new((Order::new(), Slots::<1>::new(2)));
        let (order, slots) = &*shared;
        slots.fill(0, &[10]);
        slots.fill(1, &[5]);
        order.publish(2);
        order.release(1);
        let writer = {
            let shared = Arc::clone(&shared);
            thread::spawn(move || {
                let (order, slots) = &*shared;
                for first in [1, 2] {
                    if order.settle() {
                        order.give_up(first);
                        slots.set(1, 0, 5 - first);
                    }
                }
            })
        };
        for _ in 0..2 {
            if order.may_turn(true) {
                let (first, limit) = (order.first(), slots.read::<0>(1));
                assert_eq!(limit, Some([5 - first]));
                assert_eq!((order.first(), slots.read::<0>(1)), (first, limit));
                let _ = order.may_turn(false);
                break;
            }
        }
        writer.join().unwrap();
    });
}
