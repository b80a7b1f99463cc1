#!/usr/bin/env bash
# Fails when a file includes a room or a package that its room may not (docs/architecture.md).
# Usage: tools/check_rooms.sh [--self-test] [ROOT]
set -euo pipefail

# Rooms of ours that a room may include, besides itself; lod/X stands for one method's folder.
declare -A rooms=(
  [core]="" [raster]="core" [store]="core" [mesh]="core" [scene]="core"
  [lod]="core store mesh" [lod/X]="core store mesh lod" [render]="core scene"
  [proof]="core store mesh scene render lod/engine.h")
# Packages, by the first part of their headers; the system's own C headers are free.
declare -A packages=(
  [core]="" [raster]="gdal cpl_ ogr_ hdf5.h" [store]="zstd.h xxhash.h nlohmann"
  [mesh]="meshoptimizer.h nlohmann" [scene]="nlohmann" [lod]="" [lod/X]="meshoptimizer.h"
  [render]="epoxy EGL png.h shader_sources.h" [proof]="nlohmann")
everywhere="glm fmt sys/ unistd.h fcntl.h dirent.h poll.h pthread.h"

# The room of a path below src/arete: "store", "lod", or "lod/qlod" for a method's file.
room_of() {
  case $1 in
    lod/*/*) echo "lod/$(cut -d/ -f2 <<<"$1")" ;;
    *) echo "${1%%/*}" ;;
  esac
}

allows_room() {  # FILE INCLUDED, both below src/arete
  local from to kind allowed
  from=$(room_of "$1")
  to=$(room_of "$2")
  [[ $from != "$to" ]] || return 0
  # The table of methods is the one file that sees them all.
  [[ $1 != lod/engines.cpp || $to != lod/* ]] || return 0
  kind=$from
  [[ $from != lod/* ]] || kind=lod/X
  for allowed in ${rooms[$kind]-}; do
    [[ $allowed != "$to" && $allowed != "$2" ]] || return 0
  done
  return 1
}

allows_package() {  # FILE HEADER
  local from allowed
  from=$(room_of "$1")
  [[ $from != lod/* ]] || from=lod/X
  # A header of the standard library has neither a slash nor a suffix, or is a wrapped C header.
  [[ $2 == */* || $2 == *.h ]] || return 0
  for allowed in $everywhere ${packages[$from]-}; do
    [[ $2 != "$allowed"* ]] || return 0
  done
  return 1
}

check() {  # ROOT: prints each fault, fails when there is one
  local root=$1 faults=0 path line include file
  while IFS=: read -r path line include; do
    file=${path#"$root"/src/arete/}
    include=${include#*[<\"]}
    include=${include%[>\"]*}
    if [[ $include == arete/* ]]; then
      allows_room "$file" "${include#arete/}" ||
        { echo "$path:$line: $(room_of "$file") may not include $include"; faults=1; }
    elif [[ ! -e ${path%/*}/$include ]]; then
      allows_package "$file" "$include" ||
        { echo "$path:$line: $(room_of "$file") may not use the package of <$include>"; faults=1; }
    fi
  done < <(grep -rnE --include='*.h' --include='*.cpp' '^[[:space:]]*#[[:space:]]*include' "$root/src/arete")
  return $faults
}

# Plants one fault at a time in an empty tree, and one sound file: each must be judged rightly.
self_test() {
  local root faults
  root=$(mktemp -d)
  # shellcheck disable=SC2064
  trap "rm -rf '$root'" EXIT
  judge() {  # EXPECTED FILE INCLUDE
    rm -rf "$root/src"
    mkdir -p "$root/src/arete/$(dirname "$2")"
    echo "#include $3" >"$root/src/arete/$2"
    faults=sound
    check "$root" >/dev/null || faults=fault
    [[ $faults == "$1" ]] || { echo "self-test: $2 including $3 was judged $faults"; return 1; }
  }
  judge sound store/a.cpp '"arete/core/post.h"' && judge sound store/a.cpp '<zstd.h>' &&
    judge sound store/a.cpp '<vector>' && judge sound lod/engines.cpp '"arete/lod/qlod/qlod.h"' &&
    judge sound lod/qlod/a.cpp '"arete/lod/rtin.h"' && judge sound proof/a.h '"arete/lod/engine.h"' &&
    judge fault core/a.h '"arete/store/file.h"' && judge fault store/a.cpp '"arete/raster/dem.h"' &&
    judge fault lod/qlod/a.cpp '"arete/lod/merge/merge.h"' &&
    judge fault lod/rtin.cpp '"arete/lod/qlod/qlod.h"' &&
    judge fault lod/qlod/a.cpp '"arete/render/renderer.h"' &&
    judge fault render/a.cpp '"arete/store/terrain.h"' && judge fault proof/a.cpp '"arete/lod/rtin.h"' &&
    judge fault core/a.cpp '<gdal/gdal.h>' && judge fault scene/a.cpp '<png.h>'
}

if [[ ${1-} == --self-test ]]; then
  self_test && echo "check_rooms: self-test passed"
  exit
fi
root=${1:-$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)}
check "$root" && echo "check_rooms: every include is allowed"
