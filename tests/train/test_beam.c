/* Beams of small deflection: the equations against solutions by hand, the ends, the signs against
 * textbooks. */
#include "evaluate.h"
#include "fewer.h"
#include "training_testing.h"

#include "physics/beam/beam.h"
#include "quantity_testing.h"
#include "tools/prepare/config_experiment.h"
#include "tools/train/reference.h"
#include "tools/train/trainer.h"

#define PI 3.14159265358979323846

/* ---- a scene from text --------------------------------------------------------------------------
 */

typedef struct run {
    experiment *e;
    problem *p;
    reference *known;
    trainer *trainer;
} run;

enum { CHANGES_MAX = 24, CHANGE = 256 };

typedef struct changes {
    char texts[CHANGES_MAX][CHANGE];
    const char *list[CHANGES_MAX];
    int count;
} changes;

static void change(changes *c, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void change(changes *c, const char *format, ...)
{
    va_list arguments;
    assert_true(c->count < CHANGES_MAX);
    va_start(arguments, format);
    int length = vsnprintf(c->texts[c->count], CHANGE, format, arguments);
    va_end(arguments);
    assert_true(length < CHANGE);
    c->list[c->count] = c->texts[c->count];
    c->count++;
}

static run start(const char *text, const changes *c)
{
    run r = {NULL, NULL, NULL, NULL};
    config *settings = NULL;
    ad_error error = {AD_OK, ""};
    if (prepare_read("beam.yaml", text, c->count, c->list, &settings, &error) != AD_OK ||
        config_experiment_create(settings, 1, &r.e, &error) != AD_OK ||
        experiment_problem(r.e, &r.p, &error) != AD_OK ||
        reference_create(r.e, &r.known, &error) != AD_OK ||
        trainer_create(r.e, r.p, r.known, 0, &r.trainer, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return r;
}

static void train(run *r)
{
    ad_error error = {AD_OK, ""};
    while (trainer_fit(r->trainer)->state == FIT_RUNNING) {
        if (trainer_step(r->trainer, &error) != AD_OK) {
            fail_msg("%s", error.message);
        }
    }
}

static void stop(run *r)
{
    trainer_free(r->trainer);
    reference_free(r->known);
    problem_free(r->p);
    experiment_free(r->e);
}

/* The relative L2 error of the deflection after training. */
static double solved_error(const char *text, const changes *c)
{
    reference_errors errors;
    ad_error error = {AD_OK, ""};
    run r = start(text, c);
    train(&r);
    if (reference_compare(r.known, experiment_parameters(r.e), &errors, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    stop(&r);
    return errors.position;
}

/* w, slope, V, M of a static scene at s, after training. */
static void solve_at(const char *text, const changes *c, double s, double values[4])
{
    ad_error error = {AD_OK, ""};
    field *f = NULL;
    run r = start(text, c);
    train(&r);
    if (field_create(r.e->model, r.e->mlp, false, r.e->pool, &f, &error) != AD_OK ||
        field_evaluate(f, r.e->parameters, 1, (const double *const[]){&s}, values, &error) !=
            AD_OK) {
        fail_msg("%s", error.message);
    }
    field_free(f);
    stop(&r);
}

/* ---- the equations ----------------------------------------------------------------------------
 */

/* In SI: L = 1.7, EI = 2.3, kGA = 41, rhoA = 0.6, rhoI = 0.05, k = 3 + s, c = 0.4. */
#define CLOCK "cos(3*t)"

/* w = sin(2s) cos(3t) and a section that turns by psi = cos(s) cos(3t), or for Euler and Bernoulli
 * a moment mu = 0.3 sin(s): by hand
 *   V = kGA (w_s - psi)   q = rhoA w_tt - V_s + k w + c w_t     mu = rhoI psi_tt - M_s - V
 *   V = -(EI w_sss + mu)  q = rhoA w_tt + EI w_ssss + mu_s + k w + c w_t */
typedef struct by_hand {
    const char *psi, *V, *M, *q, *mu;
} by_hand;

static const by_hand timoshenko = {
    "cos(s)*" CLOCK, "41*(2*cos(2*s)-cos(s))*" CLOCK, "-2.3*sin(s)*" CLOCK,
    "((-0.6*9+3+s+41*4)*sin(2*s)-41*sin(s))*" CLOCK "-0.4*3*sin(2*s)*sin(3*t)",
    "((2.3-0.05*9+41)*cos(s)-82*cos(2*s))*" CLOCK};
static const by_hand euler = {
    "2*cos(2*s)*" CLOCK, "2.3*8*cos(2*s)*" CLOCK "-0.3*sin(s)", "-2.3*4*sin(2*s)*" CLOCK,
    "(-0.6*9+2.3*16+3+s)*sin(2*s)*" CLOCK "+0.3*cos(s)-0.4*3*sin(2*s)*sin(3*t)", "0.3*sin(s)"};

/* The same where EI = 2.3 (1 + 0.3 s), kGA = 41 (1 - 0.2 s), rhoA = 0.6 (1 + 0.2 s),
 * rhoI = 0.05 (1 + 0.7 s) and c = 0.4 (1 + 0.1 s): the products' derivatives by hand. */
#define RESISTING "(-5.4*(1+0.2*s)+3+s)*sin(2*s)*" CLOCK "-1.2*(1+0.1*s)*sin(2*s)*sin(3*t)"
static const by_hand tapered_timoshenko = {
    "cos(s)*" CLOCK, "41*(1-0.2*s)*(2*cos(2*s)-cos(s))*" CLOCK, "-2.3*(1+0.3*s)*sin(s)*" CLOCK,
    RESISTING "-41*(-0.2*(2*cos(2*s)-cos(s))+(1-0.2*s)*(sin(s)-4*sin(2*s)))*" CLOCK,
    "(-0.05*9*(1+0.7*s)*cos(s)+2.3*(0.3*sin(s)+(1+0.3*s)*cos(s))"
    "-41*(1-0.2*s)*(2*cos(2*s)-cos(s)))*" CLOCK};
static const by_hand tapered_euler = {
    "2*cos(2*s)*" CLOCK, "9.2*(0.3*sin(2*s)+2*(1+0.3*s)*cos(2*s))*" CLOCK "-0.3*sin(s)",
    "-9.2*(1+0.3*s)*sin(2*s)*" CLOCK,
    RESISTING "-9.2*(1.2*cos(2*s)-4*(1+0.3*s)*sin(2*s))*" CLOCK "+0.3*cos(s)", "0.3*sin(s)"};

static const by_hand *by_hand_of(bool shears, bool tapered)
{
    return shears ? tapered ? &tapered_timoshenko : &timoshenko : tapered ? &tapered_euler : &euler;
}

static void taper(scene *made, bool shears)
{
    made->rod.bending_stiffness[0] = Q("2.3*(1 + 0.3*s)");
    made->rod.mass_per_length = Q("0.6*(1 + 0.2*s)");
    made->loads.drag = Q("0.4*(1 + 0.1*s)");
    if (shears) {
        made->rod.shear_stiffness[1] = Q("41*(1 - 0.2*s)");
        made->rod.rotary_inertia[0] = Q("0.05*(1 + 0.7*s)");
    }
}

static scene general_scene(bool shears, bool mixed, bool tapered, double duration)
{
    scene made;
    const by_hand *exact = by_hand_of(shears, tapered);
    scene_defaults(&made);
    made.rod.model = shears ? SCENE_TIMOSHENKO : SCENE_EULER_BERNOULLI;
    made.rod.length = Q(1.7);
    made.rod.bending_stiffness[0] = Q(2.3);
    made.rod.bending_stiffness[1] = Q(9.9);
    made.rod.mass_per_length = Q(0.6);
    if (shears) {
        made.rod.shear_stiffness[0] = Q(7);
        made.rod.shear_stiffness[1] = Q(41);
        made.rod.rotary_inertia[0] = Q(0.05);
        made.rod.rotary_inertia[1] = made.rod.rotary_inertia[2] = Q(7);
    }
    made.loads.drag = Q(0.4);
    made.duration = Q(duration);
    made.formulation = mixed ? SCENE_MIXED : SCENE_DISPLACEMENT;
    made.beam.force = Q(exact->q);
    made.beam.moment = Q(exact->mu);
    made.beam.foundation = Q("3+s");
    if (tapered) {
        taper(&made, shears);
    }
    return made;
}

static ad_value formula(const scene *given, const char *text, double unit, ad_value s, ad_value t)
{
    rod_scales scales = rod_scales_of(given);
    ad_value length = ad_scale(s, scales.length), time = ad_scale(t, scales.time);
    return ad_scale(quantity_record_at(Q(text), length, time), 1 / unit);
}

/* Residuals of what is known to be exact are rounding: of derivatives of fourth order, of terms up
 * to 200. */
static void test_equations(void **state)
{
    (void)state;
    enum { POINTS = 5 };
    const double s[POINTS] = {0, 0.2, 0.45, 0.8, 1}, t[POINTS] = {0.1, 0.5, 0, 0.9, 0.3};
    for (int which = 0; which < 8; which++) {
        bool shears = which & 1, mixed = which & 2, tapered = which & 4;
        scene given = general_scene(shears, mixed, tapered, 2);
        const by_hand *exact = by_hand_of(shears, tapered);
        rod_scales scales = rod_scales_of(&given);
        double ratio = beam_deflection_scale(&given) / scales.length;
        ad_tape *tape = ad_tape_create();
        ad_value at = ad_input(tape, "s", 1), when = ad_input(tape, "t", 1);
        const domain_place here = rod_place(&given, at, when);
        beam_state x = {formula(&given, "sin(2*s)*" CLOCK, ratio * scales.length, at, when),
                        formula(&given, exact->psi, ratio, at, when),
                        formula(&given, exact->V, ratio * scales.force, at, when),
                        formula(&given, exact->M, ratio * scales.moment, at, when)};
        for (int kind = ROD_STRAIN; kind <= ROD_MOMENT; kind++) {
            bool wanted = mixed || kind == ROD_FORCE || (shears && kind == ROD_MOMENT);
            assert_int_equal(beam_residual_rows(&given, (rod_residual_kind)kind), wanted);
            if (!wanted) {
                continue;
            }
            ad_value residual = beam_residual(&given, (rod_residual_kind)kind, x, &here);
            double *values = evaluate_at(residual, POINTS, s, t, NULL);
            for (int i = 0; i < POINTS; i++) {
                assert_near(values[i], 0, 1e-11);
            }
            free(values);
        }
        ad_tape_free(tape);
    }
}

/* Tapered cantilevers, EI = 2 - s, under a force P and a moment T at the tip:
 *   w_ss = (P (1 - s) + T)/(2 - s) = P + (T - P)/(2 - s)
 *   w = P s^2/2 + (T - P) ((2 - s) ln(1 - s/2) + s)
 * in both forms, where the strong one meets moment and shear through EI and its slope; and with
 * kGA = 5 (2 - s), which shears by another P/5 ln(2/(2 - s)). */
static void test_tapered(void **state)
{
    (void)state;
    const char *bent = "0.35*s^2 - 0.4*((2-s)*log(1-s/2) + s)";
    for (int which = 0; which < 4; which++) {
        changes c = {.count = 0};
        bool shears = which & 1;
        change(&c, "formulation=%s", which & 2 ? "displacement" : "mixed");
        change(&c, "rod={model: %s, length: 1, stiffness: {bending: [2 - s, 1], shear: %s}}",
               shears ? "timoshenko" : "euler_bernoulli", shears ? "[1, 5*(2 - s)]" : "null");
        change(&c, "beam.tip={force: 0.7, moment: 0.3}");
        change(&c, "reference.deflection='%s%s'", bent, shears ? " - 0.7/5*log(1 - s/2)" : "");
        double error = solved_error("name: tapered\n", &c);
        print_message("%s, %s: %.1e\n", c.list[0], shears ? "timoshenko" : "euler_bernoulli",
                      error);
        /* converged to rounding, of which fourth derivatives leave more */
        assert_true(error < (which == 2 ? 1e-9 : 1e-11));
    }
}

/* ---- signs and factors ------------------------------------------------------------------------
 */

#define STOUT "rod: {model: timoshenko, length: 2, stiffness: {bending: [3, 1], shear: [1, 5]}}\n"
#define SLIM  "rod: {model: euler_bernoulli, length: 2, stiffness: {bending: [3, 1]}}\n"

/* Textbook values (Timoshenko and Young 1968, Elements of Strength of Materials), in both forms: L
 * = 2, EI = 3, kGA = 5. Where the solution is a polynomial errors are below 1e-9. */
typedef struct textbook {
    const char *text, *settings[4];
    double s, w, slope, V, M; /* NaN: not in the table */
} textbook;

static const textbook cases[] = {
    /* P L^3/3EI, P L^2/2EI; shearing adds P L/kGA and turns no section. M(0) = P L. */
    {SLIM, {"beam.tip.force=0.7"}, 2, 0.7 * 8 / 9, 0.7 * 4 / 6, 0.7, 0},
    {SLIM, {"beam.tip.force=0.7"}, 0, 0, 0, 0.7, 0.7 * 2},
    {STOUT, {"beam.tip.force=0.7"}, 2, 0.7 * (8. / 9 + 2. / 5), 0.7 * 4 / 6, 0.7, 0},
    /* T L^2/2EI, T L/EI */
    {SLIM, {"beam.tip.moment=0.7"}, 2, 0.7 * 4 / 6, 0.7 * 2 / 3, 0, 0.7},
    {STOUT, {"beam.tip.moment=0.7"}, 2, 0.7 * 4 / 6, 0.7 * 2 / 3, 0, 0.7},
    /* q L^4/8EI, q L^3/6EI; shearing adds q L^2/2kGA */
    {SLIM, {"beam.force=0.7"}, 2, 0.7 * 16 / 24, 0.7 * 8 / 18, 0, 0},
    {STOUT, {"beam.force=0.7"}, 2, 0.7 * (16. / 24 + 4. / 10), 0.7 * 8 / 18, 0, 0},
    {SLIM, {"beam.force=0.7"}, 0, 0, 0, 0.7 * 2, 0.7 * 2},
    /* 5 q L^4/384EI, and q L^2/8kGA; the moment is -q L^2/8 by our sign */
    {SLIM,
     {"beam.force=0.7", "boundary.start.type=pinned", "boundary.end.type=pinned"},
     1,
     0.7 * 5 * 16 / 384 / 3,
     0,
     0,
     -0.7 * 4 / 8},
    {STOUT,
     {"beam.force=0.7", "boundary.start.type=pinned", "boundary.end.type=pinned"},
     1,
     0.7 * (5. * 16 / 384 / 3 + 4. / 8 / 5),
     0,
     0,
     -0.7 * 4 / 8},
    /* q L^4/384EI; M = q L^2/12 at the clamps, -q L^2/24 between */
    {SLIM,
     {"beam.force=0.7", "boundary.end.type=clamped"},
     1,
     0.7 * 16 / 384 / 3,
     0,
     0,
     -0.7 * 4 / 24},
    /* the other end: V = -F, M = -T at s = 0 */
    {SLIM,
     {"beam.base.force=0.7", "boundary.start.type=loaded", "boundary.end.type=clamped"},
     0,
     0.7 * 8 / 9,
     -0.7 * 4 / 6,
     -0.7,
     0},
    {SLIM,
     {"beam.base.moment=0.7", "boundary.start.type=loaded", "boundary.end.type=clamped"},
     0,
     -0.7 * 4 / 6, /* turned towards w at s = 0, and held at the other end */
     0.7 * 2 / 3,
     0,
     -0.7},
    /* a distributed moment mu: V = 0, M = mu (L - s) */
    {SLIM, {"beam.moment=0.7"}, 2, 0.7 * 8 / 3 / 3, 0.7 * 4 / 2 / 3, 0, 0},
    /* free on a foundation: w = q/k */
    {STOUT,
     {"beam.force=0.7", "beam.foundation=4", "boundary.start.type=free"},
     0.3,
     0.7 / 4,
     0,
     0,
     0}};

static void test_signs(void **state)
{
    (void)state;
    for (size_t i = 0; i < 2 * sizeof cases / sizeof *cases; i++) {
        const textbook *known = &cases[i / 2];
        const double expected[4] = {known->w, known->slope, known->V, known->M};
        double values[4];
        changes c = {.count = 0};
        change(&c, "formulation=%s", i % 2 ? "mixed" : "displacement");
        for (int k = 0; k < 4 && known->settings[k]; k++) {
            change(&c, "%s", known->settings[k]);
        }
        solve_at(known->text, &c, known->s, values);
        for (int k = 0; k < 4; k++) {
            if (!(fabs(values[k] - expected[k]) < 1e-7)) {
                fail_msg("case %zu, %s, value %d: %.10g, not %.10g", i / 2, c.list[0], k, values[k],
                         expected[k]);
            }
        }
    }
}

/* A beam with free ends on a foundation, P at one of them (Hetenyi 1946, Beams on Elastic
 * Foundation, ch. III): with b = (k/4EI)^(1/4)
 *   w(L) = 2 P b/k (sinh bL cosh bL - sin bL cos bL)/(sinh^2 bL - sin^2 bL). */
static void test_foundation(void **state)
{
    (void)state;
    double k = 400, P = 2, b = pow(k / 12, 0.25), x = 2 * b, values[4];
    double expected = 2 * P * b / k * (sinh(x) * cosh(x) - sin(x) * cos(x)) /
                      (sinh(x) * sinh(x) - sin(x) * sin(x));
    for (int mixed = 0; mixed < 2; mixed++) {
        changes c = {.count = 0};
        change(&c, "formulation=%s", mixed ? "mixed" : "displacement");
        change(&c, "boundary.start.type=free");
        change(&c, "beam={foundation: %g, tip: {force: %g}}", k, P);
        solve_at(SLIM, &c, 2, values);
        assert_near(values[0] / expected, 1, 1e-7);
        assert_near(values[2], P, 1e-12);
    }
}

/* ---- every pair of ends ------------------------------------------------------------------------
 */

/* w = s^3 (1-s)^3 e^s (1 + t^2), and psi = s^2 (1-s)^2 (1 + t^2) where the section turns by itself:
 * w, w_s, w_ss, psi, psi_s vanish at both ends, so that every end holds, and only Euler and
 * Bernoulli's V = -w_sss is left there: -6 at s = 0, 6e at s = 1, times 1 + t^2. EI = rhoA = 1,
 * kGA = 20, rhoI = 0.01, k = 5. P_k are the derivatives of s^3 (1-s)^3. */
#define P0 "(s^3*(1-s)^3)"
#define P1 "(3*s^2-12*s^3+15*s^4-6*s^5)"
#define P2 "(6*s-36*s^2+60*s^3-30*s^4)"
#define P3 "(6-72*s+180*s^2-120*s^3)"
#define P4 "(-72+360*s-360*s^2)"
#define W2 "((" P0 "+2*" P1 "+" P2 ")*exp(s))"
#define W4 "((" P0 "+4*" P1 "+6*" P2 "+4*" P3 "+" P4 ")*exp(s))"
#define W0 "(" P0 "*exp(s))"
#define W1 "((" P0 "+" P1 ")*exp(s))"
#define R0 "(s^2*(1-s)^2)"
#define R1 "(2*s-6*s^2+4*s^3)"
#define R2 "(2-12*s+12*s^2)"

static const char *const end_names[3] = {"clamped", "pinned", "free"};

static void pair_of_ends(changes *c, bool shears, bool moves, int first, int second)
{
    static const char *const sides[2] = {"start", "end"};
    static const char *const loads[2] = {"base", "tip"}, *const forces[2] = {"6", "6*exp(1)"};
    const int types[2] = {first, second};
    const char *grows = moves ? "(1+t^2)" : "1", *inertia = moves ? "2" : "0";
    change(c, "beam.foundation=5");
    for (int i = 0; i < 2; i++) {
        bool loaded = types[i] == 2 && !shears; /* V of the outside is -V at s = 0 */
        change(c, "boundary.%s.type=%s", sides[i], loaded ? "loaded" : end_names[types[i]]);
        if (loaded) {
            change(c, "beam.%s.force=%s*%s", loads[i], forces[i], grows);
        }
    }
    if (shears) {
        change(c, "beam.force=(5*" W0 "-20*(" W2 "-" R1 "))*%s+%s*" W0, grows, inertia);
        change(c, "beam.moment=(-" R2 "-20*(" W1 "-" R0 "))*%s+0.01*%s*" R0, grows, inertia);
    } else {
        change(c, "beam.force=(" W4 "+5*" W0 ")*%s+%s*" W0, grows, inertia);
    }
    change(c, "reference.deflection=" W0 "*%s", grows);
    if (moves) {
        change(c, "time={duration: 0.5, windows: 1}");
        change(c, "network.fourier={features: 48, frequency: 12}");
        change(c, "training.stages=[{optimizer: gauss_newton, steps: 4}]");
        change(c, "beam.initial.deflection=" W0);
    }
    if (moves && shears) {
        change(c, "beam.initial.slope=" R0);
    }
}

static void check_pairs(bool shears, bool mixed, bool moves, int count, const int *pairs,
                        double tolerance)
{
    static const char *const texts[2] = {
        "rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [1, 1]}, inertia: "
        "{mass_per_length: 1}}\n",
        "rod: {model: timoshenko, length: 1, stiffness: {bending: [1, 1], shear: [20, 20]}, "
        "inertia: {mass_per_length: 1, rotary: [0.01, 0, 0]}}\n"};
    for (int i = 0; i < count; i++) {
        int first = pairs[i] / 3, second = pairs[i] % 3;
        changes c = {.count = 0};
        change(&c, "formulation=%s", mixed ? "mixed" : "displacement");
        pair_of_ends(&c, shears, moves, first, second);
        double error = solved_error(texts[shears], &c);
        if (!(error < tolerance)) {
            fail_msg("%s %s %s, %s - %s: error %g", shears ? "timoshenko" : "euler_bernoulli",
                     mixed ? "mixed" : "displacement", moves ? "dynamic" : "static",
                     end_names[first], end_names[second], error);
        }
    }
}

static const int every_pair[9] = {0, 1, 2, 3, 4, 5, 6, 7, 8};

/* w is 1/3000 of what its loads could do. Measured: at most 1.7e-6, where both ends are free. */
static void test_pairs_at_rest(void **state)
{
    (void)state;
    for (int which = 0; which < 4; which++) {
        check_pairs(which & 1, which & 2, false, 9, every_pair, 1e-5);
    }
}

/* For speed with fewer functions than by default and in 4 steps. Measured: at most 5e-6 and, for
 * the mixed form, 3e-4. */
static void test_pairs_in_motion(void **state)
{
    (void)state;
    const int each_once[3] = {1, 5, 6}; /* each kind of end on either side */
    for (int shears = 0; shears <= 1; shears++) {
        check_pairs(shears, false, true, FEWER(3), each_once, 5e-5);
        check_pairs(shears, true, true, FEWER(3), each_once, 2e-3);
    }
}

/* ---- the shipped scenes, and other ways to have them ------------------------------------------
 */

static double config_error(const char *path, const changes *c)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = fopen(path, "r"), *copy = open_memstream(&text, &size);
    assert_non_null(file);
    assert_non_null(copy);
    for (int byte = fgetc(file); byte != EOF; byte = fgetc(file)) {
        fputc(byte, copy);
    }
    fclose(file);
    fclose(copy);
    double found = solved_error(text, c);
    free(text);
    return found;
}

/* Measured: 3e-13, and 7e-14 in the mixed form. */
static void test_cantilever(void **state)
{
    (void)state;
    changes strong = {.count = 0}, mixed = {.count = 0};
    change(&mixed, "formulation=mixed");
    assert_near(config_error("configs/beam_cantilever.yaml", &strong), 0, 1e-9);
    assert_near(config_error("configs/beam_cantilever.yaml", &mixed), 0, 1e-9);
}

/* Two windows of the three that a period takes. */
static void test_windows(void **state)
{
    (void)state;
    changes mixed = {.count = 0}, strong = {.count = 0};
    change(&mixed, "time.duration=0.4");
    change(&strong, "time.duration=0.4");
    change(&strong, "formulation=displacement");
    assert_near(config_error("configs/timoshenko_vibration.yaml", &mixed), 0, 2e-6);
    assert_near(config_error("configs/timoshenko_vibration.yaml", &strong), 0, 5e-6);
}

/* A sixth of the period of Euler and Bernoulli's cantilever: in two windows, and in one by the
 * strong form. Measured: 5e-8, 1e-9. */
static void test_vibration(void **state)
{
    (void)state;
    changes mixed = {.count = 0}, strong = {.count = 0};
    change(&mixed, "time.duration=0.3");
    change(&strong, "time.duration=0.3");
    change(&strong, "formulation=displacement");
    assert_near(config_error("configs/beam_vibration.yaml", &mixed), 0, 1e-6);
    assert_near(config_error("configs/beam_vibration.yaml", &strong), 0, 1e-6);
}

/* The first mode of Timoshenko's cantilever, with kGA = 1500/11 and rhoI = 0.0025. Its frequency,
 * 3.4388143891452, is from a state-transition determinant with 40 digits; the shape is the solution
 * of the equations at that frequency with w = psi = M = 0 at the ends, and leaves V(L) = -2e-16. */
static void test_cantilever_mode(void **state)
{
    (void)state;
#define MODE_A "1.8386928421342033*s"
#define MODE_B "1.8700467652821138*s"
#define MODE                                                                                       \
    "0.1*(cosh(" MODE_A ")-cos(" MODE_B ")-0.72679976550693335*(sinh(" MODE_A                      \
    ")-1.0340977178936532*sin(" MODE_B ")))"
    static const char text[] =
        "rod:\n"
        "  model: timoshenko\n"
        "  length: 1\n"
        "  stiffness: {bending: [1, 1], shear: [1, 136.36363636363637]}\n"
        "  inertia: {mass_per_length: 1, rotary: [0.0025, 0, 0]}\n"
        "time: {duration: 0.5}\n"
        "beam:\n"
        "  initial:\n"
        "    deflection: " MODE "\n"
        "    slope: 0.1*(1.8858567422883377*sinh(" MODE_A ")+1.8236736332129487*sin(" MODE_B
        ")-0.72679976550693335*1.8858567422883377*(cosh(" MODE_A ")-cos(" MODE_B ")))\n"
        "reference: {deflection: " MODE "*cos(3.4388143891452*t)}\n";
    changes c = {.count = 0};
    assert_near(solved_error(text, &c), 0, 2e-6); /* measured: 7e-7 */
}

/* Ends and initial state as loss terms. Measured: at rest below 1e-7, in motion 4e-4 and 4e-5. */
static void test_soft(void **state)
{
    (void)state;
    for (int mixed = 0; mixed <= 1; mixed++) {
        changes still = {.count = 0}, moving = {.count = 0};
        change(&still, "formulation=%s", mixed ? "mixed" : "displacement");
        change(&moving, "formulation=%s", mixed ? "mixed" : "displacement");
        change(&still, "enforcement.boundary=soft");
        change(&moving, "enforcement={boundary: soft, initial: soft}");
        change(&moving, "time={duration: 0.2, windows: 1}");
        change(&moving, "reference.deflection=0.05*sin(pi*s)*cos(9.4299468776380748*t)");
        assert_near(config_error("configs/beam_cantilever.yaml", &still), 0, 1e-6);
        assert_near(config_error("configs/timoshenko_vibration.yaml", &moving), 0, 4e-3);
    }
}

/* The free ends of an initial state are of its moment and shear, which the strong form has. */
static void test_initial(void **state)
{
    (void)state;
    scene given = general_scene(false, true, false, 1);
    const char *key = NULL;
    ad_error error;
    given.beam.moment = given.beam.force = Q(NULL);
    given.beam.deflection = Q("0.1*s^2");
    assert_int_equal(beam_check(&given, &key, &error), AD_OK);
    given.formulation = SCENE_DISPLACEMENT;
    assert_int_equal(beam_check(&given, &key, &error), AD_BAD_INPUT);
    assert_string_equal(key, "beam.initial.deflection");
    given.formulation = SCENE_MIXED;
    given.beam.velocity = Q("0.1+s");
    assert_int_equal(beam_check(&given, &key, &error), AD_BAD_INPUT);
    assert_string_equal(key, "beam.initial.velocity");
    given.initial_enforcement = SCENE_SOFT;
    assert_int_equal(beam_check(&given, &key, &error), AD_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_equations),  cmocka_unit_test(test_signs),
        cmocka_unit_test(test_foundation), cmocka_unit_test(test_tapered),
        cmocka_unit_test(test_cantilever), cmocka_unit_test(test_cantilever_mode),
        cmocka_unit_test(test_soft),       cmocka_unit_test(test_initial)};
    const struct CMUnitTest alike[] = {
        cmocka_unit_test(test_pairs_in_motion), cmocka_unit_test(test_pairs_at_rest),
        cmocka_unit_test(test_windows), cmocka_unit_test(test_vibration)};
    return run_with_alike(tests, alike, NULL, NULL);
}
