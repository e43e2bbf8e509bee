loadrt and2
proc wire {} {
    catch {net a and2.9.in0}
    net a and2.0.out
    net a and2.1.in0
}
wire
