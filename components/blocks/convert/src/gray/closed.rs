//! Test of `bin2gray` and `gray2bin` against the definition of the reflected code (Gray, US patent 2632058, 1953): each
//! number differs from the next in one bit, and the codes of 2ⁱ numbers are those of 2ⁱ⁻¹ followed by the same in
//! reverse order with one more bit set.

use super::{Bin2gray, Gray2bin};
use hal_bench::{Bench, Random};
use hal_component::Component;

struct Rig(Bench, &'static str);

impl Rig {
    fn new<C: Component>() -> Self {
        let mut bench = Bench::new();
        bench.load::<C>(&[]).unwrap();
        Self(bench, C::NAME)
    }

    fn of(&self, n: u32) -> u32 {
        let Self(bench, name) = self;
        bench.set(&format!("{name}.0.in"), n);
        bench.run(&format!("{name}.0"), 1_000_000);
        bench.get(&format!("{name}.0.out"))
    }
}

fn numbers() -> Vec<u32> {
    let mut random = Random::new(1);
    let edges = (0..32).flat_map(|i| [(1 << i) - 1, 1 << i, u32::MAX >> i, u32::MAX << i]);
    (0..300).chain(edges).chain((0..3000).map(|_| (random.word() >> 32) as u32)).collect()
}

/// The last number and the first are neighbours as well.
#[test]
fn neighbours_differ_in_one_bit() {
    let gray = Rig::new::<Bin2gray>();
    for n in numbers() {
        assert_eq!((gray.of(n) ^ gray.of(n.wrapping_add(1))).count_ones(), 1, "{n}");
    }
}

#[test]
fn each_half_is_the_other_reflected() {
    let gray = Rig::new::<Bin2gray>();
    assert_eq!(gray.of(0), 0);
    for n in numbers().into_iter().filter(|n| *n > 0) {
        let top = 1 << n.ilog2();
        assert_eq!(gray.of(n), top + gray.of(top - 1 - (n - top)), "{n}");
    }
}

#[test]
fn each_undoes_the_other() {
    let (gray, binary) = (Rig::new::<Bin2gray>(), Rig::new::<Gray2bin>());
    for n in numbers() {
        assert_eq!(binary.of(gray.of(n)), n);
        assert_eq!(gray.of(binary.of(n)), n);
    }
}
