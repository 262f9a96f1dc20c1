/* The dimensionless numbers that the equations of a rod are given. */
#include "physics/learn/groups_internal.h"
#include "physics/numerics/constants.h"
#include "physics/scene/breaks.h"
#include "physics/scene/scene_field.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double ZEROS[4] = {0, 0, 0, 0}; /* of a rotation */

/* Of the length: over which the slope of an actuator's offset is taken. */
static const double STEP = 1e-5;

/* ---- where they are looked at ---------------------------------------------------------------- */

/* Some within every piece between breaks, not at equal distances, between which what winds around
 * the rod might look straight. False: there are too many pieces. */
static bool find_places(group_source *source, const scene_breaks *breaks)
{
    const double length = scene_length(&source->middle);
    const int pieces = breaks->count + 1;
    const int each = pieces == 1 ? 5 : pieces <= 5 ? 3 : pieces <= 8 ? 2 : 1;
    if (breaks->unresolved || pieces * each > GROUP_PLACES_MAX) {
        return false;
    }
    for (int i = 0; i < pieces * each; i++) {
        const int piece = i / each;
        const double from = piece > 0 ? breaks->place[piece - 1] / length : 0;
        const double to = piece + 1 < pieces ? breaks->place[piece] / length : 1;
        const double x = 0.5 - 0.5 * cos(PI * (i % each + 0.5) / each);
        source->place[source->places++] = from + (to - from) * x;
    }
    return true;
}

static bool is_turnable(const scene *given)
{
    return given->start.type == SCENE_CLAMPED && !scene_end_is_placed(given->end.type) &&
           !scene_is_dynamic(given) && given->tube_count == 0 &&
           !rod_has_law_at_places(given, law_depends_on_shape) &&
           !rod_has_law_along(given, law_depends_on_shape) && !scene_has_displaced_tendons(given) &&
           !scene_has_rubbing_tendons(given) &&
           (!given->rod.law || given->rod.law->symmetry == SCENE_SYMMETRY_ROUND);
}

ad_status group_source_fill(const scene *family, bool by_parameters, group_source *source,
                            ad_error *error)
{
    *source = (group_source){.open = *family, .times = 1};
    source->by_parameters = by_parameters || scene_is_beam(family) || scene_is_manufactured(family);
    source->open.motion = SCENE_SPATIAL; /* everything in the frame of the world */
    for (int i = 0; i < family->parameter_count; i++) {
        source->names[i] = family->parameters[i].name;
    }
    if (source->by_parameters) {
        return AD_OK;
    }
    scene_middle(&source->open, &source->middle);
    source->numbers = rod_numbers_of(&source->middle);
    if (scene_is_dynamic(family)) {
        source->times = GROUP_TIMES_MAX;
        for (int i = 0; i < source->times; i++) {
            source->time[i] = source->numbers.duration * (i + 0.5) / source->times;
        }
    }
    source->turnable = is_turnable(family);
    scene_breaks breaks;
    const ad_status status = scene_breaks_of(&source->middle, "s", &breaks, error);
    source->by_parameters = status == AD_OK && !find_places(source, &breaks);
    return status;
}

/* ---- recording ------------------------------------------------------------------------------- */

/* At one place and time. */
typedef struct recorder {
    const group_source *source;
    rod_context rod;
    ad_value softness; /* EI of the middle by that of the member, by which loads are counted */
    ad_value upright;
    group_list *list;
    double s, t; /* m, s; NaN: not of a place */
} recorder;

static group_item *add(recorder *recorder, const char *name, const char *unit, group_kind kind,
                       double effect, ad_value value)
{
    group_list *list = recorder->list;
    if (list->count == list->capacity) {
        const int capacity = 2 * list->capacity + 64;
        group_item *more = realloc(list->items, (size_t)capacity * sizeof *more);
        if (!more) {
            ad_tape_fail(recorder->rod.tape, AD_NO_MEMORY, "out of memory for groups");
            return NULL;
        }
        list->items = more;
        list->capacity = capacity;
    }
    group_item *item = &list->items[list->count++];
    *item = (group_item){.unit = unit,
                         .s = recorder->s,
                         .t = recorder->t,
                         .kind = kind,
                         .rows = ad_rows(value),
                         .effect = {effect, effect, effect},
                         .value = value};
    snprintf(item->name, sizeof item->name, "%s", name);
    return item;
}

/* Loads by the member's own stiffness. */
static void add_load(recorder *recorder, const char *name, const char *unit, group_kind kind,
                     double effect, ad_value value, bool is_body)
{
    ad_value turned = is_body ? value : ad_rotate_inverse(recorder->upright, value);
    add(recorder, name, unit, kind, effect, ad_mul(recorder->softness, turned));
}

static ad_value quantities_of(const recorder *recorder, int count, const quantity *q, double factor)
{
    return rod_quantities(&recorder->rod, count, q, ZEROS, factor, recorder->rod.s,
                          recorder->rod.t);
}

/* What laws along the rod are given, those that resist the motion or the others. */
static void add_laws(recorder *recorder, bool resist)
{
    const rod_given *given;
    for (int left = rod_givens(&given); left > 0; left--, given++) {
        if (!given->term || resist != (given->formula != NULL)) {
            continue;
        }
        const quantity *q = rod_given_of(given, &recorder->source->open);
        ad_value row[5];
        for (int i = 0; i < given->count; i++) {
            row[i] =
                quantities_of(recorder, 1, q + i, rod_given_scale(given, i, &recorder->rod.scales));
        }
        const ad_value all = ad_stack(given->count, row);
        add(recorder, given->term, resist || given->is_factor ? "" : "EI/L^4", GROUP_SCALAR,
            resist ? 0.5 : 0.05, given->is_factor ? all : ad_mul(recorder->softness, all));
    }
}

static void add_matter(recorder *recorder, const rod_coefficients *c)
{
    const scene_rest rest = scene_rest_of(&recorder->source->open);
    const rod_scales *scale = &recorder->rod.scales;
    ad_value stiffness = ad_reciprocal(recorder->softness);
    add(recorder, "strain at rest", "", GROUP_POLAR, 0.5, c->rest_strain);
    add(recorder, "curvature at rest", "1/L", GROUP_AXIAL, 0.5, c->rest_curvature);
    add(recorder, "imperfection", "1/L", GROUP_AXIAL, 0.01,
        quantities_of(recorder, 3, rest.imperfection, scale->length));
    group_item *bent = add(recorder, "compliance of bending and twist", "1/EI", GROUP_TENSOR, 0.5,
                           ad_mul(stiffness, c->curvature_compliance));
    if (bent) {
        bent->effect[2] = 0.1;
    }
    add(recorder, "compliance of shear and stretch", "L^2/EI", GROUP_TENSOR, 3,
        ad_mul(stiffness, c->strain_compliance));
}

static void add_line_loads(recorder *recorder)
{
    const scene_loads *given = &recorder->source->open.loads;
    const rod_scales *scale = &recorder->rod.scales;
    const bool follows = given->frame == SCENE_FOLLOWER;
    add_load(recorder, "weight", "EI/L^3", GROUP_POLAR, 0.125, rod_weight(&recorder->rod), false);
    add_load(recorder, "distributed force", "EI/L^3", GROUP_POLAR, 0.125,
             quantities_of(recorder, 3, given->force, scale->length / scale->force), follows);
    add_load(recorder, "distributed moment", "EI/L^2", GROUP_AXIAL, 0.3,
             quantities_of(recorder, 3, given->moment, scale->length / scale->moment), follows);
    add_laws(recorder, false);
}

/* In motion; times by that of the middle. */
static void add_motion(recorder *recorder, const rod_coefficients *c)
{
    const scene *open = &recorder->source->open;
    const scene_properties made = scene_properties_of(open);
    const rod_scales *scale = &recorder->rod.scales;
    const double speed = scale->length / scale->time;
    const ad_value mass =
        quantities_of(recorder, 1, &made.mass_per_length, speed * speed / scale->force);
    const struct {
        const char *name;
        double effect;
        ad_value value;
    } rows[] = {{"mass", 0.5, mass},
                {"rotary inertia", 0.5, c->rotary_inertia},
                {"damping of strain", 1e-3, c->strain_damping},
                {"damping of curvature", 0.5, c->curvature_damping}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        add(recorder, rows[i].name, "", GROUP_SCALAR, rows[i].effect,
            ad_mul(recorder->softness, rows[i].value));
    }
    add_laws(recorder, true);
    add(recorder, "position at t = 0", "L", GROUP_SCALAR, 1,
        quantities_of(recorder, 3, open->initial.position, 1 / scale->length));
    add(recorder, "rotation at t = 0", "", GROUP_SCALAR, 1,
        quantities_of(recorder, 4, open->initial.rotation, 1));
    add(recorder, "velocity at t = 0", "", GROUP_SCALAR, 0.5,
        quantities_of(recorder, 3, open->initial.velocity, 1 / speed));
    add(recorder, "spin at t = 0", "", GROUP_SCALAR, 0.5,
        quantities_of(recorder, 3, open->initial.angular_velocity, scale->time));
}

/* ---- actuators, tubes ------------------------------------------------------------------------ */

static ad_value offset_at(const recorder *recorder, const quantity offset[2], double step)
{
    const ad_value s = ad_add(recorder->rod.s, ad_scalar(recorder->rod.tape, step));
    return ad_pad(rod_quantities(&recorder->rod, 2, offset, ZEROS, 1 / recorder->rod.scales.length,
                                 s, recorder->rod.t),
                  0, 3);
}

/* What actuators do in the unstressed section: force, moment, and the torque per twist that pulls
 * at a distance from the axis take to be turned. */
typedef struct pulling {
    ad_value force, moment, twist;
} pulling;

/* What a tendon does depends on the strains, so that each is an item by itself, too. */
static void add_tendon(recorder *recorder, int index, ad_value pull, ad_value offset)
{
    char name[GROUP_NAME];
    snprintf(name, sizeof name, "tension of tendons[%d]", index);
    group_item *item = add(recorder, name, "EI/L^2", GROUP_PULL, 1e-6, pull);
    if (item) {
        item->tendon = index;
    }
    snprintf(name, sizeof name, "offset of tendons[%d]", index);
    item = add(recorder, name, "L", GROUP_OFFSET, 1, offset);
    if (item) {
        item->tendon = index;
    }
}

static void add_actuator(recorder *recorder, const rod_coefficients *c, int index, pulling *sum)
{
    const scene_actuator given = scene_actuator_of(&recorder->source->open, index);
    if (recorder->s < given.from || recorder->s > given.to) {
        return;
    }
    const quantity acts = scene_actuator_pull(&given);
    const ad_value r = offset_at(recorder, given.offset, 0);
    const ad_value apart =
        ad_sub(offset_at(recorder, given.offset, STEP), offset_at(recorder, given.offset, -STEP));
    const ad_value pull = ad_mul(recorder->softness,
                                 quantities_of(recorder, 1, &acts, 1 / recorder->rod.scales.force));
    const rod_actuator one = {
        .offset = r, .slope = ad_scale(apart, 0.5 / STEP), .law = rod_actuator_law(&given)};
    const rod_wrench wrench =
        rod_actuator_wrench(&recorder->rod, &one, pull, c->rest_strain, c->rest_curvature, NULL);
    sum->force = ad_add(sum->force, wrench.force);
    sum->moment = ad_add(sum->moment, wrench.moment);
    if (given.tendon) {
        sum->twist = ad_add(sum->twist, ad_mul(pull, ad_dot(r, r)));
        add_tendon(recorder, index, pull, r);
    }
}

static void add_actuation(recorder *recorder, const rod_coefficients *c)
{
    ad_value none = ad_zeros(recorder->rod.tape, 3);
    pulling sum = {none, none, ad_zeros(recorder->rod.tape, 1)};
    const rod_numbers *numbers = &recorder->source->numbers;
    const scene *open = &recorder->source->open;
    for (int i = 0; i < scene_actuator_count(open); i++) {
        add_actuator(recorder, c, i, &sum);
    }
    if (scene_actuator_count(open) > 0) {
        add(recorder, GROUP_MOMENT, "EI/L", GROUP_AXIAL, 0.5, sum.moment);
        group_item *force = add(recorder, "force of actuators", "EI/L^2", GROUP_POLAR,
                                1 / numbers->shear_ratio, sum.force);
        if (force) {
            force->effect[2] = 1 / numbers->axial_ratio;
        }
        add(recorder, GROUP_RESISTANCE, "EI", GROUP_SCALAR,
            0.5 / fmax(numbers->torsion_ratio, 1e-3), sum.twist);
    }
}

/* What tendons have besides; of tubes. */
static void add_displaced(recorder *recorder)
{
    const scene *open = &recorder->source->open;
    const rod_scales *scale = &recorder->rod.scales;
    for (int i = 0; i < open->tendon_count; i++) {
        const scene_tendon *tendon = &open->tendons[i];
        const double lever = rod_tendon_arm(&recorder->source->middle, i);
        add(recorder, "displacement of a tendon", "L", GROUP_SCALAR, 0.5 / lever,
            quantities_of(recorder, 1, &tendon->displacement, 1 / scale->length));
        add(recorder, "stiffness of a tendon", "EI/L^3", GROUP_SCALAR, 0.01,
            ad_mul(recorder->softness,
                   quantities_of(recorder, 1, &tendon->stiffness, scale->length / scale->force)));
        add(recorder, "friction of a tendon", "", GROUP_SCALAR, 1,
            quantities_of(recorder, 1, &tendon->friction, 1));
    }
}

static void add_tubes(recorder *recorder)
{
    const scene *open = &recorder->source->open;
    for (int i = 0; i < open->tube_count; i++) {
        const rod_tube tube = rod_tube_of(&recorder->rod, i);
        add(recorder, "stiffness of a tube", "EI", GROUP_SCALAR, 0.3,
            ad_mul(recorder->softness, tube.bending));
        add(recorder, "softness of a tube", "1/EI", GROUP_SCALAR, 0.1,
            ad_mul(ad_reciprocal(recorder->softness), tube.softness));
        add(recorder, "curvature of a tube", "1/L", GROUP_SCALAR, 0.5, tube.rest);
        add(recorder, "angle of a tube", "", GROUP_SCALAR, 0.5, tube.turned);
        add(recorder, "straight part behind a tube", "L", GROUP_SCALAR, 0.5, tube.transmission);
    }
}

/* ---- at single places ------------------------------------------------------------------------ */

static void add_end(recorder *recorder, int end)
{
    const scene_end *given = end ? &recorder->source->open.end : &recorder->source->open.start;
    const scene_load *load =
        end ? &recorder->source->open.loads.tip : &recorder->source->open.loads.base;
    const rod_scales *scale = &recorder->rod.scales;
    const bool follows = load->frame == SCENE_FOLLOWER;
    if (scene_end_takes_force(given->type)) {
        add_load(recorder, end ? "tip force" : "force at s = 0", "EI/L^2", GROUP_POLAR, 1.0 / 3,
                 quantities_of(recorder, 3, load->force, 1 / scale->force), follows);
        add_load(recorder, end ? "tip moment" : "moment at s = 0", "EI/L", GROUP_AXIAL, 0.5,
                 quantities_of(recorder, 3, load->moment, 1 / scale->moment), follows);
    }
    if (scene_end_is_placed(given->type) && !recorder->source->turnable) {
        const char *const name = end ? "end" : "start";
        add(recorder, name, "L", GROUP_SCALAR, 1,
            quantities_of(recorder, 3, given->position, 1 / scale->length));
        add(recorder, name, "", GROUP_SCALAR, 1, quantities_of(recorder, 4, given->rotation, 1));
        add(recorder, name, "", GROUP_SCALAR, 1,
            quantities_of(recorder, 3, given->rotation_vector, 1));
        add(recorder, name, "", GROUP_SCALAR, 0.2, quantities_of(recorder, 1, &given->twist, 1));
    }
}

static void add_places(recorder *recorder)
{
    const scene *open = &recorder->source->open;
    const rod_scales *scale = &recorder->rod.scales;
    for (int i = 0; i < open->point_count; i++) {
        const scene_load *load = &open->points[i].load;
        const double a = open->points[i].at.number / scale->length;
        const bool follows = load->frame == SCENE_FOLLOWER;
        recorder->s = open->points[i].at.number;
        add_load(recorder, "point force", "EI/L^2", GROUP_POLAR, a * a * (3 - a) / 6,
                 quantities_of(recorder, 3, load->force, 1 / scale->force), follows);
        add_load(recorder, "point moment", "EI/L", GROUP_AXIAL, a - a * a / 2,
                 quantities_of(recorder, 3, load->moment, 1 / scale->moment), follows);
    }
    for (int i = 0; i < open->body_count; i++) {
        const double a = open->bodies[i].at.number / scale->length;
        recorder->s = open->bodies[i].at.number;
        add_load(recorder, "weight of a body", "EI/L^2", GROUP_POLAR, a * a * (3 - a) / 6,
                 ad_mul(quantities_of(recorder, 1, &open->bodies[i].mass, 1 / scale->force),
                        quantities_of(recorder, 3, open->loads.gravity, 1)),
                 false);
        add(recorder, "offset of a body", "L", GROUP_SCALAR, 0.05,
            quantities_of(recorder, 3, open->bodies[i].offset, 1 / scale->length));
        add(recorder, "magnetic moment of a body", "", GROUP_SCALAR, 0.05,
            quantities_of(recorder, 3, open->bodies[i].magnetic_moment, 1 / scale->length));
    }
    for (int i = 0; i < open->spring_count; i++) {
        const scene_spring *spring = &open->springs[i];
        recorder->s = spring->at.number;
        add(recorder, "spring", "EI/L^3", GROUP_SCALAR, 0.1,
            ad_mul(recorder->softness,
                   quantities_of(recorder, 3, spring->stiffness, scale->length / scale->force)));
        add(recorder, "spring", "EI/L", GROUP_SCALAR, 0.1,
            ad_mul(recorder->softness,
                   quantities_of(recorder, 3, spring->turning, 1 / scale->moment)));
        add(recorder, "anchor of a spring", "L", GROUP_SCALAR, 0.5,
            quantities_of(recorder, 3, spring->anchor, 1 / scale->length));
    }
    for (int i = 1; i < open->segment_count; i++) { /* of numbers: a symmetry has to leave it */
        recorder->s = scene_joint(open, i - 1);
        add(recorder, "turn of a segment", "", GROUP_AXIAL, 1,
            quantities_of(recorder, 3, open->segments[i].turn, 1));
    }
    recorder->s = NAN;
}

/* ---- all ------------------------------------------------------------------------------------- */

/* A tape at a place, with parameters. */
static void begin(recorder *recorder, double s, double t, const quantity_binding *bindings)
{
    const group_source *source = recorder->source;
    ad_tape *tape = bindings->value.tape;
    const domain_place at = rod_place(&source->middle, ad_scalar(tape, s), ad_scalar(tape, t));
    recorder->rod = rod_context_of(&source->middle, &at);
    recorder->rod.scene = &source->open;
    recorder->rod.properties = scene_properties_of(&source->open);
    recorder->rod.parameter_count = source->open.parameter_count;
    memcpy(recorder->rod.parameters, bindings,
           (size_t)recorder->rod.parameter_count * sizeof *bindings);
    recorder->s = s * recorder->rod.scales.length;
    recorder->t = recorder->rod.dynamic ? t * recorder->rod.scales.time : NAN;
}

/* The middle's EI by the member's, the mean of both directions and all places. */
static ad_value record_softness(recorder *recorder, const quantity_binding *bindings)
{
    ad_value sum = ad_scalar(bindings->value.tape, 0);
    for (int i = 0; i < recorder->source->places; i++) {
        begin(recorder, recorder->source->place[i], 0, bindings);
        const ad_value k = rod_coefficients_of(&recorder->rod).curvature_stiffness;
        sum = ad_add(sum, ad_add(ad_row(k, 0), ad_row(k, 1)));
    }
    return ad_scale(ad_reciprocal(sum), 2.0 * recorder->source->places);
}

/* The frame in which loads are counted: the world, or that of the base, whatever turns it. */
static ad_value record_upright(const recorder *recorder)
{
    static const double none[4] = {1, 0, 0, 0};
    const quantity *q = recorder->source->open.start.rotation;
    return recorder->source->turnable
               ? ad_normalize(rod_quantities(&recorder->rod, 4, q, none, 1, recorder->rod.s,
                                             recorder->rod.t))
               : ad_constant(recorder->rod.tape, 4, none);
}

/* How a formula has it together with s, so that some places do not say all of it: not; as what a
 * turn may change, a vector or what pulls; or else. */
static group_kind kind_along(const scene *open, const char *name, bool *is_along)
{
    group_kind kind = GROUP_SCALAR;
    *is_along = false;
    for (int i = 0; i < scene_field_count; i++) {
        const scene_field *field = &scene_fields[i];
        const quantity *q = scene_field_of(open, field);
        const bool turns = field->geometry == SCENE_POLAR_VECTOR ||
                           field->geometry == SCENE_AXIAL_VECTOR ||
                           (field->part == SCENE_OF_LISTS && field->geometry == SCENE_SCALAR);
        for (int k = 0; k < field->count; k++) {
            if (quantity_depends_on(q[k], name) && quantity_depends_on(q[k], "s")) {
                *is_along = true;
                kind = turns ? GROUP_PARAMETER : kind;
            }
        }
    }
    return kind;
}

static void add_parameters(recorder *recorder, ad_value parameters)
{
    const scene *open = &recorder->source->open;
    for (int i = 0; i < open->parameter_count; i++) {
        const scene_parameter *p = &open->parameters[i];
        bool is_needed;
        const group_kind kind = kind_along(open, p->name, &is_needed);
        const double effect = is_needed || recorder->source->by_parameters ? GROUP_UNKNOWN : 0;
        group_item *item = add(recorder, p->name, "", kind, 2 * effect / (p->high - p->low),
                               ad_row(parameters, i));
        if (item) {
            item->as_it_is = true;
            item->is_log = p->scale == SCENE_LOG;
        }
    }
}

void group_items(const group_source *source, ad_value parameters, group_list *list)
{
    quantity_binding bindings[SCENE_PARAMETERS_MAX];
    recorder x = {.source = source, .list = list};
    for (int i = 0; i < source->open.parameter_count; i++) {
        bindings[i] = (quantity_binding){source->names[i], ad_row(parameters, i)};
    }
    *list = (group_list){.count = 0};
    x.s = x.t = NAN;
    x.rod.tape = parameters.tape;
    add_parameters(&x, parameters);
    if (source->by_parameters) {
        return;
    }
    begin(&x, 0, 0, bindings);
    x.upright = record_upright(&x);
    x.softness = record_softness(&x, bindings);
    for (int j = 0; j < source->times; j++) {
        for (int i = 0; i < source->places; i++) {
            begin(&x, source->place[i], source->time[j], bindings);
            const rod_coefficients c = rod_coefficients_of(&x.rod);
            add_matter(&x, &c);
            add_line_loads(&x);
            add_actuation(&x, &c);
            add_tubes(&x);
            if (x.rod.dynamic) {
                add_motion(&x, &c);
            }
        }
        x.s = NAN;
        add_end(&x, 0);
        add_end(&x, 1);
        add_displaced(&x);
        add_places(&x);
    }
}
