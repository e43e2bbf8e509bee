#!/bin/sh
echo FILTER_PROGRESS=0 >&2
echo "G21 G90 F100"
while read -r x y; do echo "G81 X$x Y$y Z-5 R-1"; done < "$1"
echo "a remark of the filter" >&2
echo FILTER_PROGRESS=100 >&2
echo M2
