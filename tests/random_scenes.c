#include "random_scenes.h"

#include "random_numbers.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- profiles -------------------------------------------------------------------------------- */

/* The value at s, on the side of a jump on which `inside` is. */
static double part_value(const profile_part *part, double s, double inside)
{
    double x = (s - part->at) / part->width;
    switch (part->kind) {
    case PROFILE_CONSTANT:
        return part->value;
    case PROFILE_BAND:
        return inside > part->at && inside < part->at + part->width ? part->value : 0;
    case PROFILE_STEP:
        return inside > part->at ? part->value : 0;
    case PROFILE_BUMP:
        return part->value * exp(-x * x);
    case PROFILE_ELBOW:
        return part->value / (cosh(x) * cosh(x));
    case PROFILE_TENT:
        return inside > part->at - part->width && inside < part->at + part->width
                   ? part->value * (1 - (inside > part->at ? x : -x))
                   : 0;
    case PROFILE_KINDS:
        break;
    }
    return NAN;
}

double profile_value(const profile *p, double s, double inside)
{
    double sum = 0;
    for (int i = 0; i < p->count; i++) {
        sum += part_value(&p->parts[i], s, inside);
    }
    return sum;
}

static void write_part(const profile_part *part, FILE *to)
{
    double a = part->at, b = part->at + part->width, w = part->width, v = part->value;
    switch (part->kind) {
    case PROFILE_CONSTANT:
        fprintf(to, "(%.17g)", v);
        break;
    case PROFILE_BAND:
        if (part->spelling == 0) {
            fprintf(to, "where((s-%.17g)*(%.17g-s), %.17g, 0)", a, b, v);
        } else if (part->spelling == 1) {
            fprintf(to, "%.17g*step(s-%.17g)*step(%.17g-s)", v, a, b);
        } else if (part->spelling == 2) {
            fprintf(to, "where(s-%.17g, where(%.17g-s, %.17g, 0), 0)", a, b, v);
        } else {
            fprintf(to, "%.17g*step(min(s-%.17g, %.17g-s))", v, a, b);
        }
        break;
    case PROFILE_STEP:
        if (part->spelling < 2) {
            fprintf(to, "where(s-%.17g, %.17g, 0)", a, v);
        } else {
            fprintf(to, "%.17g*(1-step(%.17g-s))", v, a);
        }
        break;
    case PROFILE_BUMP:
        fprintf(to, "%.17g*exp(-((s-%.17g)/%.17g)^2)", v, a, w);
        break;
    case PROFILE_ELBOW:
        if (part->spelling < 2) {
            fprintf(to, "%.17g*(1-tanh((s-%.17g)/%.17g)^2)", v, a, w);
        } else {
            fprintf(to, "%.17g/cosh((s-%.17g)/%.17g)^2", v, a, w);
        }
        break;
    case PROFILE_TENT:
        fprintf(to, "%.17g*max(0, 1-abs(s-%.17g)/%.17g)", v, a, w);
        break;
    case PROFILE_KINDS:
        break;
    }
}

/* Not given where it has no parts. */
static quantity profile_quantity(const profile *p, quantities *names)
{
    char *text = NULL;
    size_t size = 0;
    FILE *to = open_memstream(&text, &size);
    for (int i = 0; i < p->count && to; i++) {
        fputs(i ? " + " : "", to);
        write_part(&p->parts[i], to);
    }
    if (!to || fclose(to) != 0) {
        abort();
    }
    quantity made = quantity_formula(names, p->count > 0 ? text : NULL);
    free(text);
    return made;
}

static void profile_fill(int count, const profile *from, quantity *to, quantities *names)
{
    bool any = false;
    for (int i = 0; i < count; i++) {
        any = any || from[i].count > 0;
    }
    for (int i = 0; i < count && any; i++) {
        to[i] = from[i].count > 0 ? profile_quantity(&from[i], names) : quantity_number(0);
    }
}

/* ---- making ---------------------------------------------------------------------------------- */

typedef struct maker {
    uint64_t state;
    random_scene *scene;
} maker;

static double in(maker *m, double low, double high)
{
    return random_in(&m->state, low, high);
}

/* A part whose integral over the rod is at most so much, and its value no more than the other. */
static void add_part(maker *m, profile *to, double unit, double integral, double most)
{
    static const double least[PROFILE_KINDS] = {1, 0.005, 1, 0.002, 0.002, 0.01};
    static const double widest[PROFILE_KINDS] = {1, 0.2, 1, 0.05, 0.05, 0.1};
    double length = m->scene->length;
    profile_kind kind = (profile_kind)random_below(&m->state, PROFILE_KINDS);
    double width = exp(in(m, log(least[kind]), log(widest[kind])));
    double size = fmin(most, integral / width);
    if (to->count == PROFILE_PARTS_MAX) {
        return;
    }
    to->parts[to->count++] = (profile_part){.kind = kind,
                                            .at = length * in(m, kind == PROFILE_TENT ? 0.12 : 0.02,
                                                              kind == PROFILE_BAND ? 0.78 : 0.88),
                                            .width = length * width,
                                            .value = unit * in(m, -size, size),
                                            .spelling = random_below(&m->state, 4)};
}

static void add_constant(profile *to, double value)
{
    to->parts[to->count++] = (profile_part){.kind = PROFILE_CONSTANT, .width = 1, .value = value};
}

/* Around 1, and above 0 whatever the parts are. */
static void make_stiffness(maker *m, profile *to, double unit, int parts)
{
    add_constant(to, unit);
    for (int i = 0; i < parts; i++) {
        add_part(m, to, unit, 1, 1);
        double *value = &to->parts[to->count - 1].value;
        *value *= *value > 0 ? 3 : 0.9 / parts;
    }
}

static void make_rod(maker *m, random_scene *x)
{
    scene *made = &x->scene;
    bool planar = random_below(&m->state, 3) == 0, shears = random_below(&m->state, 2) == 0;
    double L = x->length, stiffness = exp(in(m, -2, 2)), force = stiffness / (L * L * L);
    int loads = 1 + random_below(&m->state, 3);
    made->rod.model = shears ? SCENE_COSSERAT : SCENE_KIRCHHOFF;
    for (int i = 0; i < loads; i++) { /* in a plane along x and z, and about y */
        int axis = planar ? 2 * random_below(&m->state, 2) : random_below(&m->state, 3);
        add_part(m, &x->force[axis], force, 1.5, 60);
    }
    if (random_below(&m->state, 3) == 0) {
        add_part(m, &x->moment[planar ? 1 : random_below(&m->state, 3)], force * L, 0.7, 60);
    }
    for (int i = random_below(&m->state, 3); i > 0; i--) { /* up to 90 degrees */
        add_part(m, &x->curvature[planar ? 1 : random_below(&m->state, 3)], 1 / L, 1.6, 200);
    }
    make_stiffness(m, &x->bending[0], stiffness, random_below(&m->state, 2));
    make_stiffness(m, &x->bending[1], stiffness * in(m, 0.7, 1.4), random_below(&m->state, 2));
    make_stiffness(m, &x->torsion, stiffness * in(m, 0.5, 1), random_below(&m->state, 2));
    for (int i = 0; i < 3; i++) {
        bool in_plane = !planar || i != 1;
        x->tip_force[i] = in_plane && random_below(&m->state, 2) ? force * L * in(m, -1, 1) : 0;
    }
    double slender = exp(in(m, log(50), log(5000)));
    for (int i = 0; i < 2; i++) {
        x->shear[i] = shears ? slender * stiffness / (3 * L * L) : INFINITY;
    }
    x->axial = shears ? slender * stiffness / (L * L) : INFINITY;
    x->follower_line = random_below(&m->state, 3) == 0;
    x->follower_tip = random_below(&m->state, 3) == 0;
    /* d3 along x, d2 across the plane */
    const double turned[4] = {sqrt(0.5), 0, sqrt(0.5), 0};
    for (int i = 0; i < 4; i++) {
        x->rotation[i] = planar ? turned[i] : in(m, -1, 1);
    }
}

static void make_beam(maker *m, random_scene *x)
{
    double L = x->length, stiffness = exp(in(m, -2, 2)), force = 1e-3 * stiffness / (L * L * L);
    bool shears = random_below(&m->state, 2) == 0;
    x->scene.rod.model = shears ? SCENE_TIMOSHENKO : SCENE_EULER_BERNOULLI;
    for (int i = 1 + random_below(&m->state, 3); i > 0; i--) {
        add_part(m, &x->force[0], force * L, 1.5, 60);
    }
    if (random_below(&m->state, 3) == 0) {
        add_part(m, &x->moment[0], force * L * L, 0.7, 60);
    }
    make_stiffness(m, &x->bending[0], stiffness, random_below(&m->state, 3));
    x->shear[0] = shears ? stiffness / (L * L) * exp(in(m, log(20), log(2000))) : INFINITY;
    if (random_below(&m->state, 2)) {
        make_stiffness(m, &x->foundation, 20 * stiffness / (L * L * L * L),
                       random_below(&m->state, 2));
    }
    x->tip_force[0] = random_below(&m->state, 2) ? force * L * L * in(m, -1, 1) : 0;
}

static void normalise(double *q)
{
    double size = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4; i++) {
        q[i] /= size;
    }
}

static void fill_rod(random_scene *x)
{
    scene *to = &x->scene;
    normalise(x->rotation);
    profile_fill(3, x->force, to->loads.force, x->names);
    profile_fill(3, x->moment, to->loads.moment, x->names);
    profile_fill(3, x->curvature, to->rod.rest_curvature, x->names);
    profile_fill(2, x->bending, to->rod.bending_stiffness, x->names);
    profile_fill(1, &x->torsion, &to->rod.torsional_stiffness, x->names);
    to->loads.frame = x->follower_line ? SCENE_FOLLOWER : SCENE_DEAD;
    to->loads.tip.frame = x->follower_tip ? SCENE_FOLLOWER : SCENE_DEAD;
    to->end.type = SCENE_LOADED;
    for (int i = 0; i < 4; i++) {
        to->start.rotation[i] = quantity_number(x->rotation[i]);
    }
    for (int i = 0; i < 3; i++) {
        to->loads.tip.force[i] = quantity_number(x->tip_force[i]);
    }
    if (to->rod.model == SCENE_COSSERAT) {
        to->rod.axial_stiffness = quantity_number(x->axial);
        to->rod.shear_stiffness[0] = quantity_number(x->shear[0]);
        to->rod.shear_stiffness[1] = quantity_number(x->shear[1]);
    }
}

static void fill_beam(random_scene *x)
{
    scene *to = &x->scene;
    profile_fill(1, x->force, &to->beam.force, x->names);
    profile_fill(1, x->moment, &to->beam.moment, x->names);
    profile_fill(1, &x->foundation, &to->beam.foundation, x->names);
    profile_fill(1, x->bending, &to->rod.bending_stiffness[0], x->names);
    to->rod.bending_stiffness[1] = to->rod.bending_stiffness[0];
    if (to->rod.model == SCENE_TIMOSHENKO) {
        to->rod.shear_stiffness[0] = to->rod.shear_stiffness[1] = quantity_number(x->shear[0]);
    }
    if (x->tip_force[0] != 0) {
        to->end.type = SCENE_LOADED;
        to->beam.tip.force = quantity_number(x->tip_force[0]);
    }
}

/* ---- edges ----------------------------------------------------------------------------------- */

static void add_edge(random_scene *x, double s)
{
    if (s > 0 && s < x->length && x->edge_count < RANDOM_EDGES_MAX - 2) {
        x->edges[x->edge_count++] = s;
    }
}

static void add_edges(random_scene *x, int count, const profile *profiles)
{
    static const double smooth[] = {-20, -10, -6, -4, -2, -1, 0, 1, 2, 4, 6, 10, 20};
    for (int k = 0; k < count; k++) {
        for (int i = 0; i < profiles[k].count; i++) {
            const profile_part *part = &profiles[k].parts[i];
            bool narrow = part->kind == PROFILE_BUMP || part->kind == PROFILE_ELBOW;
            for (size_t j = 0; narrow && j < sizeof smooth / sizeof *smooth; j++) {
                add_edge(x, part->at + smooth[j] * part->width);
            }
            if (part->kind == PROFILE_TENT) {
                add_edge(x, part->at - part->width);
            }
            if (!narrow && part->kind != PROFILE_CONSTANT) {
                add_edge(x, part->at);
                add_edge(x, part->at + part->width);
            }
        }
    }
}

static int ascending(const void *a, const void *b)
{
    double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

static void gather_edges(random_scene *x)
{
    add_edges(x, 3, x->force);
    add_edges(x, 3, x->moment);
    add_edges(x, 3, x->curvature);
    add_edges(x, 2, x->bending);
    add_edges(x, 1, &x->torsion);
    add_edges(x, 1, &x->foundation);
    x->edges[x->edge_count++] = 0;
    x->edges[x->edge_count++] = x->length;
    qsort(x->edges, (size_t)x->edge_count, sizeof *x->edges, ascending);
}

random_scene *random_scene_create(uint64_t seed, bool is_beam)
{
    random_scene *x = calloc(1, sizeof *x);
    maker m = {.state = seed * 2 + is_beam, .scene = x};
    if (!x || !(x->names = quantities_create())) {
        abort();
    }
    scene_defaults(&x->scene);
    x->length = in(&m, 0.3, 2);
    x->scene.rod.length = quantity_number(x->length);
    if (is_beam) {
        make_beam(&m, x);
        fill_beam(x);
    } else {
        make_rod(&m, x);
        fill_rod(x);
    }
    gather_edges(x);
    return x;
}

void random_scene_free(random_scene *x)
{
    if (x) {
        quantities_free(x->names);
        free(x);
    }
}

static void describe(const char *name, int count, const profile *profiles, FILE *to)
{
    for (int k = 0; k < count; k++) {
        for (int i = 0; i < profiles[k].count; i++) {
            fprintf(to, "%s %s[%d] ", i ? " +" : ";", name, k);
            write_part(&profiles[k].parts[i], to);
        }
    }
}

void random_scene_describe(const random_scene *x, char *text, size_t size)
{
    FILE *to = fmemopen(text, size, "w");
    if (!to) {
        return;
    }
    fprintf(to, "%s of length %.17g%s%s, tip force %g %g %g",
            scene_model_names()[x->scene.rod.model], x->length,
            x->follower_line ? ", line follows" : "", x->follower_tip ? ", tip follows" : "",
            x->tip_force[0], x->tip_force[1], x->tip_force[2]);
    describe("force", 3, x->force, to);
    describe("moment", 3, x->moment, to);
    describe("curvature", 3, x->curvature, to);
    describe("bending", 2, x->bending, to);
    describe("torsion", 1, &x->torsion, to);
    describe("foundation", 1, &x->foundation, to);
    fclose(to);
}
