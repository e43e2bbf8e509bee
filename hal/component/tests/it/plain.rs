//! Words of plain records.

use hal_component::{Plain, fields};

#[derive(Clone, Copy, Plain)]
struct Record {
    /// Number.
    number: u64,
    /// Place in units.
    place: [f64; 2],
    /// True while it moves.
    moves: bool,
}

#[test]
fn some_fields_pass_their_own_words() {
    const SOME: u128 = fields::<Record>(&["moves", "number"]);
    let record = Record { number: 7, place: [1.0, 2.0], moves: true };
    let mut some = Vec::new();
    record.store_some::<SOME>(&mut |at, bits| some.push((at, bits)));
    assert_eq!(some, [(0, 7), (3, 1)]);
    let (mut all, mut words) = (Vec::new(), Vec::new());
    record.store_some::<{ u128::MAX }>(&mut |at, bits| all.push((at, bits)));
    record.store(&mut |bits| words.push((words.len(), bits)));
    assert_eq!(all, words);
}
