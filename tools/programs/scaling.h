/* A model of the time of a training step over several ranks:
 *
 *   step(P)     = work(P) + sums(P) + repeated(P)
 *   work(P)     = crowded(P) w(P)
 *   sums(P)     = 0 for P = 1, else e(P) (latency + (P - 1) message) + b(P) / bandwidth
 *   repeated(P) = crowded(P) r
 *   crowded(P)  = threads at work on a machine / its processors, at least 1
 *
 * w: seconds of the busiest thread of the busiest rank, on a processor of its own, for its points;
 * there are shares of points, so w falls by steps, and no further once every rank has at most one.
 * e, b: exchanges of a step, in which each rank sends a message to every other one, and bytes that
 * a rank sends in them. r: what every rank does by itself, whatever their number. Ranks of one
 * machine exchange by its memory; where there are several machines the network's numbers count, and
 * the ranks of a machine share its bandwidth.
 *
 * Not in it: ranks that wait because others are disturbed, machines of different speed, a network
 * that others use. */
#ifndef TOOLS_PROGRAMS_SCALING_H
#define TOOLS_PROGRAMS_SCALING_H

typedef struct scaling_network {
    const char *name;
    double latency;   /* s, of an exchange */
    double message;   /* s, from one message of a rank to its next */
    double bandwidth; /* bytes/s: of a rank within a machine, of a machine between them */
} scaling_network;

/* Between processes of one machine by Open MPI 4.1, as measured on two processors of a server;
 * between machines as of InfiniBand HDR100. */
extern const scaling_network scaling_memory, scaling_infiniband;

/* Where ranks run: each machine takes the next `ranks` of them. */
typedef struct scaling_machine {
    int threads;    /* of a rank */
    int processors; /* of a machine */
    int ranks;      /* on a machine at most */
} scaling_machine;

/* Of the busiest among so many ranks. */
typedef struct scaling_load {
    double work;      /* w, s */
    double exchanges; /* e */
    double bytes;     /* b */
    double repeated;  /* r, s */
} scaling_load;

typedef struct scaling_time {
    double work, sums, repeated, step; /* s */
} scaling_time;

scaling_time scaling_step(const scaling_machine *machine, int ranks, const scaling_load *load);

#endif
