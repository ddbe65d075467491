#!/usr/bin/env bash
# What a user does, on the display that tests/meshlab/desktop.sh gives: load, menu, dialog, apply.
cd /session
openbox &
sleep 1
meshlab markers.xyz template.obj >log 2>&1 &
meshlab=$!
# shot NAME [HEIGHT]
shot() {
    import -window root png:- |
        convert - -crop "1280x${2:-800}+0+0" +repage -resize 1024x -colors 128 "png8:meshlab-$1.png"
}
# Waits for a line of the log, while MeshLab lives.
wait_for() {
    while kill -0 "$meshlab"; do
        grep -q "$1" log && return
        sleep 1
    done
    shot stuck
    echo "no '$1' in the log"
    tail -20 log
    exit 1
}
click() { xdotool mousemove "$1" "$2" click 1; sleep 3; }
wait_for 'Opened mesh template.obj'
sleep 8

# Places are those of MeshLab 2025.07 on a display of 1280 x 800.
click 112 24  # Filters
click 215 214 # Smoothing, Fairing and Deformation
xdotool mousemove 549 487 # Reshape Template to Markers
sleep 2
shot menu
click 549 487
shot dialog
click 800 726 # Apply
wait_for 'Applied filter: Reshape Template to Markers'
click 568 726 # Close
shot reshaped 630

click 1258 59 # search
xdotool type 'distance to markers'
sleep 2
click 930 106
click 784 573 # Apply
wait_for 'Applied filter: Distance to Markers'
click 621 573 # Close
shot distance 630
kill "$meshlab"
