#!/bin/sh
# Checks the sample configurations of LinuxCNC's package and writes a table: which are checked, what
# they lack here, and what is found. A machine whose components, programs and files are all here may
# have no error and no warning, or samples.reasons says why.
#
#   cargo build && tests/peer/samples.sh > tests/peer/samples.md
#
# HALCMD: the program to check with; SAMPLES: the folder (package linuxcnc-uspace or linuxcnc-doc-en).
set -eu
HALCMD=${HALCMD:-target/debug/halcmd}
SAMPLES=${SAMPLES:-/usr/share/doc/linuxcnc/examples/sample-configs}
export HALLIB_PATH=${HALLIB_PATH:-/usr/share/linuxcnc/hallib}
out=$(mktemp)
trap 'rm -f "$out"' EXIT

find "$SAMPLES" -name '*.ini' | LC_ALL=C sort | while read -r ini; do
    "$HALCMD" check --json "$ini" >"$out" 2>/dev/null || true
    jq -r --arg ini "${ini#"$SAMPLES"/}" '
        .findings as $all
        # What is not here: components, programs that the start waits for, files and entries that
        # only the package has elsewhere, Tcl.
        | [$all[] | select(.code == "H201" or .code == "H110" or .code == "H111" or .code == "H112"
              or .code == "H702" or .code == "H106" or .code == "H207") | .subject] | unique as $lacks
        | [$all[] | select(.level == "error")] | length as $errors
        | [$all[] | select(.level == "warning") | .code] | unique as $warned
        | [$all[] | select(.level == "warning")] | length as $warnings
        | [$all[] | select(.level == "note")] | length as $notes
        | if ($lacks | length) > 0
          then "lacks\t\($ini)\t\($lacks | map(select(. != "")) | join(", "))\t\($errors)"
          else "whole\t\($ini)\t\($errors)\t\($warnings)\t\($notes)\t\($all
              | map(select(.level != "note") | .code) | unique | join(" "))"
          end' "$out"
done | awk -F '\t' -v reasons="$(dirname "$0")/samples.reasons" '
    BEGIN { while ((getline line < reasons) > 0) { split(line, part, "\t"); why[part[1]] = part[2] } }
    $1 == "whole" {
        reason = $3 + $4 > 0 ? why[$2] : ""
        whole[++n] = "| " $2 " | " $3 " | " $4 " | " $5 " | " $6 " | " reason " |"
    }
    $1 == "lacks" {
        lacks[++m] = "| " $2 " | " $3 " |"
        count = split($3, names, ", ")
        for (i = 1; i <= count; i++) stops[names[i]]++
        # Of a machine that lacks one thing, that thing alone stops it.
        if (count == 1) alone[names[1]]++
    }
    $1 == "whole" && $3 == 0 || $1 == "lacks" && $4 == 0 { clean++ }
    END {
        print "# The sample configurations of LinuxCNC\n"
        print "What `halcmd check` says of them; `tests/peer/samples.sh` makes this table.\n"
        print clean + 0 " of " n + m " have no error.\n"
        print n + 0 " of " n + m " have all their components, programs and files here:\n"
        print "| configuration | errors | warnings | notes | their codes | why |"
        print "|---|---|---|---|---|---|"
        for (i = 1; i <= n; i++) print whole[i]
        print "\nWhat stops the others, if it stops two or more of them:\n"
        print "| missing | configurations | stopped by it alone |"
        print "|---|--:|--:|"
        sort = "LC_ALL=C sort -t \"|\" -k 3,3nr -k 2,2"
        for (name in stops)
            if (stops[name] > 1) print "| " name " | " stops[name] " | " alone[name] + 0 " |" | sort
        close(sort)
        print "\n" m + 0 " lack something that Ferrule does not have yet; findings about the rest of them would mean little:\n"
        print "| configuration | what it lacks |"
        print "|---|---|"
        for (i = 1; i <= m; i++) print lacks[i]
    }'
