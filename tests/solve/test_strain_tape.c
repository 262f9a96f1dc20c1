/* The strain form on the tape: against the solver's own in lanes, against shapes of the other
 * solver, derivatives against differences, and what is refused. */
#include "config_testing.h"
#include "evaluate.h"
#include "fewer.h"
#include "good.h"
#include "random_numbers.h"

#include "physics/chain/strain_level.h"
#include "physics/rod/strain.h"
#include "physics/solve/solve.h"

enum { PARAMETERS = 3, STAGES = 8, NODES_MAX = 96, PLACES = 9 };

static const char *const names[PARAMETERS] = {"pull", "push", "stiff"};
static const double usual[PARAMETERS] = {1, 0.5, 1};

/* Two segments with an elbow, of which the second tapers; tendons that end mid-rod and that wind, a
 * chamber, followers within and distributed, the weight, a force and a moment at the tip;
 * magnetised, in a field with a gradient. */
static const char robot[] =
    "parameters: {pull: {range: [0, 2]}, push: {range: [0, 1]}, stiff: {range: [0.5, 2], scale: "
    "log},\n"
    "             half: stiff/2}\n"
    "rod: {model: cosserat, section: {shape: circle, radius: 0.002},\n"
    "      material: {youngs_modulus: 1e9*stiff, poissons_ratio: 0.3, density: 2000}}\n"
    "segments:\n"
    "  - {length: 0.1}\n"
    "  - {length: 0.15, turn: [0, 0.3, 0], section: {radius: \"0.002-0.004*(s-0.1)\"},\n"
    "     material: {youngs_modulus: 2e9*half}}\n"
    "boundary: {start: {type: clamped, rotation: [0.8, 0.6, 0, 0], position: [0, 0.1, 0]},\n"
    "           end: {type: loaded}}\n"
    "loads:\n"
    "  gravity: [0, 4, -8]\n"
    "  frame: follower\n"
    "  force: [\"push*s\", 0, 0]\n"
    "  moment: [0, 0.01*push, 0]\n"
    "  magnetic: {moment: [0.02, s, 0.1], field: [0.02*push, 0.01, 0],\n"
    "             gradient: [0.1, -0.2, 0.1*push, 0.05, 0.1]}\n"
    "  tip: {force: [0.02, 0.05*push, 0], moment: [0.003, 0, 0.001*pull], frame: follower}\n"
    "  points: [{at: 0.17, force: [0.1*push, 0, 0], frame: follower},\n"
    "           {at: 0.05, force: [0, 0.02, 0], moment: [0.002*push, 0, 0.001]}]\n"
    "tendons:\n"
    "  - {offset: [0.006, 0], end: 0.18, tension: pull}\n"
    "  - {offset: [\"0.005*cos(10*s)\", \"0.005*sin(10*s)\"], tension: 0.5*pull^2}\n"
    "chambers: [{offset: [0, 0.005], pressure: 5e4*push, area: 1e-5}]\n";

/* Dead forces alone. */
static const char plain[] =
    "parameters: {pull: {range: [0, 2]}, push: {range: [0, 1]}, stiff: {range: [0.5, 2], scale: "
    "log}}\n"
    "rod: {model: cosserat, length: 0.2, section: {shape: circle, radius: 0.0005},\n"
    "      material: {youngs_modulus: 60e9*stiff, poissons_ratio: 0.3, density: 6450}}\n"
    "boundary: {end: {type: loaded}}\n"
    "loads: {gravity: [0, 9.81*push, 0], tip: {force: [0.1, 0.1*push, -0.05]}}\n"
    "tendons: [{offset: [0.008, 0], tension: pull}, {offset: [-0.004, 0.0069], tension: push}]\n";

/* ---- on the tape --------------------------------------------------------------------------- */

typedef struct recorded {
    config *given;
    scene one;
    double scale; /* m */
    ad_tape *tape;
    ad_value parameters, curvature, direction; /* inputs 1 to 3 */
    ad_value state;
    strain_mesh mesh;
    int nodes;
    strain_rod *rod;
} recorded;

static recorded begin(const char *text, int stages)
{
    recorded r = {.given = read_text(text, 0, NULL), .tape = ad_tape_create()};
    ad_error error = {.message = ""};
    ad_value each[PARAMETERS], s = ad_input(r.tape, "s", 1);
    scene_middle(&r.given->scene, &r.one);
    r.scale = scene_length(&r.one);
    assert_good(strain_mesh_of(&r.one, stages, &r.mesh, &error), &error);
    r.nodes = strain_mesh_nodes(&r.mesh);
    assert_true(r.nodes <= NODES_MAX);
    r.parameters = ad_input_member(r.tape, "parameters", PARAMETERS);
    r.curvature = ad_input_member(r.tape, "curvature", 3 * r.nodes);
    r.direction = ad_input(r.tape, "direction", 3 * r.nodes);
    for (int i = 0; i < PARAMETERS; i++) {
        each[i] = ad_row(r.parameters, i);
    }
    const strain_settings settings = {&r.given->scene, PARAMETERS, names, usual, r.mesh, NULL};
    assert_good(strain_rod_create(&settings, s, each, &r.rod, &error), &error);
    r.state = strain_rod_state(r.rod, r.curvature);
    return r;
}

static void end(recorded *r)
{
    strain_rod_free(r->rod);
    ad_tape_free(r->tape);
    config_free(r->given);
}

/* of [rows] at one point. */
static void evaluate_one(const recorded *r, ad_value of, const double *parameters,
                         const double *curvature, const double *direction, double *result)
{
    (void)r;
    evaluate(1, &of, 1, (const double *const[]){NULL, parameters, curvature, direction, NULL}, NULL,
             (double *[]){result});
}

/* A curvature near the rest shape, by up to `size` of 1/length. */
static void draw(const recorded *r, double size, double *curvature)
{
    uint64_t random = 3;
    evaluate_one(r, strain_rod_rest(r->rod), usual, curvature, curvature, curvature);
    for (int i = 0; i < 3 * r->nodes; i++) {
        curvature[i] += random_in(&random, -size, size);
    }
}

/* ---- against the solver's ------------------------------------------------------------------ */

/* Residual of the form in lanes, of one rod. */
static void solve_form(const recorded *r, const double *parameters, const double *curvature,
                       double *residual)
{
    const solve_parameters open = {PARAMETERS, names, usual};
    const double tip = 1;
    double given[LANES * PARAMETERS];
    solve_rod *rod = NULL;
    strain_level level;
    ad_error error = {.message = ""};
    lanes whole = {0};
    whole += 1;
    assert_good(solve_rod_create_open(&r->given->scene, &open, &rod, &error), &error);
    assert_good(strain_level_create(rod, r->mesh.stages, r->mesh.elements, r->mesh.edges, false, 1,
                                    &tip, &level, &error),
                &error);
    double *room = malloc(strain_level_room(&level, rod) * sizeof *room);
    for (int lane = 0; lane < LANES; lane++) {
        memcpy(given + lane * PARAMETERS, parameters, PARAMETERS * sizeof *given);
    }
    assert_good(strain_level_give(&level, rod, PARAMETERS, given, room, &error), &error);
    strain_level_load(&level, &whole);
    strain_level_rest(&level);
    strain_form *form = level.form;
    for (int i = 0; i < 3 * r->nodes; i++) {
        form->at[i % r->nodes].u[i / r->nodes] = curvature[i] + (lanes){0};
    }
    strain_form_shape(form); /* v is warm then */
    strain_form_shape(form);
    for (int i = 0; i < 3 * r->nodes; i++) {
        residual[i % 3 * r->nodes + i / 3] = form->right[i][0];
    }
    free(room);
    strain_level_free(&level);
    solve_rod_free(rod);
}

/* Residuals are those of the solver to rounding. Their derivatives as exported: test_export_family.
 */
static void test_as_solver(void **state)
{
    (void)state;
    static const char *const texts[2] = {robot, plain};
    double residual[2][3 * NODES_MAX];
    for (int k = 0; k < 2; k++) {
        recorded r = begin(texts[k], STAGES);
        const double parameters[PARAMETERS] = {0.7, 0.9, 1.3};
        const int n = 3 * r.nodes;
        double curvature[3 * NODES_MAX];
        draw(&r, 3, curvature);
        solve_form(&r, parameters, curvature, residual[0]);
        evaluate_one(&r, strain_rod_residual(r.rod, r.curvature, r.state), parameters, curvature,
                     curvature, residual[1]);
        for (int i = 0; i < n; i++) {
            assert_near(residual[1][i], residual[0][i], 2e-12); /* of terms of up to 100 */
        }
        end(&r);
    }
}

/* ---- against the other solver -------------------------------------------------------------- */

/* Its shape and its curvature at the points. */
static void solve_one(const recorded *r, int count, const double *s, double *values)
{
    solution *found = NULL;
    solve_report report;
    ad_error error = {.message = ""};
    const solve_settings asked = {.tolerance = 1e-11};
    double at[NODES_MAX];
    for (int i = 0; i < count; i++) {
        at[i] = s[i] * r->scale;
    }
    assert_good(solution_create(&r->one, &asked, 0, NULL, &found, &report, &error), &error);
    assert_good(solution_evaluate(found, 19, (size_t)count, at, NULL, values, &error), &error);
    solution_free(found);
}

/* Largest distances of what is recorded at the solution's curvature: of positions, rotations,
 * strains, over the length; forces and moments over their largest; and of the residual. */
typedef struct errors {
    double position, rotation, strain, force, moment, residual;
} errors;

static errors errors_of(const char *text, int stages)
{
    static const double s[PLACES] = {0, 0.07, 0.2, 0.4, 0.55, 0.68, 0.72, 0.9, 1};
    double points[NODES_MAX], solved[19 * NODES_MAX], curvature[3 * NODES_MAX], at[PLACES];
    double expected[19 * PLACES], residual[3 * NODES_MAX];
    recorded r = begin(text, stages);
    errors e = {0};
    strain_mesh_places(&r.mesh, points);
    solve_one(&r, r.nodes, points, solved);
    solve_one(&r, PLACES, s, expected);
    for (int i = 0; i < 3 * r.nodes; i++) {
        curvature[i] = r.scale * solved[10 * r.nodes + i];
    }
    evaluate_one(&r, strain_rod_residual(r.rod, r.curvature, r.state), usual, curvature, curvature,
                 residual);
    for (int i = 0; i < 3 * r.nodes; i++) {
        e.residual = fmax(e.residual, fabs(residual[i]));
    }
    const strain_shape shape = strain_rod_shape(r.rod, r.curvature, r.state, PLACES, s);
    const rod_scales scales = rod_scales_of(&r.one);
    const struct {
        const ad_value *of;
        int rows;
        double unit, *error;
    } fields[] = {{shape.position, 3, scales.length, &e.position},
                  {shape.rotation, 4, 1, &e.rotation},
                  {shape.strain, 3, 1, &e.strain},
                  {shape.curvature, 3, 1 / scales.length, &e.strain},
                  {shape.force, 3, scales.force, &e.force},
                  {shape.moment, 3, scales.moment, &e.moment}};
    const double *known = expected;
    for (size_t f = 0; f < sizeof fields / sizeof *fields; f++) {
        for (int c = 0; c < fields[f].rows; c++, known += PLACES) {
            evaluate_one(&r, fields[f].of[c], usual, curvature, curvature, at);
            for (int i = 0; i < PLACES; i++) {
                double off = fabs(at[i] - known[i] / fields[f].unit);
                *fields[f].error = fmax(*fields[f].error, off);
            }
        }
    }
    end(&r);
    return e;
}

/* At the curvature of a solution that is known to 1e-11 the residual is what interpolation by so
 * many points leaves out, and falls with them, as do distances of shapes. */
static void test_shape(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        int stages;
        double position, strain, residual;
    } rows[] = {{robot, 6, 1e-9, 1e-5, 1e-8},     {robot, 8, 1e-10, 1e-7, 1e-10},
                {robot, 12, 1e-10, 1e-10, 1e-12}, {plain, 6, 1e-7, 2e-4, 5e-5},
                {plain, 8, 1e-8, 1e-5, 5e-7},     {plain, 12, 1e-10, 1e-8, 3e-10}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const errors e = errors_of(rows[k].text, rows[k].stages);
        assert_near(e.position, 0, rows[k].position);
        assert_near(e.rotation, 0, 10 * rows[k].position);
        assert_near(e.strain, 0, rows[k].strain);
        assert_near(e.force, 0, 100 * rows[k].position); /* of 1 to 10 EI/L^2 */
        assert_near(e.moment, 0, rows[k].strain);
        assert_near(e.residual, 0, rows[k].residual);
    }
}

/* ---- derivatives --------------------------------------------------------------------------- */

/* Of the residual and of the tip by curvature and parameters at once, along one direction: against
 * central differences of order 4. */
static void test_differences(void **state)
{
    (void)state;
    static const char *const texts[2] = {robot, plain};
    static const double weights[4] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12}, h = 1e-3;
    for (int k = 0; k < 2; k++) {
        const double tip = 1, parameters[PARAMETERS] = {0.7, 0.9, 1.3}, by[PARAMETERS] = {1, -1, 1};
        recorded r = begin(texts[k], STAGES);
        const int rows = 3 * r.nodes;
        double curvature[3 * NODES_MAX], direction[3 * NODES_MAX], moved[3 * NODES_MAX];
        double value[4][3 * NODES_MAX + 3], slope[3 * NODES_MAX + 3];
        uint64_t random = 8;
        draw(&r, 2, curvature);
        for (int i = 0; i < rows; i++) {
            direction[i] = random_in(&random, -1, 1);
        }
        const strain_shape shape = strain_rod_shape(r.rod, r.curvature, r.state, 1, &tip);
        ad_value all = ad_stack(2, (ad_value[]){strain_rod_residual(r.rod, r.curvature, r.state),
                                                ad_stack(3, shape.position)});
        ad_value change;
        const ad_value wrt[2] = {r.curvature, r.parameters},
                       along[2] = {r.direction, ad_constant(r.tape, PARAMETERS, by)};
        ad_directional(1, &all, 2, wrt, along, &change);
        ad_error error;
        assert_good(ad_tape_status(r.tape, &error), &error);
        evaluate_one(&r, change, parameters, curvature, direction, slope);
        for (int side = 0; side < 4; side++) {
            const double step = (side < 2 ? side - 2 : side - 1) * h;
            double there[PARAMETERS];
            for (int i = 0; i < rows; i++) {
                moved[i] = curvature[i] + step * direction[i];
            }
            for (int i = 0; i < PARAMETERS; i++) {
                there[i] = parameters[i] + step * by[i];
            }
            evaluate_one(&r, all, there, moved, direction, value[side]);
        }
        for (int i = 0; i < rows + 3; i++) {
            double difference = 0;
            for (int side = 0; side < 4; side++) {
                difference += weights[side] * value[side][i] / h;
            }
            assert_near(slope[i], difference, 1e-8); /* 1e-12 of fifth derivatives, 1e-14/h */
        }
        end(&r);
    }
}

/* How the state changes, from the state as an input, is what the derivative of all its steps says.
 */
static void test_state(void **state)
{
    (void)state;
    static const char *const texts[2] = {robot, plain};
    enum { ROWS_MAX = 18 * NODES_MAX + 100 };
    for (int k = 0; k < 2; k++) {
        const double parameters[PARAMETERS] = {0.7, 0.9, 1.3}, by[PARAMETERS] = {1, -1, 1};
        recorded r = begin(texts[k], STAGES);
        const int rows = ad_rows(r.state);
        assert_true(rows <= ROWS_MAX);
        double curvature[3 * NODES_MAX], direction[3 * NODES_MAX];
        double at[ROWS_MAX], all[ROWS_MAX], last[ROWS_MAX];
        uint64_t random = 9;
        draw(&r, 2, curvature);
        for (int i = 0; i < 3 * r.nodes; i++) {
            direction[i] = random_in(&random, -1, 1);
        }
        ad_value given = ad_input(r.tape, "state", rows), whole;
        const ad_value wrt[2] = {r.curvature, r.parameters},
                       along[2] = {r.direction, ad_constant(r.tape, PARAMETERS, by)};
        ad_directional(1, &r.state, 2, wrt, along, &whole);
        ad_value change =
            strain_rod_state_change(r.rod, r.curvature, given, &(strain_changes){2, wrt, along});
        const double *const inputs[] = {NULL, parameters, curvature, direction, at, NULL};
        evaluate_one(&r, r.state, parameters, curvature, direction, at);
        evaluate_one(&r, whole, parameters, curvature, direction, all);
        evaluate(1, &change, 1, inputs, NULL, (double *[]){last});
        double largest = 0;
        for (int i = 0; i < rows; i++) {
            largest = fmax(largest, fabs(all[i]));
            assert_near(last[i], all[i], 1e-11); /* steps of v leave 1e-16, sums of 100 terms */
        }
        assert_true(largest > 0.1);
        end(&r);
    }
}

/* ---- refusals ------------------------------------------------------------------------------ */

static void test_refusals(void **state)
{
    (void)state;
    static const char from[] = "tension: push}",
                      to[] = "tension: push, friction: 0.1}, "
                             "{offset: [0.004, 0.0069], end: 0.1, tension: push}";
    char text[2000];
    const char *at = strstr(plain, from);
    scene one;
    ad_error error = {.message = ""};
    snprintf(text, sizeof text, "%.*s%s%s", (int)(at - plain), plain, to, at + strlen(from));
    config *given = read_text(text, 0, NULL);
    scene_middle(&given->scene, &one);
    assert_int_equal(strain_check(&one, true, &error), AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "friction of a tendon where strains jump"));
    config_free(given);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_as_solver),
                                       cmocka_unit_test(test_differences),
                                       cmocka_unit_test(test_refusals)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_shape), cmocka_unit_test(test_state)};
    return run_with_alike(tests, alike, NULL, NULL);
}
