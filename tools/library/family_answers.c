/* Answers for members of a family: the network's, polished, with their errors, or those of solvers.
 */
#include "tools/library/trained_family.h"

#include "autodiff/host.h"
#include "physics/numerics/distance.h"
#include "tools/library/member_code.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static_assert((int)CPINN_REASON_NOT_FINITE == SOLVE_NOT_FINITE &&
                  (int)CPINN_REASON_UNSTABLE == SOLVE_UNSTABLE &&
                  (int)CPINN_REASON_TOO_FAR == SOLVE_TOO_FAR &&
                  (int)CPINN_REASON_NOT_SETTLING == SOLVE_NOT_SETTLING,
              "reasons begin with the doubts of the solver");

/* ---- words --------------------------------------------------------------------------------- */

static const struct {
    const char *word, *text;
} reasons[] = {
#define REASON_ROW(name, word, text) {word, text},
    CPINN_REASON_LIST(REASON_ROW)
#undef REASON_ROW
};

const char *cpinn_reason_word(cpinn_reason reason)
{
    return reason >= 0 && reason < CPINN_REASON_COUNT ? reasons[reason].word : "";
}

const char *cpinn_reason_text(cpinn_reason reason)
{
    return reason >= 0 && reason < CPINN_REASON_COUNT ? reasons[reason].text : "";
}

const char *cpinn_source_word(cpinn_source source)
{
    static const char *const words[] = {"network", "members", "solver", "nothing"};
    return source >= 0 && source <= CPINN_FROM_NOTHING ? words[source] : "";
}

/* ---- the range ----------------------------------------------------------------------------- */

bool cpinn_family_refuses(const cpinn_family *family, size_t members, const double *parameters,
                          size_t *member, int *parameter)
{
    AD_LEAVE_HOST;
    for (size_t i = 0; i < members; i++) {
        for (int k = 0; k < family->count; k++) {
            const double value = parameters[i * (size_t)family->count + (size_t)k];
            const bool outside = !scene_parameter_holds(&family->open.parameters[k], value);
            if (!isfinite(value) || (outside && !family->extrapolate)) {
                *member = i;
                *parameter = k;
                return true;
            }
        }
    }
    return false;
}

static ad_status check_range(const cpinn_family *family, size_t members, const double *parameters,
                             ad_error *error)
{
    size_t member;
    int k;
    if (!cpinn_family_refuses(family, members, parameters, &member, &k)) {
        return AD_OK;
    }
    const scene_parameter *p = &family->open.parameters[k];
    return ad_fail(error, AD_BAD_ARGUMENT,
                   "member %zu: %s = %g is outside its range; allowed: %g to %g", member, p->name,
                   parameters[member * (size_t)family->count + (size_t)k], p->low, p->high);
}

static bool any_outside(const cpinn_family *family, const double *parameters)
{
    bool result = false;
    for (int k = 0; k < family->count; k++) {
        result = result || !scene_parameter_holds(&family->open.parameters[k], parameters[k]);
    }
    return result;
}

/* ---- the network's answers ----------------------------------------------------------------- */

double cpinn_family_distance(const cpinn_family *family, const double *a, const double *b)
{
    return largest_distance(family->points, scene_physics_of(&family->open)->position_columns,
                            (size_t)family->columns, 1, a, b);
}

static cpinn_answer answer_of(const solve_answer *refined)
{
    return (cpinn_answer){.error = refined->left,
                          .network_error = refined->predicted,
                          .source = CPINN_FROM_NETWORK,
                          .reason = (cpinn_reason)refined->reason,
                          .trusted = refined->trusted};
}

/* What the network says by itself of positions, against its curvature after one step. */
static ad_status answer_plain(cpinn_family *family, size_t members, const double *parameters,
                              double *values, cpinn_answer *answers, ad_error *error)
{
    const size_t width = family->points * (size_t)family->columns;
    ad_status status =
        family->network.values(family->network.context, members, parameters, values, error);
    if (status == AD_OK) {
        status = solve_members_refine(family->solver, members, parameters, family->curvature, 1,
                                      family->values, NULL, family->refined, error);
    }
    for (size_t i = 0; i < members && status == AD_OK; i++) {
        const double off =
            cpinn_family_distance(family, values + i * width, family->values + i * width);
        answers[i] = answer_of(&family->refined[i]);
        answers[i].error = off + family->refined[i].left;
        answers[i].network_error = answers[i].error;
        if (answers[i].trusted && !(answers[i].error <= SOLVE_TRUSTED * family->length)) {
            answers[i].trusted = false;
            answers[i].reason =
                isfinite(answers[i].error) ? CPINN_REASON_TOO_FAR : CPINN_REASON_NOT_FINITE;
        }
    }
    return status;
}

/* family->curvature is, where there is a solver which `keeps` it, that of the equilibria which two
 * steps arrive at; without a solver the jacobian is the network's. */
static ad_status answer_by_network(cpinn_family *family, int steps, bool keeps, size_t members,
                                   const double *parameters, double *values, double *jacobian,
                                   cpinn_answer *answers, ad_error *error)
{
    const cpinn_family_network *network = &family->network;
    if (!family->solver) {
        for (size_t i = 0; i < members && answers; i++) {
            answers[i] = (cpinn_answer){.error = NAN,
                                        .network_error = NAN,
                                        .source = CPINN_FROM_NETWORK,
                                        .reason = CPINN_REASON_NO_ESTIMATE};
        }
        const ad_status status =
            network->values(network->context, members, parameters, values, error);
        return status == AD_OK && jacobian
                   ? network->jacobian(network->context, members, parameters, jacobian, error)
                   : status;
    }
    if (!answers && network->values) {
        return network->values(network->context, members, parameters, values, error);
    }
    double *curvature = family->curvature;
    ad_status status = network->curvature(network->context, members, parameters, curvature, error);
    if (status != AD_OK) {
        return status;
    }
    if (steps == 0 && answers && network->values) {
        status = answer_plain(family, members, parameters, values, answers, error);
    } else {
        status = solve_members_refine(family->solver, members, parameters, curvature, steps, values,
                                      NULL, answers ? family->refined : NULL, error);
        for (size_t i = 0; i < members && answers && status == AD_OK; i++) {
            answers[i] = answer_of(&family->refined[i]);
        }
    }
    return status == AD_OK && keeps
               ? solve_members_refine(family->solver, members, parameters, curvature, 2, NULL,
                                      curvature, NULL, error)
               : status;
}

/* ---- outside of the range ------------------------------------------------------------------ */

static bool passes_checks(const scene *one)
{
    const char *key = "";
    ad_error why;
    return scene_check(one, &key, &why) == AD_OK &&
           scene_physics_of(one)->check(one, &key, &why) == AD_OK;
}

/* Marks members that are outside of the range; beyond it a scene may be none at all. */
static void look_outside(const cpinn_family *family, size_t members, const double *parameters,
                         double *values, cpinn_answer *answers)
{
    const size_t width = family->points * (size_t)family->columns;
    for (size_t i = 0; i < members; i++) {
        const double *given = parameters + i * (size_t)family->count;
        answers[i].outside = any_outside(family, given);
        if (answers[i].outside) {
            scene one;
            scene_member(&family->open, given, &one);
            if (!passes_checks(&one)) {
                cpinn_family_say_nothing(family, CPINN_REASON_REFUSED, values + i * width,
                                         &answers[i]);
            }
        }
    }
}

/* ---- answers that are solved --------------------------------------------------------------- */

/* Whether a network's answer is to be solved instead: not where the scene is none. */
static bool is_wanting(const cpinn_family *family, int steps, cpinn_answer *answer)
{
    if (answer->trusted && steps == 2 && answer->error > CPINN_ENOUGH * family->length) {
        answer->reason = CPINN_REASON_NOT_REACHED;
        return true;
    }
    return !answer->trusted && answer->source == CPINN_FROM_NETWORK;
}

/* Members of a chunk whose answer is wanting, by the solver of members, with their curvature where
 * it `keeps` that. */
static ad_status solve_wanting(cpinn_family *family, int steps, bool keeps, size_t members,
                               const double *parameters, double *values, cpinn_answer *answers,
                               ad_error *error)
{
    const size_t count = (size_t)family->count, width = family->points * (size_t)family->columns;
    const size_t unknowns = family->numbers;
    size_t rest = 0;
    for (size_t i = 0; i < members; i++) {
        if (is_wanting(family, steps, &answers[i])) {
            memcpy(family->parameters + rest * count, parameters + i * count,
                   count * sizeof *parameters);
            family->which[rest++] = i;
        }
    }
    ad_status status =
        rest == 0
            ? AD_OK
            : solve_members_curvature(family->solver, rest, family->parameters, family->values,
                                      keeps ? family->found : NULL, family->solved, error);
    for (size_t k = 0; k < rest && status == AD_OK; k++) {
        cpinn_answer *answer = &answers[family->which[k]];
        if (keeps) {
            memcpy(family->curvature + family->which[k] * unknowns, family->found + k * unknowns,
                   unknowns * sizeof *family->found);
        }
        if (family->solved[k].solved) {
            memcpy(values + family->which[k] * width, family->values + k * width,
                   width * sizeof *values);
            answer->source = CPINN_FROM_MEMBERS;
            answer->trusted = true;
            answer->error = family->solved[k].estimate * family->length;
        }
    }
    return status;
}

/* Members of a chunk that are not trusted yet, by the other solver. */
static ad_status solve_rest(cpinn_family *family, bool keeps, size_t members,
                            const double *parameters, double *values, cpinn_answer *answers,
                            ad_error *error)
{
    size_t rest = 0;
    for (size_t i = 0; i < members; i++) {
        family->which[rest] = i;
        rest += !answers[i].trusted && answers[i].reason != CPINN_REASON_REFUSED;
    }
    return cpinn_family_solve(family, rest, family->which, parameters, values,
                              keeps ? family->curvature : NULL, answers, error);
}

/* ---- without a network --------------------------------------------------------------------- */

static bool is_without_network(const cpinn_family *family)
{
    return !family->network.curvature && !family->network.values;
}

static cpinn_answer answer_solved(const cpinn_family *family, const solve_member *solved)
{
    const bool is_there = isfinite(solved->estimate);
    return (cpinn_answer){.error = is_there ? solved->estimate * family->length : NAN,
                          .network_error = NAN,
                          .source = is_there ? CPINN_FROM_MEMBERS : CPINN_FROM_NOTHING,
                          .reason = solved->solved ? CPINN_REASON_NONE
                                    : is_there     ? CPINN_REASON_WARNING
                                                   : CPINN_REASON_NO_EQUILIBRIUM,
                          .trusted = solved->solved};
}

static ad_status answer_by_members(cpinn_family *family, bool keeps, size_t members,
                                   const double *parameters, double *values, cpinn_answer *answers,
                                   ad_error *error)
{
    const ad_status status =
        solve_members_curvature(family->solver, members, parameters, values,
                                keeps ? family->curvature : NULL, family->solved, error);
    for (size_t i = 0; i < members && answers && status == AD_OK; i++) {
        answers[i] = answer_solved(family, &family->solved[i]);
    }
    return status;
}

/* ---- compiled C ---------------------------------------------------------------------------- */

/* Whether compiled C has answered all members of a call, which are few and within the ranges, with
 * all that is asked for: derivatives and forces, which it has or not, only after two steps, and
 * none of what is yet to be solved. */
static bool answer_by_code(cpinn_family *family, bool forces, int steps, size_t members,
                           const double *parameters, double *values, double *jacobian,
                           cpinn_answer *answers)
{
    const size_t count = (size_t)family->count;
    const size_t width = family->points * (size_t)cpinn_family_columns(family);
    const bool solves = is_without_network(family), is_whole = jacobian || forces;
    bool result = family->code && forces == family->forces && members <= CPINN_FEW &&
                  (solves || !is_whole || steps == 2);
    for (size_t i = 0; i < members && result; i++) {
        result = !any_outside(family, parameters + i * count);
    }
    for (size_t i = 0; i < members && result; i++) {
        const double *given = parameters + i * count;
        double *to = values + i * width, *slopes = jacobian ? jacobian + i * width * count : NULL;
        cpinn_answer *said = answers ? answers + i : NULL;
        if (solves) {
            result = member_code_solve(family->code, given, to, slopes, family->solved);
            if (said) {
                *said = answer_solved(family, family->solved);
            }
        } else {
            member_code_answer(family->code, steps, given, to, slopes, said);
            result = !is_whole || !is_wanting(family, steps, said);
        }
    }
    return result;
}

/* ---- answers ------------------------------------------------------------------------------- */

/* Whether a curvature of solution_create is an equilibrium on the mesh of derivatives, too, stable
 * or not. */
static ad_status is_met(cpinn_family *family, const double *parameters, const double *curvature,
                        bool *met, ad_error *error)
{
    solve_answer said;
    const ad_status status =
        solve_members_refine(family->solver, 1, parameters, curvature, 1, NULL, NULL, &said, error);
    *met = status == AD_OK && said.predicted <= CPINN_ENOUGH * family->length;
    return status;
}

/* Of equilibria, with forces where these are `wanted`; not numbers where nobody has an answer. */
static ad_status differentiate(cpinn_family *family, bool wanted, size_t members,
                               const double *parameters, const cpinn_answer *answers,
                               double *jacobian, ad_error *error)
{
    const size_t unknowns = family->numbers;
    ad_status status = AD_OK;
    for (size_t i = 0; i < members && status == AD_OK; i++) {
        bool met = answers[i].source != CPINN_FROM_NOTHING;
        if (answers[i].source == CPINN_FROM_SOLVER) {
            status = is_met(family, parameters + i * (size_t)family->count,
                            family->curvature + i * unknowns, &met, error);
        }
        if (!met) {
            cpinn_put_nothing(unknowns, family->curvature + i * unknowns);
        }
    }
    return status == AD_OK
               ? solve_members_forces(family->solver, members, parameters, family->curvature, 0,
                                      jacobian, wanted ? family->carried : NULL,
                                      wanted && jacobian ? family->carried_by : NULL, error)
               : status;
}

/* `wanted`: family->carried, too, and with a jacobian family->carried_by. */
static ad_status answer_chunk(cpinn_family *family, const cpinn_polish *polish, bool wanted,
                              size_t members, const double *parameters, double *values,
                              double *jacobian, cpinn_answer *answers, ad_error *error)
{
    const int steps = answers ? polish->steps : 0;
    const bool keeps = jacobian || wanted;
    const bool solves = answers && family->solver && !polish->alone;
    const bool by_code = !wanted && answer_by_code(family, false, steps, members, parameters,
                                                   values, jacobian, answers);
    ad_status status =
        by_code ? AD_OK
        : is_without_network(family)
            ? answer_by_members(family, keeps, members, parameters, values, answers, error)
            : answer_by_network(family, steps, keeps, members, parameters, values, jacobian,
                                answers, error);
    if (status == AD_OK && answers) {
        look_outside(family, members, parameters, values, answers);
    }
    if (status == AD_OK && solves && !is_without_network(family)) {
        status = solve_wanting(family, steps, keeps, members, parameters, values, answers, error);
    }
    if (status == AD_OK && solves && !polish->quick) {
        status = solve_rest(family, keeps, members, parameters, values, answers, error);
    }
    return status == AD_OK && keeps && family->solver && !by_code
               ? differentiate(family, wanted, members, parameters, answers, jacobian, error)
               : status;
}

/* Rows of `width` numbers become rows of `more` beside them, where they are; from the last on, as
 * each moves back. */
static void set_beside(size_t rows, size_t width, size_t more, const double *beside, double *values)
{
    for (size_t i = rows; i-- > 0;) {
        double *to = values + i * (width + more);
        memmove(to, values + i * width, width * sizeof *values);
        memcpy(to + width, beside + i * more, more * sizeof *values);
    }
}

/* The network alone says nothing of equilibria, of which forces are. */
static ad_status answer_with_forces(cpinn_family *family, const cpinn_polish *polish,
                                    size_t members, const double *parameters, double *values,
                                    double *jacobian, cpinn_answer *answers, ad_error *error)
{
    static const cpinn_polish bare = {.alone = true};
    const size_t rows = members * family->points, columns = (size_t)family->columns,
                 count = (size_t)family->count;
    polish = answers ? polish : &bare;
    answers = answers ? answers : family->unasked;
    if (answer_by_code(family, true, polish->steps, members, parameters, values, jacobian,
                       answers)) {
        return AD_OK;
    }
    const ad_status status =
        answer_chunk(family, polish, true, members, parameters, values, jacobian, answers, error);
    if (status == AD_OK) {
        set_beside(rows, columns, family->more, family->carried, values);
    }
    if (status == AD_OK && jacobian) {
        set_beside(rows, columns * count, family->more * count, family->carried_by, jacobian);
    }
    return status;
}

/* Of families that solution_create alone answers. */
static ad_status answer_motions(cpinn_family *family, size_t members, const double *parameters,
                                double *values, double *jacobian, cpinn_answer *answers,
                                ad_error *error)
{
    for (size_t i = 0; i < members; i++) {
        answers[i] = (cpinn_answer){.network_error = NAN, .source = CPINN_FROM_NOTHING};
    }
    look_outside(family, members, parameters, values, answers);
    const ad_status status = solve_rest(family, false, members, parameters, values, answers, error);
    return status == AD_OK && jacobian
               ? cpinn_family_change(family, members, parameters, jacobian, answers, error)
               : status;
}

static ad_status answer_all(cpinn_family *family, const cpinn_polish *polish, bool forces,
                            size_t members, const double *parameters, double *values,
                            double *jacobian, cpinn_answer *answers, ad_error *error)
{
    static const cpinn_polish usual = {.steps = 2};
    const size_t count = (size_t)family->count;
    const size_t width =
        family->points * (size_t)(forces ? cpinn_family_columns(family) : family->columns);
    polish = polish ? polish : &usual;
    if (polish->steps < 0 || polish->steps > 2) {
        return ad_fail(error, AD_BAD_ARGUMENT, "%d steps; allowed: 0, 1, 2", polish->steps);
    }
    ad_status status = check_range(family, members, parameters, error);
    for (size_t first = 0; first < members && status == AD_OK; first += family->chunk) {
        const size_t left = members - first, now = left < family->chunk ? left : family->chunk;
        const double *given = parameters + first * count;
        double *to = values + first * width,
               *slopes = jacobian ? jacobian + first * width * count : NULL;
        cpinn_answer *said = answers ? answers + first : NULL;
        status = family->solves_all ? answer_motions(family, now, given, to, slopes,
                                                     said ? said : family->unasked, error)
                 : forces
                     ? answer_with_forces(family, polish, now, given, to, slopes, said, error)
                     : answer_chunk(family, polish, false, now, given, to, slopes, said, error);
    }
    return status;
}

ad_status cpinn_family_answer(cpinn_family *family, const cpinn_polish *polish, size_t members,
                              const double *parameters, double *values, double *jacobian,
                              cpinn_answer *answers, ad_error *error)
{
    return answer_all(family, polish, family->forces, members, parameters, values, jacobian,
                      answers, error);
}

ad_status cpinn_family_shapes(cpinn_family *family, const cpinn_polish *polish, size_t members,
                              const double *parameters, double *values, double *jacobian,
                              cpinn_answer *answers, ad_error *error)
{
    return answer_all(family, polish, false, members, parameters, values, jacobian, answers, error);
}

ad_status cpinn_family_margin(cpinn_family *family, size_t members, const double *parameters,
                              double *margin, double *by, ad_error *error)
{
    const size_t count = (size_t)family->count;
    ad_status status = AD_OK;
    if (!family->solver) {
        cpinn_put_nothing(SOLVE_MARGINS * members, margin);
        cpinn_put_nothing(by ? SOLVE_MARGINS * members * count : 0, by);
        return AD_OK;
    }
    for (size_t first = 0; first < members && status == AD_OK; first += family->chunk) {
        const size_t left = members - first, now = left < family->chunk ? left : family->chunk;
        const double *given = parameters + first * count;
        status = solve_members_curvature(family->solver, now, given, NULL, family->curvature,
                                         family->solved, error);
        if (status == AD_OK) {
            status = solve_members_margin(family->solver, now, given, family->curvature,
                                          margin + SOLVE_MARGINS * first,
                                          by ? by + SOLVE_MARGINS * first * count : NULL, error);
        }
    }
    return status;
}

ad_status cpinn_family_evaluate(cpinn_family *family, const cpinn_polish *polish, size_t members,
                                const double *parameters, double *values, cpinn_answer *answers,
                                ad_error *error)
{
    AD_LEAVE_HOST;
    return cpinn_family_answer(family, polish, members, parameters, values, NULL, answers, error);
}

ad_status cpinn_family_jacobian(cpinn_family *family, size_t members, const double *parameters,
                                double *values, double *jacobian, cpinn_answer *answers,
                                ad_error *error)
{
    AD_LEAVE_HOST;
    return cpinn_family_answer(family, NULL, members, parameters, values, jacobian, answers, error);
}
