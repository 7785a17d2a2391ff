#!/usr/bin/env bash
# The window on a virtual screen, with real key presses and a real mouse: what it shows in its title, on the screen and
# in the files it saves. Usage: real_keys.sh PROGRAM. Exit code 77 (skipped) where Xvfb, xdotool or ImageMagick is absent.
set -euo pipefail
program=$1

for tool in Xvfb xdotool import compare; do
  command -v "$tool" >/dev/null || { echo "skipped: $tool is not installed"; exit 77; }
done

folder=$(mktemp -d)
cleanup() {
  [ -n "${viewer:-}" ] && kill "$viewer" 2>/dev/null || true
  [ -n "${screen:-}" ] && kill "$screen" 2>/dev/null || true
  wait 2>/dev/null || true
  rm -rf "$folder"
}
trap cleanup EXIT
fail() { echo "FAILED: $*"; echo "title: $(title || true)"; cat "$folder/log" 2>/dev/null || true; exit 1; }

# -displayfd: the server picks a free number, so that tests may run side by side.
Xvfb -displayfd 3 -screen 0 1180x620x24 -nolisten tcp 3>"$folder/display" 2>/dev/null &
screen=$!
for _ in $(seq 100); do [ -s "$folder/display" ] && break; sleep 0.1; done
export DISPLAY=:$(cat "$folder/display")

(cd "$folder" && exec "$program" view cornell --size 480x360 --samples 100000 >log 2>&1) &
viewer=$!

window=""
title() { xdotool getwindowname "$window" 2>/dev/null; }
# wait_for SECONDS WHAT COMMAND...: until COMMAND succeeds.
wait_for() {
  local tries=$(($1 * 10)) what=$2
  shift 2
  for _ in $(seq "$tries"); do "$@" && return 0; sleep 0.1; done
  fail "$what did not happen"
}
has_window() { window=$(xdotool search --name Halflight 2>/dev/null | head -n 1) && [ -n "$window" ]; }
title_has() { title | grep -q -- "$1"; }
samples() { title | sed -n 's/.*| \([0-9]*\) spp.*/\1/p'; }
samples_above() { [ "$(samples)" -gt "$1" ] 2>/dev/null; }
samples_below() { [ "$(samples)" -lt "$1" ] 2>/dev/null; }
snapshot() { import -window "$window" "$folder/$1.png"; }
differing_pixels() { compare -metric AE -fuzz 4% "$folder/$1.png" "$folder/$2.png" null: 2>&1 | sed 's/[^0-9.].*//' || true; }
press() { xdotool key --clearmodifiers "$1"; sleep 0.4; }

wait_for 40 "a window" has_window
focus() { xdotool windowfocus "$window" 2>/dev/null; }
wait_for 20 "focus" focus
wait_for 60 "a first picture" title_has "cornell | halflight"
wait_for 60 "convergence to 20 samples a pixel" samples_above 20
title_has "relMSE" || fail "no error estimate in the title"

snapshot plain
press h
snapshot help
[ "$(differing_pixels plain help | cut -d. -f1)" -gt 5000 ] || fail "H showed no help"
press h

# A key that changes the technique starts the picture again with another one.
press t
wait_for 20 "another technique" bash -c "xdotool getwindowname $window | grep -qv '| halflight |'"
wait_for 60 "a picture by it" samples_above 0

# A screenshot is a whole PNG and an EXR.
press s
wait_for 20 "a screenshot" test -s "$folder/halflight-001.png" -a -s "$folder/halflight-001.exr"
identify "$folder/halflight-001.png" | grep -q "PNG 480x360" || fail "the screenshot has another size"

# Exposure: two presses are one stop, the picture gets brighter.
snapshot before
press bracketright
press bracketright
snapshot brighter
mean() { convert "$folder/$1.png" -crop 400x300+20+20 -colorspace gray -format '%[fx:mean]' info:; }
awk -v a="$(mean before)" -v b="$(mean brighter)" 'BEGIN { exit !(b > a * 1.1) }' || fail "] did not brighten the picture"

# A drag turns the camera and starts the picture again.
wait_for 60 "some samples" samples_above 30
high=$(samples)
xdotool mousemove --window "$window" 200 180 mousedown 1
for step in 1 2 3 4 5; do xdotool mousemove_relative -- 12 4; sleep 0.05; done
xdotool mouseup 1
sleep 0.3
samples_below "$high" || fail "a drag did not start the picture again"

# Pausing keeps the count, Escape ends the program well.
press space
sleep 0.6
first=$(samples); sleep 1; [ "$first" = "$(samples)" ] || fail "space did not pause"
press Escape
status=0
for _ in $(seq 100); do kill -0 "$viewer" 2>/dev/null || break; sleep 0.1; done
wait "$viewer" || status=$?
viewer=""
[ "$status" -eq 0 ] || fail "the program ended with $status"
echo "passed"
