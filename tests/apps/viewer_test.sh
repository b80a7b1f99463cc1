#!/usr/bin/env bash
# The viewer in a virtual display: real mouse and keys through the X server, their effect on the
# camera asserted by the trace that the viewer writes.
# Usage: viewer_test.sh ARETE [DROP_FILE]; exit 77 (skipped) without Xvfb and xdotool.
set -uo pipefail
arete=$(realpath "$1")
drop_file=${2:+$(realpath "$2")}
for tool in Xvfb xdotool; do
  command -v $tool >/dev/null || { echo "skipped: $tool is not installed"; exit 77; }
done
work=$(mktemp -d)
export XDG_CACHE_HOME=$work/cache TMPDIR=$work/tmp
mkdir "$work/tmp"
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
fail() {
  echo "FAULT: $*"
  cat stderr 2>/dev/null
  head -n 1 trace.csv 2>/dev/null
  tail -n 3 trace.csv 2>/dev/null
  exit 1
}

# ---- the trace -----------------------------------------------------------------------------------
# `holds EXPRESSION`: awk on the last whole line as n["eye_x"] and the marked one as b[...].
#   px(): pixels between where the ground point under the cursor at the mark appears now and where
#   it should: under the cursor now (px("now")) or where the cursor was (px("then")).
#   away(): metres from the eye to that ground point, now; away0() at the mark. went(): the eye's way.
mark() { tail -n 2 trace.csv | head -n 1 >mark; }
holds() {
  { head -n 1 trace.csv; cat mark; tail -n 2 trace.csv | head -n 1; } | awk -F, '
    function length3(x, y, z) { return sqrt(x * x + y * y + z * z) }
    function dist(r) { return length3(b["ground_x"] - r["eye_x"], b["ground_y"] - r["eye_y"],
                                      b["ground_z"] - r["eye_z"]) }
    function away() { return dist(n) }
    function away0() { return dist(b) }
    function went() { return length3(n["eye_x"] - b["eye_x"], n["eye_y"] - b["eye_y"],
                                     n["eye_z"] - b["eye_z"]) }
    function still() { return went() < 1e-3 && n["yaw"] == b["yaw"] && n["pitch"] == b["pitch"] }
    function px(when,   d, s, c, sp, cp, x, y, z, w, f, u, v) {
      d = 3.14159265358979 / 180
      s = sin(n["yaw"] * d); c = cos(n["yaw"] * d); sp = sin(n["pitch"] * d); cp = cos(n["pitch"] * d)
      x = b["ground_x"] - n["eye_x"]; y = b["ground_y"] - n["eye_y"]; z = b["ground_z"] - n["eye_z"]
      w = (x * s + y * c) * cp + z * sp
      f = n["height"] / 2 / (sin(n["fovy"] * d / 2) / cos(n["fovy"] * d / 2))
      u = n["width"] / 2 + f * (x * c - y * s) / w
      v = n["height"] / 2 - f * (z * cp - (x * s + y * c) * sp) / w
      if (when == "now") return length3(u - n["cursor_x"], v - n["cursor_y"], 0)
      return length3(u - b["cursor_x"], v - b["cursor_y"], 0)
    }
    NR == 1 { for (i = 1; i <= NF; i++) name[i] = $i; columns = NF; next }
    NR == 2 { for (i = 1; i <= NF; i++) b[name[i]] = $i; next }
    NF == columns { for (i = 1; i <= NF; i++) n[name[i]] = $i; whole = 1 }
    END { exit !(whole && ('"$1"')) }'
}
# Waits up to $2 tenths of a second.
comes_true() { for _ in $(seq "${2:-200}"); do ! holds "$1" || return 0; sleep 0.1; done; return 1; }
await() { comes_true "$1" || fail "$2: never came true: $1"; }
# The camera has not moved once the viewer has drawn more frames since the mark.
unmoved() {
  await 'n["frame"] > b["frame"] + 4' "frames after $1"
  holds 'still()' || fail "$1 moved the camera"
}
# Presses and releases only when the viewer has seen the mouse come to its place.
drag() {  # BUTTON DX DY
  xdotool mousedown "$1" mousemove_relative -- $(($2 / 2)) $(($3 / 2))
  xdotool mousemove_relative -- $(($2 - $2 / 2)) $(($3 - $3 / 2))
  await "n[\"cursor_x\"] == b[\"cursor_x\"] + $2 && n[\"cursor_y\"] == b[\"cursor_y\"] + $3" \
    "the mouse at the end of a drag"
  xdotool mouseup "$1"
}
at() {  # X Y: the mouse rests there, then the mark
  xdotool mousemove --window "$window" "$1" "$2"
  tail -n 2 trace.csv | head -n 1 >mark
  await "n[\"cursor_x\"] == $1 && n[\"cursor_y\"] == $2 && n[\"frame\"] > b[\"frame\"] + 1 && \
    n[\"late_blocks\"] == 0" "the mouse at $1 $2"
  mark
}

# ---- without a display ---------------------------------------------------------------------------
unset WAYLAND_DISPLAY DISPLAY
"$arete" synth -o t.tif --size 257 --kind fbm --quiet || fail synth
"$arete" build t.tif -o t.arete --methods geomipmap,full --quiet || fail build
"$arete" view t.arete 2>stderr
[[ $? == 1 && $(wc -l <stderr) == 1 ]] || fail "no display: not exit 1 with one line"
grep -q render stderr || fail "no display: the line does not name render"

# ---- a window ------------------------------------------------------------------------------------
Xvfb -displayfd 3 -screen 0 800x600x24 -nolisten tcp 3>display 2>/dev/null &
server=$!
for _ in $(seq 100); do [[ ! -s display ]] || break; sleep 0.1; done
[[ -s display ]] || fail "Xvfb did not start"
export DISPLAY=:$(<display)

timeout 60 "$arete" view t.arete --size 320x240 --path orbit --screenshot shot.png --frames 5 \
  2>stderr || fail "scripted screenshot"
[[ -s shot.png ]] || fail "no scripted screenshot"

begin() {  # ARGUMENTS of view: a viewer that has shown a few frames
  rm -f trace.csv
  timeout 120 "$arete" view "$@" --trace trace.csv 2>stderr &
  viewer=$!
  window=$(timeout 30 xdotool search --sync --onlyvisible --name '^Arete' | head -n 1)
  [[ -n $window ]] || fail "no window"
  xdotool windowfocus "$window" 2>/dev/null
  for _ in $(seq 200); do [[ ! -s trace.csv || $(wc -l <trace.csv) -lt 4 ]] || return 0; sleep 0.1; done
  fail "no picture"
}
end() {  # EXIT CODE
  xdotool key Escape
  for _ in $(seq 100); do kill -0 "$viewer" 2>/dev/null || break; sleep 0.1; done
  wait "$viewer"
  [[ $? == "$1" ]] || fail "the viewer did not end with $1"
  viewer=''
}
begin t.arete --size 640x480 --tolerance 4

# The checks themselves: what is not so never comes true, and a camera that moved is found.
at 470 340
cp mark home
! comes_true 'went() > 1' 3 || fail "the trace shows motion that was not there"
head -n 3 trace.csv | tail -n 1 | awk -F, -v OFS=, '{ $8 += 5; print }' >mark
! holds 'still()' || fail "the check for a still camera takes a moved one for still"

at 500 300
unmoved "the mouse alone"
xdotool key w; unmoved "W on the map"
xdotool key w keydown a keydown d; unmoved "A and D on the map"; xdotool keyup a keyup d

at 450 330
drag 1 80 40
await 'px("now") < 2 && went() > 0.05 * away0()' "left drag keeps the ground under the mouse"
holds 'n["eye_z"] == b["eye_z"] && n["yaw"] == b["yaw"]' || fail "left drag does more than pan"

at 430 320
xdotool click 4 click 4 click 4
await 'px("then") < 2 && away() / away0() > 0.6 && away() / away0() < 0.63' "three notches"
at 430 320
xdotool click 5 click 5 click 5
await 'px("then") < 2 && away() / away0() > 1.6 && away() / away0() < 1.66' "three notches back"

at 450 330
drag 3 0 -60
await 'px("then") < 2 && away() / away0() > 0.75 && away() / away0() < 0.9' "right drag zooms"

at 450 330
drag 2 60 30
await 'px("then") < 2 && n["yaw"] - b["yaw"] > 16 && n["yaw"] - b["yaw"] < 19' "middle drag turns"
holds 'n["pitch"] - b["pitch"] < -7 && n["pitch"] - b["pitch"] > -10' || fail "middle drag's pitch"

at 440 310
xdotool click --repeat 2 --delay 20 1
await 'away() / away0() > 0.29 && away() / away0() < 0.31' "double click flies there"

cp home mark
xdotool key space
await 'still()' "Space goes home"

# ---- flying --------------------------------------------------------------------------------------
# Speed since the mark, in heights above the ground a second: the viewer lets at most 0.1 s a frame pass.
speed() {
  awk -F, -v from="$(cut -d, -f1 mark)" '
    NR == 1 { for (i = 1; i <= NF; i++) c[$i] = i; next }
    $1 > from && x != "" {
      a = $c["eye_x"] - x; b = $c["eye_y"] - y; d = sqrt(a * a + b * b + ($c["eye_z"] - z) ^ 2)
      if (d > 0) {
        way += d; height += $c["above_ground"]; count++
        time += ($c["frame_ms"] < 100 ? $c["frame_ms"] : 100) / 1000
      }
    }
    { x = $c["eye_x"]; y = $c["eye_y"]; z = $c["eye_z"] }
    END { if (time > 0) printf "%.3f", way / time / (height / count); else print 0 }' trace.csv
}
at 470 340
xdotool key f keydown w
await 'n["mode"] == "fly" && went() > 0.05 * b["above_ground"]' "W flies"
xdotool keyup w
holds 'n["eye_z"] < b["eye_z"] && n["yaw"] == b["yaw"]' || fail "W does not fly forward"
slow=$(speed)
at 470 340
xdotool keydown shift keydown s
await 'went() > 0.2 * b["above_ground"]' "Shift S flies"
xdotool keyup s keyup shift
holds 'n["eye_z"] > b["eye_z"]' || fail "S does not fly back"
fast=$(speed)
awk "BEGIN { exit !($slow > 0.4 && $slow < 2 && $fast > 2.5 * $slow) }" ||
  fail "speeds by height: $slow, with Shift $fast"
at 470 340
drag 1 60 -30
await 'n["yaw"] > b["yaw"] + 6 && n["pitch"] > b["pitch"] + 3 && went() < 1e-3' "look around"
at 470 340
xdotool keydown e
await 'n["eye_z"] > b["eye_z"] + 0.02 * b["above_ground"]' "E flies up"
xdotool keyup e key f
await 'n["mode"] == "map"' "F goes back to the map"
cp home mark
xdotool key space
await 'still()' "Space goes home again"

# ---- what is drawn -------------------------------------------------------------------------------
shots=0
shoot() {
  shots=$((shots + 1))
  xdotool key F12
  for _ in $(seq 100); do [[ ! -s arete-$shots.png ]] || return 0; sleep 0.1; done
  fail "F12 number $shots saved nothing"
}
at 470 340
shoot
xdotool key w
unmoved "W"
shoot
! cmp -s arete-1.png arete-2.png || fail "W draws no wireframe"
xdotool key w
at 470 340
xdotool key plus plus plus plus
await 'n["triangles"] > 1.2 * b["triangles"]' "+ draws more"
at 470 340
xdotool key minus minus minus minus
await 'n["triangles"] < 0.8 * b["triangles"]' "- draws less"
at 470 340
xdotool key m
await 'n["method"] == "full"' "M shows the next method"
xdotool key m
await 'n["method"] == "geomipmap" && n["triangles"] == b["triangles"]' "M goes round"
at 470 340
xdotool key l click 4 click 4
await 'away() < 0.8 * away0() && n["frame"] > b["frame"] + 4' "zoom with L"
holds 'n["triangles"] == b["triangles"]' || fail "L does not freeze the detail"
xdotool key l
await 'n["triangles"] != b["triangles"]' "L again lets go"
at 470 340
xdotool key h; unmoved "H"; xdotool key h

at 470 340
xdotool key p click 4
await 'went() > 1' "a recorded zoom"
xdotool key p
for _ in $(seq 100); do [[ ! -s path-1.json ]] || break; sleep 0.1; done
[[ -s path-1.json ]] || fail "P saved no path"
cp home mark
xdotool key space
await 'still()' "Space during a replay"

# ---- the ground holds ----------------------------------------------------------------------------
at 470 340
for _ in $(seq 30); do xdotool click 4; done
await 'away() < 0.02 * away0()' "zooming to the ground"
xdotool key f keydown w keydown q
await 'went() > 0.9 * away0() && n["frame"] > b["frame"] + 40' "diving"
xdotool keyup w keyup q key f
awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) c[$i] = i; next }
         $c["above_ground"] <= 0 { exit 1 }' trace.csv || fail "the eye went below the ground"

# ---- the window ----------------------------------------------------------------------------------
at 470 340
xdotool windowsize "$window" 500 400
await 'n["width"] == 500 && n["height"] == 400' "another size"
unmoved "another size"
end 0
[[ ! -s stderr ]] || fail "the viewer said something"

# ---- a DEM opened directly -----------------------------------------------------------------------
"$arete" synth -o big.tif --size 2305 --kind fbm --quiet || fail synth
begin big.tif --size 320x240 --tolerance 4 --quiet
sed -n 2p trace.csv >mark
holds 'b["terrain"] == "preview"' || fail "the first picture is no preview"
await 'n["terrain"] == "store"' "the store in place of its preview"
holds 'still()' || fail "the camera moved when the store took the place of its preview"
[[ -z $(ls -A tmp) ]] || fail "the preview's files were left behind"
ls cache/arete/*.arete >/dev/null || fail "no store in the cache"
head -c 3000 big.tif >broken.tif
if [[ -n $drop_file ]]; then
  mark
  "$drop_file" "$window" broken.tif || fail "the drop was not taken"
  unmoved "a broken file dropped"
  "$drop_file" "$window" t.arete || fail "the drop was not taken"
  await 'went() > 100' "a store dropped"
fi
end 0

rm -rf cache
begin big.tif --size 320x240 --tolerance 4 --quiet
end 0
[[ -z $(ls -A tmp) ]] || fail "a cancelled preview's files were left behind"
timeout 60 "$arete" view big.tif --size 320x240 --screenshot again.png --frames 1 --quiet ||
  fail "after a cancelled build"

timeout 60 "$arete" view broken.tif --quiet 2>stderr
[[ $? == 1 && $(wc -l <stderr) == 1 ]] || fail "a broken DEM: not exit 1 with one line"
echo "apps_viewer: all as expected"
