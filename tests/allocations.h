/* Count the project's allocations and make the n-th of them fail. For one test program each, linked
 * with cpinn_wrap_allocations (tests/CMakeLists.txt); what a library does inside itself is not
 * seen. */
#ifndef TESTS_ALLOCATIONS_H
#define TESTS_ALLOCATIONS_H

#include <errno.h>
#include <stdbool.h>
#include <stddef.h>

static long allocations;        /* counted so far */
static long failing_allocation; /* 1, 2, 3, ...: the one that fails; 0: none */
static bool allocations_count = true;

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
int __real_posix_memalign(void **memory, size_t alignment, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *memory, size_t size);
int __wrap_posix_memalign(void **memory, size_t alignment, size_t size);

static bool allocation_fails(void)
{
    return allocations_count && ++allocations == failing_allocation;
}

void *__wrap_malloc(size_t size)
{
    return allocation_fails() ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    return allocation_fails() ? NULL : __real_calloc(count, size);
}

void *__wrap_realloc(void *memory, size_t size)
{
    return allocation_fails() ? NULL : __real_realloc(memory, size);
}

int __wrap_posix_memalign(void **memory, size_t alignment, size_t size)
{
    return allocation_fails() ? ENOMEM : __real_posix_memalign(memory, alignment, size);
}

#endif
