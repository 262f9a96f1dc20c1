#include "tools/train/measured_poses.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum {
    SHAPES_MAX = 4000,
    SHAPE_ROWS = 60000,
    POINTS_MIN = 15,
    POINTS_MAX = 61,
    MARKERS_MAX = 64,
    PLACE = 3
};

typedef struct posing {
    const scene *open;
    const measurements *data;
    const train_settings *settings;
    const double *values;
    const solve_measured *sets;
    int count;
    size_t *first; /* [count] rows before a set */
    measured_poses *to;
    double place[MARKERS_MAX][4]; /* of markers: s and three offsets, m */
    int *set_of;                  /* [poses] where a pose is first */
    size_t *row_of;
    uint64_t *has; /* [poses] a bit for each marker */
    ad_memory memory;
} posing;

void measured_poses_free(measured_poses *poses)
{
    if (poses) {
        ad_memory_free(&poses->memory);
        free(poses);
    }
}

void measured_row_parameters(const scene *open, const solve_measured *set, size_t row,
                             const double *values, double *parameters)
{
    const size_t count = (size_t)open->parameter_count;
    memcpy(parameters, set->known + row * count, count * sizeof *parameters);
    for (int i = 0; i < open->unknown_count; i++) {
        parameters[scene_known_count(open) + i] = values[i];
    }
}

/* ---- markers ------------------------------------------------------------------------------- */

static size_t find_marker(posing *p, const double place[4])
{
    size_t k = 0;
    while (k < p->to->markers && memcmp(p->place[k], place, sizeof p->place[k]) != 0) {
        k++;
    }
    if (k == p->to->markers && k < MARKERS_MAX) {
        memcpy(p->place[p->to->markers++], place, sizeof p->place[k]);
    }
    return k;
}

static void find_markers(posing *p)
{
    double parameters[SCENE_PARAMETERS_MAX];
    bool any = true;
    for (int set = 0; set < p->count && any; set++) {
        const solve_measured *of = &p->sets[set];
        scene_seen seen;
        if (of->view) {
            scene_seen_prepare(of->view, p->open, &seen);
        }
        for (size_t row = 0; row < of->rows && any; row++) {
            double place[4] = {of->s[row]};
            if (of->view) {
                measured_row_parameters(p->open, of, row, p->values, parameters);
                scene_seen_marker(&seen, of->s[row], of->t[row], parameters, place + 1);
            }
            const size_t found = find_marker(p, place);
            any = found < MARKERS_MAX;
            p->to->marker[p->first[set] + row] = found + 1;
        }
    }
    if (!any) { /* not told apart */
        memset(p->to->marker, 0, p->to->rows * sizeof *p->to->marker);
        p->to->markers = 0;
    }
}

/* ---- poses --------------------------------------------------------------------------------- */

static bool is_same(const posing *p, const solve_measured *a, size_t i, const solve_measured *b,
                    size_t k)
{
    const size_t count = (size_t)p->open->parameter_count;
    return (a->inputs ? a->inputs[i] : NULL) == (b->inputs ? b->inputs[k] : NULL) &&
           a->t[i] == b->t[k] &&
           memcmp(a->known + i * count, b->known + k * count, count * sizeof *a->known) == 0;
}

/* A row of a set with the same place in its file. False: there is none. */
static bool find_beside(const solve_measured *set, size_t at, size_t *row)
{
    size_t low = 0, high = set->rows;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if (set->at[middle] < at) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    *row = low;
    return low < set->rows && set->at[low] == at;
}

static bool is_beside(const posing *p, int set, int other)
{
    const train_data *a = &p->settings->data[measurements_entry(p->data, set)];
    const train_data *b = &p->settings->data[measurements_entry(p->data, other)];
    return strcmp(a->file, b->file) == 0 && a->held_out == b->held_out;
}

/* Whether a pose that a row may belong to has its marker already. */
static bool has_marker(const posing *p, size_t pose, size_t marker)
{
    return marker > 0 && (p->has[pose] >> (marker - 1) & 1);
}

/* The pose of a row among those that there are; their number: it is a new one. */
static size_t find_pose(const posing *p, int set, size_t row)
{
    const solve_measured *of = &p->sets[set];
    const size_t at = p->first[set] + row, marker = p->to->marker[at];
    const size_t *pose = p->to->pose;
    if (row > 0 && is_same(p, of, row, of, row - 1) && of->s[row] != of->s[row - 1] &&
        !has_marker(p, pose[at - 1], marker)) {
        return pose[at - 1];
    }
    for (int other = 0; other < set && marker > 0; other++) {
        size_t k;
        if (is_beside(p, set, other) && find_beside(&p->sets[other], of->at[row], &k) &&
            is_same(p, of, row, &p->sets[other], k) &&
            !has_marker(p, pose[p->first[other] + k], marker)) {
            return pose[p->first[other] + k];
        }
    }
    return p->to->count;
}

static void find_poses(posing *p)
{
    for (int set = 0; set < p->count; set++) {
        for (size_t row = 0; row < p->sets[set].rows; row++) {
            const size_t at = p->first[set] + row, pose = find_pose(p, set, row);
            if (pose == p->to->count) {
                p->set_of[pose] = set;
                p->row_of[pose] = row;
                p->has[pose] = 0;
                p->to->count++;
            }
            p->to->pose[at] = pose;
            p->has[pose] |= p->to->marker[at] > 0 ? (uint64_t)1 << (p->to->marker[at] - 1) : 0;
        }
    }
}

/* ---- shapes -------------------------------------------------------------------------------- */

/* What all made-up sets borrow, [shapes points] of each. */
static double *times_of(const measured_poses *to)
{
    return to->numbers + to->shapes * to->points;
}

static double *known_of(const measured_poses *to)
{
    return times_of(to) + to->shapes * to->points;
}

static ad_status make_room(measured_poses *to, size_t parameters, int sets, ad_error *error)
{
    const size_t rows = to->shapes * to->points;
    AD_TAKE(to, shape, to->shapes + 1);
    AD_TAKE(to, set, (size_t)sets + 1);
    AD_TAKE(to, late, (size_t)sets + 1);
    AD_TAKE(to, numbers, rows * (2 + parameters + PLACE) + 1);
    AD_TAKE(to, at, rows + 1);
    AD_TAKE(to, inputs, rows + 1);
    return ad_memory_status(&to->memory, error, "out of memory for %zu poses", to->count);
}

/* Points of a pose, from the row `row` of what is borrowed on. */
static void put_points(const posing *p, size_t pose, size_t row)
{
    const measured_poses *to = p->to;
    const solve_measured *from = &p->sets[p->set_of[pose]];
    const size_t count = (size_t)p->open->parameter_count, of = p->row_of[pose];
    for (size_t k = 0; k < to->points; k++, row++) {
        to->numbers[row] = scene_length(p->open) * (double)k / (double)(to->points - 1);
        times_of(to)[row] = from->t[of];
        memcpy(known_of(to) + row * count, from->known + of * count, count * sizeof *from->known);
        to->at[row] = from->at[of];
        to->inputs[row] = from->inputs ? from->inputs[of] : NULL;
    }
}

/* A set without rows, from the row `row` of what is borrowed on. Since 0 was measured, its
 * residuals are what is computed. */
static void open_set(const posing *p, int source, size_t row)
{
    measured_poses *to = p->to;
    const solve_measured *from = &p->sets[source];
    const size_t rows = to->shapes * to->points, count = (size_t)p->open->parameter_count;
    solve_measured *set = &to->set[to->sets];
    *set = (solve_measured){.s = to->numbers + row,
                            .t = times_of(to) + row,
                            .known = known_of(to) + row * count,
                            .columns = scene_physics_of(p->open)->position_columns,
                            .values = known_of(to) + rows * count,
                            .inputs = to->inputs + row,
                            .commands = from->commands,
                            .command = from->command,
                            .at = to->at + row};
    for (int c = 0; c < set->columns; c++) {
        set->column[c] = c;
        set->noise[c] = 1;
    }
    if (from->view && from->view->delay.is_given) {
        to->late[to->sets].delay = from->view->delay;
        set->view = &to->late[to->sets];
    }
    to->sets++;
}

static ad_status make_shapes(posing *p, ad_error *error)
{
    measured_poses *to = p->to;
    int source = -1;
    to->every = (to->count + SHAPES_MAX - 1) / SHAPES_MAX;
    to->shapes = (to->count + to->every - 1) / to->every;
    to->points = SHAPE_ROWS / to->shapes;
    to->points = to->points < POINTS_MIN   ? POINTS_MIN
                 : to->points > POINTS_MAX ? POINTS_MAX
                                           : to->points;
    const ad_status status = make_room(to, (size_t)p->open->parameter_count, p->count, error);
    for (size_t k = 0; k < to->shapes && status == AD_OK; k++) {
        const size_t pose = to->shape[k] = k * to->every;
        if (p->set_of[pose] != source) {
            source = p->set_of[pose];
            open_set(p, source, k * to->points);
        }
        put_points(p, pose, k * to->points);
        to->set[to->sets - 1].rows += to->points;
    }
    return status;
}

ad_status measured_poses_create(const scene *open, const measurements *data,
                                const train_settings *settings, const double *values,
                                measured_poses **result, ad_error *error)
{
    posing p = {.open = open,
                .data = data,
                .settings = settings,
                .values = values,
                .sets = measurements_sets(data),
                .count = measurements_count(data) + measurements_held_out(data)};
    *result = p.to = calloc(1, sizeof *p.to);
    if (p.to && AD_TAKE(&p, first, p.count)) {
        for (int i = 0; i < p.count; i++) {
            p.first[i] = p.to->rows;
            p.to->rows += p.sets[i].rows;
        }
        AD_TAKE(p.to, pose, p.to->rows);
        AD_TAKE(p.to, marker, p.to->rows);
        AD_TAKE(&p, set_of, p.to->rows);
        AD_TAKE(&p, row_of, p.to->rows);
        AD_TAKE(&p, has, p.to->rows);
    }
    const bool has_memory = p.to && !p.to->memory.is_short && !p.memory.is_short;
    ad_status status = has_memory ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for poses");
    if (status == AD_OK) {
        find_markers(&p);
        find_poses(&p);
        status = make_shapes(&p, error);
    }
    ad_memory_free(&p.memory);
    if (status != AD_OK) {
        measured_poses_free(p.to);
        *result = NULL;
    }
    return status;
}
