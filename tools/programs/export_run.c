/* Families in the strain form: what is asked of the C, and what its self-test knows. */
#include "tools/programs/export.h"

#include "physics/solve/strain_jacobian.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Members of the self-test are the first of those by which the mesh is judged. */
enum { PLACES = 21, PLACES_MAX = 200, MEMBERS = 12 };

/* Places of the shape over the length. */
static ad_status list_places(export_family *f, const char *text, double *s, ad_error *error)
{
    const double length = scene_length(f->open);
    double before = 0;
    f->s = s;
    for (f->places = 0; !text && f->places < PLACES; f->places++) {
        s[f->places] = (double)f->places / (PLACES - 1);
    }
    while (text && *text) {
        char *end;
        const double at = strtod(text, &end) / length;
        if (end == text || (*end && *end != ',') || !(at >= before && at <= 1 + 1e-9) ||
            f->places == PLACES_MAX) {
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "--places: '%.20s'; allowed: up to %d ascending arc lengths from 0 to "
                           "%g, separated by commas",
                           text, PLACES_MAX, length);
        }
        s[f->places++] = before = fmin(at, 1);
        text = end + (*end == ',');
    }
    if (s[f->places - 1] < 1 - 1e-9) {
        return ad_fail(error, AD_BAD_ARGUMENT, "--places: the last is not the tip, %g", length);
    }
    return AD_OK;
}

/* Numbers of the self-test. */
typedef struct numbers {
    double *s, *parameters, *said, *polished, *tips, *jacobian, *values, *curvature;
} numbers;

static bool allocate(export_model *x, numbers *n)
{
    const size_t count = (size_t)x->family.open->parameter_count;
    const size_t rows = 3 * solve_members_nodes(targets_solver(x->e->targets));
    const size_t shape = (size_t)TARGETS_POINTS * SOLVE_MEMBERS_COLUMNS;
    const size_t member = rows + STRAIN_COLUMNS * (1 + count) + shape;
    x->family_numbers =
        calloc(PLACES_MAX + EXPORT_JUDGED * (count + rows) + MEMBERS * (rows + member),
               sizeof *x->family_numbers);
    n->s = x->family_numbers;
    n->parameters = n->s ? n->s + PLACES_MAX : NULL;
    n->said = n->s ? n->parameters + EXPORT_JUDGED * count : NULL;
    n->polished = n->s ? n->said + EXPORT_JUDGED * rows : NULL;
    n->tips = n->s ? n->polished + MEMBERS * rows : NULL;
    n->jacobian = n->s ? n->tips + MEMBERS * STRAIN_COLUMNS : NULL;
    n->curvature = n->s ? n->jacobian + (size_t)MEMBERS * STRAIN_COLUMNS * count : NULL;
    n->values = n->s ? n->curvature + MEMBERS * rows : NULL;
    return n->s != NULL;
}

/* Which columns `names` lists, as evaluator_create takes them; NULL: all. */
static ad_status list_columns(export_family *f, const char *names, ad_error *error)
{
    const model_column *known = scene_physics_of(f->open)->columns;
    const char *at = names ? names : "r q v1 v2 v3 u1 u2 u3 n1 n2 n3 m1 m2 m3";
    for (at += strspn(at, " ,"); *at; at += strspn(at, " ,")) {
        const size_t length = strcspn(at, " ,");
        int first = *at == 'q' ? 3 : 0, count = *at == 'q' ? 4 : 3;
        if (length != 1 || (*at != 'r' && *at != 'q')) {
            count = 1;
            for (first = 0; first < STRAIN_COLUMNS; first++) {
                if (strncmp(known[first].name, at, length) == 0 && !known[first].name[length]) {
                    break;
                }
            }
        }
        if (first == STRAIN_COLUMNS) {
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "--columns: %.*s is no column of a family in the strain form; allowed: "
                           "r, q, and x to z, qw to qz, v1 to v3, u1 to u3, n1 to n3, m1 to m3",
                           (int)(length < 40 ? length : 40), at);
        }
        for (int c = first; c < first + count; c++) {
            for (int i = 0; i < f->columns; i++) {
                if (f->which[i] == c) {
                    return ad_fail(error, AD_BAD_ARGUMENT, "--columns: %s is there twice",
                                   known[c].name);
                }
            }
            f->which[f->columns++] = c;
        }
        at += length;
    }
    return f->columns > 0 ? AD_OK
                          : ad_fail(error, AD_BAD_ARGUMENT, "--columns: no column is asked for");
}

/* Tips of the polished members by the tape, on which positions agree with the solver's, whose steps
 * along the rod are others; of a member that is not trusted it may be bent beyond what these
 * resolve. */
static ad_status find_tips(export_model *x, const numbers *n, const solve_answer *answers,
                           ad_error *error)
{
    enum { POSITION = 3 };
    export_family *f = &x->family;
    const int nodes = strain_mesh_nodes(&f->mesh), count = f->open->parameter_count;
    const int all[STRAIN_COLUMNS] = {0,  1,  2,  3,  4,  5,  6,  7,  8, 9,
                                     10, 11, 12, 13, 14, 15, 16, 17, 18};
    const double end = 1;
    double places[STRAIN_ELEMENTS_MAX * STRAIN_STAGES_MAX], tips[MEMBERS * STRAIN_COLUMNS];
    double *jacobian = malloc((size_t)MEMBERS * STRAIN_COLUMNS * (size_t)count * sizeof *jacobian);
    strain_jacobian *by = NULL;
    strain_mesh_places(&f->mesh, places);
    ad_status status = jacobian
                           ? strain_jacobian_create(f->open, (size_t)nodes, places, 1, &end,
                                                    STRAIN_COLUMNS, all, x->e->pool, &by, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for a self-test");
    if (status == AD_OK) {
        status =
            strain_jacobian_run(by, MEMBERS, n->parameters, n->polished, tips, jacobian, error);
    }
    for (int i = 0; i < MEMBERS && status == AD_OK; i++) {
        const double *solved =
            n->values + ((size_t)i * TARGETS_POINTS + TARGETS_POINTS - 1) * SOLVE_MEMBERS_COLUMNS;
        for (int k = 0; k < POSITION && status == AD_OK && answers[i].trusted; k++) {
            if (!(fabs(tips[i * STRAIN_COLUMNS + k] - solved[k]) <= 1e-5 * scene_length(f->open))) {
                status = ad_fail(error, AD_BAD_PROGRAM, "the tip of member %d is at %.9g, not %.9g",
                                 i, tips[i * STRAIN_COLUMNS + k], solved[k]);
            }
        }
        for (int c = 0; c < f->columns; c++) {
            const size_t from = (size_t)i * STRAIN_COLUMNS + (size_t)f->which[c];
            const size_t to = (size_t)i * (size_t)f->columns + (size_t)c;
            n->tips[to] = tips[from];
            memcpy(n->jacobian + to * (size_t)count, jacobian + from * (size_t)count,
                   (size_t)count * sizeof *jacobian);
        }
    }
    strain_jacobian_free(by);
    free(jacobian);
    return status;
}

/* By the largest of all tips that has the unit, or what the rod has by itself. */
static void set_scales(export_family *f, const double *tips)
{
    const model_column *known = scene_physics_of(f->open)->columns;
    for (int c = 0; c < f->columns; c++) {
        const char *unit = known[f->which[c]].unit;
        f->scale[c] = export_natural_scale(f->open, unit);
        for (int i = 0; i < MEMBERS * f->columns; i++) {
            if (strcmp(known[f->which[i % f->columns]].unit, unit) == 0) {
                f->scale[c] = fmax(f->scale[c], fabs(tips[i]));
            }
        }
    }
}

ad_status export_open_family(export_model *x, const char *columns, const char *places,
                             ad_error *error)
{
    solve_members *solver = targets_solver(x->e->targets);
    solve_answer answers[MEMBERS];
    export_family *f = &x->family;
    numbers n;
    *f = (export_family){.name = x->name,
                         .open = x->e->scene,
                         .single = x->single,
                         .tip = true,
                         .members = MEMBERS,
                         .values = x->measured.values,
                         .derivatives = x->measured.jacobian};
    ad_status status = list_columns(f, columns, error);
    if (status == AD_OK && !allocate(x, &n)) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a self-test");
    }
    status = status == AD_OK ? list_places(f, places, n.s, error) : status;
    status = status == AD_OK ? export_family_of(x->e, f, n.parameters, n.said, error) : status;
    f->steps = strain_held(f->open) + strain_angles(f->open) > 0         ? 3
               : strain_forces(f->open, strain_mesh_nodes(&f->mesh)) > 0 ? 2
                                                                         : 1;
    if (status == AD_OK) {
        status = solve_members_refine(solver, MEMBERS, n.parameters, n.said, f->steps, n.values,
                                      n.polished, answers, error);
    }
    status = status == AD_OK ? find_tips(x, &n, answers, error) : status;
    if (status != AD_OK) {
        return status;
    }
    for (int i = 0; i < 3 * strain_mesh_nodes(&f->mesh) * MEMBERS; i++) {
        n.curvature[i] = n.said[i] * scene_length(f->open);
        n.polished[i] *= scene_length(f->open);
    }
    set_scales(f, n.tips);
    f->parameters = n.parameters;
    f->curvature = n.curvature;
    f->polished = n.polished;
    f->tips = n.tips;
    f->jacobian = n.jacobian;
    x->outputs = 1 + f->columns; /* lines of the self-test */
    return AD_OK;
}
