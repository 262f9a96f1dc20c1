/* The folder of a run: checkpoint.h5, history.csv, config.yaml and lock, an empty file. */
#ifndef TOOLS_TRAIN_RUN_H
#define TOOLS_TRAIN_RUN_H

#include "tools/train/trainer.h"

typedef struct run_folder {
    char path[3800];
    char checkpoint[4096];
    char history[4096];
    char config[4096];
    int held, lock;      /* descriptors of the folder and of its file lock; 0: none */
    FILE *rows;          /* history.csv, open for appending */
    size_t rows_written; /* rows of the history already there */
} run_folder;

/* Names only; nothing is touched. AD_BAD_INPUT: the path is too long. */
ad_status run_name(run_folder *run, const char *path, ad_error *error);

/* The checkpoint of a run, `path`: its folder, its checkpoint.h5 or any such file; `found` receives
 * the name of the file. AD_BAD_ARGUMENT: the path is too long; errors as of checkpoint_open. */
ad_status run_open_checkpoint(const char *path, char found[4096], checkpoint **file,
                              ad_error *error);

/* AD_BAD_INPUT when the folder already holds a run. */
ad_status run_check_new(const run_folder *run, ad_error *error);

/* Keeps the folder for this process until run_end, or until the process is gone. The folder itself
 * is locked, and its file lock as well: NFS locks no folders. AD_BAD_INPUT: another one has it;
 * AD_IO. A file system without locks is used without, and where there is no run to be resumed
 * nothing is done. */
ad_status run_lock(run_folder *run, bool resume, ad_error *error);

/* Before files are put in place by their names. AD_NOT_WRITTEN: the folder was removed or renamed,
 * and what has its name now may be another run's. */
ad_status run_check_held(const run_folder *run, ad_error *error);

/* Of what is kept from run to run: $XDG_CACHE_HOME/cpinn, else $HOME/.cache/cpinn (XDG Base
 * Directory Specification); made, if `make`. False: there is none, or no room for its name. */
bool run_cache_folder(char *path, size_t room, bool make);

/* Make the folder `path`, of less than 4000 bytes, and what leads to it. */
ad_status run_make_folder(const char *path, ad_error *error);

/* Write config.yaml, `config`, start history.csv from the rows so far. A new run saves its first
 * checkpoint before, so that whatever a killed process leaves can be resumed. */
ad_status run_begin(run_folder *run, const char *config, const history *h, ad_error *error);

/* Append the rows that history.csv does not have yet. */
ad_status run_append(run_folder *run, const history *h, ad_error *error);

void run_end(run_folder *run);

#endif
