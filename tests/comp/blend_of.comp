component blend_of "Weighted mean of two numbers.";
pin in float in0;
pin in float in1;
pin in float share = 0.5 "How much of in1, 0 to 1.";
pin out float out;
function _ fp;
license "MIT";
;;
FUNCTION(_) {
    double s = share;
    if (!(s > 0)) s = 0;
    if (s > 1) s = 1;
    out = in0 * (1 - s) + in1 * s;
}
