//! Realtime. Rotations: those of `hal-arm`.

pub(crate) use hal_arm::rotation::{
    Matrix, Vector, about, about_x, about_y, about_z, from_abc, is_straight, near, to_abc,
    to_vector,
};
