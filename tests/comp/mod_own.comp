component mod_own "Parameters that the C text declares itself.";
pin out s32 letters;
pin out s32 total;
pin out float ratio;
modparam dummy word "A word.";
modparam dummy list "Up to four numbers.";
function _;
license "MIT";
;;
static char *word = "none";
RTAPI_MP_STRING(word, "A word.");
static int list[4] = {1, 1, 1, 1};
RTAPI_MP_ARRAY_INT(list, 4, "Up to four numbers.");
static long big = 3;
RTAPI_MP_LONG(big, "A long one.");
FUNCTION(_) {
    letters = (int)strlen(word);
    total = list[0] + list[1] + list[2] + list[3];
    ratio = (double)big / 2;
}
