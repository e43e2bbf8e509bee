component width_of "As many inputs as its personality says.";
pin in bit in-##[16 : personality];
pin out unsigned number "Inputs as a number, in-00 lowest.";
function _;
license "MIT";
;;
FUNCTION(_) {
    unsigned all = 0;
    int i;
    for (i = 0; i < personality; i++)
        if (in(i)) all |= 1u << i;
    number = all;
}
