//! Packets that no card sent, between those of the card: none changes a pin.

use super::{Rig, last_card, names::value};
use hal_lbp16::MAX_PACKET;

/// Numbers of chance that are the same in every run.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, n: usize) -> usize {
        usize::try_from(self.next() >> 32).unwrap() % n
    }
}

/// Returns a packet that is no answer to the question under way: of chance, or an earlier answer that was cut, made longer, or
/// given another number.
fn noise(chance: &mut Chance, earlier: &[u8]) -> Vec<u8> {
    let mut packet = earlier.to_vec();
    match chance.below(4) {
        0 => {
            let len = chance.below(MAX_PACKET + 1);
            // Its length alone tells it from an answer.
            let len = if len == earlier.len() { len + 1 } else { len };
            packet = (0..len).map(|_| chance.next().to_le_bytes()[5]).collect();
        }
        1 => packet.truncate(chance.below(earlier.len())),
        2 => packet.push(0),
        // An earlier answer as it was: late, or doubled.
        _ => {}
    }
    packet.truncate(MAX_PACKET);
    packet
}

const CYCLES: i32 = 340_000;

#[test]
fn a_million_strange_packets_change_no_pin() {
    let mut chance = Chance(0x9E37_79B9_7F4A_7C15);
    let (quiet, loud) = (Rig::new("7i92"), Rig::new("7i92"));
    // The card of the rig that was made last.
    let card = last_card();
    let mut packets = 0;
    let mut earlier = Vec::new();
    for n in 0..CYCLES {
        for rig in [&quiet, &loud] {
            rig.set("sim.encoder.00.counts", n.wrapping_mul(3));
            rig.set("sim.in-010", n % 7 < 3);
        }
        quiet.cycle();
        let strange: Vec<Vec<u8>> = if earlier.is_empty() {
            Vec::new()
        } else {
            (0..3)
                .map(|_| noise(&mut chance, &earlier))
                .filter(|packet| !packet.is_empty())
                .collect()
        };
        packets += strange.len();
        card.with(|inside| strange.iter().for_each(|packet| inside.inject(packet))).unwrap();
        loud.cycle();
        earlier = card.with(|inside| inside.last_answer().to_vec()).unwrap();
        if n % 997 == 0 || n == CYCLES - 1 {
            for item in quiet.bench.names() {
                let mut words = item.split(' ');
                let (name, ty) = (words.next().unwrap(), words.next().unwrap());
                // Times of the question and its answer are those of the computer.
                if !name.contains(".packet-") {
                    let values = [&quiet, &loud].map(|rig| value(&rig.bench, name, ty));
                    assert_eq!(values[0], values[1], "{n}: {name}");
                }
            }
        }
        let seen = [&quiet, &loud].map(|rig| (rig.int("encoder.00.count"), rig.bit("gpio.010.in")));
        assert_eq!(seen[0], seen[1], "{n}");
        assert!(!loud.bit("packet-error"), "{n}");
    }
    assert!(packets > 1_000_000, "{packets}");
}
