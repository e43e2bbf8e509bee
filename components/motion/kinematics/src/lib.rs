//! Kinematics of machines whose joints are not axes: arms, parallel machines and five-axis machines.
#![forbid(unsafe_code)]

mod arm;
mod circles;
mod corexykins;
mod dh;
mod echo;
#[cfg(test)]
mod edges;
mod fiveaxiskins;
mod genhexkins;
mod genhexpins;
mod genserkins;
mod instances;
mod letters;
mod lineardeltakins;
mod matrixkins;
mod maxkins;
mod millturn;
mod model;
mod names;
mod pentakins;
mod pumakins;
mod rosekins;
mod rotarydeltakins;
mod rotatekins;
mod rotation;
mod scarakins;
mod scorbotkins;
mod search;
mod struts;
mod switch;
#[cfg(test)]
mod testing;
mod three21kins;
mod tips;
mod tripodkins;
mod trsrnkins;
mod trtkins;
mod userkins;
mod xyzab_tdr_kins;

pub use corexykins::Corexykins;
pub use fiveaxiskins::FiveAxiskins;
pub use genhexkins::Genhexkins;
pub use genserkins::Genserkins;
pub use lineardeltakins::Lineardeltakins;
pub use matrixkins::Matrixkins;
pub use maxkins::Maxkins;
pub use millturn::Millturn;
pub use pentakins::Pentakins;
pub use pumakins::Pumakins;
pub use rosekins::Rosekins;
pub use rotarydeltakins::Rotarydeltakins;
pub use rotatekins::Rotatekins;
pub use scarakins::Scarakins;
pub use scorbotkins::{ScorbotKins, ScorbotPlain, Scorbotkins};
pub use three21kins::Three21kins;
pub use tripodkins::Tripodkins;
pub use trsrnkins::{XyzacbTrsrn, XyzacbTrsrnDashed, XyzbcaTrsrn, XyzbcaTrsrnDashed};
pub use trtkins::{XyzacTrt, XyzacTrtPlain, XyzbcTrt, XyzbcTrtPlain};
pub use userkins::Userkins;
pub use xyzab_tdr_kins::{XyzabTdr, XyzabTdrDashed};

hal_component::export!(
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
