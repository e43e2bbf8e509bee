loadrt and2

setp and2.0.in9 1
puts never
