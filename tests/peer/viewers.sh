#!/bin/sh
# Opens a recording of the printer in programs that are not ours: `viewers.sh FOLDER`. Leaves in FOLDER
# the files and pictures of the viewer with VCD and FST in it, to be looked at.
#
# Needs halrun and halscope on the PATH; and, of Debian's packages, gtkwave, xvfb, imagemagick (pictures
# without a screen) and gnumeric (a spreadsheet's import). What is not there is passed over, and said.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1"
cp "$here"/../../configs/printer/*.hal "$here"/../../configs/printer/*.ini "$here"/../../configs/printer/*.tbl "$1"
cd "$1"

# X jogs at 50 mm/s, 200 steps a second, turns, and jogs back at 25 mm/s.
cat > viewers.hal << 'HAL'
iocontrol.estop-reset --wait
motion.enable --wait
motion.home joint=all --wait
motion.jog joint=0 velocity=50
run 900ms
record printer.vcd xstep xdir stepgen.0.position-fb stepgen.0.counts
run 100ms
motion.jog joint=0 velocity=-25
run 200ms
record off
shutdown
HAL
printf '#INCLUDE printer.ini\n[HAL]\nPOSTGUI_HALFILE = viewers.hal\n' > viewers.ini
halrun --virtual --hold viewers.ini
for ending in fst csv json; do halscope convert printer.vcd printer.$ending; done

has() {
    command -v "$1" > /dev/null || { echo "passed over: no $1"; return 1; }
}

# A picture of what GTKWave shows.
picture() {
    cat > viewers.tcl << 'TCL'
gtkwave::addSignalsFromList [list xstep xdir stepgen.0.position-fb stepgen.0.counts]
gtkwave::setZoomRangeTimes 1204000000 1504000000
set loaded [open loaded w]
puts $loaded "[gtkwave::getNumFacs] signals, [gtkwave::getMinTime] to [gtkwave::getMaxTime] ns"
close $loaded
TCL
    rm -f loaded
    xvfb-run -a -s '-screen 0 1008x400x24' sh -c '
        gtkwave --rcvar "splash_disable on" --script viewers.tcl "$1" > gtkwave.log 2>&1 &
        until [ -s loaded ]; do kill -0 $! || exit 1; sleep 0.2; done
        sleep 2
        import -window root "$1.png"
        kill $!' sh "$1"
    echo "$1 in GTKWave: $(cat loaded); $1.png shows it"
}
if has gtkwave && has xvfb-run && has import; then
    picture printer.vcd
    picture printer.fst
fi

# What a spreadsheet makes of the table: rows, columns, and cells that are text where numbers should be.
if has ssconvert; then
    ssconvert -T Gnumeric_XmlIO:sax:0 printer.csv printer.xml 2> /dev/null
    awk '
    BEGIN { RS = "<" }
    /^gnm:Cell / {
        match($0, /Row="[0-9]+"/); row = substr($0, RSTART + 5, RLENGTH - 6)
        match($0, /Col="[0-9]+"/); column = substr($0, RSTART + 5, RLENGTH - 6)
        if (row + 0 > rows + 0) rows = row
        if (column + 0 > columns + 0) columns = column
        # 40 is a floating-point number, 60 is text.
        if ($0 ~ /ValueType="40"/) numbers++
        else if (row > 0) text++
    }
    END { print "printer.csv in a spreadsheet: " rows " rows below the head, " columns + 1 " columns, " \
          numbers + 0 " numbers, " text + 0 " cells of text" }' printer.xml
fi
