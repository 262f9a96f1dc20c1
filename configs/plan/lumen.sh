#!/bin/sh
# The wall of lumen.yaml as OBJ, in mm: a pipe of 30 mm radius along z, from z = -200, which bends in the
# plane of x and z after the origin: 1.2 rad on an arc of 150 mm. Both ends are closed.
awk 'BEGIN {
    pi = atan2(0, -1); across = 48; straight = 20; bent = 30; rows = straight + bent
    for (i = 0; i <= rows; i++) {
        angle = i > straight ? 1.2 * (i - straight) / bent : 0
        x = 150 * (1 - cos(angle)); z = i > straight ? 150 * sin(angle) : -200 + 10 * i
        for (j = 0; j < across; j++) {
            v = 2 * pi * j / across
            printf "v %.6f %.6f %.6f\n", x + 30 * cos(v) * cos(angle), 30 * sin(v), \
                z - 30 * cos(v) * sin(angle)
        }
    }
    printf "v 0 0 -200\nv %.6f 0 %.6f\n", x, z
    start = (rows + 1) * across + 1; last = rows * across
    for (j = 0; j < across; j++) {
        k = (j + 1) % across
        print "f", start, k + 1, j + 1
        print "f", start + 1, last + j + 1, last + k + 1
        for (i = 0; i < rows; i++)
            print "f", i * across + j + 1, i * across + k + 1, (i + 1) * across + k + 1, \
                (i + 1) * across + j + 1
    }
}'
