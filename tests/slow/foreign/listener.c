/* Decodes the channels of CHANNELS by what lcm-gen made; prints counts and sums when its input ends.
   channels.h: the headers, and #define CHANNELS X(number, type, "channel") ... */

#include <inttypes.h>
#include <lcm/lcm.h>
#include <poll.h>
#include <stdio.h>
#include <unistd.h>
#include "channels.h"

struct sum { int64_t count, utime, seq; };

#define X(number, type, name) \
    static struct sum sum_##number; \
    static void hear_##number(const lcm_recv_buf_t *buffer, const char *channel, const type *message, void *user) \
    { \
        (void)buffer, (void)channel, (void)user; \
        sum_##number.count++; \
        sum_##number.utime += message->utime; \
        sum_##number.seq += message->seq; \
    }
CHANNELS
#undef X

int main(int argc, char **argv)
{
    lcm_t *lcm = argc > 1 ? lcm_create(argv[1]) : NULL;
    if (!lcm)
        return 1;
#define X(number, type, name) type##_subscription_set_queue_capacity(type##_subscribe(lcm, name, hear_##number, NULL), 0);
    CHANNELS
#undef X
    printf("ready\n");
    fflush(stdout);
    struct pollfd ends[] = {{STDIN_FILENO, POLLIN, 0}, {lcm_get_fileno(lcm), POLLIN, 0}};
    while (poll(ends, 2, -1) > 0 && !ends[0].revents)
        lcm_handle(lcm);
    while (lcm_handle_timeout(lcm, 500) > 0)
        ;
#define X(number, type, name) \
    printf("%s %" PRId64 " %" PRId64 " %" PRId64 "\n", name, sum_##number.count, sum_##number.utime, sum_##number.seq);
    CHANNELS
#undef X
    lcm_destroy(lcm);
    return 0;
}
