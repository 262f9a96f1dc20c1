/* What the files of the estimator share; not for others. */
#ifndef CONTROL_ESTIMATOR_INTERNAL_H
#define CONTROL_ESTIMATOR_INTERNAL_H

#include "tools/control/estimator.h"
#include "tools/control/sigma_points.h"
#include "tools/control/small_matrix.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* Of a measurement of a sensor at a sample. */
enum { ESTIMATOR_NONE, ESTIMATOR_UNUSABLE, ESTIMATOR_FRESH, ESTIMATOR_USED, ESTIMATOR_REFUSED };

/* One of the last samples. */
typedef struct estimator_record {
    double *z, *u;  /* [n], [kept] before its measurements */
    double *until;  /* [inputs] that acted until it */
    double *inputs; /* [2][inputs] from it on to the next, at both ends */
    double *values; /* [values] of all sensors */
    bool moves;     /* the inputs: the ends differ */
    double grow;    /* of the root of the covariance after the measurements */
    unsigned char state[ESTIMATOR_SENSORS_MAX];
} estimator_record;

typedef struct estimator_sensor_record {
    int width, offset; /* numbers that are compared; values in front of its own */
    int row;           /* outliers in a row */
    double gate, low, high, bias_high, sum;
    double *window;     /* [settings.window] */
    double *innovation; /* [width] */
    double *normal;     /* [width] of it, normalised: P_vv^(-1/2) of it */
    double *normals;    /* [settings.window][width] */
    int next, count;
    double last;
    double process; /* times settings.process, as it needs */
    int64_t used, missing, not_finite, late, outliers;
} estimator_sensor_record;

struct estimator {
    estimator_settings settings;
    sigma_points sigma;
    int n, states, inputs, stride, slots, values, most; /* most: of values of one sensor */
    int64_t sample;                                     /* the present one */
    int shortest;                                       /* delay: z, u are so many samples behind */
    int64_t at, checked; /* z, u are of this sample; missing measurements were counted */
    int flags;
    double outside;
    double process; /* times settings.process */
    double doubt;   /* its mean over the last `doubted` times that it was adapted */
    int64_t doubted;
    int kept;                 /* numbers of u and, behind it, of the memory of model.doubt */
    double *z, *u;            /* [n], [n][stride] of [kept] */
    double *now;              /* [inputs] */
    double *ahead;            /* [states] at the present sample */
    double *states_at, *next; /* [2 n + 1][states] */
    double *inputs_at;        /* [2 n + 1][2][inputs] */
    double *seen, *mean;      /* [2 n + 1][most], [most] */
    double *rows;             /* [3 n + 1][stride] */
    double *d, *b, *room;     /* of sigma_gather, sigma_correct */
    double *before;           /* [n] */
    double *unknown;          /* [3][n][stride], where the model doubts */
    estimator_record *record; /* [slots] */
    estimator_sensor_record sensor[ESTIMATOR_SENSORS_MAX];
};

/* Numbers beyond it are as good as none: their squares would not be finite. */
static inline bool estimator_is_usable(size_t count, const double *x)
{
    bool usable = true;
    for (size_t i = 0; i < count; i++) {
        usable &= fabs(x[i]) < 1e100;
    }
    return usable;
}

static inline estimator_record *estimator_record_of(const estimator *estimator, int64_t sample)
{
    return &estimator->record[sample % estimator->slots];
}

/* Of a parameter: what is estimated of it, back, and the standard deviation of a uniform
 * distribution over the range, which none exceeds. */
double estimator_coordinate(const estimator_parameter *p, double value);
double estimator_value(const estimator_parameter *p, double z);
double estimator_slope(const estimator_parameter *p, double value); /* of the value by it */
double estimator_uniform(const estimator_parameter *p);

/* By a standard normal number, on either side. */
#define ESTIMATOR_ONCE_IN_1000 3.29

/* Steps of z, u: from a sample to the next by the model, and by the measurements at estimator->at.
 */
void estimator_go_on(estimator *estimator, const estimator_record *from);
void estimator_take(estimator *estimator, estimator_record *at);

/* Whether states [count][states] may be an answer of the model: none is beyond 1e12 times its
 * largest deviation, where rounding would be all there is. */
bool estimator_is_answer(const estimator *estimator, int count, const double *states);

/* estimator->ahead from z by the model alone, to the present sample. */
void estimator_look_ahead(estimator *estimator);

#endif
