/* The rows of history as event files of TensorBoard (tools/files/event_file.h) in the folder of a
 * run: events.out.tfevents.NUMBER.cpinn, of which NUMBER is the first row that the file has,
 * counted from 0 in ten digits. Every process that works on the run begins a file, and takes from
 * those before what the checkpoint does not know of; so no row is there twice. */
#ifndef TOOLS_TRAIN_RUN_EVENTS_H
#define TOOLS_TRAIN_RUN_EVENTS_H

#include "tools/train/history.h"

/* The name of a file in `folder`, into path [size]. */
void run_events_path(const char *folder, size_t first_row, char *path, size_t size);

/* A file for the rows to come, and for those so far that no other has; to be closed by the caller.
 * AD_IO, AD_NOT_WRITTEN, AD_NO_MEMORY. */
ad_status run_events_begin(const char *folder, const history *h, FILE **result, ad_error *error);

/* One row, all of its columns, at the wall time of now; flushed. AD_NOT_WRITTEN. */
ad_status run_events_append(FILE *file, const history *h, size_t row, ad_error *error);

#endif
