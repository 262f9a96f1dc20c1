#!/bin/bash
# Pictures of cpinn-show: those of all robots, and .svg, .png, .gif and movies by a stand-in for the encoder.
#   test_pictures.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"
robots=$ROOT/configs/robots
python=0
command -v python3 >/dev/null || python=77

seen() { # KIND FILE [WORDS...]: by test_pictures.py
    test $python = 77 || check "$@" -- python3 "$ROOT/tests/test_pictures.py" "$@"
}

# ---- all robots ---------------------------------------------------------------------------------

mkdir all
run 0 "$ROOT/tools/pictures.sh" "$work/all"
for scene in "$robots"/*.yaml; do
    name=$(basename "$scene" .yaml)
    case $name in *_published | *_residual) continue ;; esac
    case $name in
    *_control | tendon_family) seen png "all/$name.png" 960 640 ;;
    *) seen file "all/$name.png" 960 640 ;; # quicker
    esac
    check "$name has its picture" -- test -s "$robots/$name.png"
    check "$name is in the gallery" -- grep -qF "robots/$name.png" "$ROOT/configs/README.md"
done

# ---- what is drawn ------------------------------------------------------------------------------

# The tip, tensions and the load that are written are those of the scene.
run 0 cpinn-solve "$robots/tendon_one_segment.yaml" --grid 3 --out solved.csv
run 0 cpinn-show "$robots/tendon_one_segment.yaml" --out robot.svg
said stdout.txt '^wrote robot.svg$'
seen svg robot.svg solved.csv 'tendons 2 N, 1 N, 0 N' '100 mN'
check small -- test "$(wc -c <robot.svg)" -lt 150000
run 0 cpinn-show "$robots/tendon_in_motion.yaml" --grid 21x26 --out motion.svg
seen svg motion.svg '' 'tendon 300 mN' '500 ms'
# A table alone, a beam, a ring, a family and one of its members.
run 0 cpinn-solve "$ROOT/configs/soft_arm.yaml" --grid 21x13 --out arm.csv
run 0 cpinn-show arm.csv --out arm.svg
seen svg arm.svg '' '600 ms'
run 0 cpinn-show "$ROOT/configs/beam_cantilever.yaml" --out beam.svg
seen svg beam.svg
run 0 cpinn-show "$ROOT/configs/ring.yaml" --out ring.png
seen png ring.png 960 640
run 0 cpinn-show "$robots/bensch_2024.yaml" --out family.html
said family.html '"labels": \["force = '
run 0 cpinn-show "$robots/bensch_2024.yaml" --at force=2,direction=30 --out member.svg
seen svg member.svg '' 'tendons 2.31 N, 1.15 N'
# A closed loop goes along its path.
printf 't,reference_x,reference_y,reference_z,true_x,true_y,true_z\n0,0,0,0,0,0,3e-3\n1,1,0,0,1,0,-4e-3\n' >loop.csv
run 0 cpinn-show loop.csv --out loop.svg
seen svg loop.svg '' 'tip (1000.0, 0.0, -4.0) mm'

# ---- what moves ---------------------------------------------------------------------------------

# 0.6 s twice as slow are 25 images of 50 ms.
if command -v ffmpeg >/dev/null; then
    run 0 cpinn-show arm.csv --scene "$ROOT/configs/soft_arm.yaml" --out arm.gif --slow 2
    seen gif arm.gif 720 480 25 5
fi
mkdir encoder
cat >encoder/ffmpeg <<'END'
#!/bin/sh
for last; do :; done
echo "$*" >arguments.txt
wc -c >"${last#file:}"
END
chmod +x encoder/ffmpeg
usual=$PATH
PATH=$work/encoder:$usual
while read -r ending width height rate images; do # of a fifth of 0.6 s
    run 0 cpinn-show arm.csv --out "arm.$ending" --slow 0.2
    check "all of $ending" -- test "$(cat "arm.$ending")" -eq $((images * width * height * 3))
    said arguments.txt "-video_size ${width}x$height -framerate $rate .* -f $ending file:arm.$ending.partial\$"
done <<'END'
mp4 1280 720 30 5
webm 1280 720 30 5
gif 720 480 20 3
END
# An encoder that fails at once, after some bytes, at the end: one line, no file.
for fails in 'exit 1' 'head -c 100000 >/dev/null; exit 1' 'cat >/dev/null; exit 1' 'kill -9 $$'; do
    printf '#!/bin/sh\necho "no such codec" >&2\nfor last; do :; done\necho half >"${last#file:}"\n%s\n' \
        "$fails" >encoder/ffmpeg
    rm -f other.mp4
    run 1 cpinn-show arm.csv --out other.mp4 --slow 0.2
    said stderr.txt '^cpinn-picture: arm.csv: other.mp4: not written, ffmpeg failed: no such codec$'
    check one line -- test "$(wc -l <stderr.txt)" -eq 1
    check no file -- test ! -e other.mp4 -a ! -e other.mp4.partial
done
printf '#!/bin/sh\ncat >/dev/null\n' >encoder/ffmpeg
run 1 cpinn-show arm.csv --out other.mp4 --slow 0.2
said stderr.txt 'ffmpeg failed: it says nothing'
PATH=$usual
mkdir python
printf '#!/bin/sh\nexec "%s" "$@"\n' "$(python3 -c 'import sys; print(sys.executable)')" >python/python3
chmod +x python/python3
refused 'movies need the encoder ffmpeg, .*apt-get install ffmpeg.' \
    env PATH="$BIN:$work/python" cpinn-show arm.csv --out other.mp4
refused 'pictures need python3 with numpy' env PATH="$BIN" cpinn-show arm.csv --out other.png

# A page has what its picture needs.
run 0 cpinn-show arm.csv --out page.html
run 0 cpinn-picture page.html --out page.svg
run 0 cpinn-show arm.csv --out shown.svg --quiet
check quiet -- test ! -s stdout.txt
check the same picture -- cmp page.svg shown.svg
run 0 cpinn-picture --help
said stdout.txt '^usage: cpinn-picture '
refused '^cpinn-picture: nowhere.html: No such file' cpinn-picture nowhere.html --out page.svg
refused '^cpinn-picture: arm.csv: is no page of cpinn-show' cpinn-picture arm.csv --out page.svg
refused '^cpinn-picture: --out page.bmp: allowed: .svg, .png' cpinn-picture page.html --out page.bmp
refused '^cpinn-picture: --out is missing' cpinn-picture page.html
mkdir taken.svg
run 1 cpinn-picture page.html --out taken.svg
said stderr.txt '^cpinn-picture: taken.svg: not written: Is a directory$'

# ---- what cannot be drawn -----------------------------------------------------------------------

refused 'nothing moves; allowed: .svg, .png' cpinn-show solved.csv --out still.gif
refused 'too long for a .gif; allowed: up to 50, by --slow' cpinn-show arm.csv --out long.gif --slow 1e3
refused 'allowed: .*0.001' cpinn-show arm.csv --out long.gif --slow 0
printf 's,n1\n0,1\n1,2\n' >numbers.csv
refused 'numbers.csv: ' cpinn-show numbers.csv --out numbers.png
mkdir folder
printf 'case,seconds\na,1\n' >folder/cases.csv
refused 'has no shapes for a picture; allowed: .html' cpinn-show folder --out folder.png
finish
