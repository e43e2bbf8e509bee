component mod_ints "Numbers given at loading.";
pin out s32 out;
modparam int base = 40 "Where it begins.";
modparam int step;
function _;
license "MIT";
;;
out = base + step;
