component plans "Of the kind that motmod takes for planning.";
pin out s32 length;
function _;
option tpmod yes;
license "MIT";
;;
length = length + 2;
