/* The driver of a differential drive: receives graphnav_lcm.twist_t, prints the speeds of the wheels.
 *
 * It has a timeout of its own: when no command came for TIMEOUT_S it stands, whatever has become of the sender. No
 * sender can promise that: it may have lost power, or the network.
 */
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <time.h>

#include <lcm/lcm.h>

#include "graphnav_lcm_twist_t.h"

#define TIMEOUT_S 0.5
#define PERIOD_MS 50
#define TRACK_M 0.30        /* between the wheels */
#define WHEEL_RADIUS_M 0.05

static volatile sig_atomic_t is_ending = 0;
static double v_mps = 0.0, omega_radps = 0.0;
static double command_s = -INFINITY;

/* Monotonic time: the time of day may jump, and the sender's clock is not ours. */
static double now_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void on_twist(const lcm_recv_buf_t *buffer, const char *channel, const graphnav_lcm_twist_t *twist, void *user)
{
    (void)buffer, (void)channel, (void)user;
    if (!isfinite(twist->v_mps) || !isfinite(twist->omega_radps))
        return;
    v_mps = twist->v_mps;
    omega_radps = twist->omega_radps;
    command_s = now_s();
}

static void on_signal(int number)
{
    (void)number;
    is_ending = 1;
}

int main(int argc, char **argv)
{
    const char *channel = argc > 1 ? argv[1] : "BASE_CMD";
    lcm_t *lcm = lcm_create(NULL); /* LCM_DEFAULT_URL, else the group of this machine */
    if (!lcm)
        return 1;
    signal(SIGINT, on_signal);
    signal(SIGTERM, on_signal);
    graphnav_lcm_twist_t_subscribe(lcm, channel, on_twist, NULL);
    printf("listening on %s\n", channel);

    double next_s = now_s();
    while (!is_ending) {
        double left_ms = 1e3 * (next_s - now_s());
        if (left_ms > 0.0) {
            if (lcm_handle_timeout(lcm, (int)ceil(left_ms)) < 0)
                break;
            continue;
        }
        next_s = now_s() + 1e-3 * PERIOD_MS;

        int has_command = now_s() - command_s <= TIMEOUT_S;
        if (!has_command)
            v_mps = omega_radps = 0.0;
        double left = (v_mps - 0.5 * TRACK_M * omega_radps) / WHEEL_RADIUS_M;
        double right = (v_mps + 0.5 * TRACK_M * omega_radps) / WHEEL_RADIUS_M;
        printf("left %+6.2f rad/s  right %+6.2f rad/s%s\n", left, right, has_command ? "" : "  no command");
        fflush(stdout);
    }
    lcm_destroy(lcm);
    return 0;
}
