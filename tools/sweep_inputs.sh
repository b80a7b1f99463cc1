#!/usr/bin/env bash
# Every file under the given paths through `arete build`, `info --check` and `verify`, in a sandbox.
# Each must be built and hold, or be refused in exactly one line `arete: FILE: what: what to do` with
# nothing left behind: within the time and 1 GiB, never a crash, never another word on stderr.
# Prints a Markdown row a file, the table of docs/inputs.md; what broke the promise goes to stderr.
# Usage: tools/sweep_inputs.sh [--every N] [--seconds N] ARETE PATH...
#        tools/sweep_inputs.sh --self-test
# Exit: 0 all as promised, 1 some are not, 77 no such files, sandbox (bubblewrap, time) or limits.
set -uo pipefail

kibibytes=$((1 << 20)) every=1 seconds=60
faults=0 built=0 refused=0 peak=0

fault() {  # FILE WHAT...
  echo "FAULT: $*" >&2
  faults=$((faults + 1))
}

# Runs arete in $scratch/work: the file system read-only but for $scratch, no network, little
# memory. Leaves out, err and usage (peak KiB of arete alone) in $scratch.
sandboxed() {
  timeout -k 5 "$seconds" bwrap --ro-bind / / --bind "$scratch" "$scratch" --dev /dev --proc /proc \
    --unshare-net --unshare-pid --die-with-parent --chdir "$scratch/work" --setenv HOME . \
    bash -c 'ulimit -d "$0" && exec /usr/bin/time -q -f %M -o ../usage "$@"' \
    "$kibibytes" "$arete" "$@" >"$scratch/out" 2>"$scratch/err"
}

# A verb of arete: 0 done, 1 refused, 2 a fault that was told.
run() {  # FILE VERB ARGS...
  local file=$1 code=0 kib
  shift
  sandboxed "$@" || code=$?
  kib=$(tail -n 1 "$scratch/usage")
  ((kib > peak)) && peak=$kib
  if ((code == 124 || code == 137)); then
    fault "$file: $1 ran over $seconds s"
  elif ((code > 1)); then
    fault "$file: $1 ended with $code: $(head -c 300 "$scratch/err")"
  elif ((kib > kibibytes)); then
    fault "$file: $1 took $kib KiB"
  else
    return "$code"
  fi
  return 2
}

# All that may lie in the working folder is NAME.
nothing_but() {  # FILE NAME
  local left
  left=$(find "$scratch/work" -mindepth 1 -maxdepth 1 ! -name "$2" -printf '%f ')
  [[ -z $left ]] || fault "$1: left behind: $left"
}

refusal() {  # FILE
  local name=${1##*/} line
  line=$(<"$scratch/err")
  [[ $(wc -l <"$scratch/err") == 1 && $line == "arete: $name: "*": "* ]] ||
    fault "$1: not refused in one line 'arete: $name: what: what to do', but: $line"
  nothing_but "$1" ''
  refused=$((refused + 1))
  echo "| \`$name\` | refused | | | | | | ${line#"arete: $name: "} |"
}

# The part of a line of `arete info` that an expression catches.
said() { sed -nE "s/^$1\$/\\1/p" "$scratch/info"; }

store() {  # FILE
  local name=${1##*/} notes verb
  notes=$(sed 's/^note: //' "$scratch/err" | paste -sd ' ')
  ! grep -qv '^note: ' "$scratch/err" || fault "$1: build said: $(<"$scratch/err")"
  for verb in 'info store.arete --check' \
    'verify store.arete --method geomipmap --frames 3 --size 320x240'; do
    # shellcheck disable=SC2086 # its words are wanted
    run "$1" $verb || (($? == 2)) || fault "$1: $verb: $(<"$scratch/err")"
    [[ ! -s $scratch/err ]] || fault "$1: $verb said: $(<"$scratch/err")"
    [[ $verb != info* ]] || cp "$scratch/out" "$scratch/info"
  done
  nothing_but "$1" store.arete
  built=$((built + 1))
  echo "| \`$name\` | built | $(said 'posts +([0-9]+ x [0-9]+),.*') |" \
    "$(said 'heights +(.* to .*) m, kept.*') | $(said 'no data +(.* %) of.*') |" \
    "$(said 'posts .*, (.* x .*) m apart.*') | $(said 'crs +(.*)') | $notes |"
}

sweep_file() {  # FILE
  rm -rf "$scratch/work"
  mkdir "$scratch/work"
  run "$1" build "$1" -o store.arete
  case $? in
    0) store "$1" ;;
    1) refusal "$1" ;;
    *) echo "| \`${1##*/}\` | FAULT | | | | | | |" ;;
  esac
}

sweep() {  # ARETE PATH...
  local file count=0
  if ! ls "${@:2}" >/dev/null; then return 77; fi
  arete=$(realpath "$1")
  scratch=$(mktemp -d)
  trap 'rm -rf "$scratch"' EXIT
  mkdir "$scratch/work"
  if ! sandboxed --version; then
    echo "skipped: no sandbox or limits here: $(head -n 1 "$scratch/err")" >&2
    return 77
  fi
  echo '| file | result | posts | heights, m | no data | posts apart, m | CRS | said |'
  echo '|---|---|---|---|---|---|---|---|'
  while IFS= read -r file; do
    ((count++ % every == 0)) && sweep_file "$(realpath "$file")"
  done < <(find "${@:2}" -type f | LC_ALL=C sort)
  echo "$built built, $refused refused, $faults faults; at most $((peak >> 10)) MiB" >&2
  ((built + refused > 0 && faults == 0))
}

# A fake arete that breaks the promise in one way must be flagged in these words.
expect() {  # WORDS SCRIPT
  local code=0
  printf '#!/bin/bash\n[[ $1 != --version ]] || exit 0\n%s\n' "$2" >"$fakes/arete"
  chmod +x "$fakes/arete"
  "$0" --seconds 5 "$fakes/arete" "$fakes/dem.tif" >"$fakes/out" 2>&1 || code=$?
  if ((code == 77)); then cat "$fakes/out" && exit 77; fi
  if ! grep -qF -- "$1" "$fakes/out" || ((code != ${3:-1})); then
    echo "not '$1' but exit $code: $(<"$fakes/out")"
    faults=$((faults + 1))
  fi
}

self_test() {
  local make='[[ $1 != build ]] || mkdir store.arete' no='echo "arete: dem.tif: no: go" >&2; exit 1'
  fakes=$(mktemp -d)
  trap 'rm -rf "$fakes"' EXIT
  touch "$fakes/dem.tif"
  expect '1 built, 0 refused, 0 faults' "$make" 0
  expect '0 built, 1 refused, 0 faults' "$no" 0
  expect 'ended with 139' 'kill -SEGV $$'
  expect 'ran over 5 s' 'sleep 30'
  expect 'build ended with 9' 'dd if=/dev/zero of=/dev/null bs=2G count=1 2>/dev/null || exit 9'
  expect 'build said: TIFF' "$make; echo TIFF >&2"
  expect 'verify store.arete' "$make; [[ \$1 != verify ]] || { $no; }"
  expect 'not refused in one line' "echo note: >&2; $no"
  expect 'not refused in one line' 'echo "arete: import: no: go" >&2; exit 1'
  expect 'not refused in one line' 'exit 1'
  expect 'left behind: store.arete.part' "touch store.arete.part; $no"
  expect 'left behind: store.arete' "mkdir store.arete; $no"
  expect 'left behind: core' "$make; touch core"
  ((faults == 0))
}

if [[ ${1-} == --self-test ]]; then
  self_test
  exit
fi
while [[ ${1-} == --* ]]; do
  case $1 in
    --every) every=$2 ;;
    --seconds) seconds=$2 ;;
    *) break ;;
  esac
  shift 2
done
sweep "$@"
