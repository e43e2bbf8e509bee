component hal_some_port "The hal_ of its name is not part of its pins' names.";
pin in bit pin-##-in[2];
pin out bit pin-##-in-not[2];
function read;
license "MIT";
;;
FUNCTION(read) {
    int i;
    for (i = 0; i < 2; i++) pin_in_not(i) = !pin_in(i);
}
