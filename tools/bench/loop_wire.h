/* What the robot and its controller tell each other, as datagrams on the loopback. */
#ifndef BENCH_LOOP_WIRE_H
#define BENCH_LOOP_WIRE_H

#include <arpa/inet.h>
#include <errno.h>
#include <sched.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { WIRE_PORT = 47110, WIRE_SENSORS = 8, WIRE_VALUES = 4, WIRE_INPUTS = 24 };

typedef struct wire_seen { /* from the robot */
    int64_t sample;
    double values[WIRE_SENSORS][WIRE_VALUES]; /* NaN: not taken in this sample */
} wire_seen;

typedef struct wire_told { /* to the robot */
    int64_t sample;
    int32_t wished, ends; /* 1: `wish` is judged; 1: it ends */
    double inputs[WIRE_INPUTS], wish[3];
} wire_told;

static inline double wire_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static inline void wire_sleep_until(double seconds)
{
    struct timespec then;
    then.tv_sec = (time_t)seconds;
    then.tv_nsec = (long)((seconds - (double)then.tv_sec) * 1e9);
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &then, NULL) != 0) {
    }
}

/* A socket at `port` of the loopback that sends to the other one; exits where there is none. */
static inline int wire_open(int port, int other)
{
    struct sockaddr_in address;
    const int s = socket(AF_INET, SOCK_DGRAM, 0);
    memset(&address, 0, sizeof address);
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons((uint16_t)port);
    int bad = s < 0 || bind(s, (struct sockaddr *)&address, sizeof address) != 0;
    address.sin_port = htons((uint16_t)other);
    if (bad || connect(s, (struct sockaddr *)&address, sizeof address) != 0) {
        perror("the loopback");
        exit(1);
    }
    return s;
}

/* The newest datagram of `size` that is there; how many there were. */
static inline int wire_newest(int s, void *to, size_t size)
{
    int count = 0;
    for (;;) {
        const ssize_t got = recv(s, to, size, MSG_DONTWAIT);
        if (got < 0 && errno != ECONNREFUSED) { /* that: of what was sent to nobody before */
            return count;
        }
        count += got == (ssize_t)size;
    }
}

/* Before all that is not urgent, with memory that stays, as far as that is permitted. */
static inline void wire_be_urgent(int priority)
{
    struct sched_param first;
    memset(&first, 0, sizeof first);
    first.sched_priority = priority;
    const int urgent = sched_setscheduler(0, SCHED_FIFO, &first) == 0;
    const int locked = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
    printf("SCHED_FIFO %s, memory %s\n", urgent ? "yes" : "not permitted",
           locked ? "locked" : "not locked");
}

static inline int wire_by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Of seconds [count], which are sorted. */
static inline void wire_say(const char *what, long count, double *seconds)
{
    qsort(seconds, (size_t)count, sizeof *seconds, wire_by_size);
    printf("%-22s median %8.1f us, 99.9 %% %8.1f us, worst %8.1f us\n", what,
           1e6 * seconds[count / 2], 1e6 * seconds[count - 1 - count / 1000],
           1e6 * seconds[count - 1]);
}

#endif
