/* Markers that are seen beside where a model has them, by offsets that walk randomly and fade:
 * states of a filter behind those of the model, three for each marker, with o' = -o/fade + noise.
 * They take up what a model misses for longer than a sample, the shape of a rod that is not quite
 * its own, so that the states of the model do not. */
#ifndef CONTROL_MARKER_DRIFT_H
#define CONTROL_MARKER_DRIFT_H

#include "physics/local/one_step.h"

enum { MARKER_DRIFT_MAX = 16 };

typedef struct marker_drift {
    one_step model; /* borrowed, as the observations */
    int markers;
    double fade;  /* s; 0: never */
    double *room; /* [states][states] of the model; needed where it doubts */
    struct marker_drift_eye {
        const struct marker_drift *of;
        one_observation observation; /* of a place: three values */
        int marker;
    } eye[MARKER_DRIFT_MAX];
} marker_drift;

/* The model with these states, and what is seen of a marker of `eye`. Filled, the structure stays
 * where it is. Neither has derivatives: asked for them they have no answer. */
one_step marker_drift_model(marker_drift *drift);
one_observation marker_drift_see(marker_drift *drift, int marker);

#endif
