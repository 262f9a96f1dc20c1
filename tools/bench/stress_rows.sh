# Stiff and extreme scenes for stress.sh, which is what runs this file: parts of scenes and files, then
# the rows. A row has a name, "subject/case"; its scene, texts that are joined; `set_to`, overrides as
# for --set; `file`, what is in reference.csv beside the scene; `measure`, the error, a key of the
# report, or energy; `seconds`, s; `tolerance` of the solver; `solver_set`, one more override for it.
# `network` and `solver`: what is expected of these methods, and why. Without it the method is not asked.
# shellcheck shell=bash disable=SC2034

rod='rod:
  model: kirchhoff
  length: 1
  stiffness: {bending: [1, 1], torsion: 1}
  inertia: {mass_per_length: 1, rotary: [0, 0, 0]}'
sheared='rod:
  model: cosserat
  length: 1
  stiffness: {shear: [40, 60], axial: 100, bending: [1, 2], torsion: 0.7}
  inertia: {mass_per_length: 1, rotary: [1e-2, 2e-2, 3e-2]}'
arch='rod:
  model: kirchhoff
  length: 1
  stiffness: {bending: [1, 1], torsion: 1}
  rest: {curvature: [0, -1, 0]}'
arch_pins='boundary:
  start: {type: pinned}
  end: {type: pinned, position: [0, 0, 0.958851077208406]}'
along_x='boundary: {start: {type: clamped, rotation: [0, 1, 0, 1]}}'
pins='boundary: {start: {type: pinned}, end: {type: pinned}}'
pull='loads: {tip: {force: [1, 0, 0]}}'
pull_moved='loads: {tip: {force: [t^2, 0, 0]}}'
in_one='time: {duration: 1}'
beside='reference: {file: reference.csv}'
elastica='reference: {analytic: elastica}'
rollup='motion: planar # in space a moment of fixed direction makes it flutter
reference: {analytic: rollup}'
helix='reference: {analytic: helix}'
solve='reference: solve'

slender_10='s,x,y,z
0,0,0,0
0.2,0.191700189788,0,-0.0528301165243
0.4,0.351653947184,0,-0.173593072925
0.6,0.477345097981,0,-0.3307657624
0.8,0.578375640725,0,-0.505269512577
1,0.66703437641,0,-0.686541558053'
slender_100='s,x,y,z
0,0,0,0
0.2,0.192461314586,0,-0.0475881003413
0.4,0.353715003251,0,-0.164509354739
0.6,0.480404160788,0,-0.318851261632
0.8,0.582017068252,0,-0.491016281131
1,0.671018598229,0,-0.670129395421'
weight_100='s,x,y,z
0,0,0,0
0.2,0.13967370383,0,0.12388955892
0.4,0.33764173257,0,0.14975850847
0.6,0.53754023667,0,0.15574175307
0.8,0.73752872432,0,0.15784031461
1,0.9375239354,0,0.15922338263'
weight_1000='s,x,y,z
0,0,0,0
0.2,0.18114144171,0,0.045826316912
0.4,0.38114126927,0,0.045985421677
0.6,0.58114126927,0,0.045986437
0.8,0.78114126927,0,0.045986453514
1,0.98114126927,0,0.045986454757'
follower_5='s,x,y,z
0,0,0,0
0.2,0.059304430495,0,0.18764756837
0.4,0.21685026282,0,0.30587725685
0.6,0.41401550934,0,0.32493745932
0.8,0.60468302727,0,0.26707223275
1,0.78069014278,0,0.1722778754'
follower_20='s,x,y,z
0,0,0,0
0.2,-0.041086351506,0,0.19496396912
0.4,-0.059234095057,0,0.39185707019
0.6,0.072091022901,0,0.52782121818
0.8,0.24847943551,0,0.45672801315
1,0.33015765978,0,0.27571012309'
# The closed form along +x under the tip force (0, 0, -4).
elastica_4='s,x,y,z
0,0,0,0
0.050000000000000003,0.0498582679596137,0,-0.00326743482190942
0.10000000000000001,0.0989322430208134,0,-0.0126897717387995
0.14999999999999999,0.146613556791842,0,-0.0276560457387969
0.20000000000000001,0.192469049504315,0,-0.0475351771308909
0.25,0.236217034959521,0,-0.0717090767079297
0.29999999999999999,0.277701478047225,0,-0.0995948019873866
0.34999999999999998,0.316866932459716,0,-0.130657712355398
0.40000000000000002,0.35373591776919,0,-0.164417743456658
0.45000000000000001,0.388389531452243,0,-0.200450757224809
0.5,0.420951491197506,0,-0.238386600783897
0.55000000000000004,0.451575437724294,0,-0.277905142266909
0.59999999999999998,0.480435136823375,0,-0.318731210559904
0.65000000000000002,0.507717144397845,0,-0.360629079042477
0.69999999999999996,0.533615494635494,0,-0.403396908156626
0.75,0.558328006537095,0,-0.446861393776015
0.80000000000000004,0.582053856272468,0,-0.490872748451808
0.84999999999999998,0.6049921189618,0,-0.535300060127796
0.90000000000000002,0.627341035977659,0,-0.580027018153591
0.94999999999999996,0.64929780894852,0,-0.62494796134956
1,0.671058757753154,0,-0.669964181277667'
straight='s,x,y,z
0,0,0,0
0.5,0,0,0.5
1,0,0,1'
leaning_099='s,x,y,z
0,0,0,0
0.2,0.0015611505183,0,0.1999919039
0.4,0.006087694436,0,0.39993904799
0.6,0.013132331338,0,0.5998139194
0.8,0.022004028583,0,0.79961663188
1,0.031835447034,0,0.99937479059'
leaning_101='s,x,y,z
0,0,0,0
0.2,0.0094919402633,0,0.19970036882
0.4,0.036950706181,0,0.39774563373
0.6,0.079502868866,0,0.59312776833
0.8,0.13285323219,0,0.785864616
1,0.19180997256,0,0.97697536681'
leaning_2='s,x,y,z
0,0,0,0
0.2,0.073680441006,0,0.18072702625
0.4,0.24828228882,0,0.27124573807
0.6,0.44627333459,0,0.25910650534
0.8,0.62932336726,0,0.17987969375
1,0.79709620152,0,0.071120966311'
arch_inverted='s,x,y,z
0,0,0,0
0.2,-0.07333585825,0,0.1860500756
0.4,-0.1217287757,0,0.3797114666
0.6,-0.1217287757,0,0.5791396106
0.8,-0.07333585825,0,0.7728010016
1,0,0,0.9588510772'
circle='s,x,y,z,qw,qx,qy,qz
0,0,0,0,-1,0,0,0
0.25,0.15915494309189535,0,0.15915494309189535,0.70710678118654752,0,0.70710678118654752,0
0.5,0.3183098861837907,0,0,0,0,-1,0
0.75,0.15915494309189535,0,-0.15915494309189535,-0.70710678118654752,0,0.70710678118654752,0
1,0,0,0,1,0,0,0'
twice='s,x,y,z
0,0,0,0
1,0.30172077379981,0,0.94356676371662
1,0.30172077379981,0,0.94356676371662
0,0,0,0
1,0.30172077379981,0,0.94356676371662'

at_rest=(solved 1e-6 'smooth at rest: 1e-9 is usual')
in_motion=(solved 1e-4 'smooth motion: 1e-6 to 1e-5 is usual')
exact=(solved 1e-9 '1e-10 is asked for; files have ten digits')
flutters_exact=(warning unstable:1e-9 '1e-10 is asked for; it flutters without damping')

about 'Rods: slenderness, material, size, twist'
row slender/10 quick
    scene 'rod: {model: cosserat, length: 1, section: {shape: circle, radius: 0.1}, material: {youngs_modulus: 1, poissons_ratio: 0.3}}' 'loads: {units: EI, tip: {force: [0, 0, -4]}}' "$along_x" "$beside"
    file "$slender_10"
    network "${at_rest[@]}"
    solver "${exact[@]}"
row slender/100
    scene 'rod: {model: cosserat, length: 1, section: {shape: circle, radius: 0.01}, material: {youngs_modulus: 1, poissons_ratio: 0.3}}' 'loads: {units: EI, tip: {force: [0, 0, -4]}}' "$along_x" "$beside"
    file "$slender_100"
    network "${at_rest[@]}"
    solver "${exact[@]}"
row slender/1000
    scene 'rod: {model: cosserat, length: 1, section: {shape: circle, radius: 1e-3}, material: {youngs_modulus: 1, poissons_ratio: 0.3}}' 'loads: {units: EI, tip: {force: [0, 0, -4]}}' "$along_x" "$beside"
    file "$elastica_4"
    network solved 1e-5 'the closed form neither stretches nor shears, by (radius/length)^2'
    solver solved 1e-5 'the closed form neither stretches nor shears, by (radius/length)^2'
row slender/10000 quick
    scene 'rod: {model: cosserat, length: 1, section: {shape: circle, radius: 1e-4}, material: {youngs_modulus: 1, poissons_ratio: 0.3}}' 'loads: {units: EI, tip: {force: [0, 0, -4]}}' "$along_x" "$beside"
    file "$elastica_4"
    network solved 1e-7 'the closed form neither stretches nor shears, by (radius/length)^2'
    solver solved 1e-7 'the closed form neither stretches nor shears, by (radius/length)^2'
row material/10kPa quick
    scene 'rod: {model: kirchhoff, length: 0.1, section: {shape: circle, radius: 0.005}, material: {youngs_modulus: 1e4, poissons_ratio: 0.3}}' 'loads: {tip: {force: [1.5e-3, 0, 0]}}' "$elastica"
    network "${at_rest[@]}"
    solver "${exact[@]}"
row material/200GPa
    scene 'rod: {model: kirchhoff, length: 1, section: {shape: circle, radius: 1e-3}, material: {youngs_modulus: 2e11, poissons_ratio: 0.3}}' 'loads: {tip: {force: [0.5, 0, 0]}}' "$elastica"
    network "${at_rest[@]}"
    solver "${exact[@]}"
row size/1mm
    scene 'rod: {model: kirchhoff, length: 1e-3, section: {shape: circle, radius: 1e-5}, material: {youngs_modulus: 2e11, poissons_ratio: 0.3}}' 'loads: {tip: {force: [5e-3, 0, 0]}}' "$elastica"
    network "${at_rest[@]}"
    solver "${exact[@]}"
row size/1km
    scene 'rod: {model: kirchhoff, length: 1e3, section: {shape: circle, radius: 1}, material: {youngs_modulus: 2e11, poissons_ratio: 0.3}}' 'loads: {tip: {force: [3e5, 0, 0]}}' "$elastica"
    network "${at_rest[@]}"
    solver "${exact[@]}"
row size/0.3ug-1ms
    scene 'rod: {model: cosserat, length: 1e-3, section: {shape: circle, radius: 1e-5}, material: {youngs_modulus: 4e7, poissons_ratio: 0.3, density: 1000}}' 'time: {duration: 1e-3}' 'loads: {units: EI, tip: {force: [0, 0, "-where(0.5-t/1e-3, 4*sin(pi*t/1e-3)^2, 4)"]}}' "$along_x" "$beside"
    file "$(scaled 1e-3 1e-3)"
    network "${in_motion[@]}"
    solver solved 1e-6 'as asked for'
row size/300kt-1h
    scene 'rod: {model: cosserat, length: 1e3, section: {shape: circle, radius: 10}, material: {youngs_modulus: 3.0864197530864197e6, poissons_ratio: 0.3, density: 1000}}' 'time: {duration: 3600}' 'loads: {units: EI, tip: {force: [0, 0, "-where(0.5-t/3600, 4*sin(pi*t/3600)^2, 4)"]}}' "$along_x" "$beside"
    file "$(scaled 1e3 3600)"
    network "${in_motion[@]}"
    solver solved 1e-6 'as asked for'
row twist/0.01
    scene "$rod" 'loads: {tip: {moment: [0, 3, 0.04]}}' "$helix"
    set_to 'rod.stiffness.torsion=0.01'
    measure=rotation_rms_rad
    network warning unstable:1e-5 'rad; the section turns by 4 rad, and errors grow a hundredfold'
    solver "${flutters_exact[@]}"
row twist/1e-3
    scene "$rod" 'loads: {tip: {moment: [0, 1, 1e-3]}}' "$helix"
    set_to 'rod.stiffness.torsion=1e-3'
    measure=rotation_rms_rad
    network warning unstable:1e-4 'rad; the section turns by 1 rad, and errors grow a thousandfold'
    solver "${flutters_exact[@]}"
row twist/1e-3-far
    scene "$rod" 'loads: {tip: {moment: [0, 3, 4e-3]}}' "$helix"
    set_to 'rod.stiffness.torsion=1e-3'
    measure=rotation_rms_rad
    network warning not_converged '200 steps end half way along so narrow a valley'
    solver "${flutters_exact[@]}"
row twist/1e-3-patient
    scene "$rod" 'loads: {tip: {moment: [0, 3, 4e-3]}}' "$helix"
    set_to 'rod.stiffness.torsion=1e-3' 'training.stages=[{optimizer: gauss_newton, steps: 800, function_tolerance: 0.002}]'
    measure=rotation_rms_rad
    network warning unstable:1e-4 'rad; the same valley, walked to its end'
    solver "${flutters_exact[@]}"
row twist/1000
    scene "$rod" 'loads: {tip: {moment: [0, 3, 4]}}' "$helix"
    set_to 'rod.stiffness.torsion=1e3'
    network warning unstable:1e-6 'smooth at rest: 1e-9 is usual'
    solver "${flutters_exact[@]}"
row twist/1000-angle quick
    scene "$rod" 'loads: {tip: {moment: [0, 3, 4]}}' "$helix"
    set_to 'rod.stiffness.torsion=1e3'
    measure=rotation_rms_rad
    network warning unstable:1e-6 'rad; the twist is almost locked'
    solver "${flutters_exact[@]}"
row twist/640-turns
    scene "$rod" 'loads: {tip: {moment: [0, 3, 4]}}' "$helix"
    set_to 'rod.stiffness.torsion=1e-3'
    network warning not_converged 'no network of a few waves winds 640 times'
    solver stopped 'of the load' '640 turns need more nodes than it takes'

about 'Loads: turns, large loads, followers, buckling, quaternions'
row turns/1 quick
    scene "$rod" 'loads: {tip: {moment: [0, "2*pi", 0]}}' "$rollup"
    network "${at_rest[@]}"
    solver "${exact[@]}"
row turns/2
    scene "$rod" 'loads: {tip: {moment: [0, "4*pi", 0]}}' "$rollup"
    network "${at_rest[@]}"
    solver "${exact[@]}"
row turns/5
    scene "$rod" 'loads: {tip: {moment: [0, "10*pi", 0]}}' "$rollup"
    network "${at_rest[@]}"
    solver "${exact[@]}"
row turns/5-waves
    scene "$rod" 'loads: {tip: {moment: [0, "10*pi", 0]}}' "$rollup"
    set_to 'network.fourier.wavenumber=64'
    network "${at_rest[@]}"
    solver "${exact[@]}"
row force/10 quick
    scene "$rod" 'loads: {tip: {force: [10, 0, 0]}}' "$elastica"
    network "${at_rest[@]}"
    solver "${exact[@]}"
row force/100 quick
    scene "$rod" 'loads: {tip: {force: [100, 0, 0]}}' "$elastica"
    network solved 1e-4 'a layer of a tenth of the length at the clamp'
    solver "${exact[@]}"
row force/1000
    scene "$rod" 'loads: {tip: {force: [1000, 0, 0]}}' "$elastica"
    network warning estimate_above_tolerance 'a layer of 1/30 of the length at the clamp'
    solver "${exact[@]}"
row weight/100
    scene "$rod" 'loads: {gravity: [100, 0, 0]}' "$beside"
    file "$weight_100"
    network solved 1e-4 'a layer of a tenth of the length at the clamp'
    solver "${exact[@]}"
row weight/1000
    scene "$rod" 'loads: {gravity: [1000, 0, 0]}' "$beside"
    file "$weight_1000"
    network warning estimate_above_tolerance 'a layer of 1/30 of the length at the clamp'
    solver "${exact[@]}"
row weight/1000-waves
    scene "$rod" 'loads: {gravity: [1000, 0, 0]}' "$beside"
    set_to 'network.fourier.wavenumber=64'
    file "$weight_1000"
    network warning estimate_above_tolerance 'waves as short as the layer'
    solver "${exact[@]}"
row follower/5 quick
    scene "$rod" 'loads: {tip: {force: [5, 0, 0], frame: follower}}' "$beside"
    file "$follower_5"
    network "${at_rest[@]}"
    solver "${exact[@]}"
row follower/20
    scene "$rod" 'loads: {tip: {force: [20, 0, 0], frame: follower}}' "$beside"
    set_to 'motion=planar' # in space it flutters
    file "$follower_20"
    network warning estimate_above_tolerance 'three quarters of a turn, and curvature comes and goes'
    solver "${exact[@]}"
row column/0.99 quick
    scene "$rod" 'loads: {tip: {force: [0, 0, "-0.99*pi^2/4"]}}' "$beside"
    file "$straight"
    network "${at_rest[@]}"
    solver "${exact[@]}"
row column/0.99-leaning
    scene "$rod" 'loads: {tip: {force: [1e-3, 0, "-0.99*pi^2/4"]}}' "$beside"
    file "$leaning_099"
    network solved 1e-5 "1% below Euler's load errors grow a hundredfold"
    solver "${exact[@]}"
row column/1.01 quick
    scene "$rod" 'loads: {tip: {force: [0, 0, "-1.01*pi^2/4"]}}' "$beside"
    file "$straight"
    network warning unstable 'straight, but not stable: the other branch has to be named'
    solver warning unstable 'straight, but not stable: the other branch has to be named'
row column/1.01-leaning
    scene "$rod" 'loads: {tip: {force: [1e-3, 0, "-1.01*pi^2/4"]}}' "$beside"
    file "$leaning_101"
    network solved 1e-5 'the stable branch'
    solver "${exact[@]}"
row column/1.01-named
    scene "$rod" 'loads: {tip: {force: [1e-3, 0, "-1.01*pi^2/4"]}}' "$beside"
    set_to 'rod.rest.imperfection=[0, 1, 0]'
    file "$leaning_101"
    network solved 1e-5 'the stable branch, which an imperfection names'
    solver "${exact[@]}"
row column/2 quick
    scene "$rod" 'loads: {tip: {force: [0, 0, "-2*pi^2/4"]}}' "$beside"
    file "$straight"
    network warning unstable 'straight, but not stable: the other branch has to be named'
    solver warning unstable 'straight, but not stable: the other branch has to be named'
row column/2-leaning
    scene "$rod" 'loads: {tip: {force: [1e-2, 0, "-2*pi^2/4"]}}' "$beside"
    file "$leaning_2"
    network solved 1e-6 'the stable branch'
    solver "${exact[@]}"
row column/2-named quick
    scene "$rod" 'loads: {tip: {force: [1e-2, 0, "-2*pi^2/4"]}}' "$beside"
    set_to 'rod.rest.imperfection=[0, 1, 0]'
    file "$leaning_2"
    network solved 1e-6 'the stable branch, which an imperfection names'
    solver "${exact[@]}"
row arch/60-named
    scene "$arch" "$arch_pins" 'loads: {force: [-60, 0, 0]}' "$beside"
    set_to 'rod.rest.imperfection=[0, 3, 0]' 'motion=planar' # it would turn about its pins
    file "$arch_inverted"
    network solved 1e-5 'the inverted shape, which an imperfection names'
    solver "${exact[@]}"
row arch/60
    scene "$arch" "$arch_pins" 'loads: {force: [-60, 0, 0]}' "$beside"
    file "$arch_inverted"
    network warning unstable 'straight down it gives way from 39 on: a direction has to be named'
    solver warning snapped 'the inverted shape, to which it snaps from 39 on'
row quaternion/file quick
    scene "$rod" 'loads: {tip: {moment: [0, "2*pi", 0]}}' "$rollup"
    set_to 'reference.analytic=none' 'reference.file=reference.csv'
    file "$circle"
    measure=rotation_rms_rad
    network solved 1e-6 'rad; -q is the rotation q, in the file and along the rod'
    solver "${exact[@]}"
row quaternion/opposite quick
    scene "$rod" 'boundary: {end: {type: clamped, position: [0, 0, 1], rotation: [-1, 0, 0, 0]}}' "$beside"
    file "$straight"
    network solved 1e-6 'the ends have one rotation, q and -q, and between them q passes no 0'
    solver stopped 'of the load' 'held straight, it has any tension, unless it can stretch'
row quaternion/soft
    scene "$rod" 'loads: {tip: {moment: [0, "2*pi", 0]}}' "$rollup"
    set_to 'enforcement.boundary=soft'
    network solved 1e-5 'q = identity + network has to pass near 0 before it is normalised'
    solver "${exact[@]}"

about 'Motions: steps, damping, energy, windows'
row step/at-once
    scene "$rod" "$in_one" 'loads: {tip: {force: [1e-3, 0, 0]}}' "$beside"
    file "$(tip 1 '1e-3 * step(t)')"
    tolerance=1e-5
    seconds=30
    solver_set 'rod.inertia.rotary=[1e-4, 1e-4, 2e-4]'
    network solved 1e-5 "a hundredth of the deflection; Euler and Bernoulli's modes"
    solver solved 1e-5 "a hundredth of the deflection; Euler and Bernoulli's modes"
row step/between-windows
    scene "$rod" "$in_one" 'loads: {tip: {force: ["1e-3*step(t-0.1)", 0, 0]}}' "$beside"
    set_to 'time.windows=10'
    file "$(tip 1 '1e-3 * step(t - 0.1)')"
    tolerance=1e-5
    seconds=30
    solver_set 'rod.inertia.rotary=[1e-4, 1e-4, 2e-4]'
    network solved 1e-5 "a hundredth of the deflection; Euler and Bernoulli's modes"
    solver solved 1e-5 "a hundredth of the deflection; Euler and Bernoulli's modes"
row step/within-window
    scene "$rod" "$in_one" 'loads: {tip: {force: ["1e-3*step(t-0.1)", 0, 0]}}' "$beside"
    file "$(tip 1 '1e-3 * step(t - 0.1)')"
    tolerance=1e-5
    seconds=30
    solver_set 'rod.inertia.rotary=[1e-4, 1e-4, 2e-4]'
    network solved 1e-5 "a hundredth of the deflection; Euler and Bernoulli's modes"
    solver solved 1e-5 "a hundredth of the deflection; Euler and Bernoulli's modes"
row step/push
    scene "$rod" "$in_one" 'loads: {tip: {force: ["1e-2*(step(t-0.1)-step(t-0.2))", 0, 0]}}' "$beside"
    set_to 'time.windows=10'
    file "$(tip 1 '1e-2 * (step(t - 0.1) - step(t - 0.2))')"
    tolerance=1e-5
    seconds=30
    solver_set 'rod.inertia.rotary=[1e-4, 1e-4, 2e-4]'
    network solved 1e-5 "a hundredth of the deflection; Euler and Bernoulli's modes"
    solver solved 1e-5 "a hundredth of the deflection; Euler and Bernoulli's modes"
row step/blow
    scene "$rod" "$in_one" 'loads: {tip: {force: ["0.1*(step(t-0.1)-step(t-0.11))", 0, 0]}}' "$beside"
    file "$(tip 1 '0.1 * (step(t - 0.1) - step(t - 0.11))')"
    tolerance=1e-4
    seconds=30
    solver_set 'rod.inertia.rotary=[1e-4, 1e-4, 2e-4]'
    network solved 1e-4 "a hundredth of the deflection; Euler and Bernoulli's modes"
    solver solved 1e-4 "a hundredth of the deflection; Euler and Bernoulli's modes"
row damping/heavy
    scene "$rod" "$in_one" 'loads: {tip: {force: ["1e-2*t/10", 0, 0]}}' "$beside"
    set_to 'rod.damping.curvature=[10, 10, 10]' 'time.duration=10'
    file "$(tip 10 '1e-2 / 3 * (t / 10 - (1 - exp(-t / 10)))')"
    tolerance=1e-6
    seconds=60
    solver_set 'rod.inertia.rotary=[1e-4, 1e-4, 2e-4]'
    network solved 1e-5 "a hundredth of the deflection; Euler and Bernoulli's modes"
    solver solved 1e-5 "a hundredth of the deflection; Euler and Bernoulli's modes"
row energy/2-periods
    scene "$rod" 'loads: {tip: {force: ["-where(0.9-t, sin(pi*t/1.8)^2, 1)", 0, 0]}}' 'time: {duration: 3.6, windows: 24}'
    measure=energy
    tolerance=1e-5
    seconds=30
    solver_set 'rod.inertia.rotary=[1e-4, 1e-4, 2e-4]'
    network solved 1e-4 'of the kinetic energy; nothing damps'
    solver solved 1e-4 'of the kinetic energy; nothing damps'
row energy/10-periods long
    scene "$rod" 'loads: {tip: {force: ["-where(0.9-t, sin(pi*t/1.8)^2, 1)", 0, 0]}}' 'time: {duration: 18, windows: 120}'
    measure=energy
    tolerance=1e-5
    seconds=300
    solver_set 'rod.inertia.rotary=[1e-4, 1e-4, 2e-4]'
    network solved 1e-4 'of the kinetic energy; nothing damps'
    solver solved 1e-4 'of the kinetic energy; nothing damps'
row energy/50-periods long
    scene "$rod" 'loads: {tip: {force: ["-where(0.9-t, sin(pi*t/1.8)^2, 1)", 0, 0]}}' 'time: {duration: 90, windows: 600}'
    measure=energy
    tolerance=1e-5
    seconds=1800
    solver_set 'rod.inertia.rotary=[1e-4, 1e-4, 2e-4]'
    network solved 1e-4 'of the kinetic energy; nothing damps'
    solver solved 1e-4 'of the kinetic energy; nothing damps'
row windows/of-a-static-scene quick
    scene "$rod" "$pull" "$elastica"
    set_to 'time.windows=4'
    network refused 'time.windows: windows divide the duration' 'there is no time to divide'
row windows/of-no-length quick
    scene "$rod" "$in_one" "$pull_moved"
    set_to 'time.duration=1e-320' 'time.windows=256'
    network refused 'time.duration' 'windows of length 0'
row windows/too-long quick
    scene "$rod" 'loads: {tip: {force: [1e-3, 0, 0]}}' 'time: {duration: 1e5}'
    network refused 'time.windows' '200 periods in each window, beyond its waves'
row windows/too-few
    scene "$rod" "$pull" 'time: {duration: 20, windows: 1}'
    set_to 'network.fourier.features=64'
    seconds=30
    network warning none '11 periods in one window'

about 'Beams: foundations, shear, units, modes'
row beam/foundation-1e8 quick
    scene 'rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [1, 1]}, inertia: {mass_per_length: 1}}' "$pins" 'beam: {force: "sin(pi*s)", foundation: 1e8}' 'reference: {deflection: "sin(pi*s)/(pi^4+1e8)"}'
    network solved 1e-6 'bending is a millionth'
    solver "${exact[@]}"
row beam/layer-1e6 quick
    scene 'rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [1, 1]}, inertia: {mass_per_length: 1}}' 'beam: {force: 1, foundation: 6.4e5}' 'reference: {deflection: "(1-exp(-20*s)*(cos(20*s)+sin(20*s)))/6.4e5"}'
    network warning estimate_above_tolerance 'a layer of 1/20 of the length, as short as the usual waves'
    solver solved 1e-8 'the closed form forgets the free end, by exp(-20)'
row beam/layer-1e8 quick
    scene 'rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [1, 1]}, inertia: {mass_per_length: 1}}' 'beam: {force: 1, foundation: 4e8}' 'reference: {deflection: "(1-exp(-100*s)*(cos(100*s)+sin(100*s)))/4e8"}'
    network warning not_converged 'a layer of 1/100 of the length, shorter than the waves'
    solver "${exact[@]}"
row beam/layer-1e8-waves
    scene 'rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [1, 1]}, inertia: {mass_per_length: 1}}' 'beam: {force: 1, foundation: 4e8}' 'reference: {deflection: "(1-exp(-100*s)*(cos(100*s)+sin(100*s)))/4e8"}'
    set_to 'network.fourier.wavenumber=200' 'network.fourier.features=128'
    network warning estimate_above_tolerance 'waves as short as the layer'
row beam/shear-1e6 quick
    scene 'rod: {model: timoshenko, length: 1, stiffness: {bending: [1, 1], shear: [1e6, 1e6]}, inertia: {mass_per_length: 1}}' "$pins" 'beam: {force: "sin(pi*s)"}' 'reference: {deflection: "sin(pi*s)*(pi^-4+pi^-2/1e6)"}'
    network solved 1e-6 'it hardly shears'
    solver "${exact[@]}"
row beam/shear-1e-3 quick
    scene 'rod: {model: timoshenko, length: 1, stiffness: {bending: [1, 1], shear: [1e-3, 1e-3]}, inertia: {mass_per_length: 1}}' "$pins" 'beam: {force: "sin(pi*s)"}' 'reference: {deflection: "sin(pi*s)*(pi^-4+pi^-2/1e-3)"}'
    network solved 1e-6 'it hardly bends'
    solver "${exact[@]}"
row beam/micrometres quick
    scene 'rod: {model: euler_bernoulli, length: 1e-5, stiffness: {bending: [1e-20, 1e-20]}, inertia: {mass_per_length: 1}}' "$pins" 'beam: {force: "1e-6*sin(pi*s/1e-5)"}' 'reference: {deflection: "1e-6*sin(pi*s/1e-5)/pi^4"}'
    network solved 1e-6 'only ratios count'
    solver "${exact[@]}"
row beam/mode-1
    scene 'rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [1, 1]}, inertia: {mass_per_length: 1}}' "$pins" 'time: {duration: 0.6366197723675814}' 'beam: {initial: {deflection: "1e-3*sin(1*pi*s)"}}' 'reference: {deflection: "1e-3*sin(1*pi*s)*cos((1*pi)^2*t)"}'
    network solved 1e-5 'one period'
    solver "${exact[@]}"
row beam/mode-10
    scene 'rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [1, 1]}, inertia: {mass_per_length: 1}}' "$pins" 'time: {duration: 0.006366197723675814}' 'beam: {initial: {deflection: "1e-3*sin(10*pi*s)"}}' 'reference: {deflection: "1e-3*sin(10*pi*s)*cos((10*pi)^2*t)"}'
    tolerance=1e-6
    network warning not_converged 'five waves along the beam, shorter than those of the network'
    solver solved 1e-6 'as asked for'
row beam/mode-10-waves long
    scene 'rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [1, 1]}, inertia: {mass_per_length: 1}}' "$pins" 'time: {duration: 0.006366197723675814}' 'beam: {initial: {deflection: "1e-3*sin(10*pi*s)"}}' 'reference: {deflection: "1e-3*sin(10*pi*s)*cos((10*pi)^2*t)"}'
    set_to 'network.fourier.wavenumber=50' 'losses.interior.points=6000'
    seconds=120
    network solved 1e-5 'one period'

about 'By network and solver, without a closed form'
row pair/space quick
    scene "$sheared" "$solve" 'loads: {tip: {force: [3, 4, -2], moment: [0, 1, 1]}}'
    network solved 1e-6 'two programs that share no equation'
    solver "${exact[@]}"
row pair/heavy-hook
    scene "$sheared" "$solve" 'loads: {gravity: [20, 0, -20]}'
    set_to 'rod.rest.curvature=[0, 6, 2]'
    network solved 1e-6 'two programs that share no equation'
    solver "${exact[@]}"
row pair/follower
    scene "$sheared" "$solve" 'loads: {tip: {force: [8, 3, 0], frame: follower}}'
    network warning unstable:1e-6 'two programs that share no equation'
    solver "${flutters_exact[@]}"
row pair/pulled-1e4
    scene "$sheared" "$solve" 'loads: {tip: {force: [1, 0, 1e4]}}'
    set_to 'rod.stiffness.shear=[400, 600]'
    network warning estimate_above_tolerance 'stretched a hundredfold'
    solver warning strain_large 'no linear law holds a hundredfold'
row pair/tension-buckling
    scene "$sheared" "$solve" 'loads: {tip: {force: [1, 0, 1e4]}}'
    network warning unstable 'softer in shear than in stretch it gives way under tension'
    solver warning unstable 'softer in shear than in stretch it gives way under tension'
row pair/ends
    scene "$sheared" "$solve" 'boundary: {end: {type: clamped, position: [0.2, 0.1, 0.8], rotation: [0.9, 0.2, 0.3, 0.2]}}'
    network solved 1e-6 'two programs that share no equation'
    solver "${exact[@]}"
row pair/whirl long
    scene "$sheared" "$solve" "$in_one" 'loads: {tip: {force: [t^2, "sin(3*t)^2", 0]}}'
    seconds=60
    network solved 1e-4 'two programs that share no equation'
    solver solved 1e-6 'what it was asked for'
row pair/drag-1e3
    scene "$sheared" "$solve" "$in_one" 'loads: {drag: 1000, tip: {force: ["5*t^2", 0, 0]}}'
    seconds=60
    network solved 1e-4 'two programs that share no equation'
    solver solved 1e-6 'what it was asked for'

about 'Input: numbers, files, networks, settings that cannot work'
row number/length-1e-300 quick
    scene "$rod" "$pull" "$elastica"
    set_to 'rod.length=1e-300'
    network refused 'rod.length' 'EI/L^2 overflows'
    solver refused 'rod.length' 'EI/L^2 overflows'
row number/length-1e300 quick
    scene "$rod" "$pull" "$elastica"
    set_to 'rod.length=1e300'
    network refused 'rod.length' 'EI/L^2 vanishes'
    solver refused 'rod.length' 'EI/L^2 vanishes'
row number/length-denormal quick
    scene "$rod" "$pull" "$elastica"
    set_to 'rod.length=5e-324'
    network refused 'rod.length' 'EI/L^2 overflows'
    solver refused 'rod.length' 'EI/L^2 overflows'
row number/stiffness-1e300 quick
    scene "$rod" "$pull" "$elastica"
    set_to 'rod.stiffness.bending=[1e300, 1e300]'
    network refused 'rod.stiffness.bending' 'beyond any rod'
    solver refused 'rod.stiffness.bending' 'beyond any rod'
row number/stiffness-1e-300 quick
    scene "$rod" "$pull" "$elastica"
    set_to 'rod.stiffness.bending=[1e-300, 1e-300]'
    network refused 'rod.stiffness.bending' 'beyond any rod'
    solver refused 'rod.stiffness.bending' 'beyond any rod'
row number/torsion-1e-300 quick
    scene "$rod" "$pull" "$elastica"
    set_to 'rod.stiffness.torsion=1e-300' 'motion=spatial'
    network refused 'rod.stiffness.torsion' 'its compliance overflows in a square'
    solver refused 'rod.stiffness.torsion' 'its compliance overflows in a square'
row number/modulus-1e300 quick
    scene 'rod: {length: 1, section: {shape: circle, radius: 1}, material: {youngs_modulus: 1e300, poissons_ratio: 0.3}}'
    network refused 'rod.material.youngs_modulus' 'beyond any rod'
    solver refused 'rod.material.youngs_modulus' 'beyond any rod'
row number/radius-1e-300 quick
    scene 'rod: {length: 1, section: {shape: circle, radius: 1e-300}, material: {youngs_modulus: 1, poissons_ratio: 0.3}}'
    network refused 'rod.section' 'its fourth power vanishes'
    solver refused 'rod.section' 'its fourth power vanishes'
row number/force-1e300 quick
    scene "$rod" "$pull" "$elastica"
    set_to 'loads.tip.force=[1e300, 0, 0]'
    network refused 'loads.tip.force' 'beyond any load'
    solver refused 'loads.tip.force' 'beyond any load'
row number/force-1e-300 quick
    scene "$rod" "$pull" "$elastica"
    set_to 'loads.tip.force=[1e-300, 0, 0]'
    network solved 1e-12 'as good as none: the rod stays straight'
    solver "${exact[@]}"
row number/gravity-1e300 quick
    scene "$rod" "$pull" "$elastica"
    set_to 'loads.gravity=[1e300, 0, 0]' 'reference.analytic=none'
    network refused 'loads.gravity' 'beyond any load'
    solver refused 'loads.gravity' 'beyond any load'
row number/mass-1e300 quick
    scene "$rod" "$in_one" "$pull_moved"
    set_to 'rod.inertia.mass_per_length=1e300'
    network refused 'rod.inertia.mass_per_length' 'the unit of time overflows in a square'
    solver refused 'rod.inertia.mass_per_length' 'the unit of time overflows in a square'
row number/damping-1e300 quick
    scene "$rod" "$in_one" "$pull_moved"
    set_to 'rod.damping.curvature=[1e300, 1e300, 1e300]'
    network refused 'rod.damping.curvature' 'beyond any damping'
    solver refused 'rod.damping.curvature' 'beyond any damping'
row number/drag-1e300 quick
    scene "$rod" "$in_one" "$pull_moved"
    set_to 'loads.drag=1e300'
    network refused 'loads.drag' 'beyond any drag'
    solver refused 'loads.drag' 'beyond any drag'
row number/quadratic-drag-1e300 quick
    scene "$rod" "$in_one" "$pull_moved"
    set_to 'loads.quadratic_drag=1e300'
    network refused 'loads.quadratic_drag' 'beyond any drag'
    solver refused 'loads.quadratic_drag' 'beyond any drag'
row number/duration-1e300 quick
    scene "$rod" "$in_one" "$pull_moved"
    set_to 'time.duration=1e300' 'loads.tip.force=[1, 0, 0]'
    network refused 'time.duration' 'beyond any motion'
    solver refused 'time.duration' 'beyond any motion'
row number/duration-1e-300 quick
    scene "$rod" "$in_one" "$pull_moved"
    set_to 'time.duration=1e-300'
    network refused 'time.duration' 'beyond any motion'
    solver refused 'time.duration' 'beyond any motion'
row number/wavenumber-1e300 quick
    scene "$rod" "$pull" "$elastica"
    set_to 'network.fourier.wavenumber=1e300'
    network refused 'network.fourier.wavenumber' 'waves no point can resolve'
row number/weight-1e300 quick
    scene "$rod" "$pull" "$elastica"
    set_to 'losses.interior.weights.strain=1e300'
    network refused 'losses.interior.weights.strain' 'its square overflows'
row number/overflow quick
    scene "$rod" "$pull" "$elastica"
    set_to 'rod.length=1e400'
    network refused 'rod.length' 'no double holds it'
    solver refused 'rod.length' 'no double holds it'
row number/nan quick
    scene "$rod" "$pull" "$elastica"
    set_to 'loads.tip.force=[.nan, 0, 0]'
    network refused 'loads.tip.force[0]' 'not a number'
    solver refused 'loads.tip.force[0]' 'not a number'
row number/formula-nan quick
    scene "$rod" "$in_one" "$pull_moved"
    set_to 'loads.tip.force=[sqrt(t-2), 0, 0]'
    network refused 'must be finite, and is not at t' 'the root of a negative number'
    solver refused 'must be finite, and is not at t' 'the root of a negative number'
row number/formula-nan-late quick
    scene "$rod" "$in_one" "$pull_moved"
    set_to 'loads.tip.force=[sqrt(0.97-t), 0, 0]'
    solver_set 'rod.inertia.rotary=[1e-4, 1e-4, 2e-4]'
    network stopped 'not finite' 'only where no check looks'
    solver stopped 'not finite' 'the same'
row number/formula-inf quick
    scene "$rod" "$in_one" "$pull_moved"
    set_to 'loads.tip.force=[exp(1e4*t)-1, 0, 0]'
    network refused 'loads.tip.force' 'overflows within the duration'
    solver refused 'loads.tip.force' 'overflows within the duration'
row file/nan quick
    scene "$rod" "$pull" "$beside"
    file 's,x,y,z
0,0,0,0
1,0.30172077379981,0,0.94356676371662
1,nan,0,0.9'
    network "${at_rest[@]}"
    solver "${exact[@]}"
row file/infinity quick
    scene "$rod" "$pull" "$beside"
    file 's,x,y,z
0,0,0,-inf
1,0.30172077379981,0,0.94356676371662'
    network refused 'reference.csv:2:7: ' 'its line is named'
    solver refused 'reference.csv:2:7: ' 'its line is named'
row file/overflow quick
    scene "$rod" "$pull" "$beside"
    file 's,x,y,z
0,0,0,1e999
1,0.30172077379981,0,0.94356676371662'
    network refused 'reference.csv:2:7: ' 'no double holds it'
    solver refused 'reference.csv:2:7: ' 'no double holds it'
row file/denormal quick
    scene "$rod" "$pull" "$beside"
    file 's,x,y,z
5e-324,5e-324,1e-310,0
1,0.30172077379981,0,0.94356676371662'
    network "${at_rest[@]}"
    solver "${exact[@]}"
row file/duplicates quick
    scene "$rod" "$pull" "$beside"
    file "$twice"
    network "${at_rest[@]}"
    solver "${exact[@]}"
row file/empty quick
    scene "$rod" "$pull" "$beside"
    file ''
    network refused 'reference.csv' 'there is nothing to compare with'
    solver refused 'reference.csv' 'there is nothing to compare with'
row file/no-rows quick
    scene "$rod" "$pull" "$beside"
    file 's,x,y,z'
    network refused 'there are no rows' 'there is nothing to compare with'
    solver refused 'there are no rows' 'there is nothing to compare with'
row file/elsewhere quick
    scene "$rod" "$pull" "$beside"
    file 's,x,y,z
2,0,0,0'
    network refused 'none of its 1 points lies in the scene' "another rod's file"
    solver refused 'none of its 1 points lies in the scene' "another rod's file"
row file/origin-only quick
    scene "$rod" "$pull" "$beside"
    file 's,x,y,z
0,0,0,0'
    network refused 'reference.csv' 'no error is relative to 0'
    solver refused 'reference.csv' 'no error is relative to 0'
row file/quaternion-0 quick
    scene "$rod" "$pull" "$beside"
    file 's,x,y,z,qw,qx,qy,qz
1,0.3,0,0.9,0,0,0,0'
    network refused 'the quaternion qw, qx, qy, qz is 0' 'no rotation'
    solver refused 'the quaternion qw, qx, qy, qz is 0' 'no rotation'
row file/quaternion-1e-200 quick
    scene "$rod" "$beside"
    file 's,x,y,z,qw,qx,qy,qz
1,0,0,1,-1e-200,0,0,0'
    measure=rotation_rms_rad
    network solved 1e-6 'rad; only its direction counts'
    solver "${exact[@]}"
row file/huge quick
    scene "$rod" "$pull" "$beside"
    file 's,x,y,z
1,1e300,0,0'
    network refused 'reference.csv' 'its square overflows'
    solver refused 'reference.csv' 'its square overflows'
row network/two-points quick
    scene "$rod" "$pull" "$elastica"
    set_to 'losses.interior.points=2'
    network warning interpolates 'two points leave the rod between them free'
row network/one-unit quick
    scene "$rod" "$pull" "$elastica"
    set_to 'network.hidden=[1]' 'training.stages=[{optimizer: adam, steps: 500}, {optimizer: lbfgs, steps: 500}]'
    network warning not_converged 'one hidden unit has not the shape of a rod'
row network/one-feature quick
    scene "$rod" "$pull" "$elastica"
    set_to 'network.fourier.features=1'
    network warning not_converged 'one wave has not the shape of a rod'
row training/rate-10 quick
    scene "$rod" "$pull" "$elastica"
    set_to 'network.hidden=[16]' 'training.stages=[{optimizer: adam, steps: 500, learning_rate: 10}]'
    network warning not_converged 'the best state is kept, but it is no solution'
row training/rate-1e200 quick
    scene "$rod" "$pull" "$elastica"
    set_to 'network.hidden=[16]' 'training.stages=[{optimizer: adam, steps: 500, learning_rate: 1e200}]'
    network stopped 'try: resume with' 'caught at once, with advice'
row training/one-step-gentle quick
    scene "$rod" "$pull" "$elastica"
    set_to 'training.stages=[{optimizer: adam, steps: 1}]' 'network.hidden=[8]' 'loads.tip.force=[1e-3, 0, 0]'
    network warning not_converged 'nor when all residuals are small because the load is'
row training/one-step quick
    scene "$rod" "$pull" "$elastica"
    set_to 'training.stages=[{optimizer: adam, steps: 1}]' 'network.hidden=[8]'
    network warning not_converged 'a step is no training'
