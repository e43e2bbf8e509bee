//! Torches and lasers: torch height control, plasma cutting, laser power and raster engraving.
#![forbid(unsafe_code)]

mod height;
mod laserpower;
mod ohmic;
mod pixels;
mod plasmac;
mod raster;
mod thc;
mod thcud;

hal_component::export!(
    laserpower::Laserpower,
    ohmic::Ohmic,
    plasmac::Plasmac,
    raster::Raster,
    thc::Thc,
    thcud::Thcud
);
