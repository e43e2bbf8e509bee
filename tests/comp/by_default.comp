component by_default "The personality of those that are given none.";
pin in bit in-#[8 : personality];
pin out s32 out;
function _;
option default_personality 3;
option default_count 2;
license "MIT";
;;
out = personality;
