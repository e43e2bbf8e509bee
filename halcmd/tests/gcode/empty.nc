# nothing moves
G04 P5
