#!/usr/bin/env bash
# The real program where the system fails it: every write-side system call killed or refused, names
# that cannot be exchanged, a full disk, a read-only folder, few open files, small files only, two
# builders at once, flipped bits.
# A failed build says one line, exits 1, leaves nothing beside the store, and the old store is as it
# was; after a kill the same command gives the same bytes.
# Usage: faults.sh ARETE [EVERY [FLIPS]]     EVERY: each EVERY-th call [41]; FLIPS: bits [8]
set -uo pipefail
arete=$(realpath "$1")
every=${2:-41} flips=${3:-8}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
export XDG_CACHE_HOME=$work/cache
unset DISPLAY WAYLAND_DISPLAY
faults=0 runs=0

fault() { echo "FAULT: $*"; faults=$((faults + 1)); }
has() { command -v "$1" >/dev/null || { echo "skipped: $2: no $1 here"; return 1; }; }
same() { diff -rq "$1" "$2" >/dev/null; }
one_line() { [[ $(wc -l <err) == 1 && $(head -c 7 err) == "arete: " ]]; }
fresh() { rm -rf s && mkdir s && cp -r old.arete s/t.arete; }
build() { "$arete" build new.tif -o "${1:-s/t.arete}" --force --quiet --threads 1; }

# A refused build: exit 1, one line that names a file, no part directory, the old store untouched.
check_refusal() {  # WHAT CODE
  runs=$((runs + 1))
  [[ $2 == 1 ]] || fault "$1: exit $2: $(cat err)"
  one_line || fault "$1: not one line: $(cat err)"
  grep -q "t\.arete\|new\.tif" err || fault "$1: names no file: $(cat err)"
  [[ ! -e s/t.arete.part ]] || fault "$1: leaves a part directory"
  same s/t.arete old.arete || fault "$1: the old store is changed"
}

# Indices, within their thread, of the calls of one kind that touch the store.
indices() {  # SYSCALL
  awk -v call="$1" '$2 ~ "^" call "\\(" { n[$1]++; if ($0 ~ /t\.arete/) print n[$1] }' log | sort -nu
}

inject() {  # SYSCALL INDEX FAULT
  fresh
  strace -f -qq -o /dev/null -e "trace=$1" -e "inject=$1:$3:when=$2" -- \
    "$arete" build new.tif -o s/t.arete --force --quiet --threads 1 >out 2>err
}

# After a kill: the old store or the new one, whole; then the same bytes as in one run.
check_kill() {  # WHAT
  runs=$((runs + 1))
  same s/t.arete old.arete || same s/t.arete new.arete || fault "$1: neither old nor new"
  "$arete" info s/t.arete --check >out 2>err || fault "$1: $(cat err)"
  build 2>err || fault "$1: resuming: $(cat err)"
  same s/t.arete new.arete || fault "$1: resumed to other bytes"
  [[ ! -e s/t.arete.part ]] || fault "$1: leaves a part directory"
}

check_errno() {  # SYSCALL INDEX FAULT
  local what="$1 $2 $3" code=0
  inject "$1" "$2" "$3" || code=$?
  ((code == 1)) && refused=$((refused + 1))  # of at_every_call
  if [[ $code == 0 ]]; then  # nothing was lost by it: tried again, or needless
    runs=$((runs + 1))
    same s/t.arete new.arete || fault "$what: exit 0, but not the new store"
  elif [[ $1 == unlink* || $1 == rmdir || $1 == flock ]]; then
    # What cannot be removed, or cannot be known to be one's own, stays for the next build.
    runs=$((runs + 1))
    { [[ $code == 1 ]] && one_line; } || fault "$what: exit $code: $(cat err)"
    { same s/t.arete old.arete || same s/t.arete new.arete; } || fault "$what: the store is changed"
  else
    check_refusal "$what" "$code"
  fi
}

at_every_call() {
  has strace "system calls" || return
  fresh
  strace -f -y -qq -o log "$arete" build new.tif -o s/t.arete --force --quiet --threads 1 ||
    { echo "skipped: system calls: strace may not trace here"; return; }
  local call index n=0 kind killed=0 refused=0
  for call in openat pwrite64 fallocate fsync rename renameat2 mkdir unlink unlinkat rmdir flock; do
    for index in $(indices $call); do
      for kind in signal=KILL error=ENOSPC error=EIO error=EDQUOT error=EINTR; do
        ((n++ % every == 0)) || continue
        if [[ $kind == signal=KILL ]]; then
          inject $call "$index" $kind 2>/dev/null
          (($? == 137)) && killed=$((killed + 1))
          check_kill "$call $index killed"
        else
          check_errno $call "$index" $kind
        fi
      done
    done
  done
  ((n > 0)) || fault "control: no call touches the store"
  ((n < every || killed + refused > 0)) || fault "control: no system call was failed"
  echo "system calls: $runs runs of $n points, $killed killed, $refused refused"
}

# Where names cannot be exchanged the old store moves aside first: killed at any of the last renames,
# it is there again after a build that is refused.
without_exchange() {
  has strace "no exchange of names" || return
  local plain=(strace -f -y -qq -o log -e "inject=renameat2:error=EINVAL") index gaps=0
  local command=("$arete" build new.tif -o s/t.arete --force --quiet --threads 1)
  fresh
  "${plain[@]}" "${command[@]}" || { echo "skipped: no exchange: strace may not trace here"; return; }
  same s/t.arete new.arete || fault "no exchange: not the new store"
  for index in $(indices rename | tail -n 4); do
    fresh
    { "${plain[@]}" -e "inject=rename:signal=KILL:when=$index" "${command[@]}"; } 2>/dev/null
    if [[ ! -e s/t.arete ]]; then
      gaps=$((gaps + 1))
      "$arete" info s/t.arete 2>err && fault "no exchange: info finds a store"
      { one_line && grep -q "t.arete.part/retired" err; } || fault "no exchange: $(cat err)"
    fi
    local code=0
    (ulimit -f 1 && build) 2>err || code=$?
    check_refusal "no exchange, killed at rename $index" "$code"
  done
  ((gaps > 0)) || fault "control: no kill between the two renames"
  fresh
  mkdir s/t.arete.part && mv s/t.arete s/t.arete.part/retired
  local code=0
  "$arete" build new.tif -o s/t.arete --quiet 2>err || code=$?
  [[ $code == 2 ]] || fault "no exchange, no --force: exit $code: $(cat err)"
  check_refusal "no exchange, no --force" 1
  echo "no exchange of names: $gaps kills with the old store moved aside"
}

in_box() {  # BWRAP-ARGUMENTS... -- COMMAND
  bwrap --ro-bind / / --dev /dev --proc /proc --unshare-net --unshare-pid --die-with-parent \
    --bind "$work" "$work" "$@"
}

full_disk() {
  has bwrap "full disk" || return
  in_box true 2>/dev/null || { echo "skipped: full disk: bwrap may not start here"; return; }
  local kib fitted=0
  for ((kib = 96; kib <= 4096; kib += kib / (every > 1 ? 2 : 8))); do
    in_box --size $((kib << 10)) --tmpfs "$work/s" -- bash -c '
      cp -r old.arete s/t.arete 2>/dev/null || exit 99
      "$0" build new.tif -o s/t.arete --force --quiet --threads 1 2>err; code=$?
      left=$(ls -A s); diff -rq s/t.arete old.arete >/dev/null && state=old
      echo "$code $left ${state:-new}" >result' "$arete"
    [[ $? == 99 ]] && continue
    runs=$((runs + 1))
    case $(cat result) in
      "1 t.arete old") one_line && grep -q "t\.arete" err || fault "full disk, $kib KiB: $(cat err)" ;;
      "0 t.arete new") fitted=$kib; break ;;
      *) fault "full disk, $kib KiB: $(cat result): $(cat err)" ;;
    esac
  done
  ((fitted > 0)) || fault "full disk: never fitted"
  echo "full disk: fits $fitted KiB"
}

read_only() {
  has bwrap "read-only folder" || return
  in_box true 2>/dev/null || { echo "skipped: read-only folder: bwrap may not start here"; return; }
  fresh
  local code=0
  in_box --ro-bind "$work/s" "$work/s" -- "$arete" build new.tif -o s/t.arete --force --quiet 2>err || code=$?
  check_refusal "read-only folder" "$code"
}

limits() {
  local code=0 n
  for n in 4 8 12 16 24; do  # open files
    fresh
    code=0
    (ulimit -n $n && build) 2>err || code=$?
    if [[ $code == 127 ]]; then continue; fi  # its own libraries could not be opened
    if [[ $code == 0 ]]; then same s/t.arete new.arete || fault "$n open files: another store"
    else check_refusal "$n open files" "$code"; fi
  done
  for n in 1 8; do  # KiB a file
    fresh
    code=0
    (ulimit -f $n && build) 2>err || code=$?
    check_refusal "files of $n KiB" "$code"
  done
}

# The loser says so in a line; the store is one of the two whole ones; nothing is left.
two_builders() {
  local source code i
  for i in $(seq "${1}"); do
    rm -rf s && mkdir s
    for source in old new; do
      "$arete" build $source.tif -o s/t.arete --quiet 2>err.$source & pids[$([[ $source == old ]]; echo $?)]=$!
    done
    for source in old new; do
      code=0
      wait "${pids[$([[ $source == old ]]; echo $?)]}" || code=$?
      cp err.$source err
      if [[ $code == 1 ]]; then one_line || fault "two builders: $(cat err)"
      elif [[ $code != 0 && $code != 2 ]]; then fault "two builders: exit $code: $(cat err)"; fi
    done
    same s/t.arete old.arete || same s/t.arete new.arete || fault "two builders: neither store"
    [[ ! -e s/t.arete.part ]] || fault "two builders: a part directory is left"
    runs=$((runs + 1))
  done
}

flip_bit() {  # FILE BYTE
  printf "\\x$(printf %02x $(($(od -An -tu1 -j "$2" -N 1 "$1") ^ (1 << (RANDOM % 8)))))" |
    dd of="$1" bs=1 seek="$2" conv=notrunc status=none
}

picture() {  # STORE PNG METHOD
  "$arete" render "$1" -o "$2" --method "$3" --size 160x90 --quiet 2>err
}

# A picture of a flipped store is the intact one, or fails, or says so.
check_picture() {  # WHAT METHOD
  local code=0
  rm -f flip.png
  picture s/t.arete flip.png "$2" || code=$?
  if [[ $code == 0 ]]; then
    cmp -s flip.png "intact-$2.png" && return
    changed[$2]=$((${changed[$2]:-0} + 1))
    grep -q damaged err || fault "$1: $2: another picture, no word"
  else
    { [[ $code == 1 ]] && one_line; } || fault "$1: $2: render exits $code: $(cat err)"
  fi
}

# One bit of the store: info --check must see it, and pictures of a tile and of a record method. The
# last bits are of the records: where no flip coarsens what soar draws nothing was tried.
flip_bits() {
  local file size at code what i method files record_flips=4
  local -A changed=()
  "$arete" build old.tif -o flip.arete --methods geomipmap,soar --quiet --threads 1 || exit 1
  for method in geomipmap soar; do
    picture flip.arete intact-$method.png $method ||
      { echo "skipped: flipped bits: $(cat err)"; return; }
  done
  files=(flip.arete/*)
  RANDOM=7
  for ((i = 0; i < flips + record_flips; i++)); do
    rm -rf s && mkdir s && cp -r flip.arete s/t.arete
    file=s/t.arete/$(basename "${files[i % ${#files[@]}]}")
    ((i < flips)) || file=s/t.arete/bintree.seg
    size=$(stat -c %s "$file") at=$(((RANDOM << 15 | RANDOM) % size))
    what="flip $file $at"
    flip_bit "$file" $at
    code=0
    "$arete" info s/t.arete --check >out 2>err || code=$?
    { [[ $code == 1 ]] && one_line; } || fault "$what: info --check exits $code: $(cat err)"
    for method in geomipmap soar; do check_picture "$what" $method; done
    runs=$((runs + 1))
  done
  ((${changed[soar]:-0} > 0)) || fault "control: no flip changes a picture of soar"
}

for seed in 1 2; do
  name=$([[ $seed == 1 ]] && echo old || echo new)
  "$arete" synth -o $name.tif --size 129 --seed $seed --quiet
  "$arete" build $name.tif -o $name.arete --quiet --threads 1 || exit 1
done
same old.arete new.arete && fault "control: two sources, one store"
at_every_call
without_exchange
full_disk
read_only
limits
two_builders $((every > 1 ? 3 : 20))
flip_bits
echo "$runs runs, $faults faults"
exit $((faults > 0))
