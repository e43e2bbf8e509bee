//! Kinematics of machines whose joints are not axes: arms, parallel machines and five-axis machines.
#![forbid(unsafe_code)]

mod arms;
mod echo;
#[cfg(test)]
mod edges;
mod five_axis;
mod instances;
mod letters;
mod model;
mod names;
mod parallel;
mod rotation;
mod switch;
mod tables;
#[cfg(test)]
mod testing;

pub use arms::armkins::Armkins;
pub use arms::genserkins::Genserkins;
pub use arms::pumakins::Pumakins;
pub use arms::scarakins::Scarakins;
pub use arms::scorbotkins::{ScorbotKins, ScorbotPlain, Scorbotkins};
pub use arms::three21kins::Three21kins;
pub use five_axis::fiveaxiskins::FiveAxiskins;
pub use five_axis::maxkins::Maxkins;
pub use five_axis::trsrnkins::{XyzacbTrsrn, XyzacbTrsrnDashed, XyzbcaTrsrn, XyzbcaTrsrnDashed};
pub use five_axis::trtkins::{XyzacTrt, XyzacTrtPlain, XyzbcTrt, XyzbcTrtPlain};
pub use five_axis::xyzab_tdr_kins::{XyzabTdr, XyzabTdrDashed};
pub use parallel::genhexkins::Genhexkins;
pub use parallel::lineardeltakins::Lineardeltakins;
pub use parallel::pentakins::Pentakins;
pub use parallel::rotarydeltakins::Rotarydeltakins;
pub use parallel::tripodkins::Tripodkins;
pub use tables::corexykins::Corexykins;
pub use tables::matrixkins::Matrixkins;
pub use tables::millturn::Millturn;
pub use tables::rosekins::Rosekins;
pub use tables::rotatekins::Rotatekins;
pub use tables::userkins::Userkins;

hal_component::export!(
    Armkins,
    Corexykins,
    FiveAxiskins,
    Genhexkins,
    Genserkins,
    Lineardeltakins,
    Matrixkins,
    Maxkins,
    Millturn,
    Pentakins,
    Pumakins,
    Rosekins,
    Rotarydeltakins,
    Rotatekins,
    Scarakins,
    ScorbotKins,
    ScorbotPlain,
    Scorbotkins,
    Three21kins,
    Tripodkins,
    Userkins,
    XyzabTdr,
    XyzabTdrDashed,
    XyzacTrt,
    XyzacTrtPlain,
    XyzacbTrsrn,
    XyzacbTrsrnDashed,
    XyzbcTrt,
    XyzbcTrtPlain,
    XyzbcaTrsrn,
    XyzbcaTrsrnDashed,
);
