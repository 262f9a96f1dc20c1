/* What the scene of a beam has to satisfy, and what it cannot have that rods in space can. */
#include "physics/scene/scene_internal.h"

#include <math.h>
#include <string.h>

static const char SHAPE[] = "belongs to a rod in space; leave it out, or take another rod.model";
static const char LOADS[] = "acts on a rod in space; a beam has beam.force, beam.moment, "
                            "beam.base, beam.tip and loads.drag";

ad_status scene_check_no_beam(const scene_checker *check)
{
    for (int i = 0; i < scene_field_count; i++) {
        const scene_field *field = &scene_fields[i];
        if (field->part == SCENE_OF_BEAM && scene_field_of(check->scene, field)->is_given) {
            return scene_refuse(check, field->key,
                                "belongs to a beam of small deflection; leave it out, or take "
                                "rod.model euler_bernoulli or timoshenko");
        }
    }
    return AD_OK;
}

/* What to say of a quantity of rods in space, and the key to blame; NULL: a beam may have it. */
static const char *foreign(const scene_field *field, const char **key)
{
    *key = field->key;
    switch (field->part) {
    case SCENE_OF_LOADS:
        return strncmp(field->key, "loads.", 6) == 0 ? LOADS : SHAPE;
    case SCENE_OF_LISTS:
        return strncmp(field->key, "loads.", 6) == 0
                   ? "acts on a rod in space; a beam has beam.points"
                   : SHAPE;
    case SCENE_OF_BASE:
        *key = "loads.base";
        return LOADS;
    case SCENE_OF_TIP:
        *key = "loads.tip";
        return LOADS;
    case SCENE_OF_INITIAL:
        return "is that of a rod in space; a beam has beam.initial";
    case SCENE_OF_EXACT:
        *key = "manufactured";
        return "makes loads of a rod in space; for a beam give beam.force and "
               "reference.deflection";
    default:
        return NULL;
    }
}

static ad_status check_damping(const scene_checker *check)
{
    const scene_rod *rod = &check->piece->rod;
    const struct {
        const char *key;
        bool is_given;
    } rows[] = {
        {"rod.damping.strain", quantity_any_something(3, rod->strain_damping)},
        {"rod.damping.curvature", quantity_any_something(3, rod->curvature_damping)},
        {"rod.material.viscosity", rod->viscosity.is_given},
        {"rod.material.relaxation_time", rod->relaxation_time.is_given},
        {"rod.material.maxwell.ratio", rod->maxwell_ratio.is_given},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (rows[i].is_given) {
            return scene_refuse(check, rows[i].key,
                                "belongs to a rod in space; a beam is damped by loads.drag");
        }
    }
    return AD_OK;
}

/* Keys of rods in space that a beam does not have. */
static ad_status check_rods_keys(const scene_checker *check)
{
    const scene *given = check->scene;
    const scene_loads *l = &given->loads;
    const struct {
        const char *key;
        bool is_given;
        const char *sentence;
    } rows[] = {
        {"loads.gravity", quantity_any_something(3, l->gravity),
         "acts on a rod in space; a beam has its weight across the axis in beam.force"},
        {"loads.frame", l->frame != SCENE_DEAD, LOADS},
        {"loads.base", l->base.frame != SCENE_DEAD, LOADS},
        {"loads.tip", l->tip.frame != SCENE_DEAD, LOADS},
        {"motion", given->motion != SCENE_AUTOMATIC, SHAPE},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (rows[i].is_given) {
            return scene_refuse(check, rows[i].key, rows[i].sentence);
        }
    }
    for (int i = 0; i < scene_field_count; i++) {
        const char *key = NULL, *sentence = foreign(&scene_fields[i], &key);
        if (sentence && scene_field_says(given, &scene_fields[i])) {
            return scene_refuse(check, key, sentence);
        }
    }
    return AD_OK;
}

static ad_status check_inertia(const scene_checker *check)
{
    const scene_rod *rod = &check->piece->rod;
    return rod->model == SCENE_EULER_BERNOULLI && rod->rotary_inertia[0].is_given
               ? scene_refuse(check, "rod.inertia.rotary",
                              "euler_bernoulli has no rotary inertia; leave it out, or take "
                              "timoshenko")
               : AD_OK;
}

static ad_status check_theory(const scene_checker *check)
{
    const scene *given = check->scene;
    const scene_beam *beam = &given->beam;
    scene_properties properties = scene_properties_of(given);
    bool shears = given->rod.model == SCENE_TIMOSHENKO;
    if (shears && given->formulation == SCENE_DISPLACEMENT &&
        scene_locks(properties.strain_stiffness[1])) {
        return scene_refuse(check, "formulation",
                            "displacement computes the shear from its strain and needs finite "
                            "stiffness; allowed for this beam: mixed");
    }
    if (scene_is_fourth_order(given) &&
        (given->start.type == SCENE_GUIDED || given->end.type == SCENE_GUIDED) &&
        !quantity_is_number(properties.curvature_stiffness[0], NULL)) {
        return scene_refuse(check, "formulation",
                            "displacement takes the shear at a guided end from the deflection, and "
                            "needs a stiffness that does not vary; allowed for this beam: mixed");
    }
    if (scene_is_fourth_order(given) && given->windows > 1) {
        return scene_refuse(check, "time.windows",
                            "the strong form of euler_bernoulli needs four derivatives of the "
                            "state that a window hands on, too many for rounding; allowed: 1, or "
                            "formulation mixed");
    }
    if ((beam->slope.is_given || beam->slope_rate.is_given) &&
        !quantity_is_something(properties.rotary_inertia[0])) {
        return scene_refuse(check,
                            beam->slope.is_given ? "beam.initial.slope" : "beam.initial.slope_rate",
                            "follows from the deflection, since this beam has no rotary inertia; "
                            "leave it out");
    }
    return AD_OK;
}

static ad_status check_end(const scene_checker *check, bool at_tip)
{
    const scene_end *end = at_tip ? &check->scene->end : &check->scene->start;
    const scene_beam *beam = &check->scene->beam;
    const scene_beam_load *load = at_tip ? &beam->tip : &beam->base;
    const char *type = at_tip ? "boundary.end.type" : "boundary.start.type";
    bool given = load->force.is_given || load->moment.is_given;
    if (end->type == SCENE_DRIVEN || end->type == SCENE_ROLLER) {
        return scene_refuse(check, type,
                            "driven ends and rollers are for rods in space; allowed for a beam: "
                            "clamped, pinned, guided, free, loaded");
    }
    if (end->along[0].is_given || end->across[0].is_given) {
        return scene_refuse(check, at_tip ? "boundary.end" : "boundary.start",
                            "says how the end of a rod in space slides; a guided end of a beam "
                            "slides along its deflection, leave along and across out");
    }
    if (end->type == SCENE_GUIDED) {
        return load->moment.is_given
                   ? scene_refuse(check, at_tip ? "beam.tip.moment" : "beam.base.moment",
                                  "acts on an end that does not turn; allowed: a force, or an end "
                                  "of type loaded")
                   : AD_OK;
    }
    if (end->type == SCENE_LOADED && !given) {
        return scene_refuse(check, type, "loaded, but no load is given there; say free");
    }
    if (end->type != SCENE_LOADED && given) {
        return scene_refuse(check, at_tip ? "beam.tip" : "beam.base",
                            "acts on an end of another type; allowed: an end of type loaded");
    }
    return AD_OK;
}

/* Of a spring what a deflection along d2 and a turn about d1 move. */
static ad_status check_springs(const scene_checker *check)
{
    const scene *given = check->scene;
    for (int i = 0; i < given->spring_count; i++) {
        const scene_spring *spring = &given->springs[i];
        const quantity *k = spring->stiffness, *turning = spring->turning, *at = spring->anchor;
        if (quantity_is_something(k[0]) || quantity_is_something(k[2])) {
            return scene_refuse_at(check, k,
                                   "acts across or along the beam, which deflects along d2 alone; "
                                   "allowed: [0, k, 0]");
        }
        if (quantity_is_something(turning[1]) || quantity_is_something(turning[2])) {
            return scene_refuse_at(check, turning,
                                   "acts about d2 or d3, but a beam turns about d1 alone; allowed: "
                                   "[k, 0, 0]");
        }
        if (quantity_is_something(at[0]) || quantity_is_something(at[2])) {
            return scene_refuse_at(check, at,
                                   "is a deflection along d2 for a beam; allowed: [0, w, 0]");
        }
    }
    return AD_OK;
}

/* Static equilibrium has to be unique. */
static ad_status check_support(const scene_checker *check)
{
    const scene *given = check->scene;
    quantity foundation = given->beam.foundation;
    scene_end_type start = given->start.type, end = given->end.type;
    bool turning = scene_end_holds_rotation(start) || scene_end_holds_rotation(end);
    double first = INFINITY, last = -INFINITY; /* places that are held */
    for (int i = 0; i < 2 + given->spring_count; i++) {
        const scene_spring *spring = i < 2 ? NULL : &given->springs[i - 2];
        double at = spring ? spring->at.number : i * scene_length(given);
        if (spring ? quantity_is_something(spring->stiffness[1])
                   : (i ? end : start) == SCENE_CLAMPED || (i ? end : start) == SCENE_PINNED) {
            first = fmin(first, at);
            last = fmax(last, at);
        }
        turning = turning || (spring && quantity_is_something(spring->turning[0]));
    }
    scene_range range = scene_range_of(given, quantity_or(foundation, quantity_number(0)));
    bool apart = last - first > PLACE_ROUNDING * scene_length(given);
    if (scene_is_dynamic(given) || (turning && first <= last) || apart || range.high > 0) {
        return AD_OK;
    }
    return scene_refuse(check, "boundary",
                        "a static beam with these ends is free to move; clamp one, pin both, or "
                        "give beam.foundation");
}

ad_status scene_check_beam(const scene_checker *check)
{
    ad_status status = scene_check_pieces(check, check_damping);
    if (status == AD_OK) {
        status = check_rods_keys(check);
    }
    if (status == AD_OK) {
        status = scene_check_pieces(check, check_inertia);
    }
    if (status == AD_OK) {
        status = check_theory(check);
    }
    for (int end = 0; end <= 1 && status == AD_OK; end++) {
        status = check_end(check, end);
    }
    if (status == AD_OK) {
        status = check_springs(check);
    }
    if (status == AD_OK) {
        status = check_support(check);
    }
    return status;
}
