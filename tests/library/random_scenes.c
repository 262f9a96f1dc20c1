#include "random_scenes.h"

#include "random_numbers.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- making ---------------------------------------------------------------------------------- */

typedef struct maker {
    uint64_t state;
    random_scene *scene;
} maker;

static double in(maker *m, double low, double high)
{
    return random_in(&m->state, low, high);
}

static bool one_of(maker *m, int count)
{
    return random_below(&m->state, count) == 0;
}

/* An axis of a force, or of a moment; planar rods lie along x and z, and turn about y. */
static int force_axis(maker *m)
{
    return m->scene->is_planar ? 2 * random_below(&m->state, 2) : random_below(&m->state, 3);
}

static int moment_axis(maker *m)
{
    return m->scene->is_planar ? 1 : random_below(&m->state, 3);
}

static void random_force(maker *m, double size, double *to)
{
    for (int i = 0; i < 3; i++) {
        to[i] = m->scene->is_planar && i == 1 ? 0 : in(m, -size, size);
    }
}

static void random_moment(maker *m, double size, double *to)
{
    for (int i = 0; i < 3; i++) {
        to[i] = m->scene->is_planar && i != 1 ? 0 : in(m, -size, size);
    }
}

static void make_table(maker *m, profile_part *part)
{
    for (int i = 0; i < PROFILE_ROWS; i++) {
        double x =
            (i + (i > 0 && i < PROFILE_ROWS - 1 ? in(m, -0.4, 0.4) : 0)) / (PROFILE_ROWS - 1);
        part->knots[i] = i == PROFILE_ROWS - 1 ? m->scene->length : m->scene->length * x;
        part->rows[i] = in(m, 0, 1);
    }
}

/* A part whose integral over the rod is at most so much, and its value no more than the other. */
static void add_part(maker *m, profile *to, double unit, double integral, double most)
{
    static const double least[PROFILE_KINDS] = {1, 5e-4, 1, 1e-3, 1e-3, 2e-3, 1};
    static const double widest[PROFILE_KINDS] = {1, 0.2, 1, 0.05, 0.05, 0.1, 1};
    double length = m->scene->length;
    profile_kind kind = (profile_kind)random_below(&m->state, PROFILE_KINDS);
    double width = exp(in(m, log(least[kind]), log(widest[kind])));
    double size = fmin(most, integral / width);
    if (to->count == PROFILE_PARTS_MAX) {
        return;
    }
    profile_part *part = &to->parts[to->count++];
    *part = (profile_part){.kind = kind,
                           .at = length * in(m, kind == PROFILE_TENT ? 0.12 : 0.02,
                                             kind == PROFILE_BAND ? 0.78 : 0.88),
                           .width = length * width,
                           .value = unit * in(m, -size, size),
                           .spelling = random_below(&m->state, 4)};
    if (kind == PROFILE_TABLE) {
        make_table(m, part);
    }
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

/* Ends of the pieces; the last is that of the rod, which is the sum as the scene adds it up. */
static void make_pieces(maker *m)
{
    random_scene *x = m->scene;
    double sum = 0, length = in(m, 0.3, 2);
    x->piece_count = one_of(m, 3) ? 1 + random_below(&m->state, RANDOM_PIECES_MAX) : 1;
    for (int i = 0; i < x->piece_count; i++) {
        double piece = length / x->piece_count * in(m, 0.4, 1.6);
        x->pieces[i].to = sum += piece;
        if (x->piece_count > 1) {
            x->scene.segments[i].length = quantity_number(piece);
        }
    }
    x->scene.segment_count = x->piece_count > 1 ? x->piece_count : 0;
    x->length = sum;
    if (x->piece_count == 1) {
        x->scene.rod.length = quantity_number(sum);
    }
}

/* A place strictly within the rod, sometimes a joint. */
static double place_within(maker *m)
{
    const random_scene *x = m->scene;
    return x->piece_count > 1 && one_of(m, 4) ? x->pieces[0].to : x->length * in(m, 0.05, 0.95);
}

static random_load *add_load(maker *m, int kind, double at)
{
    random_load *load = &m->scene->loads[m->scene->load_count++];
    *load = (random_load){.kind = kind, .at = at};
    return load;
}

static void make_springs(maker *m, double stiffness, double turning)
{
    random_scene *x = m->scene;
    x->spring_count = one_of(m, 4) ? 1 + random_below(&m->state, RANDOM_SPRINGS_MAX) : 0;
    for (int i = 0; i < x->spring_count; i++) {
        random_spring *spring = &x->springs[i];
        spring->at = one_of(m, 3) ? x->length : place_within(m);
        for (int k = 0; k < 3; k++) {
            bool bends = !x->is_beam || k == 1;
            spring->stiffness[k] = bends ? stiffness * in(m, 0, 5) : 0;
            bool turns = x->is_beam ? k == 0 : x->ends[0].holds_rotation;
            spring->turning[k] = turns && i == 0 ? turning * in(m, 0, 2) : 0;
        }
        spring->is_anchored = !x->is_beam && !x->ends[0].holds_rotation;
    }
}

/* ---- rods ------------------------------------------------------------------------------------ */

/* How a rod is held; those that are held twice have moderate loads, so that they seldom buckle. */
static void make_ends(maker *m, random_scene *x)
{
    static const bool holds[][4] = {/* position and rotation of s = 0, of s = length */
                                    {true, true, true, true},
                                    {true, true, true, false},
                                    {true, false, true, true},
                                    {false, false, true, true}};
    const bool *chosen = holds[random_below(&m->state, 4)];
    bool cantilever = !one_of(m, 3);
    for (int i = 0; i < 2; i++) {
        x->ends[i].holds_position = cantilever ? i == 0 : chosen[2 * i];
        x->ends[i].holds_rotation = cantilever ? i == 0 : chosen[2 * i + 1];
    }
    if (x->is_planar) { /* d3 along x, d2 across the plane */
        x->ends[0].rotation[0] = x->ends[0].rotation[2] = sqrt(0.5);
        return;
    }
    double square = 0, *q = x->ends[0].rotation;
    for (int i = 0; i < 4; i++) {
        q[i] = in(m, -1, 1);
        square += q[i] * q[i];
    }
    for (int i = 0; i < 4; i++) {
        q[i] /= sqrt(square);
    }
}

static void make_matter(maker *m, random_scene *x)
{
    static const scene_model models[] = {SCENE_COSSERAT, SCENE_COSSERAT, SCENE_KIRCHHOFF,
                                         SCENE_KIRCHHOFF, SCENE_INEXTENSIBLE};
    scene_model model = x->scene.rod.model = models[random_below(&m->state, 5)];
    double slender = exp(in(m, log(50), log(5000))), L = x->length;
    double torsion = in(m, 0.5, 1), second = in(m, 0.7, 1.4);
    for (int i = 0; i < x->piece_count; i++) {
        random_piece *piece = &x->pieces[i];
        double unit = x->stiffness * (i > 0 ? exp(in(m, -1, 1)) : 1);
        for (int k = one_of(m, 2) ? random_below(&m->state, 3) : 0; k > 0; k--) {
            add_part(m, &piece->curvature[moment_axis(m)], 1 / L, 1.6, 200); /* up to 90 degrees */
        }
        make_stiffness(m, &piece->bending[0], unit, random_below(&m->state, 2));
        make_stiffness(m, &piece->bending[1], unit * second, random_below(&m->state, 2));
        make_stiffness(m, &piece->torsion, unit * torsion, random_below(&m->state, 2));
        if (i > 0 && one_of(m, 2)) {
            random_moment(m, 1.2, piece->turn);
        }
    }
    for (int i = 0; i < 2; i++) {
        x->shear[i] = model == SCENE_KIRCHHOFF ? INFINITY : slender * x->stiffness / (3 * L * L);
    }
    x->axial = model == SCENE_COSSERAT ? slender * x->stiffness / (L * L) : INFINITY;
    if (one_of(m, 5)) {
        add_constant(&x->stretch, 1);
        add_part(m, &x->stretch, 1, 0.1, 0.5);
    }
}

static bool has_line_load(const random_scene *x)
{
    bool any = false;
    for (int i = 0; i < 3; i++) {
        any = any || x->force[i].count > 0 || x->moment[i].count > 0;
    }
    return any;
}

static void make_loads(maker *m, random_scene *x, double force)
{
    double L = x->length;
    for (int i = random_below(&m->state, 4); i > 0; i--) {
        add_part(m, &x->force[force_axis(m)], force / L, 1.5, 60);
    }
    if (one_of(m, 3)) {
        add_part(m, &x->moment[moment_axis(m)], force, 0.7, 60);
    }
    x->follows = one_of(m, 3) && has_line_load(x);
    for (int i = one_of(m, 2) ? 1 + random_below(&m->state, 3) : 0; i > 0; i--) {
        random_load *point = add_load(m, RANDOM_POINT, place_within(m));
        point->follows = one_of(m, 3);
        random_force(m, force, point->force);
        if (one_of(m, 2)) {
            random_moment(m, force * L, point->moment);
        }
    }
    for (int i = 0; i < 2; i++) {
        if (!x->ends[i].holds_position && (i == 0 || !one_of(m, 3))) {
            random_load *load = add_load(m, i ? RANDOM_TIP : RANDOM_BASE, i * L);
            load->follows = i == 1 && one_of(m, 3);
            random_force(m, force, load->force);
            if (one_of(m, 3)) {
                random_moment(m, force * L / 2, load->moment);
            }
        }
    }
    if (one_of(m, 4)) {
        random_force(m, 9.81, x->gravity);
        x->mass = force / L / 9.81 * in(m, 0.1, 1);
        for (int i = random_below(&m->state, 3); i > 0; i--) {
            random_load *body = add_load(m, RANDOM_BODY, one_of(m, 2) ? L : place_within(m));
            body->mass = force / 9.81 * in(m, 0.1, 0.5);
            for (int k = 0; k < 3; k++) {
                body->force[k] = body->mass * x->gravity[k];
            }
        }
    }
}

/* No less than the largest curvature of the unstressed rod. */
static double most_curved(const random_scene *x)
{
    double sum = 0;
    for (int i = 0; i < x->piece_count; i++) {
        for (int k = 0; k < 3; k++) {
            const profile *curvature = &x->pieces[i].curvature[k];
            for (int j = 0; j < curvature->count; j++) {
                sum += fabs(curvature->parts[j].value);
            }
        }
    }
    return sum;
}

/* Closer to the axis than the centre of any bend, where a tendon would shrink to nothing. */
static void make_pulls(maker *m, random_scene *x)
{
    double L = x->length, nearest = fmin(L, 0.5 / most_curved(x));
    x->pull_count = one_of(m, 4) ? 1 + random_below(&m->state, RANDOM_PULLS_MAX) : 0;
    for (int i = 0; i < x->pull_count; i++) {
        random_pull *pull = &x->pulls[i];
        pull->is_chamber = one_of(m, 3);
        pull->radius = fmin(L * in(m, 0.02, 0.08), nearest);
        pull->phase = x->is_planar ? 0 : in(m, -3, 3);
        pull->winding = !x->is_planar && !pull->is_chamber && one_of(m, 2) ? in(m, -6, 6) / L : 0;
        pull->from = one_of(m, 3) ? L * in(m, 0.05, 0.4) : 0;
        pull->to = one_of(m, 2) ? L * in(m, 0.5, 0.95) : L;
        pull->tension = fmin(x->stiffness / L / pull->radius, 0.1 * x->axial) * in(m, 0.1, 1);
        pull->area = 0.01 * L * L;
        pull->taper = pull->is_chamber && one_of(m, 2) ? in(m, -0.5, 0.5) : 0;
    }
}

/* A held end is where some force and moment at s = 0 bring it, so that there is an equilibrium. */
static void place_end(maker *m, random_scene *x, double force)
{
    double y[RANDOM_ROWS] = {0};
    memcpy(y + 3, x->ends[0].rotation, 4 * sizeof *y);
    if (x->ends[0].holds_position) {
        random_force(m, force, y + 7);
    }
    if (x->ends[0].holds_rotation) {
        random_moment(m, force * x->length / 2, y + 10);
    }
    random_scene_carry(x, false, x->length, y);
    memcpy(x->ends[1].position, y, sizeof x->ends[1].position);
    memcpy(x->ends[1].rotation, y + 3, sizeof x->ends[1].rotation);
}

static void place_springs(maker *m, random_scene *x)
{
    for (int i = 0; i < x->spring_count; i++) {
        random_spring *spring = &x->springs[i];
        double y[RANDOM_ROWS] = {0};
        memcpy(y + 3, x->ends[0].rotation, 4 * sizeof *y);
        random_scene_carry(x, true, spring->at, y);
        spring->is_anchored = spring->is_anchored || one_of(m, 3);
        memcpy(spring->upright, y + 3, sizeof spring->upright);
        memcpy(spring->anchor, y, sizeof spring->anchor);
        double way[3];
        random_force(m, 0.1 * x->length, way);
        for (int k = 0; k < 3 && spring->is_anchored; k++) {
            spring->anchor[k] += way[k];
        }
    }
}

/* ---- beams ----------------------------------------------------------------------------------- */

static void make_beam(maker *m, random_scene *x)
{
    static const bool holds[][4] = {{true, true, false, false}, {true, true, true, true},
                                    {true, true, true, false},  {true, false, true, false},
                                    {true, false, true, true},  {false, false, true, true}};
    const bool *held = holds[one_of(m, 2) ? 0 : random_below(&m->state, 6)];
    double L = x->length, force = 1e-3 * x->stiffness / (L * L);
    bool shears = one_of(m, 2);
    x->scene.rod.model = shears ? SCENE_TIMOSHENKO : SCENE_EULER_BERNOULLI;
    for (int i = 0; i < 2; i++) {
        x->ends[i].holds_position = held[2 * i];
        x->ends[i].holds_rotation = held[2 * i + 1];
    }
    for (int i = 1 + random_below(&m->state, 3); i > 0; i--) {
        add_part(m, &x->force[0], force / L, 1.5, 60);
    }
    if (one_of(m, 3)) {
        add_part(m, &x->moment[0], force, 0.7, 60);
    }
    for (int i = 0; i < x->piece_count; i++) {
        double unit = x->stiffness * (i > 0 ? exp(in(m, -1, 1)) : 1);
        make_stiffness(m, &x->pieces[i].bending[0], unit, random_below(&m->state, 3));
    }
    x->shear[0] = shears ? x->stiffness / (L * L) * exp(in(m, log(20), log(2000))) : INFINITY;
    if (one_of(m, 3)) {
        make_stiffness(m, &x->foundation, 20 * x->stiffness / (L * L * L * L),
                       random_below(&m->state, 2));
    }
    for (int i = one_of(m, 2) ? 1 + random_below(&m->state, 3) : 0; i > 0; i--) {
        random_load *point = add_load(m, RANDOM_POINT, place_within(m));
        point->force[0] = force * in(m, -1, 1);
        point->moment[0] = one_of(m, 2) ? force * L * in(m, -1, 1) : 0;
    }
    for (int i = 0; i < 2; i++) {
        if (!x->ends[i].holds_position && one_of(m, 2)) {
            add_load(m, i ? RANDOM_TIP : RANDOM_BASE, i * L)->force[0] = force * in(m, -1, 1);
        }
    }
    make_springs(m, x->stiffness / (L * L * L), x->stiffness / L);
}

/* ---- edges ----------------------------------------------------------------------------------- */

static void add_edge(random_scene *x, double s)
{
    if (s > 0 && s < x->length && x->edge_count < RANDOM_EDGES_MAX - 2) {
        x->edges[x->edge_count++] = s;
    }
}

static void add_edges(random_scene *x, int count, const profile *from)
{
    static const double smooth[] = {-20, -10, -6, -4, -2, -1, 0, 1, 2, 4, 6, 10, 20};
    for (int k = 0; k < count; k++) {
        for (int i = 0; i < from[k].count; i++) {
            const profile_part *part = &from[k].parts[i];
            bool narrow = part->kind == PROFILE_BUMP || part->kind == PROFILE_ELBOW;
            for (size_t j = 0; narrow && j < sizeof smooth / sizeof *smooth; j++) {
                add_edge(x, part->at + smooth[j] * part->width);
            }
            for (int j = 0; j < PROFILE_ROWS && part->kind == PROFILE_TABLE; j++) {
                add_edge(x, part->knots[j]);
            }
            if (part->kind == PROFILE_TENT) {
                add_edge(x, part->at - part->width);
            }
            if (!narrow && part->kind != PROFILE_CONSTANT && part->kind != PROFILE_TABLE) {
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
    add_edges(x, 1, &x->stretch);
    add_edges(x, 1, &x->foundation);
    for (int i = 0; i < x->piece_count; i++) {
        add_edges(x, 2, x->pieces[i].bending);
        add_edges(x, 1, &x->pieces[i].torsion);
        add_edges(x, 3, x->pieces[i].curvature);
        add_edge(x, x->pieces[i].to);
    }
    for (int i = 0; i < x->load_count; i++) {
        add_edge(x, x->loads[i].at);
    }
    for (int i = 0; i < x->spring_count; i++) {
        add_edge(x, x->springs[i].at);
    }
    for (int i = 0; i < x->pull_count; i++) {
        add_edge(x, x->pulls[i].from);
        add_edge(x, x->pulls[i].to);
    }
    x->edges[x->edge_count++] = 0;
    x->edges[x->edge_count++] = x->length;
    qsort(x->edges, (size_t)x->edge_count, sizeof *x->edges, ascending);
    int count = 1;
    for (int i = 1; i < x->edge_count; i++) {
        if (x->edges[i] > x->edges[count - 1]) {
            x->edges[count++] = x->edges[i];
        }
    }
    x->edge_count = count;
}

static void make_rod(maker *m, random_scene *x)
{
    double L = x->length, force = x->stiffness / (L * L);
    x->is_planar = one_of(m, 3);
    make_ends(m, x);
    make_matter(m, x);
    make_loads(m, x, force * (x->ends[1].holds_position ? 0.7 : 1));
    make_pulls(m, x);
    make_springs(m, force / L, x->stiffness / L);
    gather_edges(x);
    place_springs(m, x);
    if (x->ends[1].holds_position) {
        place_end(m, x, force);
    }
}

random_scene *random_scene_create(uint64_t seed, bool is_beam)
{
    random_scene *x = calloc(1, sizeof *x);
    maker m = {.state = seed * 2 + is_beam, .scene = x};
    if (!x || !(x->names = quantities_create())) {
        abort();
    }
    scene_defaults(&x->scene);
    x->scene.names = x->names;
    x->is_beam = is_beam;
    make_pieces(&m);
    x->stiffness = exp(in(&m, -2, 2));
    if (is_beam) {
        make_beam(&m, x);
        gather_edges(x);
    } else {
        make_rod(&m, x);
    }
    random_scene_fill(x);
    return x;
}

void random_scene_free(random_scene *x)
{
    if (x) {
        quantities_free(x->names);
        free(x);
    }
}
