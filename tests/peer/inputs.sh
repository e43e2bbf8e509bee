#!/bin/sh
# Writes the inputs that the scripts stream in: one line per cycle, a command and an enable bit.
cd "$(dirname "$0")" || exit 1

# hold N CYCLES: a constant command; ramp FROM TO CYCLES; wave FROM AMPLITUDE PERIODS CYCLES
tell='
function out(x) { printf "%.9f %d%s\n", x, on, more }
function hold(x, n) { at = x; while (n-- > 0) out(x) }
function ramp(to, n, i, from) { from = at; for (i = 1; i <= n; i++) out(from + (to - from) * i / n); at = to }
function wave(a, p, n, i, from) { from = at; for (i = 1; i <= n; i++) out(from + a * sin(6.283185307 * p * i / n)) }
function flip(x, each, times) { while (times-- > 0) { hold(x, each); x = -x } }
'

awk "$tell"'BEGIN {
    hold(0, 5); hold(3000, 5); on = 1
    hold(3000, 95); hold(-3300, 100); hold(20000, 50); hold(-20000, 40)
    on = 0; hold(-1000, 20); hold(1000, 10); on = 1; hold(1234.5, 60)
    on = 0; hold(1234.5, 1); on = 1; hold(1234.5, 20); on = 0; hold(-1234.5, 1); on = 1; hold(-1234.5, 30)
    flip(2500, 7, 14); hold(0, 30); hold(-700, 80); hold(4999, 55)
}' > types.in

awk "$tell"'BEGIN {
    hold(0, 3); on = 1
    hold(900, 100); hold(-900, 100); hold(2400, 80); hold(-2400, 80); hold(100000, 70); hold(-100000, 70)
    flip(1700, 13, 10); hold(0, 25); hold(-3000, 20); hold(3000, 3); hold(-3000, 40)
    on = 0; hold(5000, 10); on = 1; hold(5000, 30); hold(1e-3, 30); hold(-1e-3, 10); hold(333.3, 99)
}' > timing.in

awk "$tell"'BEGIN {
    hold(0, 5); on = 1; hold(0, 5)
    hold(7, 180); hold(-2.5, 240); ramp(10, 250); hold(10, 60); wave(3, 2, 300)
    on = 0; ramp(14, 20); on = 1; hold(14, 40); ramp(13.9, 50); hold(13.9, 20); wave(0.02, 3, 90)
    hold(14, 1); hold(13, 239)
}' > position.in

awk "$tell"'BEGIN {
    hold(0, 2); on = 1; hold(0, 2)
    wave(4, 1, 90); ramp(12, 40); hold(12, 20); ramp(9, 6); hold(-8, 50)
    on = 0; hold(-3, 4); on = 1; hold(-3, 10); ramp(3, 30); hold(3, 6)
}' > servo.in

# A ramp of 35 mm/s^2 to 10 mm/s, then at that speed; 1 ms each.
awk 'BEGIN {
    print "0 0"
    for (i = 0; i < 600; i++) {
        t = i / 1000; top = 10 / 35
        printf "%.9f 1\n", t < top ? 17.5 * t * t : 10 * t - 50 / 35
    }
}' > printer.in

# run, jog-plus, jog-minus, dir, maxvel, amplitude, pause; 10 ms each.
awk 'function o(n, run, plus, minus, dir, vel, amp, pause) {
    while (n-- > 0) print run, plus, minus, dir, vel, amp, pause
}
BEGIN {
    o(3, 0, 0, 0, 0, 5, 2, 0); o(210, 1, 0, 0, 0, 5, 2, 0); o(290, 1, 0, 0, 0, 5, 2, 1)
    o(40, 0, 0, 0, 0, 5, 2, 0); o(60, 0, 1, 0, 0, 5, 2, 0); o(30, 0, 0, 0, 0, 5, 2, 0)
    o(50, 0, 0, 1, 0, 4, 2, 0); o(20, 0, 1, 1, 0, 3, 2, 0); o(30, 0, 0, 0, 0, 5, 2, 0)
    o(120, 1, 1, 0, 1, 5, 1.5, 0); o(20, 0, 0, 0, 1, 5, 1.5, 0); o(60, 1, 0, 0, 1, 5, 1.5, 0)
    o(70, 0, 0, 0, 2, 5, 1, 0); o(150, 1, 0, 1, 2, 5, 1, 0); o(10, 0, 0, 0, 2, 5, 9, 0)
    o(80, 1, 0, 0, 0, 5, 9, 0); o(60, 0, 0, 0, 0, 5, -1, 0); o(15, 1, 0, 0, 0, 5, -1, -1)
    o(5, 0, 0, 0, 0, 5, 3, 0); o(40, 1, 0, 0, 0, 5, 3, 0); o(87, 0, 0, 0, 0, -2, 3, 0)
}' > steptest.in

# frequency, amplitude, offset, reset; 1 ms each.
awk 'function o(n, f, a, off, r) { while (n-- > 0) print f, a, off, r }
BEGIN {
    o(150, 13, 1, 0, 0); o(100, 37.5, 2, -1, 0); o(7, 37.5, 2, -1, 1); o(143, 5, -0.3, 0.25, 0)
    o(60, 499, 1, 0, 0); o(60, 500, 1, 0, 0); o(60, 1234, 1, 0, 0); o(5, 1, 1, 0, 1)
    o(115, 250, 1, 0, 0); o(100, 0, 3, 1, 0); o(100, 111.1, 0, 7, 0)
}' > siggen.in

# in, enable, load; 1 ms each.
awk "$tell"'BEGIN {
    more = " 0"; on = 1
    hold(0, 10); hold(1, 300); hold(-2, 200); ramp(3, 150); hold(3, 50); wave(1.5, 3, 300)
    on = 0; hold(3, 60); on = 1; ramp(-1, 30); more = " 1"; hold(-1, 3); hold(4, 2); more = " 0"
    hold(4, 45); hold(0.5, 1); hold(0.6, 1); hold(0.5, 98); ramp(0.55, 50); hold(0.55, 100)
}' > limit3.in

# Twelve output pins: none, each alone, all, none for a while, then any.
awk 'function o(bits, i, line) {
    for (i = 0; i < 12; i++) line = line (i ? " " : "") int(bits / 2 ^ i) % 2
    print line
}
BEGIN {
    for (i = 0; i < 5; i++) o(0)
    for (i = 0; i < 12; i++) o(2 ^ i)
    for (i = 0; i < 4; i++) o(4095)
    for (i = 0; i < 4; i++) o(0)
    x = 1
    for (i = 0; i < 120; i++) { x = (x * 1309 + 13849) % 65536; o(int(x / 16)); if (i % 9 == 0) o(int(x / 16)) }
    o(0); o(0)
}' > parport.in
