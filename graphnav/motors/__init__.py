"""Motor channels, sent by a small process that outlives the run by a stop.

`graphnav.motors.sender` is the run's side, `graphnav.motors.offsets` describes a motor channel of an LCM type.
This package imports nothing by itself: the process that sends should start fast.
"""
