#!/bin/sh
# Makes docs/figures.md: every public figure of this project, each below the command that made it.
# Usage: figures.sh DRIVER OUT.md [--device D] [--tiny]
#
# Plain sh and awk, because the bundle runs it on machines that have little else. --tiny: few agents, views and turns, to
# see that it runs. Five minutes on two cores; a quiet machine gives narrower intervals.
set -eu

fail() {
  echo "figures: $*" >&2
  exit 2
}
[ $# -ge 2 ] || fail "usage: figures.sh DRIVER OUT.md [--device D] [--tiny]"
driver=$1
out=$2
shift 2
device=
tiny=
while [ $# -gt 0 ]; do
  case $1 in
    --device) [ $# -ge 2 ] || fail "--device needs a value"; device=$2; shift ;;
    --tiny) tiny=yes ;;
    *) fail "'$1' is not an option" ;;
  esac
  shift
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

publish() {
  cp "$work/page" "$out.part"
  mv "$out.part" "$out"
}
# Whoever ends it early, gpu_check when its time is up, keeps the tables that are there.
cut_short() {  # STATUS
  trap '' INT TERM
  if [ -s "$work/page" ]; then
    printf '\nEnded before all was measured: what is missing here was not reached.\n' >>"$work/page"
    publish
  fi
  exit "$1"
}
trap 'cut_short 130' INT
trap 'cut_short 143' TERM

# ---- commands and their JSON ------------------------------------------------------------------------------------------

# run ARGUMENT...: the command's JSON, one "path<TAB>value" a line, in $work/facts, and the command itself in
# $work/commands. Status 1 is a failed check: the page says so.
run() {
  line=crowdbench
  for word in "$@"; do
    case $word in *[\(\),\#]*) line="$line '$word'" ;; *) line="$line $word" ;; esac
  done
  echo "    $line" >>"$work/commands"
  echo "$line" >&2
  status=0
  if [ -n "$device" ]; then
    "$driver" "$@" --device "$device" --json >"$work/json" 2>"$work/said" || status=$?
  else
    "$driver" "$@" --json >"$work/json" 2>"$work/said" || status=$?
  fi
  if [ "$status" -gt 1 ] || [ ! -s "$work/json" ]; then
    cat "$work/said" >&2
    fail "status $status: $line"
  fi
  # The driver prints one value, brace or bracket a line.
  awk '{
    sub(/^ +/, ""); sub(/,$/, "")
    if ($0 ~ /^[]}]/) { --depth; next }
    if (kind[depth] == "[") key = count[depth]++
    else if (match($0, /^"[^"]*": /)) { key = substr($0, 2, RLENGTH - 4); $0 = substr($0, RLENGTH + 1) }
    else key = ""
    path = prefix[depth] key
    if ($0 == "{" || $0 == "[") { ++depth; kind[depth] = $0; count[depth] = 0; prefix[depth] = path == "" ? "" : path "." }
    else { gsub(/^"|"$/, ""); print path "\t" $0 }
  }' "$work/json" >"$work/facts"
}

# Number DIGITS VALUE, n/a where there is none.
number() {
  case ${2:-null} in null) echo n/a ;; *) awk -v d="$1" -v v="$2" 'BEGIN { printf "%.*f\n", d, v }' ;; esac
}
fact() { awk -F'\t' -v path="$1" '$1 == path { print $2; exit }' "$work/facts"; }
# The commands since the last call, below the table that they made.
commands() {
  echo
  cat "$work/commands"
  echo
  : >"$work/commands"
}

# ---- the page ---------------------------------------------------------------------------------------------------------

speed() {  # OF TO AGENTS
  if [ -n "$tiny" ]; then
    run ratio --of "$1" --to "$2" --agents "$3" --occupancy 0.15 --size 160x120 --pairs 20
  else
    run ratio --of "$1" --to "$2" --agents "$3" --occupancy 0.15 --size 640x480
  fi
  time=$(fact headline)
  reason=$(fact void_reason)
  [ "$reason" = null ] && reason= || reason="void: $reason"
  [ "$(fact valid)" = true ] || reason="failed: $(fact faults.0)"
  echo "| $1 | $2 | $3 | $time | $(number 2 "$(fact "${time}_ratio")") | $(number 2 "$(fact interval.0)") .." \
    "$(number 2 "$(fact interval.1)") | $(number 2 "$(fact to_500_triangles)") |" \
    "$(number 2 "$(fact to_500_triangles_interval.0)") .. $(number 2 "$(fact to_500_triangles_interval.1)") |" \
    "$(number 2 "$(fact mesh_floor)") | $(fact pairs) | $reason |"
}

quality() {  # REPRESENTATION ELEVATION HEIGHTS AZIMUTHS
  run quality --representation "$1" --height-px "$3" --azimuth-deg "$4" --elevation-deg "$2"
  awk -F'\t' -v name="$1" -v elevation="$2" -v heights="$3" '
    $1 ~ /^rows\./ { split($1, at, "."); value[at[2], at[3]] = $2; if (at[2] + 1 > rows) rows = at[2] + 1 }
    function mean(height, key,   sum, n, i) {
      for (i = 0; i < rows; ++i) if (int(value[i, "height_px"] + 0.5) == height && value[i, key] != "null") { sum += value[i, key]; ++n }
      return n ? sum / n : "nan"
    }
    END {
      n = split(heights, list, ",")
      for (k = 1; k <= n; ++k)
        printf "| %s | %s | %s | %.3f | %.2f | %.3f | %.1f |\n", name, list[k], elevation, mean(list[k], "silhouette_iou"),
          mean(list[k], "boundary_px_mean"), mean(list[k], "ssim"), mean(list[k], "psnr")
    }' "$work/facts"
}

switch_rows() {  # DEGREES
  if [ -n "$tiny" ]; then
    run switch-distance --off-axis-deg "$1" --representation "$small" --size 160x120 --ratio 1
  else
    run switch-distance --off-axis-deg "$1"
  fi
  i=0
  while [ -n "$(fact "rows.$i.ratio")" ]; do
    echo "| $(fact "rows.$i.ratio") | $1 | $(number 3 "$(fact "rows.$i.depth_m")") |" \
      "$(number 3 "$(fact "rows.$i.measured_depth_m")") | $(number 2 "$(fact "rows.$i.measured_over_derived_percent")") |"
    i=$((i + 1))
  done
}

pops() {
  if [ -n "$tiny" ]; then
    run popmap --representation "$small" --azimuth-deg 0 --elevation-deg 0 --phase 0.025 --ratio 1
  else
    run popmap --representation flat
  fi
  i=0
  while [ -n "$(fact "sizes.$i.ratio")" ]; do
    for pose in own matched; do
      for change in cut fade; do
        at=$(awk -F'\t' -v from="sizes.$i.switch.${pose}_$change" 'index($1, from) == 1 { split($1, p, "."); print p[1] "." p[2] "." p[3] "." p[4]; exit }' "$work/facts")
        [ -n "$at" ] || fail "popmap says nothing of ${pose}_$change"
        case $pose in own) pose_text="its own" ;; *) pose_text="the stored frame's" ;; esac
        case $change in cut) change_text=cut ;; *) change_text="largest step of a 4-tick fade" ;; esac
        echo "| $(fact "sizes.$i.ratio") | $pose_text | $change_text | $(number 2 "$(fact "$at.mae.mean")") |" \
          "$(number 2 "$(fact "$at.mae.p95")") | $(number 2 "$(fact "$at.mae.worst")") |" \
          "$(number 3 "$(fact "$at.ssim_union.mean")") | $(number 3 "$(fact "$at.ssim_union.p05")") |" \
          "$(number 3 "$(fact "$at.ssim_union.worst")") |"
      done
    done
    i=$((i + 1))
  done
}

page() {
  : >"$work/commands"
  run info
  : >"$work/commands"
  cat <<TEXT
# Figures

Made by \`./run figures\`; no number on this page was typed by hand. Ratios are of process CPU time on a software rasteriser or of
GPU time on hardware, interleaved in one process: above 1, the first is the faster. Intervals are bootstrap 95 %.

Drawn by $(fact renderer) ($(fact gl_version)).

## Speed against the mesh

Beside each, the same against a level of detail: the mesh simplified to 500 triangles. Levels of equal error and of equal cost are
in [levels.md](levels.md).

| of | to | agents | time | ratio | interval | against 500 triangles | interval | mesh over its floor | pairs | |
|---|---|---|---|---|---|---|---|---|---|---|
TEXT
  if [ -n "$tiny" ]; then
    speed "$small" mesh 12
  else
    speed flat mesh 250
    speed flat mesh 1000
    speed flat flat:quad=square 1000
    speed flat flat:floor=1 1000
    speed relief mesh 100
    speed relief:bend=rigid mesh 100
    speed relief mesh 1000
    speed relief relief:search=linear,steps=16+7,proxy=box 1000
    speed polypostor mesh 1000
    speed polypostor polypostor:floor=1 1000
    speed rigid mesh 1000
    speed mesh mesh:floor=1 250
  fi
  commands

  cat <<'TEXT'
## Quality against the mesh

One walking mannequin at the identical view, mean over azimuths 0 to 315 degrees.

| representation | height, px | elevation | IoU | boundary, px | SSIM (crop) | PSNR, dB |
|---|---|---|---|---|---|---|
TEXT
  if [ -n "$tiny" ]; then
    quality "$small" 0 30,60 0:90:90
  else
    for representation in flat polypostor relief; do
      for elevation in 0 30; do quality "$representation" "$elevation" 30,60,120,240 0:315:45; done
    done
  fi
  commands

  cat <<'TEXT'
## The switch from mesh to flat impostors

Where a texel spans that many pixels: derived, and measured from pictures.

| pixels a texel | degrees off the axis | derived depth, m | measured, m | off by, % |
|---|---|---|---|---|
TEXT
  switch_rows 0
  [ -n "$tiny" ] || switch_rows 20
  commands
  cat <<'TEXT'
What it would show: differences over the silhouettes between the last picture before and the first after the switch.

| pixels a texel | mesh's pose | | MAE mean | p95 | worst | SSIM mean | p05 | worst |
|---|---|---|---|---|---|---|---|---|
TEXT
  pops
  commands
}

small=flat:views=sphere-8x2,frames=4
page >"$work/page"
publish
