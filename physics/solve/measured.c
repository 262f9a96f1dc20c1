#include "physics/solve/measured_trials.h"

#include "physics/numerics/quaternion.h"
#include "physics/numerics/sort.h"
#include "physics/scene/scene_memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { QUATERNION = 4, MEMBERS_BYTES = 64 << 20 /* of the shapes of one batch */ };

void solve_trials_free(solve_trials *trials)
{
    if (trials) {
        solve_members_free(trials->members);
        solve_trials_forget(trials);
        free(trials->place);
        ad_pool_free(trials->pool);
        ad_memory_free(&trials->memory);
        trial_memory_free(trials->inputs);
        free(trials->at);
        free(trials->curvature);
        free(trials);
    }
}

size_t solve_trials_residuals(const solve_trials *trials)
{
    return trials->residuals;
}

size_t solve_trials_experiments(const solve_trials *trials)
{
    return trials->experiments;
}

size_t solve_trials_counted(const solve_trials *trials)
{
    return (trials->experiments + trials->every - 1) / trials->every;
}

double solve_trials_tolerance(const solve_trials *trials)
{
    return trials->tolerance;
}

bool solve_trials_by_members(const solve_trials *trials)
{
    return trials->members != NULL;
}

const char *solve_trials_reason(const solve_trials *trials)
{
    return trials->reason.message;
}

size_t solve_measured_missing(const solve_measured *set)
{
    size_t count = 0;
    for (size_t i = 0; i < set->rows * (size_t)set->columns; i++) {
        count += isnan(set->values[i]) != 0;
    }
    return count;
}

/* ---- rows ---------------------------------------------------------------------------------- */

static int compare_rows(const void *left, const void *right)
{
    const measured_row *a = left, *b = right;
    const int of_a = a->inputs ? a->inputs->number : 0, of_b = b->inputs ? b->inputs->number : 0;
    if (of_a != of_b) {
        return of_a < of_b ? -1 : 1;
    }
    if (a->turn != b->turn) {
        return a->turn < b->turn ? -1 : 1;
    }
    for (int i = 0; i < a->known_count; i++) {
        if (a->known[i] != b->known[i]) {
            return a->known[i] < b->known[i] ? -1 : 1;
        }
    }
    if (a->t != b->t) {
        return a->t < b->t ? -1 : 1;
    }
    return (a->residual > b->residual) - (a->residual < b->residual);
}

static bool starts_quaternion(const scene *open, int column)
{
    const scene_physics *physics = scene_physics_of(open);
    return physics->rotation_columns == QUATERNION && column == physics->position_columns;
}

size_t solve_measured_residuals(const scene *open, const solve_measured *set, size_t row)
{
    size_t count = (size_t)set->columns;
    for (int c = 0; c < set->columns; c++) {
        count -= starts_quaternion(open, set->column[c]) ||
                 isnan(set->values[(size_t)c * set->rows + row]);
    }
    return count;
}

size_t solve_trials_row_residuals(const solve_trials *trials, const measured_row *of)
{
    return solve_measured_residuals(&trials->open, of->set, of->row);
}

size_t solve_trials_thin(solve_trials *trials, size_t every)
{
    size_t count = 0;
    trials->every = every;
    for (size_t i = 0; i < trials->experiments; i += every) {
        for (size_t r = trials->first[i]; r < trials->first[i + 1]; r++) {
            count += solve_trials_row_residuals(trials, &trials->row[r]);
        }
    }
    for (int i = 0; i < trials->unknowns && trials->at; i++) {
        trials->at[i] = NAN;
    }
    return count;
}

static void take_row(solve_trials *trials, const solve_measured *set, const scene_seen *view,
                     size_t row, size_t turn)
{
    const size_t count = (size_t)trials->open.parameter_count;
    double *known = trials->known + trials->rows * count;
    const solve_inputs *inputs = set->inputs ? set->inputs[row] : NULL;
    for (size_t i = 0; i < count; i++) {
        const bool varies = inputs && (inputs->which >> i & 1);
        known[i] = varies || i >= (size_t)scene_known_count(&trials->open)
                       ? 0
                       : set->known[row * count + i];
    }
    trials->row[trials->rows++] =
        (measured_row){.set = set,
                       .view = view,
                       .row = row,
                       .known = known,
                       .known_count = (int)count,
                       .inputs = inputs,
                       .turn = turn,
                       .t = scene_is_dynamic(&trials->open) ? set->t[row] : 0,
                       .residual = trials->residuals};
    trials->residuals += solve_measured_residuals(&trials->open, set, row);
}

/* Rows in the order of experiments, and where each of these begins. */
static ad_status take_rows(solve_trials *trials, int sets, const solve_measured *measured,
                           ad_error *error)
{
    size_t rows = 0;
    for (int i = 0; i < sets; i++) {
        rows += measured[i].rows;
    }
    AD_TAKE(trials, row, rows + 1);
    AD_TAKE(trials, known, rows * (size_t)trials->open.parameter_count + 1);
    AD_TAKE(trials, first, rows + 1);
    AD_TAKE(trials, views, (size_t)sets + 1);
    if (trials->memory.is_short) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu measured rows", rows);
    }
    const ad_status status =
        trial_memory_create(&trials->open, sets, measured, &trials->inputs, error);
    for (int i = 0; i < sets && status == AD_OK; i++) {
        const scene_view *view = measured[i].view;
        if (view) {
            scene_seen_prepare(view, &trials->open, &trials->views[i]);
        }
        for (size_t row = 0; row < measured[i].rows; row++) {
            take_row(trials, &measured[i], view ? &trials->views[i] : NULL, row,
                     trial_memory_turn(trials->inputs, i, row));
        }
    }
    qsort(trials->row, trials->rows, sizeof *trials->row, compare_rows);
    for (size_t i = 0; i < trials->rows; i++) {
        const size_t bytes = (size_t)trials->open.parameter_count * sizeof *trials->known;
        if (i == 0 || trials->row[i].inputs != trials->row[i - 1].inputs ||
            trials->row[i].turn != trials->row[i - 1].turn ||
            memcmp(trials->row[i].known, trials->row[i - 1].known, bytes) != 0) {
            trials->first[trials->experiments++] = i;
        }
    }
    trials->first[trials->experiments] = rows;
    return status;
}

/* ---- members ------------------------------------------------------------------------------- */

void solve_trials_fill(const solve_trials *trials, const double *values, size_t experiment,
                       double *parameters)
{
    const measured_row *row = &trials->row[trials->first[experiment]];
    for (int i = 0; i < trials->open.parameter_count; i++) {
        parameters[i] = row->known[i];
    }
    const double *own = values + (trials->apart ? experiment * (size_t)trials->unknowns : 0);
    for (int i = 0; i < trials->unknowns; i++) {
        parameters[scene_known_count(&trials->open) + i] = own[i];
    }
    if (scene_is_dynamic(&trials->open)) {
        scene_memory_start(&trials->open, &trials->names, parameters, 0, NULL);
    }
    trial_memory_fill(trials->inputs, values, row->turn, parameters);
}

static size_t values_of(const solve_trials *trials)
{
    return (size_t)trials->unknowns * (trials->apart ? trials->experiments : 1);
}

void solve_trials_tell(const solve_trials *trials, size_t *experiment)
{
    for (size_t e = 0; e < trials->experiments; e++) {
        for (size_t r = trials->first[e]; r < trials->first[e + 1]; r++) {
            const measured_row *row = &trials->row[r];
            const size_t count = solve_trials_row_residuals(trials, row);
            for (size_t k = 0; k < count; k++) {
                experiment[row->residual + k] = e;
            }
        }
    }
}

ad_status solve_trials_remember(solve_trials *trials, const double *values, bool slopes,
                                double *parameters, ad_error *error)
{
    const ad_status status = trial_memory_follow(trials->inputs, 1, values, slopes, error);
    for (size_t e = 0; status == AD_OK && e < trials->experiments; e++) {
        solve_trials_fill(trials, values, e, parameters + e * (size_t)trials->open.parameter_count);
    }
    return status;
}

double solve_trials_change(const solve_trials *trials, size_t experiment, int parameter,
                           const double *column)
{
    return trial_memory_change(trials->inputs, trials->row[trials->first[experiment]].turn,
                               (size_t)parameter, column);
}

static ad_status keep_curvature(solve_trials *trials, ad_error *error)
{
    const size_t unknowns = values_of(trials);
    const size_t count = trials->experiments * solve_members_numbers(trials->members);
    trials->at = malloc((unknowns + 1) * sizeof *trials->at);
    trials->curvature = malloc((count + 1) * sizeof *trials->curvature);
    for (size_t i = 0; trials->at && i < unknowns; i++) {
        trials->at[i] = NAN;
    }
    return trials->at && trials->curvature
               ? AD_OK
               : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu members", trials->experiments);
}

ad_status solve_trials_apart(solve_trials *trials, ad_error *error)
{
    trials->apart = true;
    free(trials->at);
    free(trials->curvature);
    trials->at = trials->curvature = NULL;
    return trials->members ? keep_curvature(trials, error) : AD_OK;
}

/* Places where something was measured, and which of them each row has. */
static ad_status find_places(solve_trials *trials, ad_error *error)
{
    double *s = trials->place = malloc((trials->rows + 1) * sizeof *s);
    if (!s) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu measured rows", trials->rows);
    }
    for (size_t i = 0; i < trials->rows; i++) {
        s[i] = trials->row[i].set->s[trials->row[i].row];
    }
    sort_ascending(trials->rows, s);
    for (size_t i = 0; i < trials->rows; i++) {
        if (i == 0 || s[i] > s[trials->places - 1]) {
            s[trials->places++] = s[i];
        }
    }
    for (size_t i = 0; i < trials->rows; i++) {
        const double *place = bsearch(&trials->row[i].set->s[trials->row[i].row], s, trials->places,
                                      sizeof *s, sort_compare);
        trials->row[i].place = (size_t)(place - s);
    }
    return AD_OK;
}

/* What members do not take is solved one by one, which says what is wrong with it, if anything. */
static ad_status create_members(solve_trials *trials, int threads, ad_error *error)
{
    const solve_members_settings settings = {.tolerance = trials->tolerance,
                                             .threads = threads,
                                             .points = trials->places,
                                             .s = trials->place,
                                             .own_curvature = true};
    const ad_status status =
        solve_members_create(&trials->open, &settings, &trials->members, error);
    return status == AD_NO_MEMORY ? status
           : trials->members      ? keep_curvature(trials, error)
                                  : AD_OK;
}

/* ---- making -------------------------------------------------------------------------------- */

static double choose_tolerance(const solve_trials *trials, int sets, const solve_measured *measured,
                               double asked)
{
    static const double AT_REST = 1e-8, PART_OF_NOISE = 0.1, LEAST = 1e-12;
    scene middle;
    scene_middle(&trials->open, &middle);
    double tolerance = asked > 0                   ? asked
                       : scene_is_dynamic(&middle) ? solve_settings_default(&middle).tolerance
                                                   : AT_REST;
    for (int i = 0; i < sets && !scene_is_beam(&trials->open); i++) {
        for (int c = 0; c < measured[i].columns; c++) {
            if (measured[i].column[c] < scene_physics_of(&trials->open)->position_columns) {
                tolerance =
                    fmin(tolerance, PART_OF_NOISE * measured[i].noise[c] / scene_length(&middle));
            }
        }
    }
    return fmax(tolerance, LEAST);
}

ad_status solve_trials_create(const scene *open, int sets, const solve_measured *measured,
                              double tolerance, int threads, solve_trials **result, ad_error *error)
{
    const scene_physics *physics = scene_physics_of(open);
    *result = NULL;
    solve_trials *trials = calloc(1, sizeof *trials);
    if (!trials) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for trials");
    }
    trials->open = *open;
    if (open->memory_count > 0) {
        trials->names = scene_values_of(open);
    }
    trials->unknowns = open->unknown_count;
    trials->every = 1;
    for (int i = 0; i < sets; i++) {
        const int last = measured[i].column[measured[i].columns - 1];
        const int needed = measured[i].view && last < physics->position_columns
                               ? physics->position_columns + physics->rotation_columns
                               : last + 1;
        trials->columns = needed > trials->columns ? needed : trials->columns;
    }
    ad_status status = ad_pool_open(threads, &trials->pool, error);
    status = status == AD_OK ? take_rows(trials, sets, measured, error) : status;
    if (status == AD_OK) {
        trials->tolerance = choose_tolerance(trials, sets, measured, tolerance);
    }
    if (status == AD_OK && scene_is_dynamic(open) && !scene_is_beam(open)) {
        AD_TAKE(trials, nodes, trials->experiments);
        status = trials->nodes ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for nodes");
    }
    if (status == AD_OK) {
        solve_trials_find_modes(trials);
    }
    status = status == AD_OK ? find_places(trials, error) : status;
    status = status == AD_OK ? solve_trials_record(trials, 0, error) : status;
    if (status == AD_OK && !scene_is_beam(open) && trials->columns <= SOLVE_MEMBERS_COLUMNS) {
        status = create_members(trials, threads, error);
    }
    if (status != AD_OK) {
        solve_trials_free(trials);
        return status;
    }
    *result = trials;
    return AD_OK;
}

/* ---- residuals ----------------------------------------------------------------------------- */

/* The rotation vector of p* q, of the shorter way round; q need not be unit. */
static void rotation_between(const double p[4], const double q[4], double vector[3])
{
    double turn[4];
    quaternion_quotient(p, q, turn);
    const double size = sqrt(vector_dot(turn + 1, turn + 1)), sign = turn[0] < 0 ? -1 : 1;
    const double factor = size > 0 ? 2 * atan2(size, fabs(turn[0])) / size : 2 / fabs(turn[0]);
    for (int i = 0; i < 3; i++) {
        vector[i] = sign * factor * turn[1 + i];
    }
}

/* What is compared: columns of the model, or as they are seen. */
static double seen(const measured_row *of, const double *computed, size_t stride,
                   const double pose[3 + QUATERNION], int column)
{
    return of->view && of->view->moves && column < 3 + QUATERNION
               ? pose[column]
               : computed[(size_t)column * stride];
}

void solve_trials_compare(const solve_trials *trials, const measured_row *of,
                          const double *parameters, const double *computed, size_t stride,
                          double *residuals)
{
    const solve_measured *set = of->set;
    const double root = set->weight ? sqrt(set->weight[of->row]) : 1;
    double pose[3 + QUATERNION];
    for (int i = 0; i < 3 + QUATERNION && of->view && of->view->moves; i++) {
        pose[i] = computed[(size_t)i * stride];
    }
    if (of->view && of->view->moves) {
        quaternion_normalize(pose + 3);
        scene_seen_take(of->view, set->s[of->row], of->t, parameters, pose, pose + 3);
    }
    for (int c = 0; c < set->columns; c++) {
        const double *measured = set->values + (size_t)c * set->rows + of->row;
        if (starts_quaternion(&trials->open, set->column[c])) {
            double p[4], q[4], vector[3];
            for (int i = 0; i < QUATERNION; i++) {
                p[i] = measured[(size_t)i * set->rows];
                q[i] = seen(of, computed, stride, pose, set->column[c] + i);
            }
            rotation_between(p, q, vector);
            for (int i = 0; i < 3; i++) {
                *residuals++ = root * vector[i] / set->noise[c];
            }
            c += QUATERNION - 1;
        } else if (!isnan(*measured)) {
            *residuals++ = root * (seen(of, computed, stride, pose, set->column[c]) - *measured) /
                           set->noise[c];
        }
    }
}

/* ---- one by one ---------------------------------------------------------------------------- */

double solve_trials_time(const solve_trials *trials, const measured_row *row,
                         const double *parameters)
{
    const double t =
        row->view ? scene_seen_time(row->view, row->set->s[row->row], row->t, parameters) : row->t;
    return fmin(scene_duration(&trials->open), fmax(0, t));
}

static ad_status evaluate(const solve_trials *trials, size_t experiment, const double *parameters,
                          const solution *solved, double *residuals, ad_error *error)
{
    const size_t first = trials->first[experiment], rows = trials->first[experiment + 1] - first;
    double *s = malloc((2 + (size_t)trials->columns) * rows * sizeof *s);
    if (!s) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu measured rows", rows);
    }
    double *t = s + rows, *values = t + rows;
    for (size_t i = 0; i < rows; i++) {
        s[i] = trials->row[first + i].set->s[trials->row[first + i].row];
        t[i] = solve_trials_time(trials, &trials->row[first + i], parameters);
    }
    ad_status status = solution_evaluate(solved, trials->columns, rows, s, t, values, error);
    for (size_t i = 0; status == AD_OK && i < rows; i++) {
        solve_trials_compare(trials, &trials->row[first + i], parameters, values + i, rows,
                             residuals + trials->row[first + i].residual);
    }
    free(s);
    return status;
}

static ad_status check(const scene *member, ad_error *error)
{
    const char *key = "";
    ad_error reason;
    ad_status status = scene_check(member, &key, &reason);
    status = status == AD_OK ? scene_physics_of(member)->check(member, &key, &reason) : status;
    return status == AD_OK ? AD_OK : ad_fail(error, status, "%s: %s", key, reason.message);
}

enum { ROUGH_NODES = 24 };

static ad_status solve_one(solve_trials *trials, size_t experiment, int thread,
                           const double *values, double *residuals, ad_error *error)
{
    const size_t first = trials->first[experiment], rows = trials->first[experiment + 1] - first;
    double parameters[SCENE_PARAMETERS_MAX];
    scene member;
    solution *solved = NULL;
    solve_report report;
    solve_trials_fill(trials, values, experiment, parameters);
    if (trials->row[first].inputs) {
        return solve_trials_follow(trials, experiment, thread, parameters, residuals, error);
    }
    double *times = malloc(rows * sizeof *times);
    scene_member(&trials->open, parameters, &member);
    for (size_t i = 0; times && i < rows; i++) {
        times[i] = solve_trials_time(trials, &trials->row[first + i], parameters);
    }
    ad_status status =
        times ? check(&member, error) : ad_fail(error, AD_NO_MEMORY, "out of memory for times");
    if (status == AD_OK) {
        status = solve_settle(&member, member.names, error);
    }
    if (status == AD_OK) {
        solve_settings settings = solve_settings_default(&member);
        settings.tolerance = trials->tolerance;
        settings.method = trials->moves ? SOLVE_MODES : SOLVE_COLLOCATION;
        if (trials->moves) {
            solve_trials_choose_modes(trials, experiment, &settings);
        } else if (trials->nodes && trials->nodes[experiment] > 0) {
            settings.nodes = (int)trials->nodes[experiment];
            settings.tolerance *= trials->rough ? 1 : TRIALS_STEPS;
        } else if (trials->rough && !scene_is_beam(&member)) {
            settings.nodes = ROUGH_NODES;
        }
        status = solution_create(&member, &settings, scene_is_dynamic(&member) ? rows : 0, times,
                                 &solved, &report, error);
    }
    if (status == AD_OK && !scene_is_dynamic(&member) && report.load_fraction < 1) {
        status =
            ad_fail(error, AD_NOT_FINITE, "equilibria can be followed to %.3g of the load only",
                    report.load_fraction);
    }
    if (status == AD_OK) {
        status = evaluate(trials, experiment, parameters, solved, residuals, error);
    }
    if (status == AD_OK && trials->chooses && trials->nodes[experiment] == 0) {
        trials->nodes[experiment] =
            trials->moves ? solve_trials_packed(report.modes) : report.nodes;
    }
    solution_free(solved);
    free(times);
    return status;
}

static void run_job(void *context, int item, int thread)
{
    const trial_batch *b = context;
    solve_trials *trials = b->x;
    const size_t trial = b->job[item] / trials->experiments,
                 experiment = b->job[item] % trials->experiments;
    b->status[item] =
        solve_one(trials, experiment, thread, b->values + trial * (size_t)trials->unknowns,
                  b->residuals + trial * trials->residuals, &b->error[item]);
}

ad_status solve_trials_jobs(trial_batch *b, ad_error *error)
{
    b->status = malloc((b->count + 1) * sizeof *b->status);
    b->error = malloc((b->count + 1) * sizeof *b->error);
    ad_status status = b->status && b->error
                           ? AD_OK
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu trials", b->count);
    if (status == AD_OK) {
        ad_pool_run(b->x->pool, (int)b->count, run_job, b);
    }
    for (size_t i = 0; status == AD_OK && i < b->count; i++) {
        if (b->status[i] == AD_NO_MEMORY || b->status[i] == AD_BAD_ARGUMENT) {
            status = ad_fail(error, b->status[i], "%s", b->error[i].message);
        } else if (b->status[i] != AD_OK && b->x->reason.status == AD_OK) {
            b->x->reason = b->error[i];
        }
    }
    free(b->status);
    free(b->error);
    return status;
}

/* ---- batches ------------------------------------------------------------------------------- */

/* Some trials by members; what they do not solve is left to the jobs. */
static ad_status run_members(trial_batch *b, size_t first, size_t trials, double *room,
                             ad_error *error)
{
    solve_trials *of = b->x;
    const size_t each = solve_trials_counted(of), count = trials * each;
    const size_t width = (size_t)of->open.parameter_count;
    const size_t shape = of->places * SOLVE_MEMBERS_COLUMNS;
    double *parameters = room, *shapes = parameters + count * width;
    solve_member *results = malloc(count * sizeof *results);
    if (!results) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu members", count);
    }
    for (size_t i = 0; i < count; i++) {
        solve_trials_fill(of, b->values + (first + i / each) * (size_t)of->unknowns,
                          i % each * of->every, parameters + i * width);
    }
    ad_status status =
        solve_members_curvature(of->members, count, parameters, shapes,
                                b->trials == 1 ? of->curvature : NULL, results, error);
    for (size_t i = 0; status == AD_OK && i < count; i++) {
        const size_t trial = first + i / each, experiment = i % each * of->every;
        if (!results[i].solved && of->rough) {
            continue;
        }
        if (!results[i].solved) {
            b->job[b->count++] = trial * of->experiments + experiment;
            continue;
        }
        for (size_t r = of->first[experiment]; r < of->first[experiment + 1]; r++) {
            const measured_row *row = &of->row[r];
            solve_trials_compare(of, row, parameters + i * width,
                                 shapes + i * shape + row->place * SOLVE_MEMBERS_COLUMNS, 1,
                                 b->residuals + trial * of->residuals + row->residual);
        }
    }
    free(results);
    return status;
}

static ad_status run_all_members(trial_batch *b, size_t count, ad_error *error)
{
    solve_trials *trials = b->x;
    const size_t each = solve_trials_counted(trials) * ((size_t)trials->open.parameter_count +
                                                        trials->places * SOLVE_MEMBERS_COLUMNS);
    size_t most = MEMBERS_BYTES / (each * sizeof(double));
    most = most < 1 ? 1 : most > count ? count : most;
    double *room = malloc(most * each * sizeof *room);
    ad_status status = room ? AD_OK
                            : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu members",
                                      most * trials->experiments);
    for (size_t first = 0; status == AD_OK && first < count; first += most) {
        status = run_members(b, first, count - first < most ? count - first : most, room, error);
    }
    free(room);
    return status;
}

double *solve_trials_nodes(const solve_trials *trials)
{
    return trials->nodes;
}

void solve_trials_clear(const solve_trials *trials, size_t experiment, double *residuals)
{
    for (size_t r = trials->first[experiment]; r < trials->first[experiment + 1]; r++) {
        const size_t count = solve_trials_row_residuals(trials, &trials->row[r]);
        for (size_t k = 0; k < count; k++) {
            residuals[trials->row[r].residual + k] = experiment % trials->every == 0 ? NAN : 0;
        }
    }
}

ad_status solve_trials_run(solve_trials *trials, size_t count, const double *values, bool rough,
                           double *residuals, ad_error *error)
{
    trial_batch batch = {.x = trials, .values = values, .trials = count, .residuals = residuals};
    batch.job = malloc((count * trials->experiments + 1) * sizeof *batch.job);
    if (!batch.job) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu trials", count);
    }
    for (size_t i = 0; i < count * trials->experiments; i++) {
        solve_trials_clear(trials, i % trials->experiments,
                           residuals + i / trials->experiments * trials->residuals);
    }
    trials->reason = (ad_error){.message = ""};
    trials->chooses = trials->nodes && count == 1;
    trials->rough = rough;
    ad_status status = trial_memory_follow(trials->inputs, count, values, false, error);
    if (status == AD_OK && trials->members) {
        status = run_all_members(&batch, count, error);
        if (status == AD_OK && count == 1) {
            memcpy(trials->at, values, values_of(trials) * sizeof *values);
        }
    } else {
        for (size_t i = 0; status == AD_OK && i < count * trials->experiments; i++) {
            if (i % trials->experiments % trials->every == 0) {
                batch.job[batch.count++] = i;
            }
        }
    }
    status = status == AD_OK && batch.count > 0 ? solve_trials_jobs(&batch, error) : status;
    free(batch.job);
    return status;
}
