component own_main "The C text has its own beginning and end.";
pin in s32 in;
pin out s32 out;
variable int add;
function _;
option rtapi_app no;
option extra_setup yes;
license "MIT";
;;
static int first = 3;
RTAPI_MP_INT(first, "What the first one adds.");
static char *label[2] = {0, 0};
RTAPI_MP_ARRAY_STRING(label, 2, "What the two are called.");

int rtapi_app_main(void) {
    int rc, i;
    comp_id = hal_init("own_main");
    if (comp_id < 0) return comp_id;
    for (i = 0; i < 2; i++) {
        char name[HAL_NAME_LEN + 1];
        rtapi_snprintf(name, sizeof(name), "own.%s", label[i] ? label[i] : i ? "second" : "first");
        rc = export(name, first + i);
        if (rc != 0) {
            hal_exit(comp_id);
            return rc;
        }
    }
    hal_ready(comp_id);
    return 0;
}

void rtapi_app_exit(void) { hal_exit(comp_id); }

EXTRA_SETUP() { (void)prefix; add = (int)extra_arg; return 0; }
FUNCTION(_) { out = in + add; }
