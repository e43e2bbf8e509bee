component clocked "What functions know of time.";
pin out float secs "Since it began to run.";
pin out s32 ns "The thread's period.";
pin out bit whole "At every full second.";
variable double so_far;
function update;
license "MIT";
;;
FUNCTION(update) {
    double before = so_far;
    so_far += fperiod;
    secs = so_far;
    ns = period;
    whole = (long)(so_far + 1e-9) != (long)(before + 1e-9);
}
