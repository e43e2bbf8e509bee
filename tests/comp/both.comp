component both "Whether two bits are true.";
pin in bit in0;
pin in bit in1;
pin out bit out "True if both are.";
function _;
license "MIT";
;;
out = in0 && in1;
