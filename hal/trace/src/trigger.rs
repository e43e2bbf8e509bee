//! Triggers: conditions for the start of a capture, as text and as a state machine over samples.
//!
//! ```text
//! stepgen.0.step rises            a bit becomes true; falls, toggles
//! enable                          a bit is true; not enable
//! x.pos > 5                       <, <=, >, >=, =, !=: of every type
//! x.pos rises through 5           was below and is not any more; falls through, crosses
//! x.pos in -1..1                  both ends included; outside: neither
//! tool changes                    is another than at the sample before
//! x.pos > 5 and not enable        not, and, or, in this order; ( ) group
//! 'a name' rises                  a name with blanks, or one that is a word of this language
//! ```
//!
//! A [`Condition`] is the parsed text. [`Condition::bind`] checks it against channels and returns a
//! [`When`], which evaluates the condition for two successive samples. A [`Trigger`] adds the
//! features of an oscilloscope: the share of samples before the trigger, hold-off, force, and the
//! modes. A [`Capture`] also stores the samples and returns traces. The trigger allocates no memory
//! per sample; a capture allocates memory for the samples that it stores.
//!
//! The trigger must receive every sample. An edge, change or crossing happens at the first sample
//! that shows it. If samples were lost before that one, the gap in the trace gives their number. A
//! comparison with NaN is false, except `!=`. The first sample has no predecessor, so there is no
//! edge at it.
//!
//! ```
//! use hal_protocol::Type;
//! use hal_trace::trigger::{Capture, Condition, Mode, Setup};
//!
//! let channels = [("pos".to_owned(), Type::Float), ("enable".to_owned(), Type::Bit)];
//! let when = Condition::parse("pos > 2.5 and enable")?.bind(&channels)?;
//! let setup = Setup { length: 4, before: 1, mode: Mode::Single, ..Setup::default() };
//! let mut capture = Capture::new(&channels, Some(when), setup);
//! let traces = (0..10_u8).filter_map(|n| {
//!     capture.feed(i64::from(n) * 1000, &[f64::from(n).to_bits(), 1], 0)
//! });
//! let traces: Vec<_> = traces.collect();
//! assert_eq!(traces[0].times().iter().collect::<Vec<_>>(), [2000, 3000, 4000, 5000]);
//! assert_eq!(traces[0].markers()[0].at, 3000);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod capture;
mod condition;
mod lex;
mod machine;
mod when;

pub use capture::Capture;
pub use condition::{Condition, ConditionError};
pub use machine::{Cause, HoldOff, Mode, Setup, Step, Trigger};
pub use when::When;
