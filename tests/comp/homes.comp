component homes "Of the kind that motmod takes for homing: one, without arguments.";
pin out s32 homed;
function _;
option homemod yes;
license "MIT";
;;
homed = 1;
