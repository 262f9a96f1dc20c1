/* The simulated robot of loop_host.c: the reduced rod of control.plant, in a process of its own and
 * in real time.
 *   loop_plant CONFIG.yaml [--set KEY=VALUE]... */
#define _GNU_SOURCE
#include "tools/bench/loop_wire.h"

#include "tools/control/plant.h"
#include "tools/prepare/prepare.h"

#include <math.h>

enum { SET_MAX = 64 };

typedef struct robot {
    config *nominal, *changed;
    plant *body;
    double inputs[SCENE_PARAMETERS_MAX];
    int controlled[SCENE_PARAMETERS_MAX], count;
} robot;

static ad_status open_robot(robot *r, const char *path, int count, const char **set,
                            ad_error *error)
{
    ad_status status = prepare_read_robot(path, count, set, &r->nominal, &r->changed, error);
    if (status != AD_OK) {
        return status;
    }
    const control_settings *c = &r->nominal->control;
    const scene *open = &r->nominal->scene;
    const surrogate_settings model = control_model_of(&r->nominal->surrogate);
    for (int k = 0; k < open->parameter_count; k++) {
        const scene_parameter *p = &open->parameters[k];
        r->inputs[k] = control_role_of(c, &model, p->name) == CONTROL_INPUT
                           ? fmax(p->low, 0)
                           : (p->low + p->high) / 2;
        if (control_role_of(c, &model, p->name) == CONTROL_INPUT) {
            r->controlled[r->count++] = k;
        }
    }
    return plant_create(&r->changed->scene, open, c, NULL, &r->body, error);
}

static ad_status see(robot *r, int64_t sample, wire_seen *seen, ad_error *error)
{
    const control_settings *c = &r->nominal->control;
    ad_status status = AD_OK;
    int count;
    seen->sample = sample;
    for (int i = 0; i < c->measurement_count && i < WIRE_SENSORS && status == AD_OK; i++) {
        status = plant_measure(r->body, i, seen->values[i], &count, error);
    }
    return status;
}

static void take(robot *r, const wire_told *told)
{
    for (int i = 0; i < r->count; i++) {
        r->inputs[r->controlled[i]] = told->inputs[i];
    }
}

int main(int argc, char **argv)
{
    robot r = {0};
    ad_error error = {.message = ""};
    const char *set[SET_MAX];
    int sets = 0;
    for (int i = 2; i + 1 < argc && sets < SET_MAX; i += 2) {
        set[sets++] = argv[i + 1];
    }
    if (argc < 2 || open_robot(&r, argv[1], sets, set, &error) != AD_OK) {
        fprintf(stderr, "loop_plant: %s\n", argc < 2 ? "give CONFIG.yaml" : error.message);
        return 2;
    }
    const double period = r.nominal->control.period;
    const int s = wire_open(WIRE_PORT, WIRE_PORT + 1);
    wire_told told = {0};
    while (wire_newest(s, &told, sizeof told) == 0) {
        wire_sleep_until(wire_seconds() + 0.01);
    }
    take(&r, &told);
    wire_be_urgent(70);
    ad_status status = plant_start(r.body, r.inputs, 1, &error);
    double next = wire_seconds(), squares = 0, worst = 0, longest = 0;
    long judged = 0, late = 0, silent = 0;
    for (int64_t k = 0; !told.ends && status == AD_OK; k++, next += period) {
        wire_seen seen;
        double place[3], off = 0;
        const double begin = wire_seconds();
        status = see(&r, k, &seen, &error);
        status = status == AD_OK ? plant_place(r.body, place, &error) : status;
        if (status != AD_OK) {
            break;
        }
        send(s, &seen, sizeof seen, 0);
        silent++;
        if (silent * period > 10) {
            fprintf(stderr, "loop_plant: nobody is there\n");
            return 1;
        }
        if (wire_newest(s, &told, sizeof told) > 0) {
            silent = 0;
            take(&r, &told);
        }
        if (told.wished) {
            for (int i = 0; i < 3; i++) {
                off += pow(place[i] - told.wish[i], 2);
            }
            squares += off;
            worst = fmax(worst, sqrt(off));
            judged++;
        }
        status = plant_step(r.body, period, r.inputs, &error);
        if (status != AD_OK) {
            break;
        }
        longest = fmax(longest, wire_seconds() - begin);
        late += wire_seconds() > next + period;
        wire_sleep_until(next + period);
    }
    if (status != AD_OK) {
        fprintf(stderr, "loop_plant: %s\n", error.message);
        return 1;
    }
    printf("robot: off the path by %.3g mm rms, %.3g mm worst; %ld periods late, longest %.3g ms\n",
           1e3 * sqrt(squares / (double)judged), 1e3 * worst, late, 1e3 * longest);
    plant_free(r.body);
    config_free(r.changed);
    config_free(r.nominal);
    return 0;
}
