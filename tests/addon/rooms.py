# SPDX-License-Identifier: GPL-3.0-or-later
"""Which rooms a job goes through, and somebody who hears what it tells. The native module is the stand-in (the fixture `native`)."""
REHEARSAL = ["grow", "transfer", "fold"]
ALL = ["make_character", "make_target", "fitted", "explore", "make_target", *REHEARSAL, *REHEARSAL, *REHEARSAL, *REHEARSAL, "finish"]
POSE = {"root": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], "angles": [0.7], "morphology": [1.0, 1.0]}


class Ears:
    def __init__(self, stop_at=None):
        self.heard, self.warnings, self.poses, self.stop_at = [], [], [], stop_at

    def progress(self, stage, fraction, note=""):
        self.heard.append((stage, fraction))
        return stage != self.stop_at

    def pose(self, fields):
        self.poses.append(fields)

    def warning(self, text):
        self.warnings.append(text)

    def enough(self):
        return False


class SeenEnough(Ears):
    """Ends the job as soon as it has heard of a pose, and wants that."""

    def progress(self, stage, fraction, note=""):
        super().progress(stage, fraction, note)
        return not self.poses

    def enough(self):
        return bool(self.poses)
