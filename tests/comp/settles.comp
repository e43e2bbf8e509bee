component settles "Debounces a bit: a machine of states, in C of its own.";
pin in bit in;
pin out bit out;
pin out s32 state;
param rw u32 delay = 3 "Cycles that the input must stay.";
variable unsigned left;
variable int now;
function _;
license "MIT";
;;
enum { LOW, RISING, HIGH, FALLING };

static int next(int from, int level, unsigned *rest, unsigned wait)
{
    switch (from) {
    case LOW:
        if (level) { *rest = wait; return RISING; }
        return LOW;
    case RISING:
        if (!level) return LOW;
        return --*rest ? RISING : HIGH;
    case HIGH:
        if (!level) { *rest = wait; return FALLING; }
        return HIGH;
    default:
        if (level) return HIGH;
        return --*rest ? FALLING : LOW;
    }
}

FUNCTION(_) {
    now = next(now, in, &left, delay ? delay : 1);
    out = now == HIGH || now == FALLING;
    state = now;
}
