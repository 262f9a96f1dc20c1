/* The measured defaults of network, windows, points and stages: they follow from the scene and from
 * one another. */
#include "physics/scene/breaks.h"
#include "tools/train/settings_internal.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

/* Largest frequencies of random features. Along s 8 radians per half length at rest, where fields
 * are smooth and the best fit is wanted, 6 in motion; at rest 4 more than the loads may bend a rod
 * by, if that is more, and 32 at most. In time the third bending frequency of a
 * cantilever, 61.7 EI/(rhoA L^4)^(1/2), which a load hardly excites beyond, and at least 6 radians
 * per half window. All measured on the scenes in configs/: within a factor of two of these the
 * error changes little. */
static const double AT_REST = 8, MARGIN = 4, AT_REST_MOST = 32, IN_MOTION = 6;
static const double THIRD_FREQUENCY = 61.697;

/* Of its first one. */
static const double PERIOD = 1.787;

/* In the longest of several pieces along s at least so many radians per half of it. */
static const double IN_PIECE = 4;

/* Units of L^2 (rhoA/EI)^(1/2) in a window: 1.6 periods of that frequency. Half as many windows
 * with fewer waves take half the time, to errors ten to a hundred times as large. */
static const double WINDOW = 1.0 / 6;

/* Of a scene in which a load acts suddenly at one place: waves with kinks take windows of a
 * quarter, waves twice as short along s, and for both more features. Measured with a step of EI/L^2
 * at the tip, L/radius 20, over 2 units of time: error 1e-5 in place of 1e-4. */
static const double SUDDEN_WINDOW = 1.0 / 24, SUDDEN = 12;

/* What acts at one place and is not sudden, but quick, takes windows of so many times the square of
 * the time in which it rises, from a half down to the same as far as there may be so many, and
 * waves in between: the rod rings with short ones. Measured with tendons and forces that rise in a
 * tenth of a unit of time and are then held: errors a fifth to a fortieth of those in long windows,
 * in twice to thrice the time. */
static const double OF_RISE = 1.8, QUICK = 10;

/* Radians per half length or half window beyond which no number of points resolves a wave. */
static const double LARGEST_BANDWIDTH = 1e5;

/* By how much a step lowers the loss at least while unknowns are found. */
static const double OF_UNKNOWNS = 1e-3;

/* Of a family: along s at rest this part of what one member takes; and features at rest for one
 * parameter, each further one doubles them. Measured as TRAIN_OF_PARAMETER, of 2 to 8 radians along
 * s. */
static const double OF_MEMBER = 0.25;
enum { FAMILY_FEATURES = 120 };

/* The same of motions, radians along parameters and in half the length. Each window multiplies the
 * error of the one before, so that few windows and smooth waves are best. */
static const double OF_PARAMETER_IN_MOTION = 0.5, FAMILY_IN_MOTION = 4;

enum { FEATURES_LEAST = 80, FEATURES_MAX = 256, POINTS_PER_FUNCTION = 4 };

/* ---- blame --------------------------------------------------------------------------------- */

ad_status train_refuse(char key[TRAIN_KEY_MAX], const char *field, ad_error *error,
                       const char *format, ...)
{
    va_list arguments;
    snprintf(key, TRAIN_KEY_MAX, "%s", field);
    va_start(arguments, format);
    ad_status status = ad_fail_list(error, AD_BAD_INPUT, format, arguments);
    va_end(arguments);
    return status;
}

ad_status train_refuse_stage(char key[TRAIN_KEY_MAX], int stage, const char *field, ad_error *error,
                             const char *format, ...)
{
    va_list arguments;
    snprintf(key, TRAIN_KEY_MAX, "training.stages[%d]%s%s", stage, *field ? "." : "", field);
    va_start(arguments, format);
    ad_status status = ad_fail_list(error, AD_BAD_INPUT, format, arguments);
    va_end(arguments);
    return status;
}

/* ---- windows and waves --------------------------------------------------------------------- */

static bool is_open(int value)
{
    return value == TRAIN_OPEN;
}

static bool begins_with_squares(const train_settings *settings)
{
    return optim_method_needs(settings->stages[0].optim.method) == OPTIM_NEEDS_SQUARES;
}

/* How abruptly what drives the rod changes in time. */
typedef struct pace {
    bool sudden;
    double window; /* the longest, in units of L^2 (rhoA/EI)^(1/2) */
    double waves;  /* along s, radians per half length */
} pace;

static ad_status find_pace(const scene *rod_scene, const scene_breaks *breaks, pace *result,
                           ad_error *error)
{
    if (scene_is_sudden(rod_scene, breaks)) {
        *result = (pace){true, SUDDEN_WINDOW, SUDDEN};
        return AD_OK;
    }
    double rise;
    ad_status status = scene_rise_time(rod_scene, &rise, error);
    const double unit = rod_scales_of(rod_scene).time;
    double window = fmax(SUDDEN_WINDOW, OF_RISE * pow(rise / unit, 2));
    window = fmax(window, 2 * scene_duration(rod_scene) / unit / SCENE_WINDOWS_MAX);
    *result =
        window <= WINDOW / 2 ? (pace){false, window, QUICK} : (pace){false, WINDOW, IN_MOTION};
    return status;
}

/* Between jumps in time and its ends, as many as are short enough. */
static double count_windows(const scene *rod_scene, const scene_breaks *breaks, const pace *changes)
{
    double unit = rod_scales_of(rod_scene).time * changes->window, begin = 0;
    double windows = 0;
    for (int i = 0; i <= breaks->count; i++) {
        double end = i < breaks->count ? breaks->place[i] : scene_duration(rod_scene);
        windows += ceil((end - begin) / unit * (1 - 1e-12));
        begin = end;
    }
    return windows;
}

/* Without hidden layers windows are so short that a moderate number of features spans what happens
 * in one. */
static ad_status resolve_windows(train_settings *settings, scene *rod_scene,
                                 const scene_breaks *breaks, const pace *changes, char *key,
                                 ad_error *error)
{
    bool hard = rod_scene->initial_enforcement == SCENE_HARD;
    bool short_ones = settings->network.hidden_count == 0 && scene_is_dynamic(rod_scene) && hard &&
                      !scene_is_fourth_order(rod_scene);
    if (settings->windows == 0 && short_ones) {
        double windows = count_windows(rod_scene, breaks, changes);
        if (!(windows <= SCENE_WINDOWS_MAX)) {
            return train_refuse(
                key, "time.duration", error,
                "would take %.3g windows of 1/%.2g of a period of the first bending mode; "
                "allowed: up to %d, here %.3g s, or longer windows, given by time.windows",
                windows, PERIOD / changes->window, SCENE_WINDOWS_MAX,
                SCENE_WINDOWS_MAX * changes->window * rod_scales_of(rod_scene).time);
        }
        settings->windows = (int)windows;
    }
    settings->windows = settings->windows > 1 ? settings->windows : 1;
    rod_scene->windows = settings->windows;
    return AD_OK;
}

ad_status train_resolve_windows(train_settings *settings, scene *rod_scene, char key[TRAIN_KEY_MAX],
                                ad_error *error)
{
    scene_breaks breaks;
    ad_status status = scene_breaks_of(rod_scene, "t", &breaks, error);
    pace changes;
    status = status == AD_OK ? find_pace(rod_scene, &breaks, &changes, error) : status;
    if (status != AD_OK) {
        return status;
    }
    return resolve_windows(settings, rod_scene, &breaks, &changes, key, error);
}

static ad_status check_bandwidth(const train_settings *settings, bool dynamic, char *key,
                                 ad_error *error)
{
    const double *bandwidth = settings->network.fourier_bandwidth;
    for (int i = 0; i <= dynamic; i++) {
        if (!(bandwidth[i] <= LARGEST_BANDWIDTH)) {
            return train_refuse(
                key, i ? "network.fourier.frequency" : "network.fourier.wavenumber", error,
                "is %.3g radians in half the %s, more than points can resolve; allowed: up to %g",
                bandwidth[i], i ? "window of time" : "length", LARGEST_BANDWIDTH);
        }
    }
    return AD_OK;
}

/* At rest, per half length. A moment M bends by M / EI, a force F by 2 sqrt(F / EI) at most,
 * however the rod lies: half of EI times curvature squared changes along it by no more than F
 * times 2. */
static double bandwidth_at_rest(const scene *rod_scene)
{
    if (scene_is_beam(rod_scene)) {
        return AT_REST; /* which loads bend but do not turn */
    }
    rod_numbers numbers = rod_numbers_of(rod_scene);
    double force = numbers.tip_force + numbers.distributed_force + numbers.weight;
    force += numbers.point_force;
    double moment = numbers.tip_moment + numbers.distributed_moment;
    double turns =
        moment + numbers.point_moment + numbers.actuation + numbers.tubes + 2 * sqrt(force);
    turns += pow(numbers.foundation, 0.25); /* waves of bending on it */
    return fmin(AT_REST_MOST, fmax(AT_REST, MARGIN + turns / 2));
}

/* Of the longest piece along s, the part of the whole. */
static double longest_piece(const domain *d)
{
    double longest = 0;
    for (int i = 0; i < domain_pieces(d); i++) {
        double low, high;
        domain_piece(d, i, &low, &high);
        longest = fmax(longest, high - low);
    }
    return longest;
}

static ad_status resolve_bandwidth(train_settings *settings, const scene *rod_scene,
                                   const domain *d, const pace *changes, char *key, ad_error *error)
{
    double *bandwidth = settings->network.fourier_bandwidth;
    bool dynamic = scene_is_dynamic(rod_scene);
    double half_length = scene_length(rod_scene) / 2 * longest_piece(d);
    double half_time = scene_duration(rod_scene) / rod_scene->windows / 2;
    if (d->divided) {
        half_time = domain_longest_window(d) * d->coordinates[d->time].scale / 2;
    }
    if (!dynamic && !isnan(settings->fourier_frequency)) {
        return train_refuse(key, "network.fourier.frequency", error,
                            "is along time, but the scene is static; give time.duration, or leave "
                            "it out");
    }
    if (isnan(settings->fourier_wavenumber)) {
        double whole = dynamic ? changes->waves : bandwidth_at_rest(rod_scene);
        whole *= scene_is_family(rod_scene) && !dynamic ? OF_MEMBER : 1;
        double piece = fmax(whole * longest_piece(d), fmin(whole, IN_PIECE));
        settings->fourier_wavenumber = piece / half_length;
    }
    bandwidth[0] = settings->fourier_wavenumber * half_length;
    if (dynamic) {
        if (isnan(settings->fourier_frequency)) {
            settings->fourier_frequency =
                fmax(IN_MOTION / half_time, THIRD_FREQUENCY / rod_scales_of(rod_scene).time);
        }
        bandwidth[1] = settings->fourier_frequency * half_time;
    }
    if (!scene_is_family(rod_scene) && !isnan(settings->fourier_parameters)) {
        return train_refuse(
            key, "network.fourier.parameters", error,
            "is along parameters with ranges, but the scene has none; leave it out");
    }
    if (scene_is_family(rod_scene) && isnan(settings->fourier_parameters)) {
        settings->fourier_parameters = dynamic ? OF_PARAMETER_IN_MOTION : TRAIN_OF_PARAMETER;
    }
    for (int i = 1 + dynamic; i < d->count; i++) {
        bandwidth[i] = settings->fourier_parameters;
    }
    return check_bandwidth(settings, dynamic, key, error);
}

/* ---- network ------------------------------------------------------------------------------- */

/* Of a window's motion from where it starts a rotation vector tells more simply than a quaternion.
 * From the unloaded rod a wire of one turn was measured to be too far, so not at rest. */
static void resolve_rotation(train_settings *settings, scene *rod_scene)
{
    bool from_start = scene_is_dynamic(rod_scene) && rod_scene->initial_enforcement == SCENE_HARD;
    if (is_open(settings->rotation)) {
        settings->rotation =
            from_start && settings->network.hidden_count == 0 ? SCENE_VECTOR : SCENE_QUATERNION;
    }
    rod_scene->rotation = (scene_rotation)settings->rotation;
}

/* Twice the bandwidth along s at rest; in motion 1.4 times the product of both, 2 times where kinks
 * run along the rod. */
static int default_features(const train_settings *settings, const scene *rod_scene, bool sudden)
{
    const double *bandwidth = settings->network.fourier_bandwidth;
    double count = scene_is_dynamic(rod_scene)
                       ? fmax(FEATURES_LEAST, (sudden ? 2 : 1.4) * bandwidth[0] * bandwidth[1])
                       : 2 * bandwidth[0];
    if (scene_is_family(rod_scene)) {
        count = scene_is_dynamic(rod_scene)
                    ? FEATURES_MAX
                    : ldexp(FAMILY_FEATURES, scene_known_count(rod_scene) - 1);
    }
    return (int)fmin(FEATURES_MAX, ceil(count - 1e-9));
}

static ad_status resolve_network(train_settings *settings, scene *rod_scene, domain *d, char *key,
                                 ad_error *error)
{
    nn_mlp_settings *network = &settings->network;
    if (is_open(network->hidden_count)) {
        network->hidden_count =
            begins_with_squares(settings) ? 0 : nn_mlp_settings_default().hidden_count;
    }
    if (!is_open(network->degree) && network->degree > 0) {
        return train_refuse(key, "network.polynomial.degree", error,
                            "is of families in the strain form; leave it out");
    }
    network->degree = 0;
    resolve_rotation(settings, rod_scene);
    network->orthonormal = !scene_is_fourth_order(rod_scene);
    scene_breaks breaks;
    ad_status status = scene_breaks_of(rod_scene, "t", &breaks, error);
    pace changes = {false, WINDOW, IN_MOTION};
    if (scene_is_family(rod_scene)) {
        changes.waves = FAMILY_IN_MOTION;
    } else if (status == AD_OK && network->hidden_count == 0 && scene_is_dynamic(rod_scene) &&
               !scene_is_beam(rod_scene)) {
        status = find_pace(rod_scene, &breaks, &changes, error);
    }
    if (status == AD_OK) {
        status = resolve_windows(settings, rod_scene, &breaks, &changes, key, error);
    }
    if (status == AD_OK) {
        status = model_domain_of(rod_scene, d, error);
    }
    if (status == AD_OK) {
        status = resolve_bandwidth(settings, rod_scene, d, &changes, key, error);
    }
    if (status == AD_OK && is_open(network->fourier_features)) {
        network->fourier_features =
            network->hidden_count == 0 ? default_features(settings, rod_scene, changes.sudden) : 0;
    }
    return status;
}

/* ---- points -------------------------------------------------------------------------------- */

/* Tensor grids, one in each piece, take the nearest number of points below that has their shape. */
static ad_status resolve_grid(problem_points *points, int dimension, int pieces, const char *field,
                              char *key, ad_error *error)
{
    size_t actual = 0;
    ad_error reason;
    if (!sampling_kind_is_tensor(points->sampler) || dimension == 0) {
        return AD_OK;
    }
    size_t each = (size_t)((points->points + pieces - 1) / pieces);
    if (sampling_count(points->sampler, dimension, each, &actual, &reason) != AD_OK) {
        return train_refuse(key, field, error, "%s", reason.message);
    }
    points->points = pieces * (int)actual;
    return AD_OK;
}

/* dimension: of all of the domain; faces have one less. */
static ad_status resolve_grids(problem_settings *losses, int dimension, int pieces, char *key,
                               ad_error *error)
{
    int face = dimension - 1, first = face > 0 ? face : 1;
    ad_status status =
        resolve_grid(&losses->interior, dimension, pieces, "losses.interior.points", key, error);
    if (status == AD_OK) {
        status = resolve_grid(&losses->boundary, face, 1, "losses.boundary.points", key, error);
    }
    if (status == AD_OK) {
        status = resolve_grid(&losses->initial, first, pieces, "losses.initial.points", key, error);
    }
    return status;
}

static void resolve_count(int *points, int otherwise)
{
    *points = *points == 0 ? otherwise : *points;
}

static void resolve_points(train_settings *settings, int dimension, int pieces)
{
    bool dynamic = dimension > 1;
    const nn_mlp_settings *network = &settings->network;
    problem_settings *losses = &settings->losses;
    bool linear = network->hidden_count == 0;
    int functions = 1 + 2 * network->fourier_features;
    resolve_count(&losses->interior.points, pieces * (linear    ? POINTS_PER_FUNCTION * functions
                                                      : dynamic ? 1024
                                                                : 256));
    resolve_count(&losses->adaptive.every, begins_with_squares(settings) ? 5 : 100);
    resolve_count(&losses->boundary.points, dynamic ? 64 : 1);
    resolve_count(&losses->held_out_points, pieces * (dynamic ? 1024 : 256));
    if (is_open((int)losses->interior.sampler)) { /* edges are where a linear network goes astray */
        losses->interior.sampler =
            linear ? SAMPLING_CHEBYSHEV_LOBATTO : problem_settings_default().interior.sampler;
    }
}

void train_close_compared(train_settings *settings, const scene *rod_scene)
{
    for (int i = 0; i < settings->data_count; i++) {
        train_data *data = &settings->data[i];
        data->weight = !isnan(data->weight) ? data->weight : data->noise > 0 ? 1e-6 : 1;
    }
    if (settings->reference_tolerance == 0) {
        settings->reference_tolerance = !scene_is_dynamic(rod_scene)     ? 1e-11
                                        : scene_locks_strains(rod_scene) ? 1e-4
                                                                         : 1e-8;
    }
}

/* ---- stages -------------------------------------------------------------------------------- */

/* A linear network starts near where it ends, so with hardly any damping. The functions of its
 * orthonormal basis differ in their derivatives, and so in what J^T J holds of them; in motion,
 * and for beams, damping that follows this was measured to be better by many orders. For rods at
 * rest damping all alike takes fewer steps, and only so do those wound up five times arrive. */
void train_resolve_stage(train_stage *stage, bool diagonal, bool linear)
{
    const optim_settings otherwise = optim_settings_defaults(stage->optim.method);
    optim_settings *optim = &stage->optim;
    train_close_own(stage);
    diagonal = diagonal && linear && stage->linear_algebra != TRAIN_MATRIX_FREE;
    if (isnan(optim->initial_damping)) {
        optim->initial_damping = linear ? 1e-10 : otherwise.initial_damping;
    }
    if (is_open((int)optim->scaling)) {
        optim->scaling = diagonal ? OPTIM_SCALING_DIAGONAL : otherwise.scaling;
    }
    if (optim->decay_steps == 0) {
        int64_t rest = stage->steps - optim->warmup_steps;
        optim->decay_steps = rest > 1 ? rest : 1;
    }
}

static ad_status check_stage_count(const train_settings *settings, char *key, ad_error *error)
{
    if (settings->stage_count >= 1 && settings->stage_count <= TRAIN_STAGES_MAX) {
        return AD_OK;
    }
    return train_refuse(key, "training.stages", error, "has %d stages; allowed: 1 to %d",
                        settings->stage_count, TRAIN_STAGES_MAX);
}

/* What follows from the network. */
static ad_status resolve_training(train_settings *settings, int dimension, int pieces,
                                  bool diagonal, char *key, ad_error *error)
{
    resolve_points(settings, dimension, pieces);
    for (int i = 0; i < settings->stage_count; i++) {
        train_resolve_stage(&settings->stages[i], diagonal, settings->network.hidden_count == 0);
    }
    if (settings->output_every == 0) {
        bool few = begins_with_squares(settings) && settings->windows == 1;
        settings->output_every = few ? 1 : 10; /* and one at the end of every stage */
    }
    return resolve_grids(&settings->losses, dimension, pieces, key, error);
}

/* Grids are for few coordinates; between their lines networks of families go astray. */
static void choose_sampler(train_settings *settings, int coordinates, bool of_family)
{
    if ((of_family || coordinates > SAMPLING_MAX_GRID_DIMENSION) &&
        is_open((int)settings->losses.interior.sampler)) {
        settings->losses.interior.sampler = SAMPLING_SOBOL;
    }
}

ad_status train_settings_resolve(train_settings *settings, scene *rod_scene,
                                 char key[TRAIN_KEY_MAX], ad_error *error)
{
    domain d;
    bool dynamic = scene_is_dynamic(rod_scene);
    ad_status status = check_stage_count(settings, key, error);
    if (status == AD_OK && rod_scene->formulation == SCENE_STRAIN_FORM) {
        return dynamic && !scene_is_family(rod_scene)
                   ? train_resolve_motion(settings, rod_scene, key, error)
                   : train_resolve_family(settings, rod_scene, key, error);
    }
    if (status == AD_OK) {
        train_close_stage(&settings->stages[0], train_usual_stage());
        status = resolve_network(settings, rod_scene, &d, key, error);
    }
    if (status != AD_OK) {
        return status;
    }
    choose_sampler(settings, d.count, scene_is_family(rod_scene));
    for (int i = 0; rod_scene->unknown_count > 0 && i < settings->stage_count; i++) {
        double *least = &settings->stages[i].optim.function_tolerance;
        *least = fmin(*least, OF_UNKNOWNS); /* they come last, slowly */
    }
    if (scene_is_family(rod_scene) && dynamic && settings->network.hidden_count == 0) {
        const int functions = 1 + 2 * settings->network.fourier_features;
        resolve_count(&settings->losses.interior.points,
                      2 * domain_pieces(&d) * POINTS_PER_FUNCTION * functions);
    }
    return resolve_training(settings, d.count, domain_pieces(&d),
                            dynamic || scene_is_beam(rod_scene), key, error);
}

/* ---- physics of one's own ------------------------------------------------------------------ */

/* Waves as for a scene of as many coordinates, per half range. */
static void resolve_waves(train_settings *settings, const domain *d)
{
    nn_mlp_settings *network = &settings->network;
    double usual = d->count == 1 ? AT_REST : IN_MOTION, product = 1;
    for (int i = 0, input = 0; i < d->count; i++) {
        const domain_coordinate *c = &d->coordinates[i];
        double half = (c->high - c->low) * c->scale / 2;
        double given = i == d->time ? settings->fourier_frequency : settings->fourier_wavenumber;
        const double bandwidth = isnan(given) ? usual : given * half;
        /* cos(b sin) has harmonics up to b, of pi b */
        for (int k = 0; k < (c->periodic ? 2 : 1); k++) {
            network->fourier_bandwidth[input++] = c->periodic ? bandwidth / 3 : bandwidth;
        }
        product *= bandwidth;
    }
    if (is_open(network->fourier_features)) {
        double count = d->count == 1 ? 2 * product : fmax(FEATURES_LEAST, 1.4 * product);
        network->fourier_features =
            network->hidden_count == 0 ? (int)fmin(FEATURES_MAX, ceil(count - 1e-9)) : 0;
    }
}

ad_status train_settings_resolve_model(train_settings *settings, const physics_model *m,
                                       char key[TRAIN_KEY_MAX], ad_error *error)
{
    nn_mlp_settings *network = &settings->network;
    ad_status status = check_stage_count(settings, key, error);
    if (status != AD_OK) {
        return status;
    }
    train_close_stage(&settings->stages[0], train_usual_stage());
    if (is_open(network->hidden_count)) {
        network->hidden_count =
            begins_with_squares(settings) ? 0 : nn_mlp_settings_default().hidden_count;
    }
    network->orthonormal = true;
    network->degree = network->degree > 0 ? network->degree : 0;
    settings->rotation = SCENE_QUATERNION; /* there is none */
    settings->windows = 1;
    resolve_waves(settings, &m->domain);
    choose_sampler(settings, m->domain.count, false);
    return resolve_training(settings, m->domain.count, domain_pieces(&m->domain), true, key, error);
}
