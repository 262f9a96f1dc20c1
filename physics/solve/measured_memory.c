#include "physics/solve/measured_memory.h"

#include "physics/scene/scene_memory.h"

#include <stdlib.h>
#include <string.h>

struct trial_memory {
    const scene *open;
    const solve_measured *measured;
    size_t count, states, first; /* parameters, those of them that are states, the first of these */
    size_t turns, taken;         /* taken: commands of the set at hand */
    double *turned;              /* [turns][count] */
    size_t *begins;              /* [sets + 1] turns of each set */
    int set;                     /* at hand */
    const double *values;
    size_t trials;
    double *before; /* [trials][turns][states] */
    double *slopes; /* [turns][states][count] of the first trial; NULL: not wanted */
};

ad_status trial_memory_create(const scene *open, int sets, const solve_measured *measured,
                              trial_memory **result, ad_error *error)
{
    size_t most = 0;
    const bool any = open->memory_count > 0 && !scene_is_dynamic(open);
    trial_memory *memory = any ? calloc(1, sizeof *memory) : NULL;
    *result = memory;
    for (int i = 0; i < sets; i++) {
        most += measured[i].command ? measured[i].commands : measured[i].rows;
    }
    if (memory) {
        *memory = (trial_memory){.open = open,
                                 .measured = measured,
                                 .count = (size_t)open->parameter_count,
                                 .states = (size_t)open->memory_count,
                                 .first = (size_t)scene_given_count(open),
                                 .set = -1};
        memory->turned = calloc(most * memory->count + 1, sizeof *memory->turned);
        memory->begins = calloc((size_t)sets + 1, sizeof *memory->begins);
    }
    return !any || (memory && memory->turned && memory->begins)
               ? AD_OK
               : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu rows of commands", most);
}

void trial_memory_free(trial_memory *memory)
{
    if (memory) {
        free(memory->turned);
        free(memory->begins);
        free(memory->before);
        free(memory->slopes);
        free(memory);
    }
}

size_t trial_memory_turn(trial_memory *memory, int set, size_t row)
{
    if (!memory) {
        return 0;
    }
    const solve_measured *of = &memory->measured[set];
    const double *commands = of->command ? of->command : of->known;
    const size_t to = of->command ? of->at[row] : row, bytes = memory->first * sizeof(double);
    memory->taken = set == memory->set ? memory->taken : 0;
    for (; memory->set < set; memory->set++) {
        memory->begins[memory->set + 1] = memory->turns;
    }
    for (; memory->taken <= to; memory->taken++) {
        const double *at = commands + memory->taken * memory->count;
        if (memory->taken == 0 || memcmp(at, at - memory->count, bytes) != 0) {
            memcpy(memory->turned + memory->turns++ * memory->count, at, bytes);
        }
    }
    memory->begins[set + 1] = memory->turns;
    return memory->turns - 1;
}

/* One trial. */
static void follow(trial_memory *memory, const double *values, double *before, double *slopes)
{
    const size_t count = memory->count, known = memory->first + memory->states;
    for (size_t i = 0; i < memory->turns; i++) {
        memcpy(memory->turned + i * count + known, values, (count - known) * sizeof *values);
    }
    for (int k = 0; k <= memory->set; k++) {
        const size_t from = memory->begins[k];
        scene_remember_path(memory->open, memory->begins[k + 1] - from,
                            memory->turned + from * count,
                            slopes ? slopes + from * memory->states * count : NULL);
    }
    for (size_t i = 0; i < memory->turns; i++) {
        memcpy(before + i * memory->states, memory->turned + i * count + memory->first,
               memory->states * sizeof *before);
    }
}

ad_status trial_memory_follow(trial_memory *memory, size_t trials, const double *values,
                              bool slopes, ad_error *error)
{
    if (!memory) {
        return AD_OK;
    }
    const size_t each = memory->turns * memory->states;
    free(memory->before);
    free(memory->slopes);
    memory->values = values;
    memory->trials = trials;
    memory->before = malloc((trials * each + 1) * sizeof *memory->before);
    memory->slopes = slopes ? malloc((each * memory->count + 1) * sizeof *memory->slopes) : NULL;
    if (!memory->before || (slopes && !memory->slopes)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu trials", trials);
    }
    const size_t unknowns = memory->count - memory->first - memory->states;
    for (size_t i = 0; i < trials; i++) {
        follow(memory, values + i * unknowns, memory->before + i * each,
               i == 0 ? memory->slopes : NULL);
    }
    return AD_OK;
}

void trial_memory_fill(const trial_memory *memory, const double *values, size_t turn,
                       double *parameters)
{
    if (memory) {
        const size_t unknowns = memory->count - memory->first - memory->states;
        const size_t trial = unknowns > 0 ? (size_t)(values - memory->values) / unknowns : 0;
        memcpy(parameters + memory->first,
               memory->before + (trial * memory->turns + turn) * memory->states,
               memory->states * sizeof *parameters);
    }
}

double trial_memory_change(const trial_memory *memory, size_t turn, size_t parameter,
                           const double *column)
{
    double sum = column[parameter];
    for (size_t m = 0; memory && m < memory->states; m++) {
        sum += column[memory->first + m] *
               memory->slopes[(turn * memory->states + m) * memory->count + parameter];
    }
    return sum;
}
