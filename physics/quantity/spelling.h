/* How far two words are apart, to suggest the one that was meant. */
#ifndef PHYSICS_QUANTITY_SPELLING_H
#define PHYSICS_QUANTITY_SPELLING_H

#include <stddef.h>

/* Levenshtein distance of two short words; large for long ones. */
int spelling_distance(const char *a, size_t a_length, const char *b, size_t b_length);

#endif
