//! The tests of whole programs and machines, in one program: it links once. `tests/README.md` has the map.

mod analysis;
mod architecture;
mod components;
mod dependencies;
mod engine;
mod faults;
mod language;
mod machines;
mod panel;
mod peer;
mod stops;
mod tidy;
mod words;
