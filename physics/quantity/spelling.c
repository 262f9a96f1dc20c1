#include "physics/quantity/spelling.h"

int spelling_distance(const char *a, size_t a_length, const char *b, size_t b_length)
{
    enum { LONGEST = 40 };
    int row[LONGEST + 1];
    if (a_length > LONGEST || b_length > LONGEST) {
        return 1000;
    }
    for (size_t j = 0; j <= b_length; j++) {
        row[j] = (int)j;
    }
    for (size_t i = 1; i <= a_length; i++) {
        int diagonal = row[0];
        row[0] = (int)i;
        for (size_t j = 1; j <= b_length; j++) {
            int replace = diagonal + (a[i - 1] != b[j - 1]);
            int change = row[j] < row[j - 1] ? row[j] + 1 : row[j - 1] + 1;
            diagonal = row[j];
            row[j] = replace < change ? replace : change;
        }
    }
    return row[b_length];
}
