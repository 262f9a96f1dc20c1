/* Event files of TensorBoard: scalars against steps and wall time.
 *
 * A file is a chain of TFRecords (tensorflow/core/lib/io/record_writer.h), all little endian:
 *   uint64 length; uint32 masked CRC-32C of these 8 bytes; length bytes; masked CRC-32C of them
 * where a checksum c is masked as ((c >> 15) | (c << 17)) + 0xa282ead8. Each record is an Event in
 * the encoding of protocol buffers; the fields that are written, with their numbers:
 *   Event (tensorflow/core/util/event.proto): wall_time 1 double, step 2 int64,
 *     file_version 3 string, summary 5 Summary, session_log 7 SessionLog {status 1: START = 1}
 *   Summary (tensorflow/core/framework/summary.proto): value 1, repeated {tag 1 string,
 *     simple_value 2 float}
 * Two records begin a file: the version "brain.Event:2", and the start of a session, from whose
 * step on TensorBoard forgets what it has read before. */
#ifndef TOOLS_FILES_EVENT_FILE_H
#define TOOLS_FILES_EVENT_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* Records that begin a file. */
enum { EVENTS_BEGIN = 2 };

/* CRC-32C (Castagnoli), RFC 3720 B.4. */
uint32_t events_crc(const void *bytes, size_t size);

/* wall: seconds since 1970; step: the first that is to come. Errors are those of the stream. */
void events_begin(FILE *file, double wall, int64_t step);

/* One record, of values [count] under their names; those that are NaN are left out, and so is what
 * does not fit into 4 kB. Does not allocate. */
void events_scalars(FILE *file, double wall, int64_t step, int count, const char *const *names,
                    const double *values);

/* How many whole records with right checksums the bytes begin with, `limit` at most; they end at
 * *end. */
size_t events_records(const unsigned char *bytes, size_t size, size_t limit, size_t *end);

#endif
