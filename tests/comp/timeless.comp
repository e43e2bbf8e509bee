component timeless "Functions without a period.";
pin in s32 in;
pin out s32 out;
function _;
function again;
option period no;
license "MIT";
;;
FUNCTION(_) { long period = in; out = (int)period * 2; }
FUNCTION(again) { _(__comp_inst); out = out + 1; }
