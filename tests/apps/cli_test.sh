#!/usr/bin/env bash
# The program from outside: exit codes, one-line errors, help, JSON keys, and what is left at -o.
# Usage: cli_test.sh ARETE
set -uo pipefail
arete=$(realpath "$1")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
export XDG_CACHE_HOME=$work/cache
unset DISPLAY WAYLAND_DISPLAY
faults=0

fault() { echo "FAULT: $*"; faults=$((faults + 1)); }

# expect CODE ARGS...: the exit code; a failure says one line "arete: ...", on stderr alone.
expect() {
  local code=$1 got=0
  shift
  "$arete" "$@" >stdout 2>stderr || got=$?
  [[ $got == "$code" ]] || fault "exit $got, not $code: arete $* ($(head -n 1 stderr))"
  if ((code != 0)); then
    [[ $(wc -l <stderr) == 1 && $(head -c 7 stderr) == "arete: " ]] ||
      fault "not one line 'arete: ...' on stderr: arete $*: $(cat stderr)"
  fi
}
says() { grep -qF -- "$2" "$1" || fault "$1 does not say '$2': $(cat "$1")"; }
absent() { [[ ! -e $1 ]] || fault "left behind: $1"; }
present() { [[ -s $1 ]] || fault "not made: $1"; }
keys() { for key in "$@"; do says stdout "\"$key\":"; done; }

# Help.
verbs="build info view render verify bench export synth"
for verb in $verbs; do
  expect 0 "$verb" --help
  says stdout "arete $verb "
  says stdout "Example:"
  says stdout "--quiet"
done
expect 0 --help
for verb in $verbs; do says stdout "$verb"; done

# Usage: exit 2.
expect 2
expect 2 nonesuch
expect 2 build
expect 2 synth -o x.tif --size 0
expect 2 synth -o x.tif --size 9 --kind nonesuch
expect 2 render a.arete -o a.png --size 12
expect 2 render a.arete -o a.png --cache 3X
expect 2 verify a.arete
absent x.tif

# Failures: exit 1, nothing left.
expect 1 info nonesuch.arete
says stderr "nonesuch.arete: "
expect 1 build nonesuch.tif -o n.arete
absent n.arete
echo "not a DEM" >text.tif
expect 1 build text.tif -o n.arete
says stderr "text.tif: "
absent n.arete
absent n.arete.part
expect 1 view text.tif
mkdir empty.arete
expect 1 info empty.arete

# The whole flow on a small terrain, in a path with a space.
expect 0 synth -o "my dem.tif" --size 257 --kind ridged --seed 7 --quiet
present "my dem.tif"
expect 1 synth -o "my dem.tif" --size 257
expect 0 build "my dem.tif" -o t.arete --quiet
expect 0 build "my dem.tif" -o t.arete
expect 0 info t.arete
expect 0 info t.arete --check --json
keys format_version id cols rows world_from_post z_min z_max quantum max_store_error_m nodata_share \
  crs source methods bytes segments
says stdout '"cols": 257'
expect 0 render t.arete -o still.png --size 320x180 --stats stats.csv --depth depth.tif --wireframe
present still.png
present stats.csv
present depth.tif
expect 0 render t.arete -o frames --frames 3 --size 160x90 --no-morph --method full
present frames/000000.png
present frames/000002.png
absent frames/000003.png
expect 1 render t.arete -o frames --frames 3 --size 160x90
expect 0 render t.arete -o flight.mp4 --frames 5 --size 160x90 --path orbit
present flight.mp4
expect 0 verify t.arete --method geomipmap --frames 3 --size 320x180 --json
keys method options claims conforming error_px pop_px frames tolerance_px max_error_px p999_error_px \
  max_error_angular_px cracks t_junctions background_pixels max_pop_px p999_pop_px mean_triangles \
  max_triangles achieved_error_px seconds
expect 0 verify t.arete --method full --frames 2 --size 160x90
says stdout "every claim holds"
expect 0 bench t.arete --methods full,geomipmap --frames 4 --size 160x90 --json
keys machine terrain path runs method options frames mean_triangles refine_ms p50 p99 max draw_ms \
  frame_ms evaluated_vertices visited_nodes bytes_read page_faults bytes_uploaded \
  incoherence_percent cache_bytes_max peak_rss_bytes achieved_error_px
expect 0 bench t.arete --methods full,geomipmap --frames 4 --no-draw --report report.html
[[ $(grep -c '<polyline' report.html) == 6 ]] || fault "not six lines in report.html"
# The same surface whether files are read or mapped.
for io in read mmap; do
  expect 0 bench t.arete --methods full,smart --frames 4 --no-draw --io $io --json
  grep '"mean_triangles"' stdout >"$io.triangles"
done
cmp -s read.triangles mmap.triangles || fault "--io mmap draws something else"
expect 2 bench t.arete --io dma
says stderr "mmap, read"

# Budgets: kept, or refused at open by a line that names the flag and the least that would do.
expect 0 bench t.arete --methods full,geomipmap --frames 8 --size 160x90 --triangles 20000 --cache 6M \
  --gpu-memory 6M --json
keys max_triangles terrain_bytes_max resident_bytes_max gpu_bytes_max max_tolerance_px triangles
within() {  # KEY MOST: every value of the key
  local value
  for value in $(grep -o "\"$1\": [0-9]*" stdout | grep -o '[0-9]*$'); do
    ((value <= $2)) || fault "$1 is $value, above $2"
  done
}
within max_triangles 20000
within terrain_bytes_max $((6 << 20))
within gpu_bytes_max $((6 << 20))
expect 0 verify t.arete --method full --frames 3 --size 160x90 --triangles 20000 --json
keys over_budget_frames broken_bounds max_tolerance_px max_vertex_bytes
expect 0 render t.arete -o capped.png --size 160x90 --triangles 9000 --stats capped.csv
(($(tail -n 1 capped.csv | cut -d, -f3) <= 9000)) || fault "--triangles broken: $(tail -n 1 capped.csv)"
for flag in "--triangles 9" "--cache 100K" "--gpu-memory 300K"; do
  for verb in "render t.arete -o no.png" "verify t.arete --method full" "bench t.arete"; do
    # shellcheck disable=SC2086
    expect 1 $verb $flag
    says stderr "${flag%% *}"
    says stderr "allow"
  done
done
absent no.png
# The least cache that a refusal names is taken, and a byte less is not: pages grow with the cache.
for method in full geomipmap soar smart; do
  run=(bench t.arete --methods $method --frames 1 --size 160x90)
  expect 1 "${run[@]}" --cache 20K
  least=$(grep -o '[0-9]*$' stderr)
  expect 1 "${run[@]}" --cache $((least - 1))
  says stderr "allow at least $least"
  expect 0 "${run[@]}" --cache "$least"
done

# A picture that fails half way leaves nothing.
expect 1 render t.arete -o lost.png --size 160x90 --stats no/such/dir/stats.csv
absent lost.png
expect 2 render t.arete -o lost.gif
expect 2 render t.arete -o lost.png --method nonesuch
expect 2 render t.arete -o lost.png --path nonesuch
expect 2 render t.arete -o lost.mp4 --size 161x91
expect 2 render t.arete -o lost --frames 2 --depth lost.tif
absent lost.png
absent lost.mp4
absent lost

# A mesh, and how far it is from the samples.
expect 0 export t.arete -o mesh.glb --max-error 2 --json
keys triangles vertices max_error_m rmse_m seconds watertight
says stdout '"watertight": true'
present mesh.glb
expect 2 export t.arete -o mesh.3ds
absent mesh.3ds

# A DEM in place of a store is built into the cache, once.
expect 0 render "my dem.tif" -o cached.png --size 160x90
[[ $(find cache/arete -maxdepth 1 -name '*.arete' | wc -l) == 1 ]] || fault "no store in the cache"
before=$(find cache/arete -name manifest.json -printf '%T@')
expect 0 render "my dem.tif" -o cached.png --size 160x90
[[ $(find cache/arete -name manifest.json -printf '%T@') == "$before" ]] || fault "built again"

# A damaged store is refused, or found by --check; never a crash.
cp -r t.arete damaged.arete
segment=$(find damaged.arete -name 'heights.seg')
printf 'x' | dd of="$segment" bs=1 seek=5000 conv=notrunc status=none
expect 1 info damaged.arete --check
says stderr "damaged.arete"
truncate -s -100 "$segment"
expect 1 info damaged.arete

# Ctrl-C: one line, exit 1, nothing at -o; a build goes on from there.
interrupt() {  # SECONDS ARGS...: 0 when the command was caught at work
  local got=0
  "$arete" "${@:2}" >stdout 2>stderr &
  sleep "$1"
  kill -INT $! 2>/dev/null
  wait $! || got=$?
  ((got != 0)) || return 1  # it was done before the signal came
  [[ $got == 1 && $(wc -l <stderr) == 1 ]] || fault "interrupted: exit $got: $(cat stderr)"
  says stderr "interrupted"
}
interrupt 0.7 render t.arete -o many --frames 100000 --size 160x90 || fault "100,000 frames in 0.7 s"
absent many
expect 0 synth -o large.tif --size 2049 --quiet
if interrupt 0.3 build large.tif -o large.arete --threads 1 --quiet; then absent large.arete; fi
expect 0 build large.tif -o large.arete --quiet
expect 0 info large.arete --check
absent large.arete.part

# Without a display the viewer names what to use instead.
expect 1 view t.arete
says stderr "render"

((faults == 0)) && echo "apps_cli: all as expected"
exit $((faults > 0))
