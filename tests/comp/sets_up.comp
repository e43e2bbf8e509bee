component sets_up "EXTRA_SETUP chooses the personality, and sees prefix and number.";
pin in float in-#[8 : personality & 15];
pin out float sum;
pin out s32 number;
pin out s32 letters;
variable int n;
variable int l;
function _;
option extra_setup yes;
license "MIT";
;;
EXTRA_SETUP() {
    n = (int)extra_arg;
    l = (int)strlen(prefix);
    if (personality == 0) personality = 4;
    return 0;
}
FUNCTION(_) {
    double all = 0;
    int i;
    for (i = 0; i < (personality & 15); i++) all += in(i);
    sum = all;
    number = n;
    letters = l;
}
