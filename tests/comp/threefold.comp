component threefold;
pin out s32 which;
variable int mine = -1;
function _;
option default_count 3;
license "MIT";
;;
static int next;
FUNCTION(_) {
    if (mine < 0) mine = next++;
    which = mine;
}
