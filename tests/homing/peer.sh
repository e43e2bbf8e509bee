#!/bin/sh
# Writes linuxcnc.txt: the positions to which LinuxCNC homes with these modules, as its own halcompile makes them.
#
# Run as root in a copy of this folder that others may read. It needs linuxcnc-uspace and linuxcnc-uspace-dev; the modules are
# seen by LinuxCNC alone, in a mount namespace of its own.
set -e
here=$PWD
export PATH=/usr/bin:/bin:/usr/sbin:/sbin
halcompile --compile search.c
halcompile --compile at_once.comp
cp -r /usr/lib/linuxcnc/modules modules
cp search.so at_once.so modules
chmod -R a+rwX "$here"
: > linuxcnc.txt
for name in search own at_once; do
    rm -f homed
    { cat $name.ini; printf '[DISPLAY]\nDISPLAY = ./drive.py\n'; } > linuxcnc.ini
    unshare -m sh -c "mount --bind '$here/modules' /usr/lib/linuxcnc/modules &&
        timeout 150 runuser -u nobody -- env HOME='$here' linuxcnc linuxcnc.ini" > /dev/null 2>&1
    echo "== $name" >> linuxcnc.txt
    cat homed >> linuxcnc.txt
done
