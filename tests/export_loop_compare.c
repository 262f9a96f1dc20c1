/* An exported loop on the measurements that cpinn-control recorded (--out FILE.csv): its inputs and
 * what it finds are those of the record. Of one position as sensor.
 *   compare FILE.csv TOLERANCE     by the ranges of the inputs */
#include HEADER

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define JOIN_(a, b) a##_##b
#define JOIN(a, b)  JOIN_(a, b)
#define OF(name)    JOIN(NAME, name)

enum { ROWS = 2000, COLUMNS = 64 };
static double table[ROWS][COLUMNS];
static char head[4096];
static _Alignas(64) unsigned char memory[OF(MEMORY)];

static int column(const char *name)
{
    const char *at = head;
    int i = 0;
    for (; *at; i++) {
        const size_t length = strcspn(at, ",\n");
        if (strlen(name) == length && strncmp(at, name, length) == 0) {
            return i;
        }
        at += length + (at[length] != '\0');
    }
    fprintf(stderr, "no column %s\n", name);
    exit(2);
}

static int read_table(const char *path)
{
    FILE *file = fopen(path, "r");
    char line[4096];
    int rows = 0;
    if (!file || !fgets(head, sizeof head, file)) {
        return 0;
    }
    while (rows < ROWS && fgets(line, sizeof line, file)) {
        char *at = line;
        for (int i = 0; i < COLUMNS && *at && *at != '\n'; i++) {
            table[rows][i] = *at == ',' ? NAN : strtod(at, &at);
            at += *at == ',';
        }
        rows++;
    }
    fclose(file);
    return rows;
}

int main(int argc, char **argv)
{
    OF(loop) *loop = OF(init)(memory, sizeof memory);
    const int rows = argc == 3 ? read_table(argv[1]) : 0, wished = column("reference_x");
    const int seen = column("measured0_0"), each = (int)(OF(LOOK_AHEAD) / OF(SAMPLE) + 0.5);
    const int last = rows - each * OF(HORIZON) - OF(DELAY);
    double worst = 0, path[OF(HORIZON)][3], inputs[OF(CONTROLLED)];
    for (int k = 0; k < last; k++) {
        if (!isnan(table[k][seen])) {
            OF(measure)(loop, 0, -1, table[k] + seen);
        }
        for (int i = 0; i < OF(HORIZON); i++) {
            memcpy(path[i], table[k + OF(DELAY) + (i + 1) * each] + wished, sizeof path[i]);
        }
        OF(control)(loop, path[0], inputs);
        for (int i = 0; i < OF(CONTROLLED); i++) {
            const int input = OF(controlled)[i];
            char name[80];
            snprintf(name, sizeof name, "input_%s", OF(input_names)[input]);
            const double range = OF(upper)[input] - OF(lower)[input];
            const double off = fabs(inputs[i] - table[k + OF(DELAY)][column(name)]) / range;
            worst = off <= worst || isnan(worst) ? worst : off;
        }
        OF(prepare)(loop);
    }
    printf("%d samples: %.1e of the ranges\n", last, worst);
    return !(last > 20 && worst <= atof(argv[2]));
}
