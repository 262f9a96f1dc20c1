/* A trained model as an FMU of FMI 3.0 (fmi-standard.org): Model Exchange and Co-Simulation, as
 * sources and, where `cc` is there, as a shared library for this machine.
 *
 *   modelDescription.xml, sources/buildDescription.xml
 *   sources/NAME.h, NAME.c     the model, as cpinn-export --c writes it
 *   sources/NAME_fmi3.c        the functions of the standard around it (fmi3_functions.c)
 *   binaries/PLATFORM/NAME.so
 *
 * All variables are scalars of type Float64, which every importer takes: of several places, "x[1]"
 * and "x[2]" are the x of the first and the second. The number of places is fixed at export: a size
 * that is a structural parameter is beyond most importers (FMPy 0.3.32 fails as soon as it is
 * changed). In motion s of each place is a parameter that can be tuned, at rest an input. Beyond
 * the ranges of the model outputs stay as they are at the nearer end; a warning is logged once, and
 * the output out_of_range is by how much of a range it has been left, else 0. It is a continuous
 * number, because a Boolean could change in events only, and there are none. */
#ifndef TOOLS_EMIT_FMU_H
#define TOOLS_EMIT_FMU_H

#include "autodiff/error.h"

#include <stdbool.h>
#include <stdio.h>

enum { FMU_PLACES_MAX = 64, FMU_INPUTS_MAX = 2, FMU_NOTE = 512 };

typedef struct fmu_variable {
    const char *name, *unit; /* of the SI; "" for 1 */
    double lower, upper;     /* range of an input */
} fmu_variable;

/* All of it is borrowed. */
typedef struct fmu_model {
    const char *name;                     /* of functions and files, an identifier of C */
    const char *title;                    /* of the run */
    const char *description;              /* one or more sentences */
    const char *tool;                     /* "cpinn 0.1.0" */
    const char *header, *source;          /* texts of NAME.h and NAME.c */
    const fmu_variable *inputs, *outputs; /* inputs are s and, in motion, t */
    int input_count, output_count;
    const double *places; /* [place_count] m, s at the start of a simulation */
    int place_count;
} fmu_model;

/* Write it to `path`, replacing what is there. *compiled says whether a shared library is in it, if
 * not, `note` why. AD_BAD_ARGUMENT: inputs, places or units that are not as said; AD_IO,
 * AD_NO_MEMORY. */
ad_status fmu_write(const fmu_model *model, const char *path, bool *compiled, char note[FMU_NOTE],
                    ad_error *error);

#endif
