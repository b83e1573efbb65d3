#!/usr/bin/env bash
# End-to-end demo: a physics simulation in one process streams poses to FIRE-3DV in another, which writes images.
# Installs packages, builds and runs. Starts from a bare machine; tools/setup.sh lists supported systems.
#
#   tools/demo.sh [--transport shm|tcp|udp] [--seconds N] [--size WxH] [--camera NAME] [--out DIR]
#       Writes PNGs and an MP4 of N simulated seconds of the arm (default 8, at 1280x720), 15 images per second. The
#       simulation waits for each image, so that the video is smooth on slow machines, too.
#   tools/demo.sh --window [...]
#       Opens a window and shows the arm in real time until the window is closed.
#
# FIRE3DV_DEMO_BIN=DIR uses the programs in DIR and skips installation and build.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

usage() { echo "demo.sh: $*; tools/demo.sh --help prints the options" >&2; exit 2; }
say() { printf '\n== %s\n' "$*"; }
die() { echo "demo.sh: $*" >&2; exit 1; }

transport=shm seconds=8 size=1280x720 camera=camera_front out=demo-output window=0
while [ $# -gt 0 ]; do
  case "$1" in
    --window) window=1; shift; continue ;;
    -h | --help) sed -n '2,12s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    --transport | --seconds | --size | --camera | --out) [ $# -ge 2 ] || usage "$1 needs a value" ;;
    *) usage "unknown option $1" ;;
  esac
  case "$1" in
    --transport) transport=$2 ;;
    --seconds) seconds=$2 ;;
    --size) size=$2 ;;
    --camera) camera=$2 ;;
    --out) out=$2 ;;
  esac
  shift 2
done
[[ $transport =~ ^(shm|tcp|udp)$ ]] || usage "--transport is shm, tcp or udp, not '$transport'"
[[ $seconds =~ ^[1-9][0-9]{0,3}$ ]] || usage "--seconds is a whole number from 1 to 9999, not '$seconds'"
[[ $size =~ ^[1-9][0-9]{1,4}x[1-9][0-9]{1,4}$ ]] || usage "--size is WIDTHxHEIGHT, not '$size'"
[ -n "$out" ] || usage "--out is a folder"
if [ $window = 1 ] && [ -z "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ]; then
  die "there is no display to open a window on (neither DISPLAY nor WAYLAND_DISPLAY is set): leave out --window"
fi
mkdir -p -- "$out" || die "cannot make the folder $out"
out=$(cd -- "$out" && pwd)

if [ -n "${FIRE3DV_DEMO_BIN:-}" ]; then
  bin=$FIRE3DV_DEMO_BIN
else
  say "set-up"
  "$root/tools/setup.sh"
  say "build"
  (cd "$root" && cmake --preset release && cmake --build --preset release --target fire3dv bullet_arm)
  bin=$root/build/release/bin
fi
for program in fire3dv bullet_arm; do [ -x "$bin/$program" ] || die "there is no program $bin/$program"; done

# Removes output of earlier runs.
find "$out" -maxdepth 1 -type f \( -name 'frame_*.png' -o -name frames.jsonl -o -name frames.ffconcat \
  -o -name demo.mp4 -o -name stats.csv -o -name '*.log' \) -delete

free_port() { # $1: STREAM or DGRAM
  python3 -c "import socket; s = socket.socket(socket.AF_INET, socket.SOCK_$1); s.bind(('127.0.0.1', 0)); print(s.getsockname()[1])"
}
case $transport in
  shm) uri=shm://fire3dv-demo-$$ ;;
  tcp) uri=tcp://127.0.0.1:$(free_port STREAM) ;;
  udp) uri=udp://127.0.0.1:$(free_port DGRAM) ;;
esac

children=()
stop_children() {
  local child
  for child in "${children[@]}"; do kill -TERM "$child" 2>/dev/null || true; done
  for child in "${children[@]}"; do wait "$child" 2>/dev/null || true; done
  children=()
}
trap stop_children EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

say "scene: a robot arm, blocks and cans"
scene=$out/bullet_arm.glb
"$bin/bullet_arm" --write-scene "$scene"
echo "$scene"

if [ $window = 1 ]; then
  say "the arm over $uri, until the window is closed"
  "$bin/bullet_arm" --to "$uri" --realtime --loop >"$out/bullet_arm.log" 2>&1 &
  children+=($!)
  "$bin/fire3dv" "$scene" --listen "$uri" --size "$size" --camera "$camera"
  exit
fi

say "simulation of $seconds s, drawn in another process"
echo "bullet_arm publishes the poses of its bodies over $uri; fire3dv draws $((15 * seconds + 1)) images of $size."
# 240 steps per second, every sixteenth published and drawn: 15 images per second, and one for the start. The table of
# times per pass is in the log and in stats.csv.
"$bin/fire3dv" "$scene" --listen "$uri" --headless --lockstep --exit-when-done --size "$size" --camera "$camera" \
  --out "$out" --stats "$out/stats.csv" 2> >(tee "$out/fire3dv.log" | sed -u '/^  /d; /: info: images/!{/: info: /d}') &
renderer=$!
children+=("$renderer")
"$bin/bullet_arm" --to "$uri" --seconds "$seconds" --rate 240 --lockstep --lockstep-every 16 --publish-every 16 \
  >"$out/bullet_arm.log" 2>&1 &
simulator=$!
children+=("$simulator")

# The renderer may exit as soon as the simulator says goodbye, so either may end first. A failure of either ends the
# demo.
for remaining in 2 1; do
  ended=0 code=0
  wait -n -p ended "${children[@]}" || code=$?
  if [ "$ended" = "$simulator" ]; then
    [ "$code" = 0 ] || { tail -n 5 "$out/bullet_arm.log" >&2; die "the simulator failed (exit code $code)"; }
    children=("$renderer")
  else
    [ "$code" = 0 ] || die "the renderer failed (exit code $code); the reason is above"
    children=("$simulator")
  fi
done
children=()

say "video"
"$root/tools/video_list.py" "$out" >"$out/frames.ffconcat"
video=$out/demo.mp4
ffmpeg -nostdin -v error -y -f concat -i "$out/frames.ffconcat" \
  -vf 'fps=15,pad=ceil(iw/2)*2:ceil(ih/2)*2' -c:v libx264 -preset veryfast -crf 18 -pix_fmt yuv420p -movflags +faststart "$video"
[ -s "$video" ] || die "ffmpeg wrote no video"

images=("$out"/frame_*.png)
say "done"
echo "video:  $video"
echo "images: ${#images[@]}, $out/frame_000000.png and on"
echo "times:  of an image, and from the simulator's call to the submission of the image with its poses (pose age):"
grep -E '^  (image|pose age) ' "$out/fire3dv.log"
echo "files:  frames.jsonl names the simulation step of each image, stats.csv its times; *.log is what the programs said"
echo "next:   tools/demo.sh --window opens a window (with a display); docs/tour.md shows what it can do"
