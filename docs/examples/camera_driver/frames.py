"""Write the camera images of a recorded run into a folder of JPEG files: python frames.py RUN FOLDER."""

import sys
from pathlib import Path

import cv2

from graphnav import Recording

run, folder = map(Path, sys.argv[1:])
folder.mkdir(exist_ok=True)
for number, (_, _, image) in enumerate(Recording(run / "run.lcmlog").messages("robot.image")):
    cv2.imwrite(str(folder / f"{number:04}.jpg"), image.pixels)
