//! Parallel machines: deltas, tripods, hexapods. `struts.rs` solves for the pose, `circles.rs` intersects links.

pub(crate) mod circles;
pub(crate) mod genhexkins;
pub(crate) mod genhexpins;
pub(crate) mod lineardeltakins;
pub(crate) mod pentakins;
pub(crate) mod rotarydeltakins;
pub(crate) mod struts;
pub(crate) mod tripodkins;
