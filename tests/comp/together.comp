component together "One function looks at all instances.";
pin in s32 in;
pin out s32 sum "Of all.";
pin out s32 place "Of this one.";
function _;
license "MIT";
;;
static int total(void)
{
    int all = 0;
    FOR_ALL_INSTS() all += in;
    return all;
}
FUNCTION(_) {
    struct __comp_state *mine = __comp_inst;
    int n = 0, at = 0;
    sum = total();
    FOR_ALL_INSTS() {
        if (__comp_inst == mine) at = n;
        n++;
    }
    place = at;
}
