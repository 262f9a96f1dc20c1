/* Columns of derivatives: of the shape by what changes along the rod, and of force and moment. */
#include "physics/chain/strain_inline.h"
#include "physics/chain/strain_jacobian_internal.h"

/* The mesh is so fine that the integral of R du is that of its steps. */
PROCESSOR_INLINE void place_points(strain_jacobian *x)
{
    strain_form *form = fine_of(x)->form;
    const int n = form->kind.stages;
    finer *fine = &x->fine;
    memcpy(fine->edges[0][0], x->sources.start[1], sizeof fine->edges[0][0]);
    memcpy(fine->edges[0][1], x->sources.start[0], sizeof fine->edges[0][1]);
    for (int e = 0; e < form->kind.elements; e++) {
        lanes(*turning)[3] = (lanes(*)[3])fine->turning + e * n;
        lanes(*slopes)[3] = (lanes(*)[3])fine->slopes + e * n;
        lanes at[GAUSS_STAGES_MAX][3];
        for (int j = 0; j < n; j++) {
            apply(form->at[e * n + j].R, fine->u + 3 * (e * n + j), turning[j]);
        }
        integrate_on(form, e, turning, fine->edges[e][0], at, fine->edges[e + 1][0]);
        for (int j = 0; j < n; j++) {
            strain_node *node = &form->at[e * n + j];
            lanes_vector_cross(at[j], node->slope, slopes[j]);
            add_applied(node->R, fine->v + 3 * (e * n + j), slopes[j]);
        }
        integrate_on(form, e, slopes, fine->edges[e][1], at, fine->edges[e + 1][1]);
    }
}

/* Sums of weights times three of a field [stride] at the points of an element. */
PROCESSOR_INLINE void weigh(int count, const double *weights, double by, const lanes *field,
                            int stride, lanes to[3])
{
    for (int c = 0; c < 3; c++) {
        lanes sum = NO_LANES;
        for (int j = 0; j < count; j++) {
            sum += weights[j] * field[stride * j + c];
        }
        to[c] += by * sum;
    }
}

/* Columns as strain_level_evaluate has them, in SI. */
FOR_EACH_PROCESSOR static void find_columns(strain_jacobian *x, lanes *columns)
{
    const strain_form *form = fine_of(x)->form;
    const int n = form->kind.stages;
    const double length = x->group->rod->scales.length;
    place_points(x);
    for (int k = 0; k < fine_of(x)->outputs; k++) {
        const strain_output *out = &fine_of(x)->output[k];
        const lanes *q = x->group->values + k * SOLVE_MEMBERS_COLUMNS + 3;
        const int e = out->element, first = 3 * e * n;
        lanes *to = columns + k * SOLVE_MEMBERS_COLUMNS, turn[4] = {{0}}, twice[4];
        memset(to, 0, SOLVE_MEMBERS_COLUMNS * sizeof *to);
        memcpy(to, x->fine.edges[e][1], sizeof x->fine.edges[e][1]);
        memcpy(turn + 1, x->fine.edges[e][0], sizeof x->fine.edges[e][0]);
        weigh(n, out->integrate, form->width[e], x->fine.slopes + first, 3, to);
        weigh(n, out->integrate, form->width[e], x->fine.turning + first, 3, turn + 1);
        lanes_quaternion_product(turn, q, twice);
        memcpy(x->turns[k], turn + 1, sizeof x->turns[k]);
        weigh(n, out->interpolate, 1, x->fine.v + first, 3, to + 7);
        weigh(n, out->interpolate, 1 / length, x->fine.u + first, 3, to + 10);
        for (int c = 0; c < 4; c++) {
            to[3 + c] = 0.5 * twice[c];
        }
        for (int c = 0; c < 3; c++) {
            to[c] *= length;
        }
    }
}

/* x->carried and x->twisted at the outputs, in the world, in SI. N and M are smooth there, as n and
 * m are not where the rod winds. */
FOR_EACH_PROCESSOR static void find_forces(strain_jacobian *x, lanes *forces)
{
    const strain_form *form = fine_of(x)->form;
    const int n = form->kind.stages;
    const rod_scales *scales = &x->group->rod->scales;
    const int twists = (int)x->carrying - SOLVE_MEMBERS_FORCES;
    strain_level_sample(&x->group->beyond, level_of(x), fine_of(x), twists, x->twisted,
                        x->fine.twisted);
    strain_level_sample(&x->group->beyond, level_of(x), fine_of(x), 6, x->carried[0],
                        x->fine.carried);
    for (int k = 0; k < fine_of(x)->outputs; k++) {
        const strain_output *out = &fine_of(x)->output[k];
        const lanes *from = x->fine.carried + 6 * out->element * n;
        const lanes *twisted = x->fine.twisted + twists * out->element * n;
        lanes *to = forces + (size_t)k * x->carrying;
        memset(to, 0, x->carrying * sizeof *to);
        weigh(n, out->interpolate, scales->force, from, 6, to);
        weigh(n, out->interpolate, scales->moment, from + 3, 6, to + 3);
        for (int i = 0; i < twists * n; i++) { /* theta, m */
            to[SOLVE_MEMBERS_FORCES + i % twists] +=
                out->interpolate[i / twists] * (i % 2 ? scales->moment : 1) * twisted[i];
        }
    }
}

/* Force and moment [outputs] in the world become those in the body; or what they change by
 * there, where sections have x->turns: dn = R^T (dN - turn x N). */
FOR_EACH_PROCESSOR static void turn_forces(strain_jacobian *x, bool changes, lanes *forces)
{
    for (int i = 0; i < 2 * fine_of(x)->outputs; i++) {
        const lanes *q = x->group->values + i / 2 * SOLVE_MEMBERS_COLUMNS + 3;
        const size_t at = (size_t)(i / 2) * x->carrying + (size_t)(3 * (i % 2));
        lanes R[3][3], world[3], turned[3];
        memcpy(world, forces + at, sizeof world);
        lanes_vector_cross(x->turns[i / 2], x->forces + at, turned);
        for (int c = 0; c < 3 && changes; c++) {
            world[c] -= turned[c];
        }
        lanes_rotation_matrix(q, R);
        lanes_to_body(R, world, forces + at);
    }
}

/* Strains are by metres as they are written, which change; and of lanes without an equilibrium
 * nothing is a number. */
static void correct_columns(const strain_jacobian *x, const int *which, lanes *columns)
{
    const int outputs = fine_of(x)->outputs, count = x->group->count;
    const bool grows = solve_rod_part_kind(x->changes, SOLVE_GROWTH).width > 0;
    for (int lane = 0; lane < LANES; lane++) {
        const bool is_good = isfinite(x->sought[0][lane]);
        for (size_t i = 0; i < (size_t)outputs * x->derived && !is_good; i++) {
            columns[i][lane] = NAN;
        }
        for (int i = 0; i < outputs * SOLVE_MEMBERS_COLUMNS && grows && is_good; i++) {
            const int at = lane * outputs + i / SOLVE_MEMBERS_COLUMNS;
            if (i % SOLVE_MEMBERS_COLUMNS >= 7) {
                columns[i][lane] -= x->group->values[i][lane] * x->growth[at * count + which[lane]];
                columns[i][lane] /= x->group->growth[at];
            }
        }
    }
}

/* `width` numbers of columns: row by row, as memory is written. */
static void put_columns(const strain_jacobian *x, const lanes *first, size_t width, size_t members,
                        size_t copies, size_t count, double *jacobian)
{
    for (size_t i = 0; i < width && jacobian; i++) {
        const lanes *from = first + i;
        for (size_t k = 0; k < count; from += (size_t)fine_of(x)->outputs * x->derived) {
            for (size_t lane = 0; lane < copies * members && k < count; k++) {
                for (size_t member = 0; member < members; member++, lane++) {
                    jacobian[(member * width + i) * count + k] = (*from)[lane];
                }
            }
        }
    }
}

/* Of lanes without an equilibrium they are not numbers, as curvature is not. */
void strain_columns_put_forces(strain_jacobian *x, size_t members, double *forces)
{
    const size_t width = (size_t)fine_of(x)->outputs * x->carrying;
    lanes *body = x->forces + width;
    memcpy(body, x->forces, width * sizeof *body);
    turn_forces(x, false, body);
    for (size_t member = 0; member < members; member++) {
        const bool is_good = isfinite(level_of(x)->form->at[0].u[0][member]);
        for (size_t i = 0; i < width; i++) {
            forces[member * width + i] = is_good ? body[i][member] : NAN;
        }
    }
}

void strain_columns_carry(strain_jacobian *x)
{
    const strain_form *form = level_of(x)->form;
    for (int i = 0; i < form->nodes; i++) {
        memcpy(x->carried[i], form->at[i].N, sizeof form->at[i].N);
        memcpy(x->carried[i] + 3, form->at[i].M, sizeof form->at[i].M);
    }
    for (int i = 0; i < form->nodes * form->kind.tubes; i++) {
        const strain_tube *of = &form->tubes[i % form->kind.tubes];
        x->twisted[2 * i] = of->theta[i / form->kind.tubes];
        x->twisted[2 * i + 1] = of->torsion[i / form->kind.tubes];
    }
    find_forces(x, x->forces);
}

void strain_columns_find(strain_jacobian *x, bool carries, const int *which, lanes *columns)
{
    find_columns(x, columns);
    if (carries) {
        lanes *forces = columns + (size_t)fine_of(x)->outputs * SOLVE_MEMBERS_COLUMNS;
        find_forces(x, forces);
        turn_forces(x, true, forces);
    }
    correct_columns(x, which, columns);
}

void strain_columns_put(const strain_jacobian *x, size_t members, size_t copies, size_t count,
                        const strain_derived *to)
{
    const size_t outputs = (size_t)fine_of(x)->outputs, shape = outputs * SOLVE_MEMBERS_COLUMNS;
    put_columns(x, x->columns, shape, members, copies, count, to->jacobian);
    put_columns(x, x->columns + shape, outputs * x->carrying, members, copies, count, to->by);
}
