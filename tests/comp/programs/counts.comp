component counts "A program of one instance, whose own functions use its pins.";
pin in bit press;
pin out u32 presses;
pin out u32 rounds;
option singleton yes;
option userspace yes;
license "MIT";
;;
#include <unistd.h>

static void count(void);

/* Not static, as many are written. */
void user_mainloop(void)
{
    for (;;) {
        FOR_ALL_INSTS() {
            rounds++;
        }
        if (press) count();
        usleep(1000);
    }
}

static void count(void)
{
    if (presses < 5) presses += 1;
}
