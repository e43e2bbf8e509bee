component told_after "POST_EXPORT runs when an instance is whole: it may use its pins.";
pin out s32 out;
pin in s32 in = 5;
function _;
option post_export yes;
license "MIT";
;;
POST_EXPORT() {
    (void)prefix;
    out = in * 100 + (int)extra_arg;
}
FUNCTION(_) { out = out + 1; }
