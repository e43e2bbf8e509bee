component queued "Bytes from one port to another.";
pin in port from;
pin out port to;
pin out u32 waiting;
pin out bit moved;
function _;
license "MIT";
;;
char byte;
moved = 0;
waiting = hal_port_readable(from);
if (waiting >= 1 && hal_port_writable(to) >= 1) {
    hal_port_read(from, &byte, 1);
    hal_port_write(to, &byte, 1);
    moved = 1;
}
