component many "More instances than personalities.";
pin out s32 out;
pin in bit second if personality == 2;
function _;
license "MIT";
;;
out = personality;
