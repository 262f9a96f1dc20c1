/* For tests of files: a folder of their own, gone afterwards. */
#ifndef TESTS_TEMPORARY_FOLDER_H
#define TESTS_TEMPORARY_FOLDER_H

#include <dirent.h>
#include <hdf5.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char directory[64];

static inline const char *at(const char *name)
{
    static char path[2][512];
    static int turn;
    turn = !turn;
    snprintf(path[turn], sizeof path[turn], "%s/%s", directory, name);
    return path[turn];
}

static inline int make_directory(void **state)
{
    (void)state;
    strcpy(directory, "/tmp/cpinn_test_XXXXXX");
    return mkdtemp(directory) ? 0 : -1;
}

/* Number of entries; removes them if asked to. */
static inline int entries(int remove_them)
{
    int count = 0;
    DIR *dir = opendir(directory);
    for (struct dirent *entry; dir && (entry = readdir(dir));) {
        if (entry->d_name[0] != '.') {
            count++;
            if (remove_them) {
                remove(at(entry->d_name));
            }
        }
    }
    if (dir) {
        closedir(dir);
    }
    return count;
}

static inline int remove_directory(void **state)
{
    (void)state;
    entries(1);
    rmdir(directory);
    return H5Fget_obj_count(H5F_OBJ_ALL, H5F_OBJ_ALL) == 0 ? 0 : -1; /* no identifier leaks */
}

#endif
