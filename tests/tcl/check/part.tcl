loadrt threads name1=servo period1=1000000
loadrt and2 names=a,b
