/* Motion in a plane: which scenes have it, and that the equations left are those of space. */
#include "rod_testing.h"

#include <stdio.h>

#include "physics/rod/rod_internal.h"

/* ---- a scene in any plane -------------------------------------------------------------------- */

enum { CUBE_ROTATIONS = 24, SCENE_TEXTS = 40 };

typedef enum variant {
    DYNAMIC = 1,
    SOFT = 2,
    BY_DISPLACEMENT = 4,
    FOLLOWER = 8,
    VARYING = 16, /* rest strains that depend on s, loads that are formulas */
    VARIANTS = 32
} variant;

typedef struct planar {
    scene scene;
    double q[4], axes[3][3]; /* rotation of the clamp; columns d1, d2, d3 */
} planar;

/* Those that map the world axes to world axes: the unit Hurwitz quaternions, and (1, e_i), ... */
static void cube_rotation(int index, double q[4])
{
    static const int halves[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
    memset(q, 0, 4 * sizeof *q);
    if (index < 4) {
        q[index] = 1;
    } else if (index < 12) {
        for (int i = 0; i < 4; i++)
            q[i] = i > 0 && (index - 4) >> (i - 1) & 1 ? -0.5 : 0.5;
    } else {
        q[halves[(index - 12) / 2][0]] = sqrt(0.5);
        q[halves[(index - 12) / 2][1]] = index % 2 ? -sqrt(0.5) : sqrt(0.5);
    }
}

static void axes_of(const double q[4], double axes[3][3], bool exact)
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        axes[i][i] = 1 - 2 * (q[j + 1] * q[j + 1] + q[k + 1] * q[k + 1]);
        axes[j][i] = 2 * (q[i + 1] * q[j + 1] + q[0] * q[k + 1]);
        axes[k][i] = 2 * (q[i + 1] * q[k + 1] - q[0] * q[j + 1]);
    }
    for (int i = 0; i < 9 && exact; i++)
        axes[i / 3][i % 3] = round(axes[i / 3][i % 3]);
}

/* numbers [count], each followed by `factor` ("" for none) unless it is 0. */
static void write_texts(quantity *field, int count, const double *numbers, const char *factor)
{
    for (int i = 0; i < count; i++) {
        char text[64];
        snprintf(text, sizeof text, "%.17g%s", numbers[i] + 0.0, numbers[i] != 0 ? factor : "");
        field[i] = Q(text);
    }
}

/* A vector of the plane, or its normal, in the world (or, `body`, as it is). */
static void write_vector(planar *p, quantity *field, bool body, double along_side,
                         double along_tangent, double along_normal, int director,
                         const char *factor)
{
    double parts[3] = {0}, world[3];
    parts[director] = along_normal;
    parts[1 - director] = along_side;
    parts[2] = along_tangent;
    for (int i = 0; i < 3; i++)
        world[i] = p->axes[i][0] * parts[0] + p->axes[i][1] * parts[1] + p->axes[i][2] * parts[2];
    write_texts(field, 3, body ? parts : world, factor);
}

static void add_ends(planar *p, int director, int end_type, bool follower)
{
    scene *made = &p->scene;
    made->start.type = SCENE_CLAMPED;
    made->end.type = (scene_end_type)end_type;
    made->loads.tip.frame = follower ? SCENE_FOLLOWER : SCENE_DEAD;
    write_texts(made->start.rotation, 4, p->q, "");
    write_vector(p, made->start.position, false, 0.1, 0.2, 0.3, director, "");
    write_vector(p, made->loads.tip.force, follower, 2, -1.5, 0, director, "");
    write_vector(p, made->loads.tip.moment, follower, 0, 0, 0.7, director, "");
    if (end_type == SCENE_LOADED)
        return;
    double half[4] = {cos(0.2), 0, 0, 0}, turned[4];
    half[1 + director] = sin(0.2);
    const double *a = p->q, *b = half;
    turned[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        turned[i + 1] =
            a[0] * b[i + 1] + b[0] * a[i + 1] + a[j + 1] * b[k + 1] - a[k + 1] * b[j + 1];
    }
    write_texts(made->end.rotation, 4, turned, "");
    write_vector(p, made->end.position, false, 0.2, 1.1, 0.3, director, "");
}

static void planar_scene(planar *p, const double q[4], bool exact, int director, int variants,
                         int end_type)
{
    const double kse[3] = {40, 50, 90}, kbt[3] = {1.2, 0.8, 0.5}, inertia[3] = {0.03, 0.02, 0.05};
    bool varying = variants & VARYING, follower = variants & FOLLOWER;
    memcpy(p->q, q, sizeof p->q);
    axes_of(q, p->axes, exact);
    p->scene = stiff_scene(1.2, kse, kbt, 1.3, inertia);
    scene *made = &p->scene;
    made->motion = SCENE_AUTOMATIC;
    made->duration = Q(variants & DYNAMIC ? 1.5 : 0);
    made->formulation = variants & BY_DISPLACEMENT ? SCENE_DISPLACEMENT : SCENE_MIXED;
    made->boundary_enforcement = made->initial_enforcement =
        variants & SOFT ? SCENE_SOFT : SCENE_HARD;
    add_ends(p, director, end_type, follower);
    made->loads.frame = follower ? SCENE_FOLLOWER : SCENE_DEAD;
    made->loads.drag = Q(0.2);
    const char *factor = varying && (exact || follower) ? "*(1+s*t)" : "";
    write_vector(p, made->loads.force, follower, 0.6, -0.4, 0, director, factor);
    write_vector(p, made->loads.moment, follower, 0, 0, 0.35, director, factor);
    write_vector(p, made->rod.rest_strain, true, varying ? 0.05 : 0, 1.02, 0, director,
                 varying ? "*(1+0.1*s)" : "");
    write_vector(p, made->rod.rest_curvature, true, 0, 0, 0.4, director, varying ? "*cos(s)" : "");
    for (int i = 0; i < 3; i++) {
        made->loads.gravity[i] = Q(3 * p->axes[i][2] - 2 * p->axes[i][1 - director]);
        made->rod.strain_damping[i] = Q(0.3 + 0.1 * i);
        made->rod.curvature_damping[i] = Q(0.02 + 0.01 * i);
    }
    if (variants & DYNAMIC) {
        write_vector(p, made->initial.velocity, false, 0.3, 0.1, 0, director, exact ? "*s" : "");
        write_vector(p, made->initial.angular_velocity, true, 0, 0, 0.2, director, "*s");
    }
}

/* ---- detection ------------------------------------------------------------------------------- */

static void test_all_planes(void **state)
{
    (void)state;
    static const int ends[] = {SCENE_LOADED, SCENE_PINNED, SCENE_CLAMPED, SCENE_FREE};
    for (int r = 0; r < CUBE_ROTATIONS; r++) {
        for (int director = 0; director < 2; director++) {
            for (int v = 0; v < VARIANTS; v++) {
                double q[4];
                planar p;
                cube_rotation(r, q);
                planar_scene(&p, q, true, director, v, ends[(r + v) % 4]);
                rod_plane plane = rod_plane_of(&p.scene);
                if (!plane.is_planar)
                    fail_msg("rotation %d, d%d, variant %d: %s", r, director + 1, v, plane.leaves);
                assert_int_equal(plane.director, director);
                assert_null(plane.leaves);
                assert_true(plane.height == 0.3);
                for (int i = 0; i < 3; i++)
                    assert_true(plane.normal[i] == p.axes[i][director]); /* exact, no rounding */
            }
        }
    }
}

/* A scene in the x-z plane, d2 along y, to be spoiled. */
static scene upright_scene(planar *p)
{
    planar_scene(p, (double[]){1, 0, 0, 0}, true, 1, DYNAMIC | VARYING, SCENE_LOADED);
    assert_true(rod_plane_of(&p->scene).is_planar);
    return p->scene;
}

typedef struct change {
    const char *key; /* that leaves the plane, NULL: none does */
    const char *texts[4];
    size_t offset;
    int count;
} change;

#define CHANGE(key, field, ...)                                                                    \
    {                                                                                              \
        key, {__VA_ARGS__}, offsetof(scene, field),                                                \
            (int)(sizeof(((scene *)0)->field) / sizeof(quantity))                                  \
    }

static const change changes[] = {
    CHANGE("loads.tip.force", loads.tip.force, "1", "1e-9", "0"),
    CHANGE("loads.tip.force", loads.tip.force, "1", "t", "0"),
    CHANGE("loads.tip.force", loads.tip.force, "1", "0*t", "0"), /* formulas are not looked into */
    CHANGE(NULL, loads.tip.force, "sin(t)", "2-2", "t"),
    CHANGE("loads.tip.moment", loads.tip.moment, "0.1", "1", "0"),
    CHANGE("loads.tip.moment", loads.tip.moment, "0", "1", "t"),
    CHANGE(NULL, loads.tip.moment, "0", "t", "0"),
    CHANGE(NULL, loads.base.force, "0", "1", "0"), /* the end is not loaded */
    CHANGE("loads.force", loads.force, "s", "s", "0"),
    CHANGE("loads.moment", loads.moment, "s", "s", "0"),
    CHANGE("rod.rest.strain", rod.rest_strain, "0", "0.1", "1"),
    CHANGE("rod.rest.curvature", rod.rest_curvature, "0.1", "0", "0"),
    CHANGE("rod.rest.curvature", rod.rest_curvature, "0", "1", "s"),
    CHANGE("rod.rest.imperfection", rod.imperfection, "0.1", "0", "0"),
    CHANGE("initial.velocity", initial.velocity, "0", "s", "0"),
    CHANGE("initial.angular_velocity", initial.angular_velocity, "0", "0", "s"),
    CHANGE("initial.position", initial.position, "0.1", "0.2", "s"),
    CHANGE("initial.position", initial.position, "0.1", "0.3+s*(1-s)", "s"),
    CHANGE(NULL, initial.position, "0.1*s", "0.3", "0.2+s"),
    CHANGE("initial.rotation", initial.rotation, "1", "0.1", "0", "0"),
    CHANGE("initial.rotation", initial.rotation, "cos(s)", "sin(s)", "0", "0"),
    CHANGE(NULL, initial.rotation, "cos(s)", "0", "sin(s)", "0"),
    CHANGE("boundary.start.rotation", start.rotation, "cos(t)", "sin(t)", "sin(t)", "0"),
};

static void test_what_leaves(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
        planar p;
        scene given = upright_scene(&p);
        quantity *field = (quantity *)(void *)((char *)&given + changes[i].offset);
        for (int k = 0; k < changes[i].count; k++)
            field[k] = Q(changes[i].texts[k]);
        rod_plane plane = rod_plane_of(&given);
        const char *wanted = changes[i].key ? changes[i].key : "no key";
        const char *found = plane.leaves ? plane.leaves : "no key";
        if (strcmp(found, wanted) != 0 || plane.is_planar != !changes[i].key)
            fail_msg("row %zu: %s leaves the plane, not %s", i, found, wanted);
        assert_int_equal(rod_network_outputs(&given), plane.is_planar ? 6 : 13);
        given.rotation = SCENE_VECTOR; /* in a plane an angle in either case */
        assert_int_equal(rod_network_outputs(&given), plane.is_planar ? 6 : 12);
    }
}

static const char *leaves(const scene *given)
{
    const char *key = rod_plane_of(given).leaves;
    return key ? key : "no key";
}

static void test_other_reasons(void **state)
{
    (void)state;
    planar p;
    scene given = upright_scene(&p);
    given.loads.gravity[1] = Q(-9.81);
    assert_string_equal(leaves(&given), "loads.gravity");
    given = upright_scene(&p);
    given.motion = SCENE_SPATIAL;
    assert_string_equal(leaves(&given), "motion");
    given = upright_scene(&p);
    given.start.rotation[3] = Q("0.1"); /* turned about the tangent: then the loads lie askew */
    assert_string_not_equal(leaves(&given), "no key");
    given = upright_scene(&p);
    given.end.type = SCENE_CLAMPED;
    static const char *const turned[4] = {"1", "0.1", "0", "0"}, *const aside[3] = {"0", "0", "1"};
    for (int i = 0; i < 4; i++)
        given.end.rotation[i] = Q(turned[i]);
    assert_string_equal(leaves(&given), "boundary.end.rotation");
    given.end.type = SCENE_PINNED;
    for (int i = 0; i < 3; i++)
        given.end.position[i] = Q(aside[i]); /* the plane is at y = 0.3 */
    assert_string_equal(leaves(&given), "boundary.end.position");
    given.manufactured.position[0] = given.manufactured.position[1] = Q("0");
    given.manufactured.position[2] = Q("s");
    assert_string_equal(leaves(&given), "manufactured");
}

/* Driven ends: rotations that stay in the two families a formula can be seen to stay in. */
static void test_driven(void **state)
{
    (void)state;
    static const struct {
        const char *q[4], *const r[3];
        int director, sign; /* of the normal along axis `director`; 0: spatial */
    } rows[] = {{{"cos(t)", "0", "sin(t)", "0"}, {"t", "0.3", "t^2"}, 1, 1},
                {{"0", "sin(t)", "0", "cos(t)"}, {"t", "0.3", "t^2"}, 1, -1},
                {{"cos(t)", "sin(t)", "0", "0"}, {"0.3", "sin(t)", "t"}, 0, 1},
                {{"0", "0", "2*t", "1"}, {"0.3", "sin(t)", "t"}, 0, -1},
                {{"cos(t)", "0", "0", "sin(t)"}, {"0", "0", "0"}, 0, 0}, /* twists */
                {{"cos(t)", "0", "sin(t)", "0"}, {"t", "t", "t"}, 1, 0},
                {{"cos(t)", "0", "sin(t)", "0.1"}, {"0", "0", "0"}, 1, 0}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const double kse[3] = {40, 50, 90}, kbt[3] = {1.2, 0.8, 0.5}, none[3] = {0, 0, 0};
        scene given = stiff_scene(1, kse, kbt, 1, none);
        given.motion = SCENE_AUTOMATIC;
        given.duration = Q(1);
        given.start.type = SCENE_DRIVEN;
        set_quantities(given.start.rotation, 4, rows[k].q);
        set_quantities(given.start.position, 3, rows[k].r);
        rod_plane plane = rod_plane_of(&given);
        assert_int_equal(plane.is_planar, rows[k].sign != 0);
        if (!plane.is_planar)
            continue;
        assert_int_equal(plane.director, rows[k].director);
        assert_true(plane.normal[plane.director] == rows[k].sign);
        recorded r = begin(&given);
        rod_state s = rod_ansatz(&given, &r.at, ad_zeros(r.tape, 6));
        rod_context rod = rod_context_of(&given, &r.at);
        ad_value turn = rod_rotation_to_world(&rod, s.rotation);
        double at[POINTS] = {0}, t[POINTS] = {0.1, 0.4, 0.9, 0.2, 0.6, 0.8};
        double *q = evaluate_at(turn, POINTS, at, t, NULL);
        for (int i = 0; i < POINTS; i++) {
            double wanted[4], size = 0;
            for (int j = 0; j < 4; j++) {
                wanted[j] = quantity_value(given.start.rotation[j], 0, t[i] * rod.scales.time);
                size += wanted[j] * wanted[j];
            }
            for (int j = 0; j < 4; j++) /* the clamp is met with its sign */
                assert_near(q[j * POINTS + i], wanted[j] / sqrt(size), 1e-14);
        }
        free(q);
        ad_tape_free(r.tape);
    }
}

/* Between held ends angles are interpolated; -q is the rotation q. */
static void test_held_ends(void **state)
{
    (void)state;
    const double kse[3] = {40, 50, 90}, kbt[3] = {1.2, 0.8, 0.5}, none[3] = {0, 0, 0};
    static const char *const turned[2][4] = {{"-1", "0", "0", "0"}, {"0", "0", "-1", "0"}};
    for (int half = 0; half < 2; half++) {
        scene given = stiff_scene(1, kse, kbt, 1, none);
        given.motion = SCENE_AUTOMATIC;
        given.start.type = given.end.type = SCENE_CLAMPED;
        set_quantities(given.end.rotation, 4, turned[half]);
        recorded r = begin(&given);
        rod_state s = rod_ansatz(&given, &r.at, ad_zeros(r.tape, 6));
        double at[POINTS] = {0, 0.1, 0.25, 0.5, 0.8, 1}, t[POINTS] = {0};
        double *q = evaluate_at(s.rotation, POINTS, at, t, NULL);
        for (int i = 0; i < POINTS; i++) { /* by no or half a turn in all */
            assert_near(q[i], cos(half * PI * at[i] / 2), 1e-15);
            assert_near(fabs(q[2 * POINTS + i]), sin(half * PI * at[i] / 2), 1e-15);
        }
        free(q);
        ad_tape_free(r.tape);
    }
}

/* ---- equations ------------------------------------------------------------------------------- */

/* Any outputs that vary with s and t. */
static ad_value some_outputs(const scene *given, const recorded *r)
{
    ad_value rows[13];
    int count = rod_network_outputs(given);
    for (int i = 0; i < count; i++) {
        ad_value phase = ad_add(ad_scale(r->s, 1 + 0.3 * i), ad_scale(r->t, 0.5 + 0.2 * i));
        rows[i] = ad_sin(ad_add(phase, ad_scalar(r->tape, 0.7 * i)));
    }
    return ad_stack(count, rows);
}

typedef struct block {
    bool axial, world;
} block;

/* What the rows of a residual are, three of a spatial scene at a time. */
static int blocks_of(const scene *given, rod_residual_kind kind, block *blocks)
{
    const block vector = {false, false}, axial = {true, false}, world = {false, true};
    const scene_end *end = kind == ROD_END ? &given->end : &given->start;
    bool soft = given->boundary_enforcement == SCENE_SOFT;
    bool form = given->formulation == SCENE_DISPLACEMENT;
    int count = 0;
    switch (kind) {
    case ROD_STRAIN:
        blocks[count++] = vector;
        break;
    case ROD_FORCE:
        blocks[count++] = world;
        break;
    case ROD_INITIAL:
        for (int i = 0; i < 4; i++)
            blocks[count++] = i % 2 ? axial : world;
        break;
    case ROD_START:
    case ROD_END:
        if (soft || (form && scene_hold_of(end).directions < 3))
            blocks[count++] = world;
        if (soft || (form && !scene_end_holds_rotation(end->type)))
            blocks[count++] = axial;
        break;
    default:
        blocks[count++] = axial;
    }
    return count;
}

/* The rows that planar equations have against those of space, turned into the plane's frame; what
 * they leave out vanishes. 1e-13 of the largest row: rounding of two orders of operations. */
static void compare_rows(const rod_plane *plane, int count, const block *blocks, const double *flat,
                         const double *space)
{
    double size = 1;
    for (int i = 0; i < 3 * count * POINTS; i++)
        size = fmax(size, fabs(space[i]));
    for (int point = 0; point < POINTS; point++) {
        int row = 0;
        for (int b = 0; b < count; b++) {
            for (int i = 0; i < 3; i++) {
                double wanted = blocks[b].world ? 0 : space[(3 * b + i) * POINTS + point];
                for (int j = 0; j < 3 && blocks[b].world; j++)
                    wanted += plane->axes[j][i] * space[(3 * b + j) * POINTS + point];
                bool kept = (i == plane->director) == blocks[b].axial;
                double found = kept ? flat[row++ * POINTS + point] : 0;
                assert_near(found, wanted, 1e-13 * size);
            }
        }
    }
}

static void check_against_space(const scene *given)
{
    scene spatial = *given;
    spatial.motion = SCENE_SPATIAL;
    rod_plane plane = rod_plane_of(given);
    assert_true(plane.is_planar);
    recorded r = begin(given);
    rod_context rod = rod_context_of(given, &r.at);
    rod_state flat = rod_ansatz(given, &r.at, some_outputs(given, &r));
    rod_state space = {.position = rod_position_to_world(&rod, flat.position),
                       .rotation = rod_rotation_to_world(&rod, flat.rotation),
                       .force = rod_to_world(&rod, flat.force),
                       .moment = flat.moment};
    double t[POINTS];
    points_of_time(given, t);
    for (int kind = 0; kind < ROD_RESIDUAL_COUNT; kind++) {
        block blocks[4];
        int all = rod_residual_rows(&spatial, (rod_residual_kind)kind);
        int kept = rod_residual_rows(given, (rod_residual_kind)kind), sum = 0;
        int count = all ? blocks_of(given, (rod_residual_kind)kind, blocks) : 0;
        for (int b = 0; b < count; b++)
            sum += blocks[b].axial ? 1 : 2;
        assert_int_equal(all, 3 * count);
        assert_int_equal(kept, sum);
        if (all == 0)
            continue;
        ad_value rows[2] = {rod_residual(given, (rod_residual_kind)kind, flat, &r.at),
                            rod_residual(&spatial, (rod_residual_kind)kind, space, &r.at)};
        assert_int_equal(ad_rows(rows[0]), kept);
        double *numbers[2] = {evaluate_at(rows[0], POINTS, unit_s, t, NULL),
                              evaluate_at(rows[1], POINTS, unit_s, t, NULL)};
        compare_rows(&plane, count, blocks, numbers[0], numbers[1]);
        free(numbers[0]);
        free(numbers[1]);
    }
    assert_int_equal(ad_tape_status(r.tape, NULL), AD_OK);
    ad_tape_free(r.tape);
}

static void test_equations(void **state)
{
    (void)state;
    static const int ends[] = {SCENE_LOADED, SCENE_PINNED, SCENE_CLAMPED};
    static const double skew[2][4] = {{0.8, 0, 0, 0.6}, {0.5, 0.1, -0.7, 0.5}};
    for (int r = 0; r < CUBE_ROTATIONS + 2; r++) {
        bool exact = r < CUBE_ROTATIONS;
        for (int v = r % 8; v < VARIANTS; v += 8) { /* over the rotations all of them */
            double q[4];
            planar p;
            if (exact)
                cube_rotation(r, q);
            else
                memcpy(q, skew[r - CUBE_ROTATIONS], sizeof q);
            planar_scene(&p, q, exact, (r / 8 + v / 8) % 2, v, ends[(r + v) % 3]);
            check_against_space(&p.scene);
        }
    }
}

/* What a user sees across the plane is the number 0, not a small one. */
static void test_observables(void **state)
{
    (void)state;
    for (int rotation = 0; rotation < CUBE_ROTATIONS; rotation++) {
        double q[4];
        planar p;
        int k = rotation % 2, across = 0;
        cube_rotation(rotation, q);
        planar_scene(&p, q, true, k, DYNAMIC | VARYING, SCENE_LOADED);
        recorded r = begin(&p.scene);
        rod_state s = rod_ansatz(&p.scene, &r.at, some_outputs(&p.scene, &r));
        rod_observables o = rod_observe(&p.scene, s, &r.at);
        while (p.axes[across][k] == 0)
            across++;
        const double height = 0.3 * p.axes[across][k];
        double *y = evaluate_at(ad_row(o.position, across), 1, unit_s, unit_s, NULL);
        assert_near(*y, height, 1e-16);
        free(y);
        assert_true(ad_extent_of(ad_row(o.position, across)) == AD_UNIFORM);
        assert_true(ad_is_constant(ad_row(o.velocity, across), 0));
        const ad_value vectors[2] = {o.strain, o.force};
        const ad_value axials[3] = {o.curvature, o.moment, o.angular_velocity};
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 2; j++)
                assert_int_equal(ad_is_constant(ad_row(vectors[j], i), 0), i == k);
            for (int j = 0; j < 3; j++)
                assert_int_equal(ad_is_constant(ad_row(axials[j], i), 0), i != k);
        }
        ad_tape_free(r.tape);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_planes),    cmocka_unit_test(test_what_leaves),
        cmocka_unit_test(test_other_reasons), cmocka_unit_test(test_driven),
        cmocka_unit_test(test_held_ends),     cmocka_unit_test(test_equations),
        cmocka_unit_test(test_observables),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
