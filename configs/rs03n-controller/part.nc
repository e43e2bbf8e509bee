(A slot with round ends, and a full circle inside)
G21 G90 G17
G0 Z10
G0 X-10 Y10
G1 Z-1 F300
G1 X10
G2 X10 Y-10 R10
G1 X-10
G2 X-10 Y10 R10
G0 Z10
G0 X5 Y0
G1 Z-1
G3 I-5 J0
G0 Z10
