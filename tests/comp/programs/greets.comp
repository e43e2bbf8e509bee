component greets "Two programs' worth of instances by name; the new types; its own words; an end.";
pin in bool stop;
pin in real in = 0.5;
pin out real out;
pin out si32 first "What its own word says.";
pin out real other "The value of another component's pin.";
pin out bool linked "Whether that pin is linked.";
pin out real line "The value of the signal.";
pin out bool driven "Whether an output is linked to the signal.";
pin out bool inverts "The value of another component's parameter.";
pin out bool missing "An unknown name is an error.";
pin out bool waited "A wait in place takes its time.";
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
    hal_type_t type;
    hal_data_u *data;
    bool flag;
    while (running) {
        FOR_ALL_INSTS() {
            out_set(in * times);
            first_set(word);
            if (hal_get_pin_value_by_name("mux2.0.out", &type, &data, &flag) == 0 && type == HAL_FLOAT) {
                other_set(data->f);
                linked_set(flag);
            }
            if (hal_get_signal_value_by_name("level", 0, &data, &flag) == 0) {
                line_set(data->f);
                driven_set(flag);
            }
            if (hal_get_param_value_by_name("sim-parport.0.pin-01-out-invert", &type, &data) == 0) inverts_set(data->b);
            missing_set(hal_get_pin_value_by_name("level", &type, &data, &flag) == -1);
            long long before = rtapi_get_time();
            rtapi_delay(1000);
            waited_set(rtapi_get_time() - before >= 1000 && rtapi_delay_max() >= 1000);
            if (stop) running = 0;
        }
        usleep(1000);
    }
}
