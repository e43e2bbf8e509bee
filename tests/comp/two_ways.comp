component two_ways "Two functions, and what one hands to the other.";
pin in float raw;
pin out float shown;
variable double held;
function read nofp "Takes the input.";
function write_out fp "Gives it out.";
license "MIT";
;;
FUNCTION(read) { held = raw; }
FUNCTION(write_out) { shown = held; }
