/* A camera driver in C: publishes the raw gray pictures that it reads as graphnav_lcm.image_t, stamped as they come.
 *
 *   ffmpeg -i VIDEO -f rawvideo -pix_fmt gray -s 160x120 - | ./camera 160 120 CAMERA
 *
 * The message is a zeroed struct of which only what must be known is set: size and pixels of the picture, and when it was
 * taken. A step_px of 0 counts as 1. Without seq a run cannot count what the network loses, nor tell two cameras on one
 * channel apart by their numbers: count it where you can.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <lcm/lcm.h>

#include "graphnav_lcm_image_t.h"

int main(int argc, char **argv)
{
    if (argc < 3) {
        fprintf(stderr, "usage: %s COLS ROWS [CHANNEL] < gray pictures\n", argv[0]);
        return 2;
    }
    graphnav_lcm_image_t image;
    memset(&image, 0, sizeof image);
    image.cols = atoi(argv[1]);
    image.rows = atoi(argv[2]);
    image.channels = 1;
    image.size = image.rows * image.cols;
    image.data = malloc((size_t)image.size);
    lcm_t *lcm = lcm_create(NULL); /* LCM_DEFAULT_URL, else the group of this machine */
    if (!lcm || !image.data || image.size <= 0)
        return 1;
    while (fread(image.data, (size_t)image.size, 1, stdin) == 1) {
        struct timespec now;
        clock_gettime(CLOCK_REALTIME, &now);
        image.utime = (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000; /* microseconds of the time of day */
        graphnav_lcm_image_t_publish(lcm, argc > 3 ? argv[3] : "CAMERA", &image);
    }
    free(image.data);
    lcm_destroy(lcm);
    return 0;
}
