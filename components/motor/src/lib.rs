//! Commutation and transforms of three-phase motors.
#![forbid(unsafe_code)]

mod clarke2;
mod clarke3;
mod clarkeinv;

hal_component::export!(clarke2::Clarke2, clarke3::Clarke3, clarkeinv::Clarkeinv);
