//! Commutation and transforms of three-phase motors.
#![forbid(unsafe_code)]

mod bldc;
mod clarke2;
mod clarke3;
mod clarkeinv;
#[cfg(test)]
mod closed;
mod commutate;
mod drive;
mod hall;
mod letters;

hal_component::export!(bldc::Bldc, clarke2::Clarke2, clarke3::Clarke3, clarkeinv::Clarkeinv);
