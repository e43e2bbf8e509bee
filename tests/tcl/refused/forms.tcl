
loadrt pid count=2
