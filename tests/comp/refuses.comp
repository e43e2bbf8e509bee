component refuses "EXTRA_SETUP may refuse; then nothing stays.";
pin in bit in;
modparam int worst = 3;
function _;
option extra_setup;
license "MIT";
;;
EXTRA_SETUP() {
    if (extra_arg >= worst) {
        rtapi_print_msg(RTAPI_MSG_ERR, "%s: no more than %d\n", prefix, worst);
        return -ENODEV;
    }
    return 0;
}
FUNCTION(_) {}
