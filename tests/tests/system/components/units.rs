//! The documentation of every float pin and parameter states its unit, that it has none, or its range.

use hal_protocol::Type;
use hal_tests::programs::programs;
use halcmd::manual::man;

/// Words that name a unit, or state that there is none.
const WORDS: &str = "counts cycles degrees fraction hertz k microseconds milliseconds mm ms nanoseconds \
    ns part percent periods pixels pulses radians ratio revolution revolutions rpm seconds steps turns unit \
    units volts °c °f µs";
/// Phrases of several words with the same meaning.
const PHRASES: &[&str] = &[
    "always 0",
    "how many",
    "is not used",
    "number of",
    "per minute",
    "per second",
    "without effect",
];

/// Returns whether a text states the meaning of its number.
fn says(doc: &str) -> bool {
    let text = doc.to_lowercase();
    let letter = |c: char| c.is_alphanumeric() || c == '°';
    let words: Vec<&str> = text.split(|c| !letter(c)).filter(|w| !w.is_empty()).collect();
    let number = |word: &str| word.starts_with(|c: char| c.is_ascii_digit());
    // For example `-1 to 1`, and `1 or 4`.
    let range = |w: &[&str]| matches!(*w, [low, "to" | "or", high] if number(low) && number(high));
    words.iter().any(|w| WORDS.split(' ').any(|unit| unit == *w))
        || PHRASES.iter().any(|p| text.contains(p))
        || words.windows(3).any(range)
}

#[test]
fn every_float_has_a_unit_or_a_range() {
    let mut silent = Vec::new();
    for page in man::pages(&[programs().to_owned()]).unwrap() {
        let floats = page.items.iter().filter(|i| i.ty == Type::Float && !says(&i.doc));
        silent.extend(floats.map(|i| format!("{}: {}", i.first, i.doc)));
    }
    assert!(silent.is_empty(), "{} of them:\n{}", silent.len(), silent.join("\n"));
}

#[test]
fn what_says_it_is_known() {
    for doc in [
        "Highest speed, in units per second; positive.",
        "The gain; no unit.",
        "How much is driven, from -1 to 1.",
        "Always 0: not used.",
        "Temperature, in °C.",
        "Number of samples.",
    ] {
        assert!(says(doc), "{doc}");
    }
    for doc in [
        "The number.",
        "Second number.",
        "Position; 0: any.",
        "The unity of it.",
        "A pin.",
        "A quarter turn on.",
        "",
    ] {
        assert!(!says(doc), "{doc}");
    }
}
