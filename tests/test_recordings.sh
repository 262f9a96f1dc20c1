#!/bin/bash
# Motions whose inputs were recorded, as users have them: unknowns from them, and the filter that
# goes through them again. The motion is solved by another method, with the inputs as formulas.
#   test_recordings.sh BIN ROOT
set -u
. "$(dirname "$0")/programs.sh"

cat >arm.yaml <<'YAML'
parameters:
  pull1: {range: [0, 4]}
  pull2: {range: [0, 4]}
  payload: {range: [0, 0.1]}
  stiffness: {range: [0.5, 2]}
rod:
  model: kirchhoff
  length: 0.3
  section: {shape: circle, radius: 0.01}
  material: {youngs_modulus: 1.0e6*stiffness, poissons_ratio: 0.45, density: 1070,
             relaxation_time: 0.03}
boundary: {start: {type: clamped}}
initial: {state: equilibrium}
loads: {gravity: [0, 0, 9.81]}
tendons:
  - {offset: [0.01, 0], tension: pull1}
  - {offset: [0, 0.01], tension: pull2}
bodies: [{at: 0.3, mass: payload}]
time: {duration: 2, windows: 1}
YAML

# near A B MOST: whether A is not further from B.
near() { awk -v a="$1" -v b="$2" -v most="$3" 'BEGIN { d = a - b; exit !(d <= most && -d <= most) }'; }

# The truth every 20 ms at two places, by the solver that estimates its error, and files with a
# noise of 0.3 mm that is always the same.
truth() { # FILE PAYLOAD [OPTION...]
    run 0 cpinn-solve arm.yaml --set "parameters.pull1=2*sin(2*t)^2" --set "parameters.pull2=1.5+1.5*sin(5*t)" \
        --set parameters.stiffness=0.8 --set "parameters.payload=$2" --method modes --points places.csv --out "$1" --quiet "${@:3}"
    awk -F, -v OFS=, -v load="$2" 'NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i
            print "s,t,pull1,pull2,payload,x,y,z"; next }
        function noise() { seed = (seed * 16807) % 2147483647; return seed / 2147483647 }
        function normal() { n = 0; for (k = 0; k < 12; k++) n += noise(); return 3e-4 * (n - 6) }
        NR == 2 { seed = 12345 }
        { t = $at["t"]; printf "%s,%s,%.12g,%.12g,%g,%.9g,%.9g,%.9g\n", $at["s"], t, 2 * sin(2 * t)^2,
            1.5 + 1.5 * sin(5 * t), load, $at["x"] + normal(), $at["y"] + normal(), $at["z"] + normal() }' \
        "$1" >"$1.measured.csv"
}
awk 'BEGIN { print "s,t"; for (k = 0; k <= 100; k++) print "0.15," k / 50 "\n0.3," k / 50 }' >places.csv
truth light.csv 0.01
truth heavy.csv 0.04
data() { echo "data=[{quantity: position, file: $1, noise: 3.0e-4}]"; }

# Stiffness and damping from one recording, within four deviations, and as well known as that.
run 0 cpinn-solve arm.yaml --set 'parameters.stiffness={identify: 1.2, range: [0.5, 2]}' \
    --set 'rod.material.relaxation_time={identify: 0.01, range: [0.001, 0.1], scale: log}' \
    --set "$(data light.csv.measured.csv)" --json found.json
said stdout.txt 'identified from 606 numbers of 1 experiment:'
pick() { tr -d '\n ' <found.json | sed "s/.*\"name\":\"$1\",\([^}]*\)}.*/\1/" | tr ',' '\n' | grep "\"$2\"" | cut -d: -f2; }
four() { awk -v d="$(pick "$1" standard_deviation)" 'BEGIN { print 4 * d }'; }
check stiffness -- near "$(pick stiffness value)" 0.8 "$(four stiffness)"
check damping -- near "$(pick material_relaxation_time value)" 0.03 "$(four material_relaxation_time)"
check known well -- near "$(pick stiffness standard_deviation)" 0 2e-3

# How long the rod is, from where its tip was for a while.
awk -F, -v OFS=, 'NR == 1 || $1 == 0.3 && $2 <= 0.5 { print $2, $3, $4, $5, $6, $7, $8 }' light.csv.measured.csv >tip.csv
run 0 cpinn-solve arm.yaml --set parameters.stiffness=0.8 --set 'parameters.long={identify: 0.26, range: [0.2, 0.4]}' \
    --set rod.length=long --set 'bodies[0].at=long' --set "$(data tip.csv)" --json found.json
check length -- near "$(pick long value)" 0.3 "$(four long)"
check length known well -- near "$(pick long standard_deviation)" 0 2e-4

# A load that is a formula of time goes on beside inputs that were recorded.
if ! watched; then
    pushed="loads.tip.force=[0.1*sin(8*t), 0, 0]"
    truth pushed.csv 0.01 --set "$pushed"
    run 0 cpinn-solve arm.yaml --set 'parameters.stiffness={identify: 1.2, range: [0.5, 2]}' --set "$pushed" \
        --set "$(data pushed.csv.measured.csv)" --json found.json
    check stiffness beside a load in time -- near "$(pick stiffness value)" 0.8 "$(four stiffness)"
fi

# A motion that is slow where the search begins and rings where it ends takes other steps of time there. A rod of 4 Hz is
# seen every 0.4 s; measured to 0.1 mm, with no noise. It was found at 18.6 and at an end of the range, 77 mm off.
cat >rings.yaml <<'YAML'
parameters: {pull: {range: [0, 40]}, stiffness: {range: [0.05, 100], scale: log}, tau: {range: [1.0e-4, 2], scale: log}}
rod:
  model: kirchhoff
  length: 0.3
  section: {shape: circle, radius: 0.01}
  material: {youngs_modulus: 1.0e6*stiffness, poissons_ratio: 0.45, density: 1070, relaxation_time: tau}
initial: {state: equilibrium}
tendons: [{offset: [0.01, 0], tension: pull}]
time: {duration: 2}
YAML
awk 'BEGIN { print "s,t"; for (k = 0; k <= 5; k++) print "0.3," k / 2.5 }' >instants.csv
run 0 cpinn-solve rings.yaml --set 'parameters.pull=where(t-0.4,where(t-0.8,0,30*(0.8-t)/0.4),30*t/0.4)' --set parameters.stiffness=20 \
    --set parameters.tau=5e-4 --method modes --points instants.csv --out rings.csv
awk -F, -v OFS=, 'NR == 1 { print $0, "pull" } NR > 1 { print $0, NR == 3 ? 30 : 0 }' rings.csv >rings_seen.csv
run 0 cpinn-solve rings.yaml --set 'parameters.stiffness={identify: 10, range: [0.05, 100], scale: log}' \
    --set 'parameters.tau={identify: 1.5, range: [1.0e-4, 2], scale: log}' --method modes --modes 4,0,0,0 \
    --set 'data=[{quantity: position, file: rings_seen.csv, noise: 1.0e-4}]' --json found.json
check ringing stiffness -- near "$(pick stiffness value)" 20 "$(four stiffness)"
check ringing damping -- near "$(pick tau value)" 5e-4 "$(four tau)"

# Cameras that are a sample late, and off the axis: what they saw stands in the rows of the next sample.
awk -F, -v OFS=, 'NR == 2 || NR == 3 { print $1, $2, $3, $4, $5, "", "", "" } NR > 3 { print $1, $2, $3, $4, $5, x[NR % 2], y[NR % 2], z[NR % 2] } NR == 1 { print }
    { x[NR % 2] = $6; y[NR % 2] = $7; z[NR % 2] = $8 }' light.csv.measured.csv >late.csv
run 0 cpinn-solve arm.yaml --set 'parameters.stiffness={identify: 1.2, range: [0.5, 2]}' \
    --set 'data=[{quantity: position, file: late.csv, noise: 3.0e-4, delay: {identify: 0.05, range: [0, 0.1]}, marker: [{identify: 0.01, range: [-0.02, 0.02]}, 0]}]' --json found.json
check delay -- near "$(pick data_0_delay value)" 0.02 "$(four data_0_delay)"
check marker -- near "$(pick data_0_marker_0 value)" 0 "$(four data_0_marker_0)"
check stiffness with a delay -- near "$(pick stiffness value)" 0.8 "$(four stiffness)"
check delay known well -- near "$(pick data_0_delay standard_deviation)" 0 1e-3

# What was seen before it was has to be within the motion, too.
refused 'light.csv.measured.csv:[0-9]*: t - delay is 2.0[0-9]*; allowed: 0.1 to 2$' cpinn-solve arm.yaml \
    --set 'parameters.stiffness={identify: 1.2, range: [0.5, 2]}' \
    --set 'data=[{quantity: position, file: light.csv.measured.csv, noise: 3.0e-4, delay: -0.1}]'

# Where nothing is to be found, too, it is said why no row has a solution.
sed -e '/^  payload\|^  stiffness\|^  pull2\|^tendons\|offset\|^bodies/d' -e 's/\*stiffness//; s/start: {type: clamped}/start: {type: driven, position: [pull1, 0, 0]}/' arm.yaml >follows.yaml
echo 'springs: [{at: 0.3, stiffness: [1, 1, 1]}]' >>follows.yaml
run 3 cpinn-solve follows.yaml --set "$(data light.csv.measured.csv)"
said stdout.txt '^warning .misfit.: .* no solution for 202 rows .*: boundary.start follows the input pull1, and springs'

# The filter finds the payload of both recordings, and the model predicts to the noise: what is
# measured has 0.3 mm in three directions, 0.52 mm, one sample and half a second ahead.
each() { tr -d '\n ' <replay.json | sed 's/.*"recordings":\[//' | tr '{' '\n' | grep -o "\"$1\":[-0-9.e]*" | cut -d: -f2; }
cat >filter.txt <<'TEXT'
control={estimate: [payload]}
surrogate={step: 0.02, modes: [4, 2, 0, 0], parameters: [payload]}
parameters.stiffness=0.8
TEXT
settings() { while read -r line; do printf '%s\n' --set "$line"; done <filter.txt; }
mapfile -t filter < <(settings)
both='data=[{quantity: position, file: light_tip.csv, noise: 3.0e-4}, {quantity: position, file: heavy_tip.csv, noise: 3.0e-4}]'
for load in light heavy; do
    awk -F, 'NR == 1 || $1 == 0.3' "$load.csv.measured.csv" >"${load}_tip.csv"
done
run 2 cpinn-control arm.yaml "${filter[@]}" --set 'data=[{quantity: position, file: light_tip.csv, noise: 3.0e-4, robust: cauchy}]' --replay
said stderr.txt 'data\[0\].robust: is of cpinn-solve; allowed here: squares'
run 0 cpinn-control arm.yaml "${filter[@]}" --set "$both" --replay --ahead 0.5 --json replay.json
mapfile -t found < <(each value)
mapfile -t deviation < <(each standard_deviation)
check light payload -- near "${found[0]}" 0.01 "$(awk -v d="${deviation[0]}" 'BEGIN { print 4 * d }')"
check heavy payload -- near "${found[1]}" 0.04 "$(awk -v d="${deviation[1]}" 'BEGIN { print 4 * d }')"
check heavy payload told -- near "${found[1]}" 0.04 4e-3
mapfile -t ahead < <(each ahead | tail -n 2)
check half a second ahead -- near "${ahead[1]}" 5.2e-4 1.5e-4

# Markers of which the model is off by 4 mm to and fro: as noise that is none they spoil the payload, and the filter says
# so; as offsets that walk they do not.
awk -F, -v OFS=, 'NR > 1 { $6 += 4e-3 * sin(3 * $2); $7 += 4e-3 * cos(4 * $2) } { print }' heavy_tip.csv >off.csv
run 3 cpinn-control arm.yaml "${filter[@]}" --set "$(data off.csv)" --replay --ahead 0.5
run 0 cpinn-control arm.yaml "${filter[@]}" --set "$(data off.csv)" --replay --ahead 0.5 --drift 0.02 --fade 1 --json replay.json
mapfile -t deviation < <(each standard_deviation)
check payload beside drift -- near "$(each value)" 0.04 "$(awk -v d="${deviation[0]}" 'BEGIN { print 4 * d }')"
check payload beside drift known well -- near "${deviation[0]}" 0 0.01
check a sample ahead of drift -- near "$(each step)" 5.2e-4 3e-4

# A motor that plays and one that lags. The truth has them as formulas of time: a play is exact there, and the lag of
# 1.5 + 1.5 sin(5 t) has a closed form. Threshold and time are found, and the filter carries them along.
late=0.05
lagged=$(awk -v tau=$late 'BEGIN { a = 5 * tau; printf "1.5+1.5*(sin(5*t)-%g*cos(5*t)+%g*exp(-t/%g))/%g", a, a, tau, 1 + a * a }')
truth plays.csv 0.04 --set 'tendons[0].tension=play(pull1, 0.3)' --set "tendons[1].tension=$lagged+0*pull2"
awk -F, 'NR == 1 || $1 == 0.3' plays.csv.measured.csv >plays_tip.csv
motors=(--set 'tendons[0].tension=play(pull1, gap)' --set 'tendons[1].tension=lag(pull2, late)')
run 0 cpinn-solve arm.yaml --set 'parameters.gap={identify: 0.1, range: [0, 1]}' "${motors[@]}" --set "$(data plays.csv.measured.csv)" \
    --set 'parameters.late={identify: 0.1, range: [0.01, 0.5], scale: log}' --set parameters.stiffness=0.8 --json found.json
check threshold -- near "$(pick gap value)" 0.3 "$(four gap)"
check threshold known well -- near "$(pick gap standard_deviation)" 0 2e-3
check lag -- near "$(pick late value)" $late "$(four late)"
check lag known well -- near "$(pick late standard_deviation)" 0 1e-3
run 0 cpinn-control arm.yaml "${filter[@]}" "${motors[@]}" --set parameters.gap=0.3 --set "parameters.late=$late" \
    --set "$(data plays_tip.csv)" --replay --ahead 0.5 --json replay.json
check payload behind motors -- near "$(each value)" 0.04 4e-3
mapfile -t ahead < <(each ahead | tail -n 1)
check half a second ahead behind motors -- near "${ahead[0]}" 5.2e-4 1.5e-4
run 2 cpinn-train arm.yaml "${filter[@]}" "${motors[@]}" --set parameters.gap=0.3 --set "parameters.late=$late"
said stderr.txt 'a trained one-step model does not take plays and lags of inputs'
run 2 cpinn-control arm.yaml "${filter[@]}" "${motors[@]}" --set parameters.gap=0.3 --set "parameters.late=$late" \
    --set control.model=linear --set "$(data plays_tip.csv)" --replay
said stderr.txt 'is linear, and inputs have plays or lags; allowed: reduced'

run 2 cpinn-control arm.yaml "${filter[@]}" --set control.model=linear --set "$both" --replay
said stderr.txt 'control.model: holds inputs while a step lasts, and those of a recording go linearly; allowed: reduced'

# What a file does not say of the payload is found alike; of an input it is refused.
cut -d, -f1-4,6- heavy_tip.csv >unsaid.csv
run 0 cpinn-control arm.yaml "${filter[@]}" --set "$(data unsaid.csv)" --replay --ahead 0.5 --json replay.json
check unsaid payload -- near "$(each value)" "${found[1]}" 1e-9
awk -F, -v OFS=, '{ print } NR == 9 { $3 += 0.1; print }' heavy_tip.csv >twice.csv
run 2 cpinn-control arm.yaml "${filter[@]}" --set "$(data twice.csv)" --replay
said stderr.txt 'twice.csv: row 9 has another input than the one before, at the same t = 0.14 s; allowed: one value of each input'
cut -d, -f1-3,5- heavy_tip.csv >one_input.csv
run 2 cpinn-control arm.yaml "${filter[@]}" --set "$(data one_input.csv)" --replay
said stderr.txt "one_input.csv: column 'pull2' is missing"

# Refused: inputs that begin later than the motion, or end before it; a row without one; what is
# not seen of the reduced rod; samples that are not evenly spaced; data without inputs over time.
unknown='parameters.stiffness={identify: 1.2, range: [0.5, 2]}'
run 2 cpinn-solve arm.yaml --set "$unknown" --set 'rod.rest.curvature[0]=pull1' --set "$(data light_tip.csv)" \
    --set 'springs=[{at: 0.3, turning: [0.1, 0.1, 0.1]}]'
said stderr.txt 'rod.rest follows the input pull1, and springs or a foundation are measured from the unstressed rod'
awk -F, 'NR == 1 || $2 > 0.3' heavy_tip.csv >late.csv
run 2 cpinn-solve arm.yaml --set "$unknown" --set "$(data late.csv)"
said stderr.txt 'late.csv: inputs begin at t = 0.32 s; allowed: from t = 0 on'
awk -F, -v OFS=, 'NR == 20 { $3 = "" } { print }' heavy_tip.csv >gap.csv
run 2 cpinn-solve arm.yaml --set "$unknown" --set "$(data gap.csv)"
said stderr.txt 'gap.csv.*pull1'
sed 's/x,y,z/v1,v2,v3/' heavy_tip.csv >strain.csv
run 2 cpinn-solve arm.yaml --set "$unknown" --set 'data=[{quantity: strain, file: strain.csv, noise: 1.0e-3}]'
said stderr.txt 'strain.csv: has inputs over time and strain; allowed with these: position'
sed '9d' heavy_tip.csv >uneven.csv
run 2 cpinn-control arm.yaml "${filter[@]}" --set "$(data uneven.csv)" --replay
said stderr.txt 'allowed: evenly spaced samples'
run 2 cpinn-control arm.yaml "${filter[@]}" --replay \
    --set 'data=[{quantity: position, file: heavy_tip.csv, noise: 3.0e-4, marker: [0.01, 0]}]'
said stderr.txt 'a replay takes positions alone, of the axis'
awk -F, -v OFS=, 'NR > 1 { $3 = 1; $4 = 1 } { print }' heavy_tip.csv >still.csv
run 2 cpinn-control arm.yaml "${filter[@]}" --set "$(data still.csv)" --replay
said stderr.txt 'no file has inputs over time'

finish
