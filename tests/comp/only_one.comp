component only_one "There is one of it, and it is called so.";
pin in s32 in;
pin out s32 out;
function _;
function extra_work;
option singleton yes;
license "MIT";
;;
FUNCTION(_) { out = in + 1; }
FUNCTION(extra_work) { out = out * 10; }
