/* For tests: a robot with three tendons among surfaces of triangles, and shapes at random of its
 * ways. */
#ifndef TESTS_PLAN_TESTING_H
#define TESTS_PLAN_TESTING_H

#include "meshes.h"
#include "near.h"
#include "random_numbers.h"
#include "temporary_folder.h"
#include "tools/config/config.h"
#include "tools/plan/certificate.h"

static inline environment *open_mesh(mesh *m, environment_side side)
{
    surface *of = NULL;
    environment *result = NULL;
    ad_error error = {.message = ""};
    mesh_write_stl(m, at("mesh.stl"));
    mesh_free(m);
    assert_int_equal(surface_read(at("mesh.stl"), 1, &of, &error), AD_OK);
    assert_int_equal(environment_create(of, side, &result, &error), AD_OK);
    return result;
}

static const char robot_text[] =
    "parameters:\n"
    "  pull_1: {range: [0, 6]}\n"
    "  pull_2: {range: [0, 6]}\n"
    "  pull_3: {range: [0, 6]}\n"
    "  stiffness: {range: [0.5, 2]}\n"
    "rod:\n"
    "  length: 0.2\n"
    "  section: {shape: circle, radius: 0.5e-3}\n"
    "  material: {youngs_modulus: 60e9*stiffness, poissons_ratio: 0.3, density: 6450}\n"
    "tendons:\n"
    "  - {offset: [8e-3, 0], tension: pull_1}\n"
    "  - {offset: [-4e-3, 6.928203230275509e-3], tension: pull_2}\n"
    "  - {offset: [-4e-3, -6.928203230275509e-3], tension: pull_3}\n";

typedef struct robot {
    config *owner;
    plan_robot moves;
    plan_exact *exact;
} robot;

/* stiffness: fixed, as "stiffness=1"; NULL: unknown. */
static inline robot make_robot_of(bool base, const char *stiffness)
{
    robot r = {.owner = NULL};
    ad_error error = {.message = ""};
    char key[PLAN_KEY] = "";
    plan_settings settings = plan_settings_default();
    const char *const range = "parameters.stiffness={range: [0.9, 1.2]}";
    if (stiffness) {
        settings.fixed[settings.fixed_count++] = stiffness;
    } else {
        settings.unknown[settings.unknown_count++] = "stiffness";
    }
    if (base) {
        settings.slide[0] = -0.05, settings.slide[1] = 0.05;
        settings.turn[0] = -1, settings.turn[1] = 1;
    }
    assert_int_equal(
        config_read("robot.yaml", robot_text, stiffness ? 0 : 1, &range, &r.owner, &error), AD_OK);
    assert_int_equal(plan_robot_create(&settings, &r.owner->scene, &r.moves, key, &error), AD_OK);
    return r;
}

static inline robot make_robot(bool base)
{
    return make_robot_of(base, "stiffness=1.1");
}

static inline void open_robot(robot *r, size_t points)
{
    ad_error error = {.message = ""};
    assert_int_equal(
        plan_exact_create(&r->moves, &r->owner->scene, points, 0, 0, &r->exact, &error), AD_OK);
}

static inline void free_robot(robot *r)
{
    plan_exact_free(r->exact);
    config_free(r->owner);
}

/* Shapes of a way at random, by solutions on more points, among them those of the certificate: so
 * lines between them are within what it looked at. Returns how much further they are from the
 * surface than is promised for the place of the way, at least, m; what the solver may be off is
 * allowed. */
static inline double try_way(robot *r, const environment *of, const certificate *c, double radius,
                             uint64_t seed, int shapes, double from, bool unknown)
{
    double q[PLAN_BATCH * PLAN_VARIABLES_MAX], promised[PLAN_BATCH];
    const size_t n = (size_t)c->variables;
    double closest = INFINITY, worst = INFINITY;
    for (int k = 0; k < shapes; k += PLAN_BATCH) {
        for (size_t m = 0; m < PLAN_BATCH; m++) {
            const size_t i = random_bits(&seed) % (c->count - 1);
            const double part = random_in(&seed, 0, 1);
            promised[m] = c->least[i];
            for (size_t v = 0; v < n; v++) {
                const double *const a = &c->configuration[i * n + v];
                q[m * n + v] = a[0] + part * (a[n] - a[0]);
            }
        }
        if (unknown) { /* a stiffness for the batch */
            r->moves.fixed[3] = random_in(&seed, 0.9, 1.2);
        }
        assert_int_equal(plan_exact_shapes(r->exact, PLAN_BATCH, q, NULL), AD_OK);
        for (size_t m = 0; m < PLAN_BATCH; m++) {
            double within = INFINITY, nearest = INFINITY;
            for (size_t p = 0; p + 1 < r->exact->points; p++) {
                const double *const at_p = &r->exact->r[3 * (m * r->exact->points + p)];
                if (r->exact->s[p] < from) {
                    continue;
                }
                const double d = environment_segment(of, at_p, at_p + 3, within);
                within = fabs(d) + 0.004; /* more than there is from point to point */
                nearest = fmin(nearest, d - radius);
            }
            assert_true(r->exact->error[m] < 1e-8);
            assert_true(nearest >= promised[m] - 2e-10);
            closest = fmin(closest, nearest);
            worst = fmin(worst, nearest - promised[m]);
        }
    }
    assert_true(closest >= c->all.free - 2e-10);
    print_message("promised %.6f m, found %.6f m; %zu shapes, %.2g m more than promised\n",
                  c->all.free, closest, c->count, worst);
    return worst;
}

/* ---- searches -------------------------------------------------------------------------------- */

static inline ad_status by_solver(void *context, const double *parameters, double *values,
                                  ad_error *error)
{
    solve_member said;
    return solve_members_solve(context, 1, parameters, values, &said, error);
}

static inline void add_box(mesh *m, const double low[3], const double high[3])
{
    static const size_t quads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                       {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    const size_t first = m->corners;
    for (int i = 0; i < 8; i++) {
        mesh_corner(m, i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1],
                    i & 4 ? high[2] : low[2]);
    }
    for (int i = 0; i < 6; i++) {
        const size_t *const q = quads[i];
        mesh_triangle(m, first + q[0], first + q[1], first + q[2]);
        mesh_triangle(m, first + q[0], first + q[2], first + q[3]);
    }
}

/* A solver for searches, at 41 points s along the 0.2 m. */
static inline solve_members *quick_solver(const robot *of, double *s)
{
    for (int k = 0; k <= 40; k++) {
        s[k] = 0.005 * k;
    }
    const solve_members_settings members = {.tolerance = 1e-6, .threads = 1, .points = 41, .s = s};
    solve_members *quick = NULL;
    assert_int_equal(solve_members_create(&of->owner->scene, &members, &quick, NULL), AD_OK);
    return quick;
}

/* A robot with what its searches and its certificates need, and one with more points. */
typedef struct mover {
    robot exact, fine;
    double s[41];
    solve_members *quick;
} mover;

static inline void open_mover(mover *m, bool base)
{
    m->exact = make_robot(base);
    m->fine = make_robot(base);
    open_robot(&m->exact, 61);
    open_robot(&m->fine, 181);
    m->quick = quick_solver(&m->exact, m->s);
}

static inline void close_mover(mover *m)
{
    solve_members_free(m->quick);
    free_robot(&m->exact);
    free_robot(&m->fine);
}

/* A wall across the square at x = 1 with a gap, or none. */
typedef struct square {
    double gap;
    size_t asked;
} square;

static inline bool in_square(void *context, const double *q)
{
    square *const s = context;
    s->asked++;
    return fabs(q[0] - 1) > 0.2 || (q[1] > 2 && q[1] < 2 + s->gap);
}

#endif
