"""Motor channels, sent by a small process that outlives the run to stop the robot.

`graphnav.live.motors.sender` is the run's side, `graphnav.live.motors.offsets` describes a motor channel of an LCM
type.
The package itself imports nothing, so that the sending process starts fast.
"""
