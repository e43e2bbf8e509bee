component bare_c "Without the macros: plain C over the state.";
pin in float in;
pin out float out;
param rw float gain = 3;
variable int runs;
function _;
option no_convenience_defines yes;
license "MIT";
;;
static void _(struct __comp_state *inst, long period)
{
    (void)period;
    inst->runs_p++;
    *inst->out_p = *inst->in * inst->gain + inst->runs;
}
