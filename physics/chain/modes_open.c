/* A reduced rod of a family, whose parameters are its inputs. */
#include "autodiff/dense.h"
#include "physics/chain/modes_internal.h"
#include "physics/scene/breaks.h"
#include "physics/scene/scene_field.h"
#include "physics/scene/support.h"

/* What becomes longer while it moves has to be a mode. */
static ad_status check_lengths(const scene *open, uint64_t staying, ad_error *error)
{
    char text[sizeof error->message];
    for (int k = 0; k < open->parameter_count && !(open->feed.to > 0); k++) {
        if (!(staying >> k & 1) && quantity_depends_on(open->place, open->parameters[k].name)) {
            support_sentence(support_feature_find("a length or place with a range"),
                             SUPPORT_ONE_STEP, text, sizeof text);
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "%s; what comes out of a port may follow a parameter by rod.feed_time",
                           text);
        }
    }
    return AD_OK;
}

/* Of an end that follows an input its rates are not known. */
static ad_status check_end(const solve_rod *rod, bool follows, ad_error *error)
{
    return !follows && modes_end_directions(rod) > 0 &&
                   solve_rod_part_kind(rod, SOLVE_END).by_parameters
               ? ad_fail(error, AD_BAD_ARGUMENT,
                         "boundary.end depends on a parameter, and the end is held; allowed: "
                         "numbers and formulas of t")
               : AD_OK;
}

/* What turns the base is a mode, and formulas have 0 in its place. */
static ad_status check_turn(const scene *open, ad_error *error)
{
    for (int k = 0; k < open->parameter_count && open->start.turn_time.is_given; k++) {
        const char *name = open->parameters[k].name;
        for (int i = 0;
             i < scene_field_count && quantity_any_depends_on(4, open->start.rotation, name); i++) {
            const quantity *of = scene_field_of(open, &scene_fields[i]);
            if (of != open->start.rotation &&
                quantity_any_depends_on(scene_fields[i].count, of, name)) {
                return ad_fail(
                    error, AD_BAD_ARGUMENT,
                    "%s depends on %s, which turns the base by boundary.start.turn_time; "
                    "allowed: in boundary.start.rotation alone",
                    scene_fields[i].key, name);
            }
        }
    }
    return AD_OK;
}

/* Points of the modes are where nothing jumps in the middle of the ranges. */
static ad_status check_places(const scene *family, ad_error *error)
{
    static const double PART = 0.05;
    double middle[SCENE_PARAMETERS_MAX];
    scene_breaks unused;
    int moved_by = -1;
    const ad_status status = scene_breaks_moved(family, "s", scene_middle_values(family, middle),
                                                PART, &unused, &moved_by, error);
    return status == AD_OK && moved_by >= 0
               ? ad_fail(error, AD_BAD_ARGUMENT,
                         "the parameter %s moves a place at which a formula of s jumps or has a "
                         "kink; allowed: places that stay",
                         family->parameters[moved_by].name)
               : status;
}

static bool has_modes(const modes *m, int strain)
{
    bool all = true;
    for (int e = m->hinges; e < m->elements && all; e++) {
        bool any = false;
        for (int a = m->element[e].own; a < m->element[e].end; a++) {
            any = any || m->mode[a].strain == strain;
        }
        all = any;
    }
    return all;
}

/* Nor does a strain without modes follow what may move, nor what is measured from the start. */
static ad_status find_rest(modes *m, const scene *open, uint64_t staying, ad_error *error)
{
    const scene_rest rest = scene_rest_of(open);
    for (int at = 0; at < MODES_STRAINS * open->parameter_count && !(open->feed.to > 0); at++) {
        const int k = at / MODES_STRAINS, c = at % MODES_STRAINS;
        const quantity of = c < MODES_U ? rest.strain[c] : rest.curvature[c - MODES_U];
        const bool depends = quantity_depends_on(of, open->parameters[k].name),
                   moves = depends && !(staying >> k & 1);
        m->rest_moves |= moves;
        m->origin_moves |= depends && !moves;
        if (moves && scene_measures_from_rest(open)) {
            return ad_fail(
                error, AD_BAD_ARGUMENT,
                "rod.rest follows the input %s, and springs or a foundation are measured "
                "from the unstressed rod; allowed: springs that do not turn, with an "
                "anchor",
                open->parameters[k].name);
        }
        if (moves && !has_modes(m, c)) {
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "rod.rest depends on %s along what is locked or has no modes; allowed: "
                           "a rest shape that stays there",
                           open->parameters[k].name);
        }
    }
    return AD_OK;
}

ad_status modes_create_open(const scene *family, bool follows, uint64_t staying,
                            const modes_counts *counts, int finer, solve_rod **rod, modes **result,
                            ad_error *error)
{
    const char *names[SCENE_PARAMETERS_MAX];
    double low[SCENE_PARAMETERS_MAX], high[SCENE_PARAMETERS_MAX], middle[SCENE_PARAMETERS_MAX];
    const solve_parameters parameters = {family->parameter_count, names,
                                         scene_middle_values(family, middle)};
    const solve_parameters *open = parameters.count > 0 ? &parameters : NULL;
    for (int k = 0; k < parameters.count; k++) {
        names[k] = family->parameters[k].name;
        low[k] = family->parameters[k].low;
        high[k] = family->parameters[k].high;
    }
    ad_status status = check_lengths(family, staying, error);
    status = status == AD_OK ? check_turn(family, error) : status;
    status = status == AD_OK && !(family->feed.to > 0) ? check_places(family, error) : status;
    if (status != AD_OK) {
        return status;
    }
    status = open ? solve_rod_create_open(family, open, rod, error)
                  : solve_rod_create(family, rod, error);
    status = status == AD_OK ? check_end(*rod, follows, error) : status;
    status = status == AD_OK ? modes_create(*rod, open, counts, finer, result, error) : status;
    status = status == AD_OK ? find_rest(*result, family, staying, error) : status;
    return status == AD_OK ? modes_set_ranges(*result, low, high, error) : status;
}

ad_status modes_begin_open(modes *m, const scene *family, const double *inputs, const double *rates,
                           const modes_linear *linear, ad_error *error)
{
    double middle[SCENE_PARAMETERS_MAX];
    modes_move(m, rates);
    if (m->inputs == 0 || family->initial.state != SCENE_EQUILIBRIUM) {
        const ad_status status = modes_at(m, 0, inputs, error);
        return status == AD_OK ? modes_initial(m, linear->q, linear->v, error) : status;
    }
    const ad_status status = ad_dense_load(error);
    return status == AD_OK ? modes_initial_settled(m, scene_middle_values(family, middle), inputs,
                                                   rates, linear, error)
                           : status;
}
