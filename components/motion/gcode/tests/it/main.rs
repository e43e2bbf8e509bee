//! Programs as data: what they give, what they give in the reference, and what their state is on the way.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]
#![expect(clippy::print_stderr, reason = "the report of a comparison")]

mod axes;
mod changer;
mod comments;
mod contours;
mod foreign;
mod golden;
mod input;
mod oracle;
mod plane;
mod rs274d;
mod state;
mod support;
mod ticks;
mod turning;
mod world;
