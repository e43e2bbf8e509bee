component doubles "A program of its own: every classic type, inputs with first values, parameters.";
pin in float in = 1.5;
pin out float out;
pin in bit go = true;
pin out bit gone;
pin in s32 a = -7;
pin out s32 na;
pin in u32 b;
pin out u32 nb;
pin in s64 c = -5000000000;
pin out s64 nc;
pin in u64 d = 18446744073709551615;
pin out u64 nd;
pin io s32 counter = 3 "Set by either side.";
pin out float row-#[2 : personality];
param rw float gain = 2;
param rw s32 add = 1;
param r bit large;
variable int loops;
option userspace yes;
option default_personality 2;
license "MIT";
;;
#include <unistd.h>

void user_mainloop(void)
{
    for (;;) {
        FOR_ALL_INSTS() {
            int i;
            out = in * gain;
            gone = go;
            na = a + add;
            nb = b + 1;
            nc = c;
            nd = d;
            for (i = 0; i < personality; i++) row(i) = in * i;
            large = in > 5;
            if (counter == 10) counter = 20;
            loops++;
        }
        usleep(1000);
    }
}
