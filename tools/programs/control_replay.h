/* Recordings of a scene's data gone through by its filter, as cpinn-control prints them. */
#ifndef TOOLS_PROGRAMS_CONTROL_REPLAY_H
#define TOOLS_PROGRAMS_CONTROL_REPLAY_H

#include "physics/scene/verdict.h"
#include "tools/config/config.h"
#include "tools/control/replay.h"
#include "tools/files/json.h"

enum { REPLAYS_MAX = 64 };

typedef struct replays {
    int count, estimates;
    char name[REPLAYS_MAX][80]; /* of the file */
    bool held_out[REPLAYS_MAX];
    replay_report report[REPLAYS_MAX];
    double ahead; /* s */
} replays;

/* All recordings of the data. AD_BAD_INPUT, with file and key: none of them has inputs over time;
 * those of measurements_read and replay_run. */
ad_status replays_run(const config *of, const loop_setup *setup, const replay_settings *settings,
                      replays *result, ad_error *error);
void replays_print(const config *of, const replays *replays, const char *model);
void replays_json(const config *of, const replays *replays, json *to);

/* What is further from what the files say of it than its deviation explains, and what the model
 * leaves out. */
void replays_judge(const config *of, const replays *replays, verdict *to);

#endif
