# Cuts samples of a script with two threads to whole periods of the slow one, counted in the first
# column; fails when one of them does not hold ten samples.
$1 >= 1 { held[$1 + 0] = held[$1 + 0] $0 "\n"; n[$1 + 0]++ }
END {
    last = int(NR / 10) - 2
    for (i = 1; i <= last; i++) {
        if (n[i] != 10) exit 1
        printf "%s", held[i]
    }
}
