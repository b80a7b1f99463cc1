#!/usr/bin/env bash
# The viewer in a virtual display: a scripted screenshot, then keys and mouse through the X server.
# Usage: viewer_test.sh ARETE; exit 77 (skipped) without Xvfb and xdotool.
set -uo pipefail
arete=$(realpath "$1")
for tool in Xvfb xdotool; do
  command -v $tool >/dev/null || { echo "skipped: $tool is not installed"; exit 77; }
done
work=$(mktemp -d)
export XDG_CACHE_HOME=$work/cache
# Mesa's GLX keeps two small blocks for the life of the process; leaks of ours show in the other tests.
export ASAN_OPTIONS=${ASAN_OPTIONS:-}:detect_leaks=0
cd "$work"
server='' viewer=''
finish() {
  [[ -z $viewer ]] || kill "$viewer" 2>/dev/null
  [[ -z $server ]] || kill "$server" 2>/dev/null
  wait 2>/dev/null
  rm -rf "$work"
}
trap finish EXIT
fail() { echo "FAULT: $*"; cat stderr 2>/dev/null; exit 1; }

unset WAYLAND_DISPLAY
Xvfb -displayfd 3 -screen 0 800x600x24 -nolisten tcp 3>display 2>/dev/null &
server=$!
for _ in $(seq 100); do [[ ! -s display ]] || break; sleep 0.1; done
[[ -s display ]] || fail "Xvfb did not start"
export DISPLAY=:$(<display)

"$arete" synth -o t.tif --size 257 --kind fbm --quiet || fail synth
"$arete" build t.tif -o t.arete --quiet || fail build
timeout 60 "$arete" view t.arete --size 640x480 --path orbit --screenshot shot.png --frames 5 \
  2>stderr || fail "scripted screenshot"
[[ -s shot.png ]] || fail "no scripted screenshot"

timeout 120 "$arete" view t.arete --size 640x480 2>stderr &
viewer=$!
window=$(timeout 30 xdotool search --sync --onlyvisible --name '^Arete' | head -n 1)
[[ -n $window ]] || fail "no window"
xdotool windowfocus "$window" 2>/dev/null

# Screenshots taken with F12 are numbered; each action must change the picture, Space undo it.
shots=0
shoot() {
  shots=$((shots + 1))
  sleep 0.3
  xdotool key F12
  for _ in $(seq 100); do [[ ! -s arete-$shots.png ]] || return 0; sleep 0.1; done
  fail "F12 number $shots saved nothing"
}
differ() { ! cmp -s "arete-$1.png" "arete-$2.png" || fail "$3 changed nothing"; }
xdotool mousemove 450 350
shoot
xdotool mousedown 1 mousemove_relative 60 30 mousemove_relative 60 30 mouseup 1
shoot
differ 1 2 "left drag"
xdotool click 4 click 4
shoot
differ 2 3 "wheel"
xdotool key w
shoot
differ 3 4 "wireframe"
xdotool key w key f keydown w
sleep 0.5
xdotool keyup w
shoot
differ 3 5 "flying forward"
xdotool key f key space
sleep 1.5
shoot
cmp -s arete-1.png arete-6.png || fail "Space does not go home"
xdotool key m
shoot
xdotool key l key h key p
sleep 0.4
xdotool key p
sleep 0.4
[[ -s path-1.json ]] || fail "P saved no path"
xdotool key Escape
for _ in $(seq 100); do kill -0 "$viewer" 2>/dev/null || break; sleep 0.1; done
wait "$viewer" || fail "the viewer did not end well"
viewer=''
echo "apps_viewer: all as expected"
