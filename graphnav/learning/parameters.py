"""The parameters of environments, each declared once."""

from __future__ import annotations

from graphnav.core.parameters import Parameter

OBSERVE = Parameter(
    "observe",
    doc='What the agent observes: a channel (``"robot.image"``), a stage with one channel, a field '
    '(``"robot.goal.bearing_rad"``), or a list of these; None: the image. One array is a `Box`, several are a `Dict` '
    "by port, or by port and field.",
    example='"robot.image"',
)
ACT = Parameter(
    "act",
    doc="The stage that the agent replaces, by its name or a channel of it; None: the one that commands the robot, "
    "before the guard if there is one.",
    example='"control"',
)
REWARD = Parameter(
    "reward",
    doc='What a step is worth: weights of the changes of metrics (``"drive.path_length_m"``), of ``"progress_m"`` '
    '(by how much the way to the goal has become shorter; without a goal, how far it drove), of every ``"step"`` and '
    'of outcomes (``"goal"``, ``"contact"``, ``"timeout"``, ``"end"``); or a function of a `Transition`. None: '
    '``{"progress_m": 1, "goal": 10, "contact": -10}``.',
    example='{"progress_m": 1.0, "goal": 10.0}',
)
TIME_LIMIT_S = Parameter(
    "time_limit_s",
    type=float,
    doc="Simulated seconds after which an episode is truncated, in place of the graph's ``run.until_s``.",
    example="60.0",
)
RECORD = Parameter(
    "record",
    doc="A folder in which every episode leaves a run folder, 0000, 0001, ...: `info`, `replay`, `figure` and the "
    "others read them. None: none.",
    example='"episodes"',
)
RENDER_MODE = Parameter(
    "render_mode",
    doc='``"rgb_array"``: `render` returns the world from above. None: it returns None.',
    example='"rgb_array"',
)
TRUTH = Parameter(
    "truth",
    default=False,
    doc="Allow to observe true data, which no robot has, as the critic of an asymmetric learner does.",
    example="True",
)
SKIP = Parameter(
    "skip",
    default=True,
    doc="Leave out the stages that neither the observation nor the reward nor the way of the action to the robot "
    "needs. It changes no message of the others.",
    example="False",
)
NORMALIZED = Parameter(
    "normalized",
    default=False,
    doc="Let the floats of an action be from -1 to 1, which learners prefer, in place of the bounds of the channel's "
    "fields, which are those of the robot for a twist.",
    example="True",
)
COUNT = Parameter("n", doc="How many worlds step together.", example="8")
PROCESSES = Parameter("processes", default=2, doc="In how many processes they step.", example="2")

OF_ENV = (OBSERVE, ACT, REWARD, TIME_LIMIT_S, RECORD, RENDER_MODE, TRUTH, SKIP, NORMALIZED)
