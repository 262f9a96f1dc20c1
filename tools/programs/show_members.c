/* cpinn-show: members of a family, by its network or by the solver of members. */
#include "tools/programs/show_source.h"

#include "physics/chain/solve_members.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SWEEP = 21, SWEEP_POINTS = 61, SPREAD = 9, SPREAD_POINTS = 101, LABEL = 120 };

static ad_status make_members(samples *p, const scene *of, size_t members, size_t points,
                              ad_error *error)
{
    ad_status status = samples_make(p, points, error);
    for (size_t i = 0; i < points && status == AD_OK; i++) {
        p->s[i] = scene_length(of) * (double)i / (double)(points - 1);
    }
    p->members = members;
    p->parameters = calloc(members * (size_t)scene_known_count(of) + 1, sizeof *p->parameters);
    return p->parameters ? status : ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
}

/* "tension_1 = 2, share = 0.5", of parameters from `first` on. */
static void describe(const scene *of, int first, int end, const double *parameters,
                     char text[LABEL])
{
    const int digits = end > first + 1 ? 3 : 4;
    size_t used = 0;
    *text = '\0';
    for (int k = first; k < end && used < LABEL; k++) {
        const int more =
            snprintf(text + used, LABEL - used, "%s%.40s = %.*g", k > first ? ", " : "",
                     of->parameters[k].name, digits, parameters[k]);
        used += more > 0 ? (size_t)more : 0;
    }
}

/* `swept`: each member is named by the one parameter that moves. */
static ad_status put_members(showing *showing, const scene *of, bool swept, ad_error *error)
{
    const samples *p = &showing->samples;
    const int count = scene_known_count(of);
    const char **labels = calloc(p->members + 1, sizeof *labels);
    char(*texts)[LABEL] = calloc(p->members + 1, sizeof *texts);
    ad_status status =
        labels && texts ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
    for (size_t i = 0; i < p->members && status == AD_OK; i++) {
        const int first = swept ? (int)(i / SWEEP) : 0;
        describe(of, first, swept ? first + 1 : count, p->parameters + i * (size_t)count, texts[i]);
        labels[i] = texts[i];
    }
    status = status == AD_OK ? show_put_shapes(showing, of, labels, NULL, NULL, error) : status;
    free(labels);
    free(texts);
    return status;
}

/* ---- by a network -------------------------------------------------------------------------- */

static ad_status put_errors(showing *showing, ad_error *error)
{
    const samples *p = &showing->samples;
    double *number = malloc((3 * p->members + 1) * sizeof *number);
    double *network = number + p->members, *answer = network + p->members;
    if (!number) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
    }
    for (size_t i = 0; i < p->members; i++) {
        number[i] = (double)i;
        network[i] = p->said[i].network_error;
        answer[i] = p->said[i].error;
    }
    json_open(&showing->to, "curves", '[');
    show_open_curve(&showing->to, "Predicted error of the shape", "member", "", "m", true);
    show_series(&showing->to, "network", number, network, p->members);
    show_series(&showing->to, "after two steps", number, answer, p->members);
    show_close_curve(&showing->to);
    json_close(&showing->to, ']');
    free(number);
    return AD_OK;
}

ad_status show_family(showing *showing, const double *member, ad_error *error)
{
    const scene *of = showing->e->scene;
    const int count = scene_known_count(of);
    samples *p = &showing->samples;
    cpinn_family *family = NULL;
    ad_status status = make_members(p, of, member ? 1 : (size_t)count * SWEEP, SWEEP_POINTS, error);
    for (size_t i = 0; i < p->members && status == AD_OK; i++) {
        for (int k = 0; k < count; k++) {
            const double part = k == (int)(i / SWEEP) ? (double)(i % SWEEP) / (SWEEP - 1) : 0.5;
            p->parameters[i * (size_t)count + (size_t)k] =
                member ? member[k] : scene_parameter_at(&of->parameters[k], part);
        }
    }
    const cpinn_family_settings settings = {.points = SWEEP_POINTS, .s = p->s};
    status = status == AD_OK ? cpinn_family_of(showing->e, &settings, &family, error) : status;
    bool is_live = false;
    if (status == AD_OK && !member && !showing->reference_path && !show_is_picture(showing->out)) {
        status = show_live(showing, family, SWEEP_POINTS, p->s, &is_live, error);
    }
    if (status == AD_OK && !member) {
        status = show_workspace(showing, family, SWEEP_POINTS, p->s, error);
    }
    if (is_live) {
        cpinn_family_free(family);
        return status;
    }
    if (status == AD_OK) {
        const cpinn_polish polish = {.steps = *cpinn_family_without_error(family) ? 0 : 2};
        const answer found = answer_of_family(family, &polish);
        status = samples_ask(p, &found, error);
    }
    status = status == AD_OK ? put_errors(showing, error) : status;
    status = status == AD_OK ? put_members(showing, of, true, error) : status;
    cpinn_family_free(family);
    return status;
}

/* ---- by the solver ------------------------------------------------------------------------- */

void show_spread(const scene *of, int members, double *parameters)
{
    const int count = scene_known_count(of);
    double g = 1.5;
    for (int i = 0; i < 60; i++) {
        g = pow(1 + g, 1.0 / (count + 1));
    }
    for (int i = 0; i < members; i++) {
        for (int k = 0; k < count; k++) {
            const double part =
                count == 1 ? (double)i / (members - 1) : fmod(0.5 + (i + 1) * pow(g, -k - 1), 1);
            parameters[i * count + k] = scene_parameter_at(&of->parameters[k], part);
        }
    }
}

static ad_status solve(showing *showing, const scene *of, ad_error *error)
{
    samples *p = &showing->samples;
    cpinn_family *family = NULL;
    const cpinn_polish by_members = {.alone = true};
    const cpinn_family_settings settings = {.threads = 1, .points = p->count, .s = p->s};
    ad_status status = cpinn_family_prepare(of, 0, &settings, &family, error);
    if (status == AD_OK && *cpinn_family_without_error(family)) {
        status = ad_fail(error, AD_BAD_ARGUMENT, "%s", cpinn_family_without_error(family));
    }
    if (status == AD_OK) {
        const answer found = answer_of_family(family, &by_members);
        status = samples_ask(p, &found, error);
    }
    status = status == AD_OK ? show_workspace(showing, family, p->count, p->s, error) : status;
    p->of = of; /* that of the family goes with it */
    cpinn_family_free(family);
    return status;
}

/* Keeps members that are solved, one after the other. */
static void drop_unsolved(samples *p, size_t known)
{
    const size_t members = p->members, columns = (size_t)p->columns;
    size_t blocks = 0;
    for (size_t k = 0; k < columns * members; k++) {
        if (p->said[k % members].trusted) {
            memmove(p->values + blocks++ * p->count, p->values + k * p->count,
                    p->count * sizeof *p->values);
        }
    }
    p->members = 0;
    for (size_t i = 0; i < members; i++) {
        if (p->said[i].trusted) {
            memmove(p->parameters + p->members * known, p->parameters + i * known,
                    known * sizeof *p->parameters);
            p->said[p->members++] = p->said[i];
        }
    }
}

ad_status show_members(showing *showing, ad_error *error)
{
    const scene *of = &showing->settings->scene;
    samples *p = &showing->samples;
    snprintf(showing->title, sizeof showing->title, "%s", showing->settings->settings.name);
    ad_status status = make_members(p, of, SPREAD, SPREAD_POINTS, error);
    if (status == AD_OK) {
        show_spread(of, SPREAD, p->parameters);
        status = solve(showing, of, error);
    }
    if (status == AD_OK) {
        drop_unsolved(p, (size_t)scene_known_count(of));
        json_open(&showing->to, "facts", '[');
        show_scene_facts(&showing->to, of);
        show_fact(&showing->to, "members without an equilibrium", "%.0f",
                  (double)(SPREAD - p->members));
        json_close(&showing->to, ']');
        status = p->members > 0 ? put_members(showing, of, false, error)
                                : ad_fail(error, AD_BAD_INPUT, "%s: none of %d members is solved",
                                          showing->source, SPREAD);
    }
    return status;
}
