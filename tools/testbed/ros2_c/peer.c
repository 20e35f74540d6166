/* A ROS 2 robot in C, by Cyclone DDS alone: it publishes pictures and odometry and counts commands and maps.

   usage: peer DOMAIN SECONDS RATE_HZ COLS ROWS JPEG_FILE
   It prints one line for each message: "sent TOPIC STAMP_US", "heard TOPIC X Z", and "cpu SECONDS" at the end. */
#include <dds/dds.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include "ros.h"

#define TYPE(package, kind) package##_msg_dds__##kind##_
#define MAX_TAKEN 64

static std_msgs_msg_dds__Header_ stamped(long long *us) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  *us = now.tv_sec * 1000000LL + now.tv_nsec / 1000;
  std_msgs_msg_dds__Header_ header = {{(int32_t)now.tv_sec, (uint32_t)(now.tv_nsec / 1000 * 1000)}, "peer"};
  return header;
}

static dds_entity_t endpoint(dds_entity_t node, const dds_topic_descriptor_t *type, const char *name, int is_writer) {
  dds_qos_t *qos = dds_create_qos();
  int is_map = strcmp(name, "rt/local_map") == 0;
  /* as ROS has them: sensor data is best effort, commands are reliable, a map is latched */
  dds_qset_reliability(qos, is_writer ? DDS_RELIABILITY_BEST_EFFORT : DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_durability(qos, is_map ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, is_writer ? 5 : MAX_TAKEN);
  dds_entity_t topic = dds_create_topic(node, type, name, NULL, NULL);
  dds_entity_t made = is_writer ? dds_create_writer(node, topic, qos, NULL) : dds_create_reader(node, topic, qos, NULL);
  dds_delete_qos(qos);
  if (made < 0) {
    fprintf(stderr, "%s: %s\n", name, dds_strretcode(-made));
    exit(1);
  }
  return made;
}

static void take(dds_entity_t reader, const char *name, int is_twist) {
  void *samples[MAX_TAKEN] = {0};
  dds_sample_info_t infos[MAX_TAKEN];
  int count = dds_take(reader, samples, infos, MAX_TAKEN, MAX_TAKEN);
  for (int k = 0; k < count; k++) {
    if (!infos[k].valid_data) continue;
    const TYPE(geometry_msgs, Twist) *twist = samples[k];
    const TYPE(nav_msgs, OccupancyGrid) *map = samples[k];
    if (is_twist)
      printf("heard %s %.17g %.17g\n", name, twist->linear.x, twist->angular.z);
    else
      printf("heard %s %u %u\n", name, map->info.width, map->data._length / (map->info.width ? map->info.width : 1));
  }
  if (count > 0) dds_return_loan(reader, samples, count);
}

int main(int argc, char **argv) {
  if (argc != 7) return 2;
  double seconds = atof(argv[2]), rate = atof(argv[3]);
  unsigned cols = (unsigned)atoi(argv[4]), rows = (unsigned)atoi(argv[5]);
  dds_entity_t node = dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL);
  if (node < 0) return 1;
  dds_entity_t image_out = endpoint(node, &sensor_msgs_msg_dds__Image__desc, "rt/camera/image_raw", 1);
  dds_entity_t jpeg_out = endpoint(node, &sensor_msgs_msg_dds__CompressedImage__desc, "rt/camera/compressed", 1);
  dds_entity_t odometry_out = endpoint(node, &nav_msgs_msg_dds__Odometry__desc, "rt/odom", 1);
  dds_entity_t twist_in = endpoint(node, &geometry_msgs_msg_dds__Twist__desc, "rt/cmd_vel", 0);
  dds_entity_t map_in = endpoint(node, &nav_msgs_msg_dds__OccupancyGrid__desc, "rt/local_map", 0);

  TYPE(sensor_msgs, Image) image = {0};
  image.height = rows, image.width = cols, image.step = cols, image.encoding = "mono8";
  image.data._length = image.data._maximum = rows * cols;
  image.data._buffer = malloc(rows * cols);
  srand(1);
  for (unsigned k = 0; k < rows * cols; k++) image.data._buffer[k] = (uint8_t)(rand() & 255);

  TYPE(sensor_msgs, CompressedImage) jpeg = {0};
  jpeg.format = "jpeg";
  jpeg.data._buffer = malloc(1 << 20);
  FILE *file = fopen(argv[6], "rb");
  if (file == NULL) return 1;
  jpeg.data._length = jpeg.data._maximum = (uint32_t)fread(jpeg.data._buffer, 1, 1 << 20, file);
  fclose(file);

  TYPE(nav_msgs, Odometry) odometry = {0};
  odometry.child_frame_id = "base_link";
  odometry.pose.pose.orientation.w = 1.0;

  dds_time_t begin = dds_time(), period = (dds_time_t)(1e9 / rate);
  for (long tick = 0; tick * period < (dds_time_t)(seconds * 1e9); tick++) {
    dds_time_t due = begin + tick * period;
    if (due > dds_time()) dds_sleepfor(due - dds_time());
    long long us;
    image.header = stamped(&us);
    if (dds_write(image_out, &image) == 0) printf("sent /camera/image_raw %lld\n", us);
    jpeg.header = stamped(&us);
    if (dds_write(jpeg_out, &jpeg) == 0) printf("sent /camera/compressed %lld\n", us);
    odometry.header = stamped(&us);
    odometry.pose.pose.position.x = tick * 0.01;
    if (dds_write(odometry_out, &odometry) == 0) printf("sent /odom %lld\n", us);
    take(twist_in, "/cmd_vel", 1);
    take(map_in, "/local_map", 0);
    fflush(stdout);
  }
  struct rusage used;
  getrusage(RUSAGE_SELF, &used);
  printf("cpu %.3f\n", used.ru_utime.tv_sec + used.ru_stime.tv_sec + 1e-6 * (used.ru_utime.tv_usec + used.ru_stime.tv_usec));
  dds_delete(node);
  return 0;
}
