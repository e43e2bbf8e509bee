//! A machine test from Rust: its waveform is a text, here in the code itself.

use hal_tests::programs::{programs, root};
use halcmd::programs::haltest::{Options, run_with};

const TURN: &str = "\
xstep                 ‾\\_100_/‾400‾\\_500_/‾800‾\\_900_/‾1200‾\\_1300_/‾1500‾
xdir                  _/‾1000‾
viagpio.sim.reg-4d-4  ‾\\_100_/‾400‾\\_500_/‾800‾\\_900_/‾1200‾\\_1300_/‾1500‾
viagpio.sim.reg-4f-2  _/‾1000‾
";

#[test]
fn a_reversal_of_the_printer() {
    let options = Options { program: Some(programs().join("haltest")), ..Options::default() };
    let outcome = run_with(root().join("configs/printer/tests/reversal.toml"), &options);
    assert!(outcome.passed(), "{outcome}");
    assert_eq!(outcome.drawing("turn"), Some(TURN));
}
