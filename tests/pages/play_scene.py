"""Plays the scene NAME in FOLDER, and prints what is wrong with it as JSON.   play_scene.py NAME FOLDER"""
import json
import pathlib
import sys

from command_scenes import SCENES
from scenes import play

chosen = next(scene for scene in SCENES if scene.name == sys.argv[1])
print(json.dumps(play(chosen, pathlib.Path(sys.argv[2]))))
