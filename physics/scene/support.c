#include "physics/scene/support.h"

#include "physics/scene/breaks.h"
#include "physics/scene/scene_field.h"
#include "physics/scene/scene_rows.h"

#include <stdio.h>
#include <string.h>

/* ---- forms --------------------------------------------------------------------------------- */

typedef enum form_kind { NETWORK, EXPORT, SOLVER, PATH, STEP } form_kind;

typedef struct form_row {
    const char *name, *subject;
    form_kind kind;
    bool moves;
} form_row;

#define FORM(constant, name, subject, kind, moves) {name, subject, kind, moves},
static const form_row forms[SUPPORT_FORMS] = {SUPPORT_FORM_LIST(FORM)};
#undef FORM

const char *support_form_name(support_form form)
{
    return forms[form].name;
}

bool support_form_moves(support_form form)
{
    return forms[form].moves;
}

support_form support_formulation(const scene *rod_scene)
{
    static const support_form of[2][4] = {
        {SUPPORT_MIXED, SUPPORT_DISPLACEMENT, SUPPORT_FAMILY, SUPPORT_POSE_STRAIN},
        {SUPPORT_MIXED_MOTION, SUPPORT_DISPLACEMENT_MOTION, SUPPORT_STRAIN_MOTION,
         SUPPORT_POSE_STRAIN_MOTION}};
    _Static_assert(SCENE_MIXED == 0 && SCENE_DISPLACEMENT == 1 && SCENE_STRAIN_FORM == 2 &&
                       SCENE_POSE_STRAIN == 3,
                   "the order of the rows above");
    return of[scene_is_dynamic(rod_scene)][rod_scene->formulation];
}

/* ---- who has a feature ---------------------------------------------------------------------- */

/* "tendons.friction" of "tendons[2].friction", or what begins so: "loads.tip" of "loads.tip.force".
 */
static bool is_of(const char *key, const char *section)
{
    while (*section) {
        if (*key == '[') {
            key += strcspn(key, "]") + 1;
        } else if (*key++ != *section++) {
            return false;
        }
    }
    return *key == '\0' || *key == '.' || *key == '[';
}

/* The key of the first quantity in a section that the scene gives as something else than its
 * default. */
static const char *given(const scene *scene, const char *section)
{
    for (int i = 0; i < scene_field_count; i++) {
        if (is_of(scene_fields[i].key, section) && scene_field_says(scene, &scene_fields[i])) {
            return scene_fields[i].key;
        }
    }
    return NULL;
}

/* The first quantity that depends on a name, of parts of a scene. */
static const char *depends(const scene *scene, const char *name, bool of_matter)
{
    for (int i = 0; i < scene_field_count; i++) {
        const scene_field *field = &scene_fields[i];
        const bool counts =
            !of_matter || (field->part == SCENE_OF_ROD && (is_of(field->key, "rod.section") ||
                                                           is_of(field->key, "rod.stiffness") ||
                                                           is_of(field->key, "rod.material")));
        if (counts && quantity_any_depends_on(field->count, scene_field_of(scene, field), name)) {
            return field->key;
        }
    }
    return NULL;
}

static const char *tapered(const scene *scene)
{
    return depends(scene, "s", true);
}

static const char *timed(const scene *scene)
{
    return scene_is_dynamic(scene) ? depends(scene, "t", false)
                                   : NULL; /* at rest scene_check has it */
}

static const char *follows_along(const scene *scene)
{
    return scene->loads.frame == SCENE_FOLLOWER ? "loads.frame" : NULL;
}

static const char *follows_at_tip(const scene *scene)
{
    return scene->loads.tip.frame == SCENE_FOLLOWER ? "loads.tip.frame" : NULL;
}

static const char *several(const scene *scene)
{
    return scene->segment_count > 0 ? "segments" : NULL;
}

static const char *has_bodies(const scene *scene)
{
    return scene->body_count > 0 ? "bodies" : NULL;
}

static const char *has_tubes(const scene *scene)
{
    return scene->tube_count > 0 ? "tubes" : NULL;
}

static const char *lawful(const scene *scene)
{
    return scene->rod.law ? "rod.law" : NULL;
}

static const char *damped(const scene *scene)
{
    static const char *const keys[] = {"rod.material.viscosity",
                                       "rod.material.relaxation_time",
                                       "rod.damping",
                                       "segments.damping",
                                       "segments.material.viscosity",
                                       "segments.material.relaxation_time"};
    const char *key = NULL;
    for (size_t i = 0; i < sizeof keys / sizeof *keys && !key; i++) {
        key = given(scene, keys[i]);
    }
    return key;
}

static const char *branches(const scene *scene)
{
    const char *key = given(scene, "rod.material.maxwell");
    return key ? key : given(scene, "segments.material.maxwell");
}

static const char *resting(const scene *scene)
{
    const char *key = given(scene, "rod.rest.curvature");
    key = key ? key : given(scene, "rod.rest.strain");
    key = key ? key : given(scene, "segments.rest.curvature");
    return key ? key : given(scene, "segments.rest.strain");
}

static const char *imperfect(const scene *scene)
{
    const char *key = given(scene, "rod.rest.imperfection");
    return key ? key : given(scene, "segments.rest.imperfection");
}

static const char *locked(const scene *scene)
{
    return !scene_is_beam(scene) && scene_locks_somewhere(scene) ? "rod.model" : NULL;
}

/* Of a rod in motion that does not shear, or that does, about any director. */
static const char *without_inertia(const scene *scene, bool shears)
{
    for (int k = 0; k < scene_pieces(scene) && scene_is_dynamic(scene) && !scene_is_beam(scene);
         k++) {
        const scene_piece piece = scene_piece_of(scene, k);
        const scene_properties of = scene_rod_properties(&piece.rod);
        const bool locks =
            scene_locks(of.strain_stiffness[0]) && scene_locks(of.strain_stiffness[1]);
        for (int i = 0; i < 3; i++) {
            if (quantity_is(of.rotary_inertia[i], 0) && locks != shears) {
                return "rod.inertia.rotary";
            }
        }
    }
    return NULL;
}

static const char *turns_freely(const scene *scene)
{
    return without_inertia(scene, false);
}

static const char *shears_freely(const scene *scene)
{
    return without_inertia(scene, true);
}

static const char *start_is(const scene *scene, int count, const scene_end_type *types)
{
    for (int i = 0; i < count; i++) {
        if (scene->start.type == types[i] && !scene_is_beam(scene)) {
            return "boundary.start.type";
        }
    }
    return NULL;
}

static const char *pinned_start(const scene *scene)
{
    return start_is(scene, 1, (const scene_end_type[]){SCENE_PINNED});
}

static const char *driven_start(const scene *scene)
{
    return start_is(scene, 1, (const scene_end_type[]){SCENE_DRIVEN});
}

static const char *open_start(const scene *scene)
{
    return start_is(scene, 2, (const scene_end_type[]){SCENE_FREE, SCENE_LOADED});
}

static const char *sliding_start(const scene *scene)
{
    return start_is(scene, 2, (const scene_end_type[]){SCENE_GUIDED, SCENE_ROLLER});
}

static const char *held_end(const scene *scene)
{
    return !scene_is_beam(scene) &&
                   (scene->end.type == SCENE_CLAMPED || scene->end.type == SCENE_PINNED)
               ? "boundary.end.type"
               : NULL;
}

static const char *sliding_end(const scene *scene)
{
    return !scene_is_beam(scene) && scene_end_slides(scene->end.type) ? "boundary.end.type" : NULL;
}

static const char *driven_end(const scene *scene)
{
    return scene->end.type == SCENE_DRIVEN ? "boundary.end.type" : NULL;
}

static const char *turned_end(const scene *scene)
{
    return scene->end.twist.is_given                           ? "boundary.end.twist"
           : quantity_any_given(3, scene->end.rotation_vector) ? "boundary.end.rotation_vector"
                                                               : NULL;
}

/* A body or a spring at s = 0, which the support does not take. */
static const char *loaded_pin(const scene *scene)
{
    if (scene->start.type == SCENE_PINNED) {
        const double same = 1e-9 * scene_length(scene);
        for (int i = 0; i < scene->spring_count; i++) {
            if (scene->springs[i].at.number <= same) {
                return "springs";
            }
        }
        for (int i = 0; i < scene->body_count; i++) {
            if (scene->bodies[i].at.number <= same) {
                return "bodies";
            }
        }
    }
    return NULL;
}

static const char *tendon_with(const scene *scene, bool keeps_length)
{
    for (int i = 0; i < scene->tendon_count; i++) {
        const scene_tendon *tendon = &scene->tendons[i];
        if (tendon->displacement.is_given && tendon->stiffness.is_given != keeps_length) {
            return scene_key_of(scene, &tendon->displacement);
        }
    }
    return NULL;
}

static const char *elastic(const scene *scene)
{
    return tendon_with(scene, false);
}

static const char *keeps_length(const scene *scene)
{
    return tendon_with(scene, true);
}

static const char *rubs(const scene *scene)
{
    for (int i = 0; i < scene->tendon_count; i++) {
        if (quantity_is_something(scene->tendons[i].friction)) {
            return scene_key_of(scene, &scene->tendons[i].friction);
        }
    }
    return NULL;
}

/* Where the path of a tendon with friction may have a kink. */
static const char *kinks(const scene *scene)
{
    scene_breaks breaks;
    ad_error unused;
    if (!rubs(scene) || scene_breaks_of(scene, "s", &breaks, &unused) != AD_OK) {
        return NULL;
    }
    for (int i = 0; i < scene->tendon_count; i++) {
        const scene_tendon *tendon = &scene->tendons[i];
        const double length = scene_length(scene), inside = 1e-12 * length;
        const double from = tendon->start.is_given ? tendon->start.number : 0;
        const double to = tendon->end.is_given ? tendon->end.number : length;
        for (int k = 0; k < breaks.count && quantity_is_something(tendon->friction); k++) {
            if (breaks.place[k] > from + inside && breaks.place[k] < to - inside) {
                return scene_key_of(scene, &tendon->friction);
            }
        }
    }
    return NULL;
}

static const char *manufactured(const scene *scene)
{
    return scene_is_manufactured(scene) ? "manufactured.position" : NULL;
}

static const char *manufactured_locked(const scene *scene)
{
    return manufactured(scene) ? locked(scene) : NULL;
}

static const char *manufactured_tension(const scene *scene)
{
    const char *key = rubs(scene);
    key = key ? key : elastic(scene);
    key = key ? key : keeps_length(scene);
    return manufactured(scene) ? key : NULL;
}

static const char *manufactured_imperfect(const scene *scene)
{
    return manufactured(scene) ? imperfect(scene) : NULL;
}

static const char *begins(const scene *scene)
{
    const char *key = given(scene, "initial");
    return key ? key : given(scene, "beam.initial");
}

static const char *settles(const scene *scene)
{
    return scene->initial.state == SCENE_EQUILIBRIUM ? "initial.state" : NULL;
}

static const char *small(const scene *scene)
{
    return scene_is_beam(scene) ? "rod.model" : NULL;
}

static const char *soft(const scene *scene)
{
    return scene->boundary_enforcement != SCENE_HARD ? "enforcement.boundary"
           : scene_is_dynamic(scene) && scene->initial_enforcement != SCENE_HARD
               ? "enforcement.initial"
               : NULL;
}

static const char *ranged(const scene *scene)
{
    return scene_is_family(scene) ? "parameters" : NULL;
}

/* What scene_map has made numbers of, or could. */
static const char *ranged_place(const scene *scene)
{
    for (int i = 0; i < scene_field_count; i++) {
        const scene_field *field = &scene_fields[i];
        for (int k = 0; k < scene_known_count(scene) &&
                        (field->rule == SCENE_LENGTH || field->rule == SCENE_PLACE);
             k++) {
            if (quantity_depends_on(*scene_field_of(scene, field), scene->parameters[k].name)) {
                return field->key;
            }
        }
    }
    return scene->rod.growth.is_given && !(scene->feed.to > 0) ? "parameters" : NULL;
}

/* In motion, by a formula of t; or by a parameter, which a drive follows. */
static const char *fed_in_time(const scene *scene)
{
    const bool moves =
        scene->feed.by == SCENE_FED_IN_TIME || quantity_depends_on(scene->rod.inserted, "t");
    return scene_is_dynamic(scene) && moves ? "rod.inserted" : NULL;
}

static const char *fed_by_input(const scene *scene)
{
    bool follows = scene->feed.to > 0 && scene->feed.by >= 0;
    for (int k = 0; k < scene_known_count(scene); k++) {
        follows |= quantity_depends_on(scene->rod.inserted, scene->parameters[k].name);
    }
    return scene_is_dynamic(scene) && scene->rod.feed_time.is_given && follows ? "rod.feed_time"
                                                                               : NULL;
}

static const char *turned_by_input(const scene *scene)
{
    return scene_is_dynamic(scene) && scene->start.turn_time.is_given ? "boundary.start.turn_time"
                                                                      : NULL;
}

static const char *inserted_tubes(const scene *scene)
{
    return scene->rod.inserted.is_given || scene->feed.to > 0 ? has_tubes(scene) : NULL;
}

static const char *mapped_law(const scene *scene)
{
    return ranged_place(scene) ? lawful(scene) : NULL;
}

/* A state of one within another is in no formula. */
static const char *remembers(const scene *scene)
{
    const char *key = NULL;
    for (int k = scene_given_count(scene); k < scene_known_count(scene) && !key; k++) {
        key = depends(scene, scene->parameters[k].name, false);
    }
    return key;
}

static const char *unknown(const scene *scene)
{
    return scene->unknown_count > 0 ? "parameters" : NULL;
}

static const char *never(const scene *scene)
{
    (void)scene;
    return NULL;
}

/* ---- the table ------------------------------------------------------------------------------ */

/* cells: at rest mixed, displacement, pose_strain, family, export; collocation, path; in
 * motion mixed, displacement, pose_strain, strain; nodes, modes; one-step model. y: taken, o:
 * without effect, x: not built, m: impossible. section: where `has` is NULL. */
typedef struct feature_row {
    const char *name, *section;
    const char *(*has)(const scene *x);
    const char *cells, *reason;
} feature_row;

#define OF_STATE                     "yyyyy yy yyyy yy y"
#define OF_MOTION                    "ooooo oo yyyy yy y"
#define OF_LAW(name, section, cells) {name, section, NULL, cells, NULL},

#define OF_A_BEAM   "a beam of small deflection is linear and has no shape in space"
#define OF_STRAINS  "its forces follow from the strains, and a locked strain gives none"
#define OF_SOLUTION "the chosen solution does not say it"
static const char at_rest[] = "a rod at rest does not change in time";
static const char of_steps[] = "a step is the same at any time, and what changes is an input";

/* clang-format off */
static const feature_row features[] = {
    {"a beam of small deflection", NULL, small,
     "yymmm ym yymm ym m", OF_A_BEAM},
    {"a manufactured solution with locked strains", NULL, manufactured_locked,
     "mmmmm mm mmmm mm m", OF_STRAINS},
    {"a manufactured solution with a tendon whose tension is sought", NULL, manufactured_tension,
     "mmmmm mm mmmm mm m", OF_SOLUTION},
    {"a manufactured solution with an imperfection", NULL, manufactured_imperfect,
     "mmmmm mm mmmm mm m", OF_SOLUTION},
    {"a manufactured solution", NULL, manufactured,
     "yyymm yx yyyy yy m", "it is that of one scene, and what has ranges is of many"},
    {"a rod with tubes that is inserted", NULL, inserted_tubes,
     "xxxxx xx xxxx xx x", NULL},
    {"a learned law of a rod whose lengths or places have ranges", NULL, mapped_law,
     "xxxxx xx xxxx xx x", NULL},
    {"concentric tubes", NULL, has_tubes,
     "yxxyy yy xxxx xx x", NULL},
    {"locked shear or stretch", NULL, locked,
     "ymmyy yy ymmy yy y", OF_STRAINS},
    {"a learned law", NULL, lawful,
     "yyyyy yy yyyy yy y", NULL},
    {"friction of a tendon", NULL, rubs,
     "yxxyy yx xxxx xy y", NULL},
    {"friction of a tendon where strains jump", NULL, kinks,
     "xxxxx yx xxxx xy y", NULL},
    {"a tendon that keeps its length", NULL, keeps_length,
     "yxxyy yx xxxx xx x", NULL},
    {"a tendon of given displacement", NULL, elastic,
     "yxxyy yx yxxy yy y", NULL},
    {"a tendon of given tension", "tendons.tension", NULL,
     "yyyyy yy yyyy yy y", NULL},
    {"a chamber", "chambers", NULL,
     "yyyyy yy yyyy yy y", NULL},
    {"a free or loaded start", NULL, open_start,
     "yyyxx yy yyyx yx x", NULL},
    {"a sliding start", NULL, sliding_start,
     "yyyxx yy yyyx yx x", NULL},
    {"a spring or body at a pinned start", NULL, loaded_pin,
     "yxxxx yy yxxx yx x", NULL},
    {"a pinned start", NULL, pinned_start,
     "yyyxx yy yyyy yy y", NULL},
    {"a driven start", NULL, driven_start,
     "yyyyy yy yyyy yy y", NULL},
    {"an end turned by an angle", NULL, turned_end,
     "yyyxx yy yyyx yy x", NULL},
    {"a held end", NULL, held_end,
     "yyyyy yy yyyx yy x", NULL},
    {"a sliding end", NULL, sliding_end,
     "yyyyy yy yyyx yy x", NULL},
    {"a driven end", NULL, driven_end,
     "yyyyy yy yyyx yy x", NULL},
    {"segments", NULL, several,
     "yxxyy yy yxxy yy y", NULL},
    {"a point load", "loads.points", NULL,
     "yxxyy yy yxxy yy y", NULL},
    {"a body", NULL, has_bodies,
     "yxxyy yy yxxy yy y", NULL},
    {"a spring", "springs", NULL,
     "yxxyy yy yxxy yy y", NULL},
    SCENE_LAW_FEATURES(OF_LAW)
    {"a distributed load that follows", NULL, follows_along,
     "yyyyy yy yyyy yy y", NULL},
    {"a load at the tip that follows", NULL, follows_at_tip,
     "yyyyy yy yyyy yy y", NULL},
    {"a tapered rod", NULL, tapered,
     "yyyyy yy yyyy yy y", NULL},
    {"a rest shape", NULL, resting,
     "yyyyy yy yyyy yy y", NULL},
    {"an imperfection", NULL, imperfect,
     "yyyyy yy mmmm mm m", "it goes as the loads of a rod at rest grow"},
    {"damping of the material", NULL, damped,
     "ooooo oo yyyy yy y", NULL},
    {"a material with a Maxwell branch", NULL, branches,
     "ooooo oo xxxx yy y", NULL},
    {"a length or place with a range", NULL, ranged_place,
     "yxxyy yy xxxx yy x", NULL},
    {"a rod that moves through its port by a formula", NULL, fed_in_time,
     "mmmmm mm xxxx xy m", at_rest},
    {"a rod that moves through its port by an input", NULL, fed_by_input,
     "oxxoo oo xxxx yy y", NULL},
    {"a base that an input turns", NULL, turned_by_input,
     "ooooo oo xxxx yy y", NULL},
    {"a rod that shears without rotary inertia", NULL, shears_freely,
     "ooooo oo yyyx xx x", NULL},
    {"a rod without shear and rotary inertia", NULL, turns_freely,
     "ommoo oo ymmy xy y", OF_STRAINS},
    {"a given state at t = 0", NULL, begins,
     "mmmmm mm yyyy yy y", at_rest},
    {"equilibrium at t = 0", NULL, settles,
     "mmmmm mm yyyy yy y", at_rest},
    {"a formula of time", NULL, timed,
     "mmmmm mm yyyy yy m", at_rest},
    {"soft conditions", NULL, soft,
     "yyymm oo yyym oo o", "its shapes meet the conditions exactly"},
    {"a parameter with a range", NULL, ranged,
     "yyyyy yy yyyx yy y", NULL},
    {"a play or lag of an input", NULL, remembers,
     "xxxyx yy xxxx yy y", NULL},
    {"a parameter to be identified", NULL, unknown,
     "yyyxx yy xxxx yy x", NULL},
    {"measured data", "data", never, /* the last: support_check_data */
     "yyyxx yy yyyx yy x", NULL},
};
/* clang-format on */
enum { FEATURES = sizeof features / sizeof features[0] };

int support_feature_count(void)
{
    return FEATURES;
}

const char *support_feature_name(int feature)
{
    return features[feature].name;
}

const char *support_feature_reason(int feature, bool moves)
{
    const char *reason = features[feature].reason;
    return moves && reason == at_rest ? of_steps : reason;
}

int support_feature_find(const char *name)
{
    for (int i = 0; i < FEATURES; i++) {
        if (strcmp(features[i].name, name) == 0) {
            return i;
        }
    }
    return -1;
}

const char *support_key(const scene *rod_scene, int feature)
{
    const feature_row *row = &features[feature];
    return row->has ? row->has(rod_scene) : given(rod_scene, row->section);
}

support_answer support_of(int feature, support_form form)
{
    int left = (int)form;
    for (const char *at = features[feature].cells; *at; at++) {
        if (*at != ' ' && left-- == 0) {
            return *at == 'y'   ? SUPPORT_TAKEN
                   : *at == 'o' ? SUPPORT_WITHOUT_EFFECT
                   : *at == 'm' ? SUPPORT_IMPOSSIBLE
                                : SUPPORT_NOT_BUILT;
        }
    }
    return SUPPORT_NOT_BUILT;
}

/* ---- sentences ------------------------------------------------------------------------------- */

static bool is_refused(int feature, support_form form)
{
    const support_answer answer = support_of(feature, form);
    return answer == SUPPORT_NOT_BUILT || answer == SUPPORT_IMPOSSIBLE;
}

/* Forms at rest or in motion that take a feature, of this kind if there are any: "formulation
 * mixed, displacement"; "": none does. */
static void list_forms(int feature, bool moves, form_kind kind, char *text, size_t size)
{
    bool same = false;
    size_t at = 0;
    text[0] = '\0';
    for (int k = 0; k < SUPPORT_FORMS; k++) {
        same |= forms[k].moves == moves && forms[k].kind == kind &&
                !is_refused(feature, (support_form)k);
    }
    for (int k = 0; k < SUPPORT_FORMS; k++) {
        const bool counts = forms[k].moves == moves && !is_refused(feature, (support_form)k) &&
                            (!same || forms[k].kind == kind);
        const char *subject = forms[k].subject;
        if (counts && at < size) { /* "formulation mixed, displacement" */
            const size_t word = strcspn(subject, " ") + 1;
            const bool again = *text && strncmp(text, subject, word) == 0;
            at += (size_t)snprintf(text + at, size - at, "%s%s", *text ? ", " : "",
                                   again ? subject + word : subject);
        }
    }
}

void support_sentence(int feature, support_form form, char *text, size_t size)
{
    const feature_row *row = &features[feature];
    const char *why = support_of(feature, form) == SUPPORT_IMPOSSIBLE
                          ? support_feature_reason(feature, forms[form].moves)
                          : "it is not built yet";
    char others[400];
    list_forms(feature, forms[form].moves, forms[form].kind, others, sizeof others);
    if (*others) {
        snprintf(text, size, "%s does not take %s: %s; allowed: %s", forms[form].subject, row->name,
                 why, others);
    } else {
        const bool moves = forms[form].moves;
        list_forms(feature, !moves, NETWORK, others, sizeof others);
        snprintf(text, size, "nothing takes %s %s: %s; allowed: a scene without it%s", row->name,
                 moves ? "in motion" : "at rest", why,
                 !*others ? ""
                 : moves  ? ", or without time.duration"
                          : ", or with time.duration");
    }
}

/* ---- checks ------------------------------------------------------------------------------ */

static ad_status refuse(int feature, support_form form, const char *found, const char **key,
                        ad_error *error)
{
    char text[sizeof error->message];
    support_sentence(feature, form, text, sizeof text);
    if (key) {
        *key = found;
    }
    return ad_fail(error, AD_BAD_ARGUMENT, "%s", text);
}

/* A motion in a form for rods at rest, or the other way round. */
static ad_status refuse_time(support_form form, const char **key, ad_error *error)
{
    const bool moves = forms[form].moves;
    if (key) {
        *key = "time.duration";
    }
    return ad_fail(error, AD_BAD_ARGUMENT, "%s is of scenes %s, and this one %s; allowed: %s",
                   forms[form].subject, moves ? "in motion" : "at rest",
                   moves ? "is at rest" : "moves",
                   moves ? "a scene with time.duration" : "a scene without time.duration");
}

ad_status support_check(const scene *rod_scene, support_form form, const char **key,
                        ad_error *error)
{
    if (forms[form].moves != scene_is_dynamic(rod_scene)) {
        return refuse_time(form, key, error);
    }
    for (int i = 0; i < FEATURES; i++) {
        const char *found = is_refused(i, form) ? support_key(rod_scene, i) : NULL;
        if (found) {
            return refuse(i, form, found, key, error);
        }
    }
    return AD_OK;
}

ad_status support_check_data(support_form form, const char **key, ad_error *error)
{
    const int data = FEATURES - 1;
    return is_refused(data, form) ? refuse(data, form, features[data].section, key, error) : AD_OK;
}

ad_status support_check_any(const scene *rod_scene, const char **key, ad_error *error)
{
    const bool moves = scene_is_dynamic(rod_scene);
    for (int i = 0; i < FEATURES; i++) {
        bool refused = true;
        for (int k = 0; k < SUPPORT_FORMS && refused; k++) {
            refused = forms[k].moves != moves || is_refused(i, (support_form)k);
        }
        const char *found = refused ? support_key(rod_scene, i) : NULL;
        if (found) {
            return refuse(i, moves ? SUPPORT_MIXED_MOTION : SUPPORT_MIXED, found, key, error);
        }
    }
    return AD_OK;
}
