component cleans_up "EXTRA_CLEANUP runs when it is unloaded, and when making it failed.";
pin in bit in-#[2 : personality];
function _;
option extra_cleanup yes;
license "MIT";
;;
EXTRA_CLEANUP() { rtapi_print_msg(RTAPI_MSG_ERR, "cleaned up\n"); }
FUNCTION(_) {}
