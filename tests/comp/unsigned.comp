component unsigned "Variables of the short names for unsigned types.";
pin in bit step;
pin out u32 total;
pin out u32 wrapped;
variable uint steps;
variable ushort small = 65535;
variable ulong large;
function _ nofp;
license "MIT";
;;
FUNCTION(_) {
    if (step) {
        steps += 1;
        small += 1;
        large += 2;
    }
    total = steps + (uint)large;
    wrapped = small;
}
