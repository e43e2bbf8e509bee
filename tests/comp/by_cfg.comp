component by_cfg "As many as its own parameter says.";
pin out s32 index;
modparam int channels = 2 "How many.";
function _;
option count_function;
option extra_setup yes;
variable int mine;
license "MIT";
;;
int get_count(void) { return channels; }
EXTRA_SETUP() { (void)prefix; mine = (int)extra_arg; return 0; }
FUNCTION(_) { index = mine; }
