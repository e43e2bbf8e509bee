# nominal, correction forward, correction reverse
0 0.1 -0.1
50 0.2 -0.2
