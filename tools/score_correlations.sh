#!/bin/sh
# Makes docs/score_correlations.md: how far the scores agree about the four families of representations, over heights, views
# and characters, and the pictures about which they do not.
# Usage: score_correlations.sh DRIVER OUT.md [--characters DIR] [--device D] [--rows FILE] [--tiny]
#
# --characters: a folder of glTF files that are scored beside the mannequin (../shared/characters where it is there).
# --rows: a store of the same views, made by the commands that the page names: it is read and nothing is drawn.
# --tiny: two heights, one view, the mannequin alone, to see that it runs. Pictures go to the folder OUT-pictures.
set -eu

fail() {
  echo "score_correlations: $*" >&2
  exit 2
}
[ $# -ge 2 ] || fail "usage: score_correlations.sh DRIVER OUT.md [--characters DIR] [--device D] [--rows FILE] [--tiny]"
driver=$1
out=$2
shift 2
characters=$(dirname "$0")/../../shared/characters
device=
rows=
tiny=
while [ $# -gt 0 ]; do
  case $1 in
    --characters) [ $# -ge 2 ] || fail "--characters needs a value"; characters=$2; shift ;;
    --device) [ $# -ge 2 ] || fail "--device needs a value"; device=$2; shift ;;
    --rows) [ $# -ge 2 ] || fail "--rows needs a value"; rows=$2; shift ;;
    --tiny) tiny=yes ;;
    *) fail "'$1' is not an option" ;;
  esac
  shift
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

families=flat,polypostor,relief,rigid
heights=24,48,96,192
azimuths=0,60,135,250
elevations=0,20
if [ -n "$tiny" ]; then
  families=flat:views=hemi-4,rigid
  heights=24,48
  azimuths=0
  elevations=0
  characters=
fi

# A character that a family refuses keeps its other rows: status 1.
score() {
  [ -z "$rows" ] || return 0
  echo "scoring $1" >&2
  status=0
  "$driver" quality --representation "$families" --character "$1" --height-px "$heights" --azimuth-deg "$azimuths" \
    --elevation-deg "$elevations" --db "$work/scores.sqlite" ${device:+--device "$device"} >"$work/said" 2>&1 || status=$?
  [ "$status" -le 1 ] || { cat "$work/said" >&2; fail "quality failed for $1"; }
}

score mannequin
for file in ${characters:+"$characters"/*.glb}; do
  [ -f "$file" ] || continue
  score "$file"
  # Whose it is: the first two lines that say something of the licence that lies beside it.
  licence=${file%.glb}.LICENSE.txt
  if [ -f "$licence" ]; then printf -- '- %s: %s\n' "$(basename "$file")" "$(grep '[^[:space:]]' "$licence" | head -n 2 | tr -s '\r\n\t ' ' ')" >>"$work/licences"; fi
done
"$driver" correlate "${rows:-$work/scores.sqlite}" --markdown "$out.part" --pictures "${out%.md}-pictures" >/dev/null
{
  printf '\n## How it was made\n\nBy `tools/score_correlations.sh`, for each character:\n\n'
  printf '    crowdbench quality --representation %s --character C --height-px %s --azimuth-deg %s --elevation-deg %s --db FILE.sqlite\n' \
    "$families" "$heights" "$azimuths" "$elevations"
  printf '    crowdbench correlate FILE.sqlite --markdown PAGE.md --pictures DIR\n'
  if [ -f "$work/licences" ]; then
    printf '\nCharacters of others, drawn here:\n\n'
    cat "$work/licences"
  fi
} >>"$out.part"
mv "$out.part" "$out"
