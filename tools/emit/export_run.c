/* Families in the strain form: what the self-test of their C knows. */
#include "tools/emit/export_model.h"

#include "tools/emit/export_shapes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Members of the self-test are the first of those by which the mesh is judged. */
enum { PLACES = 21, MEMBERS = 12 };

/* Numbers of the self-test. */
typedef struct numbers {
    double *s, *parameters, *said, *polished, *shapes, *values, *curvature;
} numbers;

static bool allocate(export_model *model, numbers *n)
{
    const size_t count = (size_t)model->family.open->parameter_count;
    const size_t rows = solve_members_numbers(targets_solver(model->e->targets));
    const size_t shape = (size_t)TARGETS_POINTS * SOLVE_MEMBERS_COLUMNS;
    const size_t member = rows + (size_t)EXPORT_COMPARED * STRAIN_COLUMNS_MAX + shape;
    model->family_numbers =
        calloc(EXPORT_PLACES_MAX + EXPORT_JUDGED * (count + rows) + MEMBERS * (rows + member),
               sizeof *model->family_numbers);
    n->s = model->family_numbers;
    n->parameters = n->s ? n->s + EXPORT_PLACES_MAX : NULL;
    n->said = n->s ? n->parameters + EXPORT_JUDGED * count : NULL;
    n->polished = n->s ? n->said + EXPORT_JUDGED * rows : NULL;
    n->shapes = n->s ? n->polished + MEMBERS * rows : NULL;
    n->curvature = n->s ? n->shapes + MEMBERS * EXPORT_COMPARED * STRAIN_COLUMNS_MAX : NULL;
    n->values = n->s ? n->curvature + MEMBERS * rows : NULL;
    return n->s != NULL;
}

/* Columns of the polished members by the tape, at the tip and before it; on the tip positions agree
 * with the solver's, whose steps along the rod are others; of a member that is not trusted it may
 * be bent beyond what these resolve. */
static ad_status find_shapes(export_model *model, const numbers *n, const solve_answer *answers,
                             ad_error *error)
{
    enum { POSITION = 3 };
    export_family *f = &model->family;
    int which[EXPORT_COMPARED];
    const int compared = export_family_compared(f, which), rows = MEMBERS * compared;
    const int columns = strain_columns(f->open);
    double s[EXPORT_COMPARED];
    double shapes[MEMBERS * EXPORT_COMPARED * STRAIN_COLUMNS_MAX];
    for (int i = 0; i < compared; i++) {
        s[i] = f->s[which[i]];
    }
    const export_shapes asked = {f->open,        &f->mesh, (size_t)compared, s,
                                 model->e->pool, MEMBERS,  n->parameters,    n->polished};
    ad_status status = export_shapes_find(&asked, shapes, error);
    for (int i = 0; i < MEMBERS && status == AD_OK; i++) {
        const double *solved =
            n->values + ((size_t)i * TARGETS_POINTS + TARGETS_POINTS - 1) * SOLVE_MEMBERS_COLUMNS;
        const double *tip = shapes + ((i + 1) * compared - 1) * columns;
        for (int k = 0; k < POSITION && status == AD_OK && answers[i].trusted; k++) {
            if (!(fabs(tip[k] - solved[k]) <= 1e-5 * scene_length(f->open))) {
                status = ad_fail(error, AD_BAD_PROGRAM, "the tip of member %d is at %.9g, not %.9g",
                                 i, tip[k], solved[k]);
            }
        }
    }
    for (int to = 0; to < rows * f->columns && status == AD_OK; to++) {
        const int from = to / f->columns * columns + f->which[to % f->columns];
        n->shapes[to] = shapes[from];
    }
    return status;
}

/* By the largest of all these that has the unit, or what the rod has by itself. */
static void set_scales(export_family *f, const double *shapes)
{
    int which[EXPORT_COMPARED];
    const int rows = MEMBERS * export_family_compared(f, which);
    const model_column *known = scene_physics_of(f->open)->columns;
    for (int c = 0; c < f->columns; c++) {
        const char *unit = known[f->which[c]].unit;
        f->scale[c] = export_natural_scale(f->open, unit);
        for (int i = 0; i < rows * f->columns; i++) {
            if (strcmp(known[f->which[i % f->columns]].unit, unit) == 0) {
                f->scale[c] = fmax(f->scale[c], fabs(shapes[i]));
            }
        }
    }
}

/* Places of the shape over the length. */
static void put_places(export_family *f, int places, const double *s, double *to)
{
    f->places = s ? places : PLACES;
    f->s = to;
    for (int i = 0; i < f->places; i++) {
        to[i] = s ? s[i] : (double)i / (PLACES - 1);
    }
}

ad_status export_members_prepare(export_model *model, int places, const double *s, ad_error *error)
{
    solve_members *solver = targets_solver(model->e->targets);
    solve_answer answers[MEMBERS];
    export_family *f = &model->family;
    numbers n;
    f->name = model->name;
    f->open = model->e->scene;
    f->single = model->single;
    f->tip = true;
    f->members = MEMBERS;
    f->values = model->measured.values;
    f->derivatives = model->measured.jacobian;
    if (!allocate(model, &n)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a self-test");
    }
    put_places(f, places, s, n.s);
    ad_status status = export_family_of(model->e, f, n.parameters, n.said, error);
    f->steps = strain_held(f->open) + strain_angles(f->open) + f->open->tube_count > 0 ? 3
               : strain_forces(f->open, strain_mesh_nodes(&f->mesh)) > 0               ? 2
                                                                                       : 1;
    if (status == AD_OK) {
        status = solve_members_refine(solver, MEMBERS, n.parameters, n.said, f->steps, n.values,
                                      n.polished, answers, error);
    }
    status = status == AD_OK ? find_shapes(model, &n, answers, error) : status;
    if (status != AD_OK) {
        return status;
    }
    for (size_t i = 0; i < solve_members_numbers(solver) * MEMBERS; i++) {
        n.curvature[i] = n.said[i] * scene_length(f->open);
        n.polished[i] *= scene_length(f->open);
    }
    set_scales(f, n.shapes);
    f->parameters = n.parameters;
    f->curvature = n.curvature;
    f->polished = n.polished;
    f->shapes = n.shapes;
    model->outputs = 1 + f->columns; /* lines of the self-test */
    return AD_OK;
}
