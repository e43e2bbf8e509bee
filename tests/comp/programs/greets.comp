component greets "Two programs' worth of instances by name; the new types; its own words; an end.";
pin in bool stop;
pin in real in = 0.5;
pin out real out;
pin out si32 first "What its own word says.";
param rw ui32 times = 3;
option userspace yes;
option userinit yes;
license "MIT";
;;
#include <stdlib.h>
#include <unistd.h>

static int word;

void userinit(int count, char **words)
{
    word = count > 1 ? atoi(words[1]) : -1;
}

void user_mainloop(void)
{
    int running = 1;
    while (running) {
        FOR_ALL_INSTS() {
            out_set(in * times);
            first_set(word);
            if (stop) running = 0;
        }
        usleep(1000);
    }
}
