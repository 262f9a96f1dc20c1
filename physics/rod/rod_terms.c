/* Which physical terms a scene has, for people: the tape drops the others by folding constants. */
#include "physics/rod/rod_internal.h"
#include "physics/scene/scene_field.h"

#include <math.h>

typedef struct term_list {
    rod_term *terms;
    int count;
} term_list;

static const char planar_motion[] = "planar motion";

/* Present when reason is NULL. */
static void term_add(term_list *list, const char *name, const char *reason)
{
    list->terms[list->count++] =
        (rod_term){.name = name, .present = reason == NULL, .reason = reason};
}

/* NULL, or the first reason that applies. */
static const char *reason_if(bool applies, const char *reason, const char *otherwise)
{
    return applies ? reason : otherwise;
}

/* Whether it is the number `value` for all s and t, or not given. */
static bool is_only(quantity q, double value)
{
    return !q.is_given || quantity_is(q, value);
}

static bool are_zero(const quantity *x)
{
    return !quantity_any_something(3, x);
}

/* Whether two are the same for all s. */
static bool are_same(quantity a, quantity b)
{
    return a.node == b.node && (a.node || a.number == b.number);
}

/* `across` [3]: by symmetry there is none of this strain. */
static void terms_of_stiffness(term_list *list, const char *const *names, const quantity *stiffness,
                               const bool *across)
{
    for (int i = 0; i < 3; i++) {
        const char *symmetry = reason_if(across[i], planar_motion, NULL);
        term_add(list, names[i],
                 reason_if(scene_locks(stiffness[i]), "infinite stiffness", symmetry));
    }
}

static void terms_of_strains(const scene *rod_scene, term_list *list)
{
    static const char *const strains[3] = {"shear along d1", "shear along d2", "stretch"};
    static const char *const curvatures[3] = {"bending about d1", "bending about d2", "twist"};
    scene_properties properties = scene_properties_of(rod_scene);
    rod_plane plane = rod_plane_of(rod_scene);
    bool strain_across[3], curvature_across[3];
    for (int i = 0; i < 3; i++) {
        strain_across[i] = plane.is_planar && i == plane.director;
        curvature_across[i] = plane.is_planar && i != plane.director;
    }
    terms_of_stiffness(list, strains, properties.strain_stiffness, strain_across);
    terms_of_stiffness(list, curvatures, properties.curvature_stiffness, curvature_across);
    term_add(list, "nonlinear law", reason_if(!rod_scene->rod.law, "not given", NULL));
    scene_rest rest = scene_rest_of(rod_scene);
    bool unstrained =
        is_only(rest.strain[0], 0) && is_only(rest.strain[1], 0) && is_only(rest.strain[2], 1);
    bool turns = false;
    for (int i = 1; i < rod_scene->segment_count; i++) {
        turns = turns || !are_zero(rod_scene->segments[i].turn);
    }
    term_add(list, "rest strain", reason_if(unstrained, "not given", NULL));
    term_add(list, "rest curvature", reason_if(are_zero(rest.curvature), "not given", NULL));
    term_add(list, "turned joints", reason_if(!turns, "not given", NULL));
}

/* Of what resists the motion, from force per length and velocity at the velocity of the first
 * bending mode where its amplitude is the length, c: the damping c/(2 rhoA w1). */
static rod_term resisting(const scene *rod_scene, const rod_given *given)
{
    const quantity *q = rod_given_of(given, rod_scene);
    const char *still = scene_is_dynamic(rod_scene) ? NULL : "static scene";
    rod_term row = {.name = given->term,
                    .key = scene_key_of(rod_scene, q),
                    .formula = given->formula,
                    .reason =
                        reason_if(!quantity_any_something(given->count, q), "not given", NULL)};
    row.reason = still ? still : row.reason;
    row.present = row.reason == NULL;
    if (row.present) {
        const double frequency = rod_first_frequency(rod_scene);
        const double speed = frequency * scene_length(rod_scene);
        double c = 0;
        for (int i = 0; i < given->count; i++) {
            c += scene_mean(rod_scene, q[i]) * pow(speed, -given->unit[i].time - 1);
        }
        const quantity mass = scene_properties_of(rod_scene).mass_per_length;
        row.damping = c / (2 * scene_mean(rod_scene, mass) * frequency);
    }
    return row;
}

rod_term rod_drag_term(const scene *rod_scene)
{
    const rod_given *given;
    rod_givens(&given);
    while (rod_given_of(given, rod_scene) != &rod_scene->loads.drag) {
        given++;
    }
    return resisting(rod_scene, given);
}

/* Of laws along the rod that resist the motion, or of the others. */
static void terms_of_laws(const scene *rod_scene, bool resist, term_list *list)
{
    const rod_given *given;
    for (int left = rod_givens(&given); left > 0; left--, given++) {
        const bool absent = !quantity_any_something(given->count, rod_given_of(given, rod_scene));
        if (!given->term) {
            continue;
        }
        if (resist && given->formula) {
            list->terms[list->count++] = resisting(rod_scene, given);
        } else if (!resist && !given->formula) {
            term_add(list, given->term, reason_if(absent, "not given", NULL));
        }
    }
}

static void terms_of_time(const scene *rod_scene, term_list *list)
{
    scene_properties properties = scene_properties_of(rod_scene);
    const quantity *inertia = properties.rotary_inertia;
    const char *still = scene_is_dynamic(rod_scene) ? NULL : "static scene";
    bool pointlike = are_zero(inertia);
    bool round = are_same(inertia[0], inertia[1]) && are_same(inertia[1], inertia[2]);
    const char *no_inertia = reason_if(pointlike, "rho I = 0", still);
    const char *about_normal = reason_if(rod_plane_of(rod_scene).is_planar, planar_motion, NULL);
    term_add(list, "translational inertia", still);
    term_add(
        list, "added mass of a fluid",
        still ? still
              : reason_if(!quantity_is_something(rod_scene->loads.added_mass), "not given", NULL));
    term_add(list, "rotary inertia", still ? still : no_inertia);
    term_add(list, "gyroscopic moment",
             still ? still
                   : reason_if(round, "rho I equal about all axes",
                               no_inertia ? no_inertia : about_normal));
    term_add(list, "strain damping",
             still ? still : reason_if(are_zero(properties.strain_damping), "not given", NULL));
    term_add(list, "curvature damping",
             still ? still : reason_if(are_zero(properties.curvature_damping), "not given", NULL));
    terms_of_laws(rod_scene, true, list);
}

static const char *load_reason(scene_end_type type, const scene_load *load)
{
    if (!scene_end_takes_force(type)) {
        return "the end is not loaded";
    }
    return reason_if(are_zero(load->force) && are_zero(load->moment), "zero", NULL);
}

static void terms_of_loads(const scene *rod_scene, term_list *list)
{
    const scene_loads *loads = &rod_scene->loads;
    bool weightless = are_zero(loads->gravity);
    term_add(list, "gravity", reason_if(weightless, "not given", NULL));
    term_add(list, "distributed force", reason_if(are_zero(loads->force), "not given", NULL));
    term_add(list, "distributed moment", reason_if(are_zero(loads->moment), "not given", NULL));
    if (scene_is_manufactured(rod_scene)) {
        term_add(list, "manufactured loads", NULL);
        return;
    }
    terms_of_laws(rod_scene, false, list);
    for (int i = 0; i < scene_list_count; i++) {
        const scene_list *entries = &scene_lists[i];
        if (entries->offset < offsetof(scene, beam)) { /* those of a rod */
            term_add(list, entries->key,
                     reason_if(scene_list_length(rod_scene, entries) == 0, "not given", NULL));
        }
    }
    term_add(list, "base load", load_reason(rod_scene->start.type, &loads->base));
    term_add(list, "tip load", load_reason(rod_scene->end.type, &loads->tip));
}

int rod_terms(const scene *rod_scene, rod_term *terms)
{
    term_list list = {.terms = terms, .count = 0};
    terms_of_strains(rod_scene, &list);
    terms_of_time(rod_scene, &list);
    terms_of_loads(rod_scene, &list);
    return list.count;
}
