//! The simulated card against closed forms, a model that runs tick by tick, and random packets.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]
#![expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "values are small")]

mod bench;
mod boards;
mod counters;
mod levels;
mod oracle;
mod packets;
mod remotes;
mod stepping;
