//! The `.hal` language.
