/* Files of pixels: one as PNG, many given to an encoder for a movie. */
#ifndef TOOLS_PICTURE_IMAGES_H
#define TOOLS_PICTURE_IMAGES_H

#include "autodiff/error.h"

#include <stddef.h>

/* bytes [size], which the caller frees, of rgb [height][width][3]. AD_NO_MEMORY. */
ad_status image_png(int width, int height, const unsigned char *rgb, unsigned char **bytes,
                    size_t *size, ad_error *error);

/* A movie by ffmpeg, which gets the images through a pipe; only one at a time. The file, .mp4,
 * .webm or .gif, which goes on for ever, appears when it is whole. AD_BAD_INPUT: ffmpeg is not
 * installed; AD_NOT_WRITTEN: it failed, and how. */
typedef struct image_movie image_movie;
ad_status image_movie_begin(const char *path, int width, int height, int per_second,
                            image_movie **result, ad_error *error);
ad_status image_movie_add(image_movie *movie, const unsigned char *rgb, ad_error *error);
ad_status image_movie_end(image_movie *movie, ad_error *error);
void image_movie_free(image_movie *movie); /* without an end there is no file; NULL is allowed */

#endif
