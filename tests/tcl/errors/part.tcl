loadrt and2
loadrt nosuch
