component made_later "Offers to make instances after loading.";
pin in s32 in;
pin out s32 out;
function _;
option constructable yes;
option extra_setup yes;
variable long given;
license "MIT";
;;
EXTRA_SETUP() { (void)prefix; given = extra_arg; return 0; }
FUNCTION(_) { out = in + (int)given; }
