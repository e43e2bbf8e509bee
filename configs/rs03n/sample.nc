(A groove with a round end, and an arc on the way back)
G21 G90 G17
G0 Z10.
G0 X20. Y10. S1500 M3
G1 Z-0.5 F300
X60. Y10.
G3 X60. Y30. R10.
G1 X20.
G2 X20. Y10. I0. J-10.
G0 Z10.
M5
M2
