component with_data "Each instance has a struct of the C text's own.";
pin in float in;
pin out float highest;
pin out float lowest;
pin out u32 samples;
function _;
option data struct range;
license "MIT";
;;
struct range {
    double low, high;
    unsigned count;
    char room[1000];
};

FUNCTION(_) {
    if (data.count == 0 || in > data.high) data.high = in;
    if (data.count == 0 || in < data.low) data.low = in;
    data.room[999] = 1;
    samples = ++data.count;
    highest = data.high;
    lowest = data.low;
}
