/* What a curvature from elsewhere is worth (solve_members.h): Newton's steps from there, and how
 * far the rod is from its equilibrium. */
#include "physics/chain/strain_group.h"
#include "physics/chain/strain_tubes.h"
#include "physics/local/complement.h"
#include "physics/local/strain_algebra.h"

/* The largest ratio of two steps that settle; and what is left, over the length, when the second is
 * of rounding and of the mesh. */
static const double RATIO_MOST = 0.25, MESH_LEAVES = 1e-5;

typedef struct question {
    strain_group *group;
    size_t members;
    strain_level *level, *fine; /* of the curvature, of positions */
    lanes length, ratio;        /* of the last step; of the last two */
    double again[LANES];        /* of two steps from what is returned, where an end is held */
    bool stable[LANES];
    double predicted[LANES], left[LANES];
} question;

/* The torsion of tubes at s = 0 is that of their polynomial there. */
static void set_bases(strain_form *form)
{
    double value[GAUSS_STAGES_MAX];
    gauss_lagrange(&form->rule, 0, value);
    for (int k = 0; k < form->kind.tubes; k++) {
        strain_tube *of = &form->tubes[k];
        of->base = NO_LANES;
        for (int j = 0; j < form->kind.stages; j++) {
            of->base += value[j] * of->torsion[j];
        }
    }
}

static void set_curvature(strain_group *group, size_t members, const double *curvature)
{
    strain_level *level = &group->level[group->modes];
    strain_form *fine = group->level[group->modes + STRAIN_BEYOND].form;
    const int width = strain_group_width(group), numbers = width * level->form->nodes;
    strain_level_rest(level); /* v is sought from there */
    memset(level->form->still, 0, sizeof level->form->still);
    memset(fine->still, 0, sizeof fine->still);
    for (size_t lane = 0; lane < LANES; lane++) {
        const double *from = curvature + lane % members * (size_t)numbers;
        for (int i = 0; i < numbers; i++) {
            (*strain_number(level->form, i / width, i % width))[lane] =
                from[i] * group->rod->scales.length;
        }
    }
    set_bases(level->form);
}

/* Forces that hold the end, and tensions, are those with which the equations are met best. */
static void guess_held(strain_form *form)
{
    const int n = form->elastic, open = form->holding, count = open + form->tension_count;
    lanes *columns = form->matrix, *there = form->coupled, *rest = columns + count * n;
    lanes *of[COMPLEMENT_MAX];
    strain_form_shape(form);
    memcpy(rest, form->right, (size_t)n * sizeof *rest);
    strain_form_linearise(form);
    for (int c = 0; c < count; c++) {
        const int at = c < open ? n + c : form->tension_at + c - open;
        of[c] = strain_form_unknown(form, at);
        form->direction[at] = NO_LANES + 1;
        strain_form_apply(form, form->direction, there);
        form->direction[at] = NO_LANES;
        memcpy(columns + c * n, there, (size_t)n * sizeof *columns);
    }
    for (int lane = 0; lane < LANES; lane++) {
        double x[COMPLEMENT_MAX];
        for (int c = 0; c < count; c++) {
            x[c] = (*of[c])[lane];
        }
        solve_complement_fit(n, count, open, LANES, (const double *)columns + lane, x);
        for (int c = 0; c < count; c++) {
            (*of[c])[lane] = x[c];
        }
    }
}

/* Forces that the shape does not give by itself are sought from those of the shape that the
 * curvature has without stretch. */
static void guess_forces(strain_form *form)
{
    if (form->unknowns == form->elastic) {
        return;
    }
    const bool holds = form->holding + form->tension_count > 0;
    for (int k = 0; k < 2 && holds; k++) { /* the second knows the stretch */
        strain_form_rub(form);
        guess_held(form);
    }
    strain_form_place(form);
    strain_form_push(form);
    strain_form_rub(form);
    for (int i = 0; i < form->nodes && form->push_at >= 0; i++) {
        memcpy(form->at[i].push, form->pushes[i].force, sizeof form->at[i].push);
    }
    for (int k = 0; k < form->place_count; k++) {
        memcpy(form->places[k].force, form->places[k].push.force, sizeof form->places[k].force);
    }
}

ad_status strain_group_take(strain_group *group, size_t members, const double *parameters,
                            const double *curvature, ad_error *error)
{
    strain_level *level = &group->level[group->modes];
    const lanes whole = NO_LANES + 1;
    ad_status status = strain_group_parameters(group, members, parameters, error);
    if (status == AD_OK) {
        status = strain_level_give(level, group->rod, group->count, group->parameters, group->room,
                                   error);
    }
    if (status == AD_OK) {
        set_curvature(group, members, curvature);
        strain_level_load(level, &whole);
        guess_forces(level->form);
    }
    return status;
}

static void put_curvature(const question *q, bool stepped, double *refined)
{
    const strain_form *form = q->level->form;
    const int width = strain_group_width(q->group);
    for (size_t lane = 0; lane < q->members; lane++) {
        for (int i = 0; i < width * form->nodes; i++) {
            const int node = i / width, k = i % width;
            const int row = k < 3 ? 3 * node + k : torsion_at(form, node, k - 3);
            const double step = stepped ? form->right[row][lane] : 0;
            *refined++ =
                ((*strain_number(form, node, k))[lane] - step) / q->group->rod->scales.length;
        }
    }
}

static void put_values(const question *q, double *values)
{
    strain_group *group = q->group;
    const size_t width = (size_t)q->fine->outputs * SOLVE_MEMBERS_COLUMNS;
    strain_group_evaluate(group, group->modes + STRAIN_BEYOND);
    if (q->members == LANES) {
        for (size_t i = 0; i < width; i++) {
            for (size_t lane = 0; lane < LANES; lane++) {
                values[lane * width + i] = group->values[i][lane];
            }
        }
    }
    for (size_t lane = 0; lane < q->members && q->members < LANES; lane++) {
        strain_group_put(group, (int)lane, values + lane * width);
    }
}

static void move(strain_form *form)
{
    const lanes whole = NO_LANES + 1;
    strain_form_move(form, form->right, &whole);
}

void strain_group_place(strain_group *group)
{
    strain_level *fine = &group->level[group->modes + STRAIN_BEYOND];
    strain_level_refine(&group->beyond, &group->level[group->modes], fine);
    strain_form_place(fine->form);
}

/* The shape as it is, on the finer mesh, whose points are `placed` from then on. */
static void place(question *q)
{
    strain_group_place(q->group);
    strain_group_keep(q->fine->form, q->group->placed);
}

static void step(question *q, int k, bool stays)
{
    strain_form *form = q->level->form;
    bool all[LANES];
    lanes length;
    memset(all, true, sizeof all);
    strain_group_step(form, all, &length);
    for (int lane = 0; lane < LANES; lane++) {
        q->stable[lane] = q->stable[lane] && form->negative[lane] == 0 && isfinite(length[lane]);
    }
    if (k > 0) {
        q->ratio = length / q->length;
    }
    q->length = length;
    if (k == 0 && !stays) {
        place(q);
    }
    if (!stays) {
        move(form);
    }
}

/* Forces of laws at places and of ends that are held, tensions, and torsions at s = 0, in `right`
 * of both. */
static void copy_forces(const strain_form *from, strain_form *to)
{
    memcpy(to->right + to->elastic, from->right + from->elastic,
           (size_t)from->holding * sizeof *to->right);
    memcpy(to->right + to->tension_at, from->right + from->tension_at,
           (size_t)from->tension_count * sizeof *to->right);
    memcpy(to->right + to->tube_at, from->right + from->tube_at,
           (size_t)from->kind.tubes * sizeof *to->right);
    for (int k = 0; k < from->place_count; k++) {
        const int first = from->places[k].unknown;
        if (first >= 0) {
            memcpy(to->right + to->places[k].unknown, from->right + first, 3 * sizeof *to->right);
        }
    }
}

/* The change towards the equilibrium, of the residual in `right` of the finer mesh: what that is at
 * the points of the other, by the elimination that was last there; and what it is beyond that by
 * itself, as the shortest waves of curvature bend the rod the least. */
static void approach(question *q)
{
    strain_group *group = q->group;
    strain_form *form = q->level->form, *fine = q->fine->form;
    lanes *more = group->start, *there = group->before;
    const bool pushed = form->push_at >= 0;
    const int tubes = form->kind.tubes;
    const int from[] = {0, pushed ? form->push_at : 0, form->angle_at, form->tube_at + tubes};
    const int to[] = {0, pushed ? fine->push_at : 0, fine->angle_at, fine->tube_at + tubes};
    const int width[] = {3, pushed ? 3 : 0, form->rub_count, tubes};
    enum { KINDS = sizeof width / sizeof *width };
    for (int k = 0; k < KINDS; k++) {
        strain_level_sample(&group->back, q->fine, q->level, width[k], fine->right + to[k],
                            form->right + from[k]);
    }
    copy_forces(fine, form);
    for (int k = 0; k < form->tension_count; k++) { /* from which a step leads to those that pull */
        form->tensions[k].pull = fine->tensions[k].pull;
    }
    memcpy(more, form->right, (size_t)form->unknowns * sizeof *more);
    strain_form_solve_again(form);
    for (int i = 0; i < form->unknowns; i++) {
        more[i] = form->right[i] - more[i];
    }
    for (int k = 0; k < KINDS; k++) {
        strain_level_sample(&group->beyond, q->level, q->fine, width[k], more + from[k], there);
        for (int i = 0; i < width[k] * fine->nodes; i++) {
            fine->right[to[k] + i] += there[i];
        }
    }
    copy_forces(form, fine);
}

static void look_beyond(question *q, int steps)
{
    lanes length;
    strain_level_refine(&q->group->beyond, q->level, q->fine);
    strain_form_shape(q->fine->form);
    approach(q);
    strain_group_measure(q->level->form, &length);
    if (steps == 1) {
        q->ratio = length / q->length;
    }
}

/* The finer mesh by that change, in which forces that are sought stretch the rod, too. */
static void move_beyond(strain_form *fine)
{
    move(fine);
    if (fine->unknowns > fine->elastic) {
        strain_form_strain(fine);
    } else {
        strain_form_place(fine);
    }
}

/* How far what was given, and what is returned, are from where that change leads; and the next,
 * where an end is held: along what that leaves free a rod may be soft, and far from linear. */
static void compare(question *q, bool stepped)
{
    strain_group *group = q->group;
    strain_form *fine = q->fine->form;
    double next[LANES] = {0};
    strain_group_keep(fine, group->other);
    move_beyond(fine);
    strain_group_compare(fine, group->other, true, q->left);
    if (fine->holding > 0) {
        strain_form_shape(fine);
        approach(q);
        strain_group_keep(fine, group->before);
        move_beyond(fine);
        strain_group_compare(fine, group->before, true, next);
        for (int lane = 0; lane < LANES; lane++) {
            q->again[lane] = next[lane] / q->left[lane];
            q->left[lane] = 0;
        }
        strain_group_compare(fine, group->other, true, q->left);
    }
    if (stepped) {
        strain_group_compare(fine, group->placed, true, q->predicted);
    }
}

static void put_answers(const question *q, bool stepped, solve_answer *answers)
{
    for (size_t lane = 0; lane < q->members; lane++) {
        const double off = (stepped ? q->predicted : q->left)[lane],
                     unit = q->group->rod->scales.length;
        solve_answer *to = &answers[lane];
        *to = (solve_answer){.predicted = off * unit,
                             .left = q->left[lane] * unit,
                             .ratio = stepped ? q->ratio[lane] : NAN,
                             .stable = q->stable[lane]};
        const bool settles =
            ((!stepped || to->ratio <= RATIO_MOST) && q->again[lane] <= RATIO_MOST) ||
            q->left[lane] <= MESH_LEAVES;
        to->reason = !isfinite(off) || !isfinite(to->left) ? SOLVE_NOT_FINITE
                     : !to->stable                         ? SOLVE_UNSTABLE
                     : off > SOLVE_TRUSTED                 ? SOLVE_TOO_FAR
                     : !settles                            ? SOLVE_NOT_SETTLING
                                                           : SOLVE_NO_DOUBT;
        to->trusted = to->reason == SOLVE_NO_DOUBT;
    }
}

ad_status strain_group_refine(strain_group *group, size_t members, const double *parameters,
                              const double *curvature, int steps, double *values, double *refined,
                              solve_answer *answers, ad_error *error)
{
    question q = {.group = group,
                  .members = members,
                  .level = &group->level[group->modes],
                  .fine = &group->level[group->modes + STRAIN_BEYOND]};
    const lanes whole = NO_LANES + 1;
    ad_status status = strain_group_take(group, members, parameters, curvature, error);
    if (status == AD_OK && answers) {
        status = strain_level_give(q.fine, group->rod, group->count, group->parameters, group->room,
                                   error);
    }
    if (status != AD_OK) {
        return status;
    }
    memset(q.stable, true, sizeof q.stable);
    if (answers) {
        strain_level_load(q.fine, &whole);
    }
    if (answers || steps != 0) {
        for (int k = 0; k < (steps > 1 ? steps : 1); k++) {
            step(&q, k, steps <= 0);
        }
    } else {
        strain_form_strain(q.level->form);
    }
    if (refined) {
        put_curvature(&q, steps < 0, refined);
    }
    if (answers) {
        look_beyond(&q, steps);
    } else if (values) {
        if (steps > 0) { /* v was that of the curvature before the step */
            strain_form_strain(q.level->form);
        }
        place(&q);
    }
    if (values) {
        put_values(&q, values);
    }
    if (answers) {
        compare(&q, steps > 0);
        put_answers(&q, steps > 0, answers);
    }
    return AD_OK;
}
