component new_bits "The new type bool: NAME reads, NAME_set writes.";
pin in bool a;
pin in bool b = true;
pin out bool both_;
pin io bool flip = yes;
param rw bool invert;
param r bool last;
function _;
license "MIT";
;;
FUNCTION(_) {
    int v = a && b;
    if (invert) v = !v;
    both__set(v);
    flip_set(!flip);
    last_set(both_);
}
