#include "tools/train/measurements.h"

#include "physics/check/plausible.h"
#include "tools/files/table_file.h"
#include "tools/train/identify.h"
#include "tools/train/measured_columns.h"
#include "tools/train/recorded_inputs.h"
#include "tools/train/reference.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct measurements {
    int count, held_out; /* to be fitted, of which sets come first; the others */
    solve_measured set[TRAIN_DATA_MAX];
    int entry[TRAIN_DATA_MAX];                   /* of the settings' list, of a set */
    double *numbers[TRAIN_DATA_MAX];             /* all of a set */
    const solve_inputs **inputs[TRAIN_DATA_MAX]; /* of its rows; NULL: none */
    recorded_inputs *recorded;
    int beside; /* as of measurements_read_beside, while files are read */
    const char *const *names;
    size_t *at[TRAIN_DATA_MAX]; /* the same */
    size_t missing;
    bool tells_noise;
};

/* A file being read, and its columns as the scene calls them. */
typedef struct reading {
    const scene *open;
    const train_data *data;
    const table_file *table;
    measured_columns *columns;
    const double *s, *t, *known[SCENE_PARAMETERS_MAX];
    const double *values[MODEL_COLUMNS_MAX]; /* of the quantity */
    const double *where;                     /* NULL: all rows */
    const solve_inputs **inputs;             /* [rows of the file], then of the set; or NULL */
    const measurements *of;
    char *key; /* to blame */
} reading;

int measurements_count(const measurements *measurements)
{
    return measurements->count;
}

int measurements_held_out(const measurements *measurements)
{
    return measurements->held_out;
}

int measurements_entry(const measurements *measurements, int set)
{
    return measurements->entry[set];
}

size_t measurements_missing(const measurements *measurements)
{
    return measurements->missing;
}

bool measurements_tell_noise(const measurements *measurements)
{
    return measurements->tells_noise;
}

const solve_measured *measurements_sets(const measurements *measurements)
{
    return measurements->set;
}

void measurements_set_modes(measurements *measurements, const int modes[4])
{
    for (int i = 0; i < measurements->count + measurements->held_out; i++) {
        memcpy(measurements->set[i].modes, modes, sizeof measurements->set[i].modes);
    }
}

ad_status measurements_take_squares(const train_settings *settings, char key[TRAIN_KEY_MAX],
                                    ad_error *error)
{
    for (int i = 0; i < settings->data_count; i++) {
        if (settings->data[i].robust != TRAIN_SQUARES) {
            snprintf(key, TRAIN_KEY_MAX, "data[%d].robust", i);
            return ad_fail(error, AD_BAD_INPUT,
                           "is of cpinn-solve; allowed here: squares, as what is far off is not "
                           "left out");
        }
    }
    return AD_OK;
}

void measurements_free(measurements *measurements)
{
    for (int i = 0; measurements && i < measurements->count + measurements->held_out; i++) {
        free(measurements->numbers[i]);
        free(measurements->inputs[i]);
        free(measurements->at[i]);
    }
    recorded_inputs_free(measurements ? measurements->recorded : NULL);
    free(measurements);
}

/* ---- columns ------------------------------------------------------------------------------- */

/* The columns of each quantity: of rods the first, of beams the second name on. */
static const struct {
    const char *rod, *beam;
    int rod_columns;
} columns_of[TRAIN_QUANTITY_COUNT] = {
    [TRAIN_POSITION] = {"x", "w", 3},    [TRAIN_ROTATION] = {"qw", "slope", 4},
    [TRAIN_STRAIN] = {"v1", NULL, 3},    [TRAIN_CURVATURE] = {"u1", NULL, 3},
    [TRAIN_FORCE] = {"n1", "V", 3},      [TRAIN_MOMENT] = {"m1", "M", 3},
    [TRAIN_VELOCITY] = {"vx", "w_t", 3}, [TRAIN_ANGULAR_VELOCITY] = {"w1", "slope_t", 3}};

/* The columns of a quantity among those of the scene's model; false: this scene has none. */
static bool columns(const scene *rod_scene, train_quantity quantity, int *first, int *count)
{
    const scene_physics *physics = scene_physics_of(rod_scene);
    const bool beam = scene_is_beam(rod_scene);
    const char *name = beam ? columns_of[quantity].beam : columns_of[quantity].rod;
    *count = beam ? 1 : columns_of[quantity].rod_columns;
    for (int i = 0; name && i < physics->column_count; i++) {
        if (strcmp(physics->columns[i].name, name) == 0 &&
            (scene_is_dynamic(rod_scene) || !physics->columns[i].of_motion)) {
            *first = i;
            return true;
        }
    }
    return false;
}

/* A column that has to be there; what it is stands in `what`. */
static ad_status need(const reading *r, const char *name, const char *what, const double **values,
                      ad_error *error)
{
    const bool is_formula = measured_columns_say(r->columns, name);
    ad_error reason;
    const ad_status status = measured_columns_find(r->columns, name, values, &reason);
    if (status == AD_OK && *values) {
        return AD_OK;
    }
    if (is_formula) {
        snprintf(strrchr(r->key, '.'), 9, ".columns");
    }
    return status == AD_OK ? ad_fail(error, AD_BAD_INPUT, "%s: column '%s' is missing; %s",
                                     r->data->file, name, what)
                           : ad_fail(error, status, "%s", reason.message);
}

/* Names that say what nothing asks for. */
static ad_status check_names(const reading *r, const solve_measured *set, ad_error *error)
{
    const char *known[SCENE_PARAMETERS_MAX + MODEL_COLUMNS_MAX + 2] = {"s", "t"};
    char allowed[400] = "s";
    int count = scene_is_dynamic(r->open) ? 2 : 1;
    for (int c = 0; c < set->columns; c++) {
        known[count++] = scene_physics_of(r->open)->columns[set->column[c]].name;
    }
    for (int i = 0; i < scene_given_count(r->open); i++) {
        known[count++] = r->open->parameters[i].name;
    }
    const char *stray = measured_columns_stray(r->columns, count, known);
    for (int i = 1; stray && i < count; i++) {
        const size_t used = strlen(allowed);
        snprintf(allowed + used, sizeof allowed - used, ", %s", known[i]);
    }
    if (stray) {
        snprintf(strrchr(r->key, '.'), 9, ".columns");
    }
    return stray ? ad_fail(error, AD_BAD_INPUT, "'%s' is nothing that is needed; allowed: %s",
                           stray, allowed)
                 : AD_OK;
}

/* Whether a file may leave out a known value, and does. */
static bool may_miss(const reading *r, const char *name)
{
    bool may = false;
    for (int i = 0; i < r->of->beside; i++) {
        may = may || strcmp(r->of->names[i], name) == 0;
    }
    return may && !measured_columns_have(r->columns, name);
}

static ad_status find_columns(reading *r, const solve_measured *set, ad_error *error)
{
    const scene *open = r->open;
    if (table_rows(r->table) == 0) {
        return ad_fail(error, AD_BAD_INPUT, "%s: there are no rows; at least one is needed",
                       r->data->file);
    }
    ad_status status = check_names(r, set, error);
    const bool is_tip = open->place.is_given && !measured_columns_have(r->columns, "s") &&
                        !measured_columns_say(r->columns, "s");
    if (status == AD_OK && !is_tip) {
        status = need(r, "s", "the place along the rod in m", &r->s, error);
    }
    if (status == AD_OK && scene_is_dynamic(open) &&
        (!(r->data->rate > 0) || measured_columns_say(r->columns, "t"))) {
        status = need(r, "t", "the time in s; or give its rate in Hz", &r->t, error);
    }
    for (int i = 0; i < scene_given_count(open) && status == AD_OK; i++) {
        const char *name = open->parameters[i].name;
        status = may_miss(r, name)
                     ? AD_OK
                     : need(r, name,
                            "a parameter with a range that is not to be found has a value in each "
                            "row",
                            &r->known[i], error);
    }
    for (int c = 0; c < set->columns && status == AD_OK; c++) {
        const char *name = scene_physics_of(open)->columns[set->column[c]].name;
        status = need(r, name, "of a quantity all columns are needed", &r->values[c], error);
    }
    if (status == AD_OK && r->data->where) {
        status = measured_columns_compute(r->columns, r->data->where, &r->where, error);
        if (status != AD_OK) {
            snprintf(strrchr(r->key, '.'), 12, ".rows.where");
        }
    }
    for (int i = scene_known_count(open); i < open->parameter_count && status == AD_OK; i++) {
        if (!r->data->columns && measured_columns_have(r->columns, open->parameters[i].name)) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s: column '%s' is a parameter that is to be found; leave it out, or "
                           "take `identify` away in the scene",
                           r->data->file, open->parameters[i].name);
        }
    }
    return status;
}

/* Positions in mm, of which chi squared would say nothing. */
static ad_status check_positions(const reading *r, const solve_measured *set, ad_error *error)
{
    char text[SCENE_WARNING_TEXT];
    const double *values[MODEL_COLUMNS_MAX];
    bool implausible;
    for (int c = 0; c < set->columns; c++) {
        values[c] = set->values + (size_t)c * set->rows;
    }
    if (scene_positions_implausible(r->open, set->rows, values, &implausible, text) != AD_OK) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu measured rows", set->rows);
    }
    const char *hint = implausible && strstr(text, "not in mm")
                           ? "; columns: {x: x/1000, y: y/1000, z: z/1000} reads mm"
                           : "";
    return implausible ? ad_fail(error, AD_BAD_INPUT, "%s: %s%s", r->data->file, text, hint)
                       : AD_OK;
}

/* ---- rows ---------------------------------------------------------------------------------- */

/* Whether a row of the file counts. Rows are counted by the first index. */
static bool is_chosen(const reading *r, size_t row)
{
    const size_t number = row / table_inner(r->table) + 1, from = (size_t)r->data->from;
    return number >= from && (r->data->to == 0 || number <= (size_t)r->data->to) &&
           (number - from) % (size_t)r->data->every == 0 && (!r->where || r->where[row] > 0);
}

static ad_status check_number(const reading *r, size_t row, const char *name, double value,
                              double low, double high, ad_error *error)
{
    const size_t line = table_line(r->table, row);
    const double slack = REFERENCE_END_TOLERANCE * (high - low); /* files hold rounded numbers */
    char place[32];
    if (value >= low - slack && value <= high + slack) {
        return AD_OK;
    }
    snprintf(place, sizeof place, line ? "%zu" : " row %zu", line ? line : row + 1);
    if (isnan(value)) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%s:%s: column '%s' has no number; allowed there: a number in each row",
                       r->data->file, place, name);
    }
    return ad_fail(error, AD_BAD_INPUT, "%s:%s: %s is %g; allowed: %g to %g", r->data->file, place,
                   name, value, low, high);
}

/* A quaternion is unit to a few digits, as it was written. */
static ad_status check_rotation(const reading *r, size_t row, ad_error *error)
{
    double square = 0;
    for (int c = 0; c < 4; c++) {
        square += pow(r->values[c][row], 2);
    }
    return check_number(r, row, "the length of qw to qz", sqrt(square), 0.999, 1.001, error);
}

/* Of a row, numbers of the quantity that count: of a quaternion all four do, or none. */
static int count_numbers(const reading *r, const solve_measured *set, size_t row)
{
    int count = 0;
    for (int c = 0; c < set->columns; c++) {
        count += isfinite(r->values[c][row]) != 0;
    }
    return set->columns == 4 && count < 4 ? 0 : count;
}

/* The s of a place on the rod as it is written. */
static ad_status find_place(const reading *r, size_t row, const double *known, double *s,
                            ad_error *error)
{
    const scene *open = r->open;
    double values[SCENE_PARAMETERS_MAX];
    for (int k = 0; k < open->parameter_count; k++) {
        values[k] = k < scene_known_count(open) ? known[k] : open->guess[k];
    }
    *s = scene_s_of_place(open, values, r->s[row], 0);
    return isfinite(*s)
               ? AD_OK
               : ad_fail(error, AD_BAD_INPUT,
                         "%s: s = %g m is not on the rod, or goes with what is to be found; "
                         "allowed: places on a part of it that stays, and no column s for the tip",
                         r->data->file, r->s[row]);
}

/* s, t and known values of a row, which has to be within the scene whether it counts or not. */
static ad_status take_row(const reading *r, size_t row, double *s, double *t, double *known,
                          ad_error *error)
{
    const scene *open = r->open;
    const double length = scene_length(open), duration = scene_duration(open);
    const bool maps = open->place.is_given;
    ad_status status = maps ? AD_OK : check_number(r, row, "s", r->s[row], 0, length, error);
    *s = maps ? length : fmin(length, fmax(0, r->s[row]));
    *t = 0;
    if (status == AD_OK && scene_is_dynamic(open)) {
        const double at = r->t ? r->t[row] : (double)(row / table_inner(r->table)) / r->data->rate;
        *t = fmin(duration, fmax(0, at));
        double late = 0;
        status = check_number(r, row, "t", at, 0, duration, error);
        if (status == AD_OK && quantity_is_number(r->data->view.delay, &late)) {
            status = check_number(r, row, "t - delay", at - late, -late, duration, error);
        }
    }
    for (int k = 0; k < open->parameter_count && status == AD_OK; k++) {
        const scene_parameter *p = &open->parameters[k];
        const bool is_known = k < scene_given_count(open);
        known[k] = !is_known ? 0 : r->known[k] ? r->known[k][row] : NAN;
        status = is_known && r->known[k]
                     ? check_number(r, row, p->name, known[k], p->low, p->high, error)
                     : AD_OK;
    }
    return status == AD_OK && maps && r->s ? find_place(r, row, known, s, error) : status;
}

/* What was commanded in each row of the file, chosen or not, in its order; where that is not known,
 * as before. */
static void take_commands(const reading *r, double *command)
{
    const size_t count = (size_t)r->open->parameter_count;
    memset(command, 0, table_rows(r->table) * count * sizeof *command);
    for (size_t i = 0; i < table_rows(r->table); i++) {
        for (size_t k = 0; k < (size_t)scene_given_count(r->open); k++) {
            const double now = r->known[k] ? r->known[k][i] : NAN,
                         before = i > 0 ? command[(i - 1) * count + k] : 0;
            command[i * count + k] = isfinite(now) ? now : before;
        }
    }
}

/* numbers: s, t, known values of the rows that have a number, then their measured columns, then
 * the commands of all rows, of which these are those at [rows]. */
static ad_status take_rows(const reading *r, solve_measured *set, double *numbers, size_t *at,
                           size_t *missing, ad_error *error)
{
    const size_t rows = table_rows(r->table), parameters = (size_t)r->open->parameter_count;
    double *s = numbers, *t = s + rows, *known = t + rows, *values = known + rows * parameters;
    double *command = values + rows * (size_t)set->columns;
    bool any = false;
    ad_status status = AD_OK;
    for (size_t i = 0; i < rows && status == AD_OK; i++) {
        const size_t to = set->rows;
        if (!is_chosen(r, i)) {
            continue;
        }
        const int count = count_numbers(r, set, i);
        any = true;
        status = take_row(r, i, s + to, t + to, known + to * parameters, error);
        if (status == AD_OK && count > 0 && set->columns == 4) {
            status = check_rotation(r, i, error);
        }
        for (int c = 0; c < set->columns; c++) {
            values[(size_t)c * rows + to] = r->values[c][i];
        }
        at[to] = i;
        *missing += (size_t)(set->columns - count);
        if (r->inputs) {
            r->inputs[to] = r->inputs[i];
        }
        set->rows += count > 0;
    }
    for (int c = 1; c < set->columns; c++) { /* columns follow one another */
        memmove(values + (size_t)c * set->rows, values + (size_t)c * rows,
                set->rows * sizeof *values);
    }
    set->s = s;
    set->t = t;
    set->known = known;
    set->values = values;
    set->inputs = r->inputs;
    take_commands(r, command);
    set->commands = rows;
    set->command = command;
    set->at = at;
    return status != AD_OK || set->rows > 0
               ? status
               : ad_fail(error, AD_BAD_INPUT, "%s: %s; at least one row is needed", r->data->file,
                         any ? "in every row a number is missing" : "no row is chosen");
}

/* Of all rows the inputs over time; what they drive is seen in places, turns and their rates. */
static ad_status find_inputs(reading *r, ad_error *error)
{
    const train_quantity quantity = r->data->quantity;
    const size_t rows = table_rows(r->table);
    ad_status status = recorded_inputs_find(r->of->recorded, r->open, r->data->file, rows, r->t,
                                            r->known, r->inputs, error);
    const bool seen = quantity == TRAIN_POSITION || quantity == TRAIN_ROTATION ||
                      quantity == TRAIN_VELOCITY || quantity == TRAIN_ANGULAR_VELOCITY;
    for (size_t i = 0; i < rows && status == AD_OK && !seen; i++) {
        if (r->inputs[i]) {
            status = ad_fail(error, AD_BAD_INPUT,
                             "%s: has inputs over time and %s; allowed with these: position, "
                             "rotation, velocity, angular_velocity",
                             r->data->file, train_quantity_names()[quantity]);
        }
    }
    return status;
}

/* A set that is there, of rows that are not. */
static ad_status fill_set(reading *r, solve_measured *set, double **numbers, size_t **at,
                          size_t *missing, ad_error *error)
{
    const size_t rows = table_rows(r->table);
    ad_status status = find_columns(r, set, error);
    status = status == AD_OK && r->inputs ? find_inputs(r, error) : status;
    if (status != AD_OK) {
        return status;
    }
    *numbers = malloc((rows + 1) * (size_t)(2 + 2 * r->open->parameter_count + set->columns) *
                      sizeof **numbers);
    *at = malloc((rows + 1) * sizeof **at);
    if (!*numbers || !*at) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu measured rows", rows);
    }
    status = take_rows(r, set, *numbers, *at, missing, error);
    /* cameras may stand anywhere */
    const bool is_of_scene =
        r->data->quantity == TRAIN_POSITION && !quantity_any_given(3, r->data->view.position);
    return status == AD_OK && is_of_scene ? check_positions(r, set, error) : status;
}

/* What is seen beside the axis, or by a frame of its own. */
static ad_status check_view(const scene *open, const train_data *file, int index, char *key,
                            ad_error *error)
{
    const scene_view *view = &file->view;
    const bool placed = file->quantity == TRAIN_POSITION && !scene_is_beam(open);
    const bool turned = file->quantity == TRAIN_ROTATION && !scene_is_beam(open);
    const struct {
        const char *key, *allowed;
        bool wrong;
    } rows[] = {{"marker", "of positions of a rod", quantity_any_given(3, view->marker) && !placed},
                {"frame.position", "of positions of a rod",
                 quantity_any_given(3, view->position) && !placed},
                {"frame.rotation", "of positions and rotations of a rod",
                 quantity_any_given(4, view->rotation) && !placed && !turned},
                {"frame.rotation_vector",
                 "of positions and rotations of a rod, without frame.rotation",
                 quantity_any_given(3, view->rotation_vector) &&
                     ((!placed && !turned) || quantity_any_given(4, view->rotation))},
                {"delay", "in motion", view->delay.is_given && !scene_is_dynamic(open)},
                {"rate", "in motion", file->rate > 0 && !scene_is_dynamic(open)}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (rows[i].wrong) {
            snprintf(key, TRAIN_KEY_MAX, "data[%d].%s", index, rows[i].key);
            return ad_fail(error, AD_BAD_INPUT, "is given here; allowed: %s", rows[i].allowed);
        }
    }
    return AD_OK;
}

static ad_status read_file(const scene *open, const train_data *file, int index,
                           measurements *measurements, char *key, ad_error *error)
{
    int first;
    table_file *table = NULL;
    const int at = measurements->count + measurements->held_out;
    solve_measured *set = &measurements->set[at];
    if (!columns(open, file->quantity, &first, &set->columns)) {
        snprintf(key, TRAIN_KEY_MAX, "data[%d].quantity", index);
        return ad_fail(error, AD_BAD_INPUT, "this scene has no %s",
                       train_quantity_names()[file->quantity]);
    }
    ad_status status = check_view(open, file, index, key, error);
    if (status != AD_OK) {
        return status;
    }
    snprintf(key, TRAIN_KEY_MAX, "data[%d].file", index);
    set->view = scene_view_is_given(&file->view) ? &file->view : NULL;
    for (int c = 0; c < set->columns; c++) {
        set->column[c] = first + c;
        set->noise[c] = file->noise > 0 ? file->noise : 1;
    }
    measurements->entry[at] = index;
    *(file->held_out ? &measurements->held_out : &measurements->count) += 1;
    reading r = {.open = open, .data = file, .key = key, .of = measurements};
    status = table_read(file->file, TABLE_MEASURED, &table, error);
    r.table = table;
    if (status == AD_OK) {
        status = measured_columns_create(table, open->names, file->columns, &r.columns, error);
    }
    if (status == AD_OK && scene_is_dynamic(open) && !scene_is_beam(open)) {
        r.inputs = measurements->inputs[at] = calloc(table_rows(table) + 1, sizeof *r.inputs);
        status = r.inputs ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for inputs");
    }
    if (status == AD_OK) {
        status = fill_set(&r, set, &measurements->numbers[at], &measurements->at[at],
                          &measurements->missing, error);
    }
    measured_columns_free(r.columns);
    table_free(table);
    return status;
}

/* Unknowns are found from all files at once. One noise that is not known can be found, several
 * cannot; how much a number counts is its noise. */
static ad_status check_unknowns(const scene *open, const measurements *measurements,
                                const train_data *all, char *key, ad_error *error)
{
    size_t numbers = 0;
    for (int k = 0; k < measurements->count; k++) {
        const solve_measured *set = &measurements->set[k];
        const int i = measurements->entry[k];
        const train_data *file = &all[i], *first = &all[measurements->entry[0]];
        const bool quaternion =
            file->quantity == TRAIN_ROTATION && set->columns == 4; /* three numbers */
        numbers += set->rows * (size_t)(set->columns - quaternion) - solve_measured_missing(set);
        if ((file->noise > 0) != (first->noise > 0) ||
            (!(file->noise > 0) && file->quantity != first->quantity)) {
            snprintf(key, TRAIN_KEY_MAX, "data[%d].noise",
                     file->noise > 0 ? measurements->entry[0] : i);
            return ad_fail(error, AD_BAD_INPUT,
                           "is needed to find unknowns; it may be left out where nothing but one "
                           "quantity is measured, and then of all entries");
        }
        if (!(file->weight > 0) || file->weight != first->weight) {
            snprintf(key, TRAIN_KEY_MAX, "data[%d].weight", i);
            return ad_fail(error, AD_BAD_INPUT,
                           "is %g, of the first entry %g; allowed where there are unknowns: one "
                           "weight for all, above 0, since how much numbers count is their noise",
                           file->weight, first->weight);
        }
    }
    snprintf(key, TRAIN_KEY_MAX, "data");
    return identify_check(open->unknown_count, numbers, !measurements->tells_noise, error);
}

ad_status measurements_read(const scene *open, const train_settings *settings,
                            measurements **result, char key[TRAIN_KEY_MAX], ad_error *error)
{
    return measurements_read_beside(open, settings, 0, NULL, result, key, error);
}

ad_status measurements_read_beside(const scene *open, const train_settings *settings, int beside,
                                   const char *const *names, measurements **result,
                                   char key[TRAIN_KEY_MAX], ad_error *error)
{
    measurements *x = calloc(1, sizeof *x);
    ad_status status = x ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for measurements");
    *result = NULL;
    if (x) {
        x->beside = beside;
        x->names = names;
        status = recorded_inputs_create(&x->recorded, error);
    }
    for (int i = 0; i < 2 * settings->data_count && status == AD_OK; i++) {
        const int index = i % settings->data_count; /* those that are held out come last */
        if (settings->data[index].held_out == (i >= settings->data_count)) {
            status = read_file(open, &settings->data[index], index, x, key, error);
        }
    }
    if (status == AD_OK && x->count == 0 && !names) {
        snprintf(key, TRAIN_KEY_MAX, "data[0].held_out");
        status = ad_fail(error, AD_BAD_INPUT, "all data are held out; one entry has to be fitted");
    }
    if (status == AD_OK && x->count > 0) {
        x->tells_noise = settings->data[x->entry[0]].noise > 0;
    }
    if (status == AD_OK && open->unknown_count > 0) {
        status = check_unknowns(open, x, settings->data, key, error);
    }
    if (status != AD_OK) {
        measurements_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}
