"""The format of map files."""

from __future__ import annotations

from graphnav import FileFormat
from graphnav_world.maps.map_keys import MapKeys

EXAMPLE = """\
about: A room with two boxes, an L-shaped corridor out of it, and someone who walks to and fro in it.

start: {at_m: [0, 0], heading_deg: 0}
goal: {box: {center_m: [7, 4.5], size_m: [1.3, 0.6]}}

textures:
  floor: {mean: 125, contrast: 34, grain_m: 0.16}
  box: {mean: [60, 110], contrast: 30}

walls:
  # Room and corridor are one line: from the upper side of the door around the room, then around the corridor.
  - along:
      [[3, 0.7], [3, 2], [-1, 2], [-1, -2], [3, -2], [3, -0.7],
       [5, -0.7], {arc: {center_m: [5, 2], radius_m: 2.7, from_deg: -90, to_deg: 0}}, [7.7, 5],
       [6.3, 5], [6.3, 2], {arc: {center_m: [5, 2], radius_m: 1.3, from_deg: 0, to_deg: -90}}]
    closed: true

obstacles:
  - {box: {center_m: [1, [0.9, 1.3]], size_m: [0.5, 0.5], turn_deg: [0, 90]}, height_m: 0.4, texture: box}
  - {box: {center_m: [1.5, -1.2], size_m: [0.8, 0.4]}, height_m: 0.4, texture: box}
  - circle: {center_m: [7.5, 3.2], radius_m: 0.12}
    moves: {through_m: [[7.1, 3.2]], speed_mps: 0.05}
"""

MAP = FileFormat(
    "map",
    MapKeys,
    title="Maps",
    doc=f"""
A map is a YAML file from which `world.pymunk` and `world.robot` draw a world: walls, obstacles, where the robot starts
and where it has to go. Its path is the parameter `map` of the world; relative to the graph, or in `--set` to the
working folder.

- Lengths are in metres. The floor is the plane of x and y, seen from above with x to the right and y up.
- Angles are in degrees, counterclockwise; 0 is along x, 90 along y.
- Wherever a number is described as "a number or a range", `[low, high]` is drawn from the seed of the run: every seed
  is another world, and the same seed is the same world. The coordinates of a point may be ranges, too:
  `[1, [0.4, 0.6]]` has x = 1 and y between 0.4 and 0.6.
- The robot is a disc of 0.2 m radius if the graph does not set `robot_radius_m`, or `robot_size_m` for a rectangle,
  of which the circle around it counts here. It has to fit at the start, and a path of its width has to lead to the
  goal: a map with ranges is drawn again until that is so, up to 300 times; fewer times the larger it is and the more
  pillars it has, so that reading a map takes seconds at most.
- Everything fits into 100 m. Paths are searched on a grid of 2.5 cm, in maps of more than 625 square metres on a
  coarser one, of 10 cm for 100 m by 100 m.
- Rules of YAML 1.2 hold: `1e-3` is a number, `yes` is a string. Aliases (`&a`, `*a`) may be used.

## A complete map

Save it as `my_map.yaml`, then drive through it, and look at `map.png` in the run's folder:

```sh
graphnav run corridor_ccw --set robot.map=my_map.yaml
```

```yaml
{EXAMPLE}```

`graphnav schema --of map` prints the JSON Schema, for completion and checks in editors.
""",
)
