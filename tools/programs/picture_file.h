/* Pictures as files. */
#ifndef TOOLS_PROGRAMS_PICTURE_FILE_H
#define TOOLS_PROGRAMS_PICTURE_FILE_H

#include "tools/picture/picture.h"

/* As .svg or .png, by the ending of the path. AD_NO_MEMORY, AD_IO, AD_NOT_WRITTEN. */
ad_status picture_file_write(const picture *p, const char *path, ad_error *error);

/* Whether the path has one of these endings, and a folder. AD_BAD_ARGUMENT, AD_IO. */
ad_status picture_file_check(const char *path, ad_error *error);

#endif
