/* cpinn-show: where the tips of a family's members are, how well they can be moved from there, and
 * how much the rod bends for it.
 *
 * The Jacobian of a tip is that of its place by the parameters that actuate the rod, as fractions z
 * of their ranges (where none does, by all). A direction in which no member goes a hundredth as far
 * as the robot does in its best is none of the workspace: in a plane the one across it, of three
 * tendons the one in which they compress the rod. Of the other singular values, s1 the largest and
 * sd the least, follow
 *
 *   dexterity      sd, m: how far the tip goes in its worst direction for |dz| = 1
 *   conditioning   sd/s1, the local conditioning index (Gosselin and Angeles, J. Mech. Des. 113,
 *                  1991): 1 where all directions are alike, 0 where one of them is lost.
 *
 * Strain is the largest of all fibres along the rod (physics/rod/rod_section.h), stability the
 * margin of physics/chain/solve_members.h. */
#include "tools/programs/show_source.h"

#include "autodiff/dense.h"
#include "autodiff/memory.h"
#include "physics/chain/solve_members.h"
#include "physics/numerics/sort.h"
#include "physics/rod/rod_section.h"
#include "physics/scene/breaks.h"
#include "physics/solve/stability.h"
#include "tools/library/trained_family.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MEMBERS = 2000, BATCH = 50, V = 7, U = 10 };

#define LEAST_DIRECTION 1e-2

/* Columns after those of parameters. */
enum { X, Y, Z, DEXTERITY, CONDITIONING, CURVATURE, STRAIN, STABILITY, ERROR, TRUSTED, NUMBERS };

static const struct {
    const char *name, *unit;
} own[NUMBERS] = {[X] = {"x", "m"},
                  [Y] = {"y", "m"},
                  [Z] = {"z", "m"},
                  [DEXTERITY] = {"dexterity", "m"},
                  [CONDITIONING] = {"conditioning", ""},
                  [CURVATURE] = {"curvature", "1/m"},
                  [STRAIN] = {"strain", ""},
                  [STABILITY] = {"stability", ""},
                  [ERROR] = {"error", "m"},
                  [TRUSTED] = {"trusted", ""}};

typedef struct workspace {
    const scene *of;
    bool moves[SCENE_PARAMETERS_MAX]; /* which parameters the Jacobian is by */
    double *parameters;               /* [MEMBERS][parameters] */
    double *numbers;                  /* [parameters + NUMBERS][MEMBERS], */
    double *singular;                 /* and [MEMBERS][3], the largest first */
    const char **source, **reason;    /* [MEMBERS] */
    int reasons[CPINN_REASON_COUNT];  /* of members that are not trusted */
    size_t trusted;
    int directions;
    const char *without_margin; /* why there is no stability margin; NULL: there is one */
    bool has_section;           /* without a section there is no strain of fibres */
    ad_tape *tape;              /* of that strain: */
    ad_value strain;            /* by s, parameters [of->parameter_count], strains [6] */
    scene_breaks breaks;        /* along the rod, */
    double length;              /* of the member in the middle */
    ad_memory memory;
} workspace;

static double *own_column(const workspace *w, int which)
{
    return w->numbers + (size_t)(w->of->parameter_count + which) * MEMBERS;
}

static void workspace_free(workspace *w)
{
    ad_memory_free(&w->memory);
    ad_tape_free(w->tape);
}

static ad_status prepare(workspace *w, ad_error *error)
{
    const size_t count = (size_t)w->of->parameter_count;
    bool any = false;
    AD_TAKE(w, parameters, MEMBERS * count);
    AD_TAKE(w, numbers, (count + NUMBERS) * MEMBERS);
    AD_TAKE(w, singular, 3 * MEMBERS);
    AD_TAKE(w, source, 2 * MEMBERS);
    if (w->memory.is_short) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a workspace");
    }
    w->reason = w->source + MEMBERS;
    for (int k = 0; k < w->of->parameter_count; k++) {
        w->moves[k] = scene_parameter_actuates(w->of, k);
        any = any || w->moves[k];
    }
    for (int k = 0; k < w->of->parameter_count; k++) {
        w->moves[k] = w->moves[k] || !any;
    }
    show_spread(w->of, MEMBERS, w->parameters);
    for (size_t i = 0; i < MEMBERS; i++) {
        own_column(w, STABILITY)[i] = own_column(w, STRAIN)[i] = NAN; /* unless they are found */
    }
    for (size_t i = 0; i < MEMBERS * count; i++) {
        w->numbers[i % count * MEMBERS + i / count] = w->parameters[i];
    }
    return AD_OK;
}

/* Singular values of a [3][count], the largest first: roots of the eigenvalues of a a', so that
 * those below 1e-8 of the largest are noise. */
static void find_singular(size_t count, double a[3][SCENE_PARAMETERS_MAX], double to[3])
{
    double square[9] = {0}, axes[9];
    for (size_t i = 0; i < 9; i++) {
        for (size_t k = 0; k < count; k++) {
            square[i] += a[i / 3][k] * a[i % 3][k];
        }
    }
    ad_dense_diagonalize(3, square, axes);
    for (int i = 0; i < 3; i++) {
        const double size = sqrt(fmax(0, square[4 * i]));
        int at = i;
        for (; at > 0 && to[at - 1] < size; at--) {
            to[at] = to[at - 1];
        }
        to[at] = size;
    }
}

/* The strain of fibres at a point, and where formulas jump. */
static ad_status record_strain(workspace *w, ad_error *error)
{
    const int count = w->of->parameter_count;
    ad_value parameter[SCENE_PARAMETERS_MAX];
    scene one;
    w->tape = ad_tape_create();
    const ad_value place = ad_input(w->tape, "s", 1), all = ad_input(w->tape, "p", count);
    const ad_value shape = ad_input(w->tape, "strains", 6);
    for (int k = 0; k < count; k++) {
        parameter[k] = ad_row(all, k);
    }
    w->strain = rod_section_record(w->of, ROD_SECTION_STRAIN, place, parameter, shape);
    scene_middle(w->of, &one);
    w->length = scene_length(&one);
    return scene_breaks_of(&one, "s", &w->breaks, error);
}

/* The largest strain of fibres of members from `first` on, which were asked for. */
static ad_status find_strain(workspace *w, const samples *from, size_t first, ad_error *error)
{
    const size_t count = (size_t)w->of->parameter_count, rows = samples_rows(from);
    double *s = malloc((2 + count) * rows * sizeof *s), *parameters = s + rows;
    double *found = parameters + count * rows;
    if (!s) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a workspace");
    }
    for (size_t i = 0; i < rows; i++) {
        s[i] = scene_breaks_before(&w->breaks, w->length, from->s[i % from->count]);
        for (size_t k = 0; k < count; k++) {
            parameters[k * rows + i] = from->parameters[i / from->count * count + k];
        }
    }
    const double *const inputs[] = {s, parameters, from->values + V * rows};
    const ad_run run = {.points = rows, .inputs = inputs, .outputs = &found, .everywhere = true};
    const ad_status status = ad_evaluate(1, &w->strain, NULL, &run, error);
    w->has_section = status != AD_BAD_INPUT;
    for (size_t i = 0; i < rows && status == AD_OK; i++) {
        double *most = own_column(w, STRAIN) + first + i / from->count;
        *most = i % from->count == 0 ? found[i] : fmax(*most, found[i]);
    }
    free(s);
    return w->has_section ? status : AD_OK;
}

/* Of a member of some that were asked for. */
static void take(workspace *w, size_t member, const samples *from, size_t which)
{
    const size_t count = (size_t)w->of->parameter_count, rows = samples_rows(from);
    const size_t first = which * from->count, tip = first + from->count - 1;
    const cpinn_answer *said = &from->said[which];
    double by[3][SCENE_PARAMETERS_MAX], bends = 0;
    bool known = true;
    for (size_t k = 0; k < 3; k++) {
        own_column(w, X + (int)k)[member] = from->values[k * rows + tip];
        for (size_t j = 0; j < count; j++) {
            by[k][j] = w->moves[j] ? from->slopes[(k * count + j) * rows + tip] *
                                         scene_parameter_slope(&w->of->parameters[j],
                                                               w->parameters[member * count + j])
                                   : 0;
            known = known && isfinite(by[k][j]);
        }
    }
    for (size_t i = first; i <= tip; i++) {
        bends = fmax(bends, hypot(from->values[U * rows + i], from->values[(U + 1) * rows + i]));
    }
    if (known) {
        find_singular(count, by, w->singular + 3 * member);
    } else {
        w->singular[3 * member] = NAN;
    }
    own_column(w, CURVATURE)[member] = isfinite(from->values[tip]) ? bends : NAN;
    own_column(w, ERROR)[member] = said->error;
    own_column(w, TRUSTED)[member] = said->trusted;
    w->source[member] = cpinn_source_word(said->source);
    w->reason[member] = cpinn_reason_word(said->reason);
    w->trusted += said->trusted;
    w->reasons[said->reason] += !said->trusted;
}

static void judge(workspace *w)
{
    double most[3] = {0};
    for (size_t i = 0; i < 3 * (size_t)MEMBERS; i++) {
        const bool counts = own_column(w, TRUSTED)[i / 3] != 0 && isfinite(w->singular[i / 3 * 3]);
        most[i % 3] = fmax(most[i % 3], counts ? w->singular[i] : 0);
    }
    while (w->directions < 3 && most[w->directions] > LEAST_DIRECTION * most[0]) {
        w->directions++;
    }
    for (size_t i = 0; i < MEMBERS; i++) {
        const double *s = w->singular + 3 * i;
        own_column(w, DEXTERITY)[i] = isfinite(s[0]) && w->directions ? s[w->directions - 1] : NAN;
        own_column(w, CONDITIONING)[i] = own_column(w, DEXTERITY)[i] / s[0];
    }
}

static bool is_known(const workspace *w, int which)
{
    return which == STABILITY ? !w->without_margin : which != STRAIN || w->has_section;
}

/* ---- what becomes of it -------------------------------------------------------------------- */

static ad_status write_table(const workspace *w, const char *path, ad_error *error)
{
    table_build to;
    table_begin(&to, MEMBERS);
    for (int k = 0; k < w->of->parameter_count; k++) {
        table_add(&to, w->of->parameters[k].name, "", w->numbers + (size_t)k * MEMBERS, NULL);
    }
    for (int k = 0; k < NUMBERS; k++) {
        if (is_known(w, k)) {
            table_add(&to, own[k].name, own[k].unit, own_column(w, k), NULL);
        }
    }
    table_add(&to, "source", "", own_column(w, ERROR), w->source);
    table_add(&to, "reason", "", own_column(w, ERROR), w->reason);
    return table_write(path, &to.table, error);
}

/* A row of the page's table: what is least and most of trusted members, and where. */
static void put_extremes(json *to, const workspace *w, int which, bool largest)
{
    const double *values = own_column(w, which), *trusted = own_column(w, TRUSTED);
    size_t best = MEMBERS;
    char text[64];
    for (size_t i = 0; i < MEMBERS; i++) {
        if (trusted[i] != 0 && isfinite(values[i]) &&
            (best == MEMBERS || (largest ? values[i] > values[best] : values[i] < values[best]))) {
            best = i;
        }
    }
    if (best == MEMBERS) {
        return;
    }
    json_open(to, NULL, '[');
    snprintf(text, sizeof text, "%s %s", largest ? "largest" : "least", own[which].name);
    json_text(to, NULL, text);
    snprintf(text, sizeof text, "%.4g%s%s", values[best], *own[which].unit ? " " : "",
             own[which].unit);
    json_text(to, NULL, text);
    for (int k = 0; k < w->of->parameter_count; k++) {
        snprintf(text, sizeof text, "%.4g", w->numbers[(size_t)k * MEMBERS + best]);
        json_text(to, NULL, text);
    }
    json_close(to, ']');
}

static void put_table(json *to, const workspace *w)
{
    json_open(to, "tables", '[');
    json_open(to, NULL, '{');
    json_text(to, "title", "Workspace: ends of what its members have, and where");
    json_open(to, "rows", '[');
    json_open(to, NULL, '[');
    json_text(to, NULL, "");
    json_text(to, NULL, "value");
    for (int k = 0; k < w->of->parameter_count; k++) {
        json_text(to, NULL, w->of->parameters[k].name);
    }
    json_close(to, ']');
    for (int k = X; k <= STABILITY; k++) { /* what is not known has none */
        put_extremes(to, w, k, false);
        put_extremes(to, w, k, true);
    }
    put_extremes(to, w, ERROR, true);
    json_close(to, ']');
    json_close(to, '}');
    json_close(to, ']');
}

/* Whether a member is shown by this column. */
static bool is_shown(const workspace *w, int which, size_t member)
{
    return own_column(w, TRUSTED)[member] != 0 && isfinite(own_column(w, which)[member]);
}

/* Of a column, which a hundredth of the tips lies beyond; room [trusted]. */
static void find_ends(const workspace *w, int which, double *room, double ends[2])
{
    size_t count = 0;
    for (size_t i = 0; i < MEMBERS; i++) {
        if (is_shown(w, which, i)) {
            room[count++] = own_column(w, which)[i];
        }
    }
    sort_ascending(count, room);
    ends[0] = count > 0 ? room[count / 100] : 0;
    ends[1] = count > 0 ? room[count - 1 - count / 100] : 0;
}

/* Which column colours tips. */
static ad_status choose(const workspace *w, const char *name, int *which, ad_error *error)
{
    char allowed[200] = "";
    *which = DEXTERITY;
    for (int k = DEXTERITY; k <= ERROR; k++) {
        if (is_known(w, k)) {
            const size_t used = strlen(allowed);
            snprintf(allowed + used, sizeof allowed - used, "%s%s", used > 0 ? ", " : "",
                     own[k].name);
            if (!name || strcmp(name, own[k].name) == 0) {
                *which = name ? k : *which;
                return AD_OK;
            }
        }
    }
    return ad_fail(error, AD_BAD_INPUT, "--by: is %s; allowed for this robot: %s", name, allowed);
}

static void put_words(json *to, const workspace *w)
{
    char text[400];
    int used =
        snprintf(text, sizeof text, "%zu of %d members all over the ranges; %zu are not trusted",
                 w->trusted, MEMBERS, MEMBERS - w->trusted);
    for (int k = 0; k < CPINN_REASON_COUNT && used < (int)sizeof text; k++) {
        if (w->reasons[k] > 0) {
            used += snprintf(text + used, sizeof text - (size_t)used, ", %d: %s", w->reasons[k],
                             cpinn_reason_text((cpinn_reason)k));
        }
    }
    if (w->without_margin && used < (int)sizeof text) {
        used +=
            snprintf(text + used, sizeof text - (size_t)used, "; stability %s", w->without_margin);
    }
    if (!w->has_section && used < (int)sizeof text) {
        snprintf(text + used, sizeof text - (size_t)used, "; strain needs rod.section%s",
                 w->of->tube_count > 0 ? ", and no tubes" : "");
    }
    json_text(to, "says", text);
    json_integer(to, "directions", w->directions);
    json_open(to, "moves", '[');
    for (int k = 0; k < w->of->parameter_count; k++) {
        json_text(to, NULL, w->moves[k] ? w->of->parameters[k].name : NULL);
    }
    json_close(to, ']');
}

/* Trusted members alone. */
static ad_status put_tips(json *to, const workspace *w, int by, ad_error *error)
{
    double *few = malloc((w->trusted + 1) * sizeof *few);
    if (!few) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a workspace");
    }
    json_open(to, "workspace", '{');
    json_integer(to, "rows", (int64_t)w->trusted);
    json_text(to, "by", own[by].name);
    put_words(to, w);
    json_open(to, "columns", '[');
    for (int k = X; k <= ERROR; k++) {
        size_t count = 0;
        if (!is_known(w, k)) {
            continue;
        }
        for (size_t i = 0; i < MEMBERS; i++) {
            few[count] = own_column(w, k)[i];
            count += own_column(w, TRUSTED)[i] != 0;
        }
        show_column(to, own[k].name, own[k].unit, few, count, k > Z);
    }
    json_close(to, ']');
    json_open(to, "ends", '['); /* of colours, by each column after the place */
    for (int k = Z + 1; k <= ERROR; k++) {
        double ends[2];
        if (is_known(w, k)) {
            find_ends(w, k, few, ends);
            json_open(to, NULL, '[');
            json_number(to, NULL, ends[0]);
            json_number(to, NULL, ends[1]);
            json_close(to, ']');
        }
    }
    json_close(to, ']');
    json_close(to, '}');
    free(few);
    return AD_OK;
}

/* Members a batch at a time. */
static ad_status ask(workspace *w, cpinn_family *family, const answer *found, size_t points,
                     const double *s, ad_error *error)
{
    const size_t count = (size_t)w->of->parameter_count;
    samples p = {.count = 0};
    ad_status status = samples_make(&p, points, error);
    if (status == AD_OK) {
        memcpy(p.s, s, points * sizeof *s);
        p.derives = true;
        p.members = BATCH;
    }
    for (size_t first = 0; first < MEMBERS && status == AD_OK; first += BATCH) {
        p.parameters = w->parameters + first * count;
        status = samples_ask(&p, found, error);
        if (status == AD_OK && !w->without_margin) {
            double margin[BATCH][SOLVE_MARGINS];
            status = cpinn_family_margin(family, BATCH, p.parameters, margin[0], NULL, error);
            for (size_t i = 0; i < BATCH && status == AD_OK; i++) {
                own_column(w, STABILITY)[first + i] = margin[i][0];
            }
        }
        if (status == AD_OK && w->has_section) {
            status = find_strain(w, &p, first, error);
        }
        for (size_t i = 0; i < BATCH && status == AD_OK; i++) {
            take(w, first + i, &p, i);
        }
    }
    p.parameters = NULL;
    samples_free(&p);
    return status;
}

ad_status show_workspace(showing *showing, cpinn_family *family, size_t points, const double *s,
                         ad_error *error)
{
    const cpinn_polish two_steps = {.steps = 2};
    const answer found = answer_of_family(family, &two_steps);
    workspace w = {.of = found.scene,
                   .without_margin = stability_without_margin(found.scene),
                   .has_section = true};
    int by = DEXTERITY;
    if (*cpinn_family_without_error(family) ||
        (show_is_picture(showing->out) && !showing->workspace && !showing->by)) {
        return AD_OK;
    }
    ad_status status = prepare(&w, error);
    status = status == AD_OK ? record_strain(&w, error) : status;
    status = status == AD_OK ? ask(&w, family, &found, points, s, error) : status;
    status = status == AD_OK ? choose(&w, showing->by, &by, error) : status;
    if (status == AD_OK) {
        judge(&w);
        status = put_tips(&showing->to, &w, by, error);
        put_table(&showing->to, &w);
        showing->has_workspace = true;
    }
    if (status == AD_OK && showing->workspace) {
        status = write_table(&w, showing->workspace, error);
    }
    workspace_free(&w);
    return status;
}
