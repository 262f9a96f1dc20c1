# Two of cosseratbench's experiments without contact, by PyElastica 1.0.0 and MuJoCo 3.13.0. MuJoCo does not run the twist.
results=results-0.2
take jakeryderv/cosseratbench $results/cantilever $results/twist

percent() { # metric, experiment, solver
    times 100 "$(number "$1" "data/$results/$2/default/$3/result.json")"
}

# The twist at which a straight rod buckles, clamped at both ends (Greenhill): the least M L/EI for tau = T L^2/EI, with
# a = M L/(2 EI) and b = sqrt(a^2 - tau), of 2 b (cos b - cos a) = tau sin b. Here GJ is 2/3 EI.
greenhill() {
    awk -v tau="$1" 'function f(m,   a, b) { a = m / 2; b = sqrt(a * a - tau)
            return 2 * b * (cos(b) - cos(a)) - tau * sin(b) }
        BEGIN { step = 0.01; m = 2 * sqrt(tau) + step
            while (f(m) * f(m + step) > 0) m += step
            high = m + step
            for (i = 0; i < 60; i++) { middle = (m + high) / 2; if (f(m) * f(middle) > 0) m = middle; else high = middle }
            printf "%.12g\n", 1.5 * m }'
}

run twist.txt cpinn-solve "$scenes/cosseratbench.yaml" --json twist.json
load=$(number bifurcation_load twist.json)
straight=$(greenhill "$(awk -v load="$load" 'BEGIN { print 10 * load }')")
row "twist at which it buckles; below Greenhill: PyElastica; 50 elements" unit=% rows=1 \
    published="$(percent critical_twist_error twist pyelastica)" seconds="$seconds" \
    physics="$(times 100 "$(awk -v load="$load" -v s="$straight" 'BEGIN { print 1 - load * 16.5 / s }')")"
run cantilever.txt cpinn-solve "$scenes/cosseratbench.yaml" --set rod.section.radius=0.02 --set boundary.end=null \
    --set 'loads.tip.force=[0,0,-0.0075]' --grid 2 --out cantilever.csv
off=$(awk -F, 'NR == 1 { for (c = 1; c <= NF; c++) if ($c == "z") at = c }
    END { print -$at / (0.0075 / (3 * 1e6 * atan2(0, -1) * 0.02^4 / 4)) - 1 }' cantilever.csv)
for solver in pyelastica mujoco; do
    row "deflection of a tip; off Euler and Bernoulli: $solver; 20 elements" unit=% rows=1 \
        published="$(percent tip_deflection_error cantilever $solver)" physics="$(times 100 "$off")" seconds="$seconds"
done
