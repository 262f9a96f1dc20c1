#!/bin/bash
# The pictures of the robots, which tools/pictures.sh draws and pages show; the place that one names;
# movies, for which an encoder stands in.
#   test_pictures.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"

is_png() {
    [ "$(head -c 8 "$1" 2>/dev/null | od -An -tx1 | tr -d ' ')" = 89504e470d0a1a0a ]
}

mkdir drawn
run 0 "$ROOT/tools/pictures.sh" "$work/drawn"
check a picture of each robot -- test "$(ls drawn | wc -l)" -ge 12
for file in drawn/*.png; do
    name=$(basename "$file")
    check "$name is a picture" -- is_png "$file"
    check "$name is less than 250 kB" -- test "$(stat -c %s "$file")" -lt 250000
    check "$name is in configs/robots" -- is_png "$ROOT/configs/robots/$name"
    said "$ROOT/configs/README.md" "robots/$name"
done

# The tip, in mm to a tenth, is where the solver has it.
robot=$ROOT/configs/robots/tendon_pulled.yaml
run 0 cpinn-show "$robot" --out pulled.svg
run 0 cpinn-solve "$robot" --out pulled.csv
tip=$(awk -F, '$1 == "s" { for (i = 1; i <= NF; i++) at[$i] = i; next }
    { x = $at["x"]; y = $at["y"]; z = $at["z"] }
    END { printf "tip (%.1f, %.1f, %.1f) mm", 1000 * x, 1000 * y, 1000 * z }' pulled.csv)
check "the picture names the $tip" -- grep -qF "$tip" pulled.svg

# An encoder gets whole images, 30 a second of the motion; what it makes is the movie.
mkdir bin
cat >bin/ffmpeg <<'END_OF_ENCODER'
#!/bin/bash
for last; do :; done
wc -c >"${last#file:}"
echo "$*" >"$WORDS"
END_OF_ENCODER
chmod +x bin/ffmpeg
cat >swing.yaml <<'END'
rod: {model: kirchhoff, length: 0.3, section: {shape: circle, radius: 0.005},
  material: {youngs_modulus: 1.0e7, poissons_ratio: 0.45, density: 1070}}
boundary: {start: {type: clamped, rotation: [0, 1, 0, 1]}}
loads: {gravity: [0, 0, -9.81]}
time: {duration: 0.1}
END
export WORDS=$work/words.txt
PATH=$work/bin:$PATH run 0 cpinn-show swing.yaml --out swing.mp4
said words.txt '-pixel_format rgb24 -video_size 1280x720'
images=$(($(cat swing.mp4) / (3 * 1280 * 720)))
check whole images -- test "$(cat swing.mp4)" -eq $((images * 3 * 1280 * 720)) -a "$images" -ge 3
printf '#!/bin/sh\necho it breaks >&2\nexit 1\n' >bin/ffmpeg
PATH=$work/bin:$PATH run 1 cpinn-show swing.yaml --out broken.mp4
said stderr.txt 'it breaks'
check nothing is left -- test -z "$(ls | grep broken)"
if ! command -v ffmpeg >/dev/null; then
    refused 'ffmpeg, which is not installed' cpinn-show swing.yaml --out none.mp4
fi
finish
