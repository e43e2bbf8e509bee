//! Tests of the plugin on a bench.
