#!/bin/sh
# Makes the pictures of the view in the documentation: tools/figures/view_pictures.sh [PROGRAM]
# Walks tangent_circle with a browser as viewer (view_live.webp), then plays the result (view_playback.webp). Needs chromium,
# node and ffmpeg.
set -eu
root=$(dirname "$(dirname "$(dirname "$(readlink -f "$0")")")")
program=${1:-$root/build/release/tools/cli/gaitslam}
place=$(mktemp -d "${TMPDIR:-/tmp}/gaitslam-view-XXXXXX")
trap 'rm -rf "$place"' EXIT

# photograph NAME SECONDS THEME: a picture of the program that prints its URL into $place/url.
photograph() {
  until grep -q token "$place/url"; do sleep 0.1; done
  node "$root/tests/tools/use_view.cjs" picture "$(sed -n 's/^view at //p' "$place/url")" "$place/profile" "$2" "$place/$1.png" 1200 860 "$3" >"$place/log"
  ffmpeg -loglevel error -y -i "$place/$1.png" -quality 80 "$root/tools/figures/$1.webp"
}

"$program" run "$root/scenarios/tangent_circle.yaml" --view --wait --out "$place/walk" >"$place/url" &
photograph view_live 24 dark
wait $!
"$program" view "$place/walk/seed-1" >"$place/url" &
photograph view_playback 32.6 light
kill -INT $!
wait $!
