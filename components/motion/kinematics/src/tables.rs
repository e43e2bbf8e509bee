//! Machines whose joints are combinations of axes: rotated, coupled or given by a matrix.

pub(crate) mod corexykins;
pub(crate) mod matrixkins;
pub(crate) mod millturn;
pub(crate) mod rosekins;
pub(crate) mod rotatekins;
pub(crate) mod userkins;
