component knobs "Parameters of every classic type, to set and to read.";
pin in bit go;
param rw bit b;
param rw float f = 0.25;
param rw s32 s;
param rw u32 u;
param r bit rb;
param r float rf;
param r s32 rs;
param r u32 ru;
param rw float gain-##[3] = 1;
param r float out-##[3];
function _;
license "MIT";
;;
if (go) {
    int i;
    rb = !b;
    rf = f * 2;
    rs = -s;
    ru = u + 1;
    for (i = 0; i < 3; i++) out(i) = gain(i) * (i + 1);
    if (f > 100) f = 100;
}
