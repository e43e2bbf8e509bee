component new_reals "The new type real.";
pin in real in;
pin in real gain = 1.5;
pin out real out;
pin io real held = -1.0;
param rw real limit = 1e3;
param r real over;
function _;
license "MIT";
;;
real_t v = in * gain;
if (v > limit) { over_set(v - limit); v = limit; }
out_set(v);
held_set(held + hal_get_real(in_ptr));
