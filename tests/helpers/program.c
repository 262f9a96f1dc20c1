/* The tests of a room, as one program: `main` of each file is `main_NAME` here.
 *   test_ROOM NAME [ARGUMENT...] */
#include <stdio.h>
#include <string.h>

#define ALONE(name) int main_##name(void);
#define GIVEN(name) int main_##name(int count, char **arguments);
#include ROOM
#undef ALONE
#undef GIVEN

int main(int count, char **arguments)
{
    const char *wanted = count > 1 ? arguments[1] : "";
#define ALONE(name)                                                                                \
    if (strcmp(wanted, #name) == 0)                                                                \
        return main_##name();
#define GIVEN(name)                                                                                \
    if (strcmp(wanted, #name) == 0)                                                                \
        return main_##name(count - 1, arguments + 1);
#include ROOM
    fprintf(stderr, "no test '%s' is in this room\n", wanted);
    return 2;
}
