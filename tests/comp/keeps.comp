component keeps "Variables: of several types, arrays, pointers, with first values and without.";
pin in float in;
pin out float mean "Of the last four.";
pin out s32 runs;
pin out bit same;
variable double ring[4] = 1.0;
variable int at;
variable unsigned long long so_far = 10;
variable double *newest;
variable const char **unused;
variable hal_u32_t kept = 3;
function _;
license "MIT";
;;
FUNCTION(_) {
    double all = 0;
    int i;
    ring[at] = in;
    newest = &ring[at];
    at = (at + 1) % 4;
    for (i = 0; i < 4; i++) all += ring[i];
    mean = all / 4;
    so_far++;
    runs = (int)so_far + (int)kept;
    same = *newest == in && unused == 0;
}
