/* Steps by compiled programs, once a run has lasted. */
#include "tools/train/clock.h"
#include "tools/train/run.h"
#include "tools/train/trainer_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Is there a program cc in one of the folders of PATH? */
static bool has_compiler(void)
{
    char path[4200];
    for (const char *at = getenv("PATH"); at && *at;) {
        int length = (int)strcspn(at, ":");
        if (length > 0 && snprintf(path, sizeof path, "%.*s/cc", length, at) < (int)sizeof path &&
            access(path, X_OK) == 0) {
            return true;
        }
        at += length + (at[length] == ':');
    }
    return false;
}

bool trainer_fuse_folder(char *path, bool make)
{
    enum { ROOM = 3900 };
    if (!has_compiler() || !run_cache_folder(path, ROOM, make)) {
        return false;
    }
    strcat(path, "/compiled");
    return true;
}

/* What fails is not tried again, and steps go on as they are. */
void trainer_fuse(trainer *t)
{
    if (!*t->compiled && train_seconds() - t->began > TRAINER_FUSE_AFTER && !t->fuse_tried) {
        t->fuse_tried = true;
        if (!trainer_fuse_folder(t->compiled, true)) {
            *t->compiled = '\0';
        }
    }
    if (*t->compiled) {
        problem_fuse(t->problem, t->compiled, false, &t->info.fused, NULL);
    }
}
