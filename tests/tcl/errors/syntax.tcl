loadrt and2
foreach a {1 2 {
