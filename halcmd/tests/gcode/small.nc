# a square with a round corner
G20 G00 Z.5 M03
G01 X1 F10
G03 X.5 Y.5 I-.5 J0
G28
