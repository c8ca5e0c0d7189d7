#!/bin/sh
# Makes docs/approaches.md: every approach in numbers, from one seed on one machine, and in a line each what is argued.
# Usage: approaches.sh DRIVER PLAN.toml OUT.md [--device D]
#
# PLAN: bench/plans/approaches.toml, or one of its form; its results are kept beside OUT as OUT.sqlite, and an ended run goes on.
# About an hour on two quiet cores once everything is baked, most of it the 10,000 agents.
set -eu

fail() {
  echo "approaches: $*" >&2
  exit 2
}
[ $# -ge 3 ] || fail "usage: approaches.sh DRIVER PLAN.toml OUT.md [--device D]"
driver=$1 plan=$2 out=$3
shift 3
device=
[ $# -eq 0 ] || { [ "$1" = --device ] && [ $# -eq 2 ] || fail "'$1' is not an option"; device=$2; }
[ -x "$driver" ] || fail "$driver is not there"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
with_device() { if [ -n "$device" ]; then "$driver" "$@" --device "$device"; else "$driver" "$@"; fi; }

# value JSON KEY: of the first member of that name. The driver prints one member a line.
value() { sed -n "s/^ *\"$2\": \"\{0,1\}\(.*[^\",]\)\"\{0,1\},\{0,1\}\$/\1/p" "$1" | sed -n 1p; }

results=${out%.md}.sqlite
status=0
with_device sweep "$plan" --out "$results" --markdown "$work/tables" >/dev/null || status=$?
[ "$status" -le 1 ] || fail "status $status of the sweep"  # 1: points failed, which the tables show
representations=$(sed -n 's/^representation = \[\(.*\)\]$/\1/p' "$plan" | sed 's/", *"/ /g' | tr -d '"')

# bytes one|all REPRESENTATION: what it takes of the mannequin with its walk, or all of its clips, in $work/bake.
bytes() {
  played='--clip 0 --clip 1 --clip 2 --clip 3'
  [ "$1" = all ] || played='--clip 0'
  shift
  with_device bake --character mannequin $played --representation "$1" --report --json >"$work/bake" 2>/dev/null || : >"$work/bake"
}
mib() { awk -v b="${1:-}" 'BEGIN { if (b == "") print "n/a"; else printf "%.2f\n", b / 1048576 }'; }
# bytes_with REPRESENTATION OPTION: MiB of one clip; "-" where it has no such option.
bytes_with() {
  case $1 in *:*) with=$1,$2 ;; *) with=$1:$2 ;; esac
  bytes one "$with"
  held=$(value "$work/bake" gpu_bytes)
  if [ -n "$held" ]; then mib "$held"; else echo -; fi
}
# flicker REPRESENTATION VIEWS...: as `quality` prints it.
flicker() {
  seen=$1
  shift
  with_device quality --representation "$seen" --height-px 120 --elevation-deg 12 "$@" --json 2>/dev/null |
    sed -n 's/^ *"flicker": \([0-9.e-]*\),\{0,1\}$/\1/p' | awk '{ printf "%.2f", $1; n = 1 } END { if (!n) print "n/a" }'
}

{
  printf '# The approaches beside each other\n\nMade by `tools/approaches.sh`. '
  with_device info --json >"$work/info"
  printf 'Drawn by %s.\n\n' "$(value "$work/info" renderer)"
  cat "$work/tables"
  printf '\n## What they take\n\nThe built-in mannequin by default options: MiB of textures and buffers with its walk alone, with its four clips, with the walk in\n'
  printf '20 stored frames and from 264 views (sphere-24x11); - where it has no such option; and the seconds that the bake took (of what comes\n'
  printf 'from the cache, when it was baked).\n\n'
  printf '| representation | one clip, MiB | four clips | 20 frames | 264 views | bake of four, s |\n|---|--:|--:|--:|--:|--:|\n'
  for r in $representations; do
    bytes one "$r"
    one=$(mib "$(value "$work/bake" gpu_bytes)")
    by_frames=$(bytes_with "$r" frames=20)
    by_views=$(bytes_with "$r" views=sphere-24x11)
    bytes all "$r"
    printf '| %s | %s | %s | %s | %s | %s |\n' "$r" "$one" "$(mib "$(value "$work/bake" gpu_bytes)")" "$by_frames" "$by_views" \
      "$(value "$work/bake" bake_seconds | awk '{ printf "%.1f", $1 }')"
  done
  printf '\n## What flickers and pops\n\n'
  printf 'One mannequin 120 pixels tall, twelve degrees from above: the score `flicker` (code values; 0: as steady as the mesh) over 31 frames of its\n'
  printf 'walk, and over 61 of an eye that goes round it by a degree a frame while it stands, where what is stored by views changes at once. Each frame is\n'
  printf 'drawn as if it were the first: what ages from frame to frame is not seen here. No row switches between others; the switches of one that does are\n'
  printf 'measured by `crowdbench popping`.\n\n| representation | walking | from round about |\n|---|--:|--:|\n'
  for r in $representations; do
    printf '| %s | %s | %s |\n' "$r" "$(flicker "$r" --azimuth-deg 33 --time 0:1:0.033333 --flicker)" \
      "$(flicker "$r" --azimuth-deg 0:60:1 --time 0 --orbit)"
  done
  printf '\n## What is argued\n\n| representation | clips at run time | close by | from above | shadows |\n|---|---|---|---|---|\n'
  "$driver" info --representations --json | sed -n 's/^ *"\(name\|new_clips\|close_by\|from_above\|shadows\)": "\(.*\)",\{0,1\}$/\1\t\2/p' |
    awk -F '\t' '{ of[$1] = $2 } $1 == "shadows" { printf "| %s | %s | %s | %s | %s |\n", of["name"], of["new_clips"], of["close_by"], of["from_above"], of["shadows"] }'
} >"$out.part"
mv "$out.part" "$out"
