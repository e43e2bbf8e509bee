//! Mills whose rotary axes tilt the tool or the table. `tips.rs` is shared by those with one axis for each letter.

pub(crate) mod fiveaxiskins;
pub(crate) mod maxkins;
pub(crate) mod tips;
pub(crate) mod trsrnkins;
pub(crate) mod trtkins;
pub(crate) mod xyzab_tdr_kins;
