# SPDX-License-Identifier: GPL-3.0-or-later
"""The rooms in their order, on arrays: what a worker does with a job. Knows the native module, not Blender.

A search for a pose that is stopped from outside (`tell.enough()`) gives the best so far, when the job ends with that stage.
A job is a dict: `options` (DesignOptions.as_dict()), `character` {names, parents, hinges}, `until` (one of UNTIL),
`stored` {embedding, path, start, rival}, as an earlier result gave them: an embedding or a path that is there is not searched again,
`start` is a pose to search from; `rival` a pose that is kept unless the search finds a better one; `steering` (core/steering.py) what the search leaves alone; `explore` {count, least_difference}: search
for several poses (the result has them as `solutions`), and go on with the best; `names`, `target` and `warnings` go into the result.
`edits` (optional) are the artist's edits of the segmentation, in order: {kind ("remove", "inhibit", "keep_whole", "assign", "move_seam", or one of wishes.GIVES: which part makes room at a bone's joint), bone and
other (armature bones), name (for messages), thickness_mm, faces, from, to (names of arrays: corners of painted triangles, n x 9, places of a
seam's points, n x 3, world units)}. Arrays: heads, tails, axes, vertices, rotation (float64), triangles (int32).
"""
import importlib
import time
from array import array

from . import outcome, schedule, steering, together, wishes
from .options import LONGEST_SIDE, DesignOptions, UserError
from .poses import Poses
from .rehearsal import Rehearsals

UNTIL = ("embedding", "segmentation", "folding", "finishing")
STAGES = ("character", "target", *UNTIL)
PRINTED_RADIUS_MM = 3.5   # a pin of 3 mm with ears of 2 mm about it (FACTS: printing)
PREVIEW_CLEARANCE_MM = 0.05
TRIED = 3                  # folded poses, of which the one is taken that loses least to carving when it unfolds
ELSEWHERE = 1_000_003      # added to the seed for a second search
EVALUATIONS = 8000         # of the objective, for each
SHOWN_RESOLUTION = 96      # edges along the longest side: the division of the surface that is sent back is no finer
DIVISION = {"vertices": "d", "triangles": "i", "bones": "i"}   # its arrays, each named division_...: world units, corners, an index into bodies or -1
FINE = 96                  # voxels along the longest side, from which on a rehearsal takes too long: the best pose is taken as it is
DIFFERENT = 0.15           # share of the target that goes to another bone, for poses to differ
EXPANSIONS_A_SECOND = 150  # moves that the search for the fold's order may try, for each second of its target time: few enough for most machines
ECHOED = ("heads", "tails", "axes", "rotation")  # sent back, so that a result can be applied by itself


class Cancelled(Exception):
    """The other side asked for a stop."""


def run(job, arrays, tell):
    """Does a job. `tell` has progress(stage, fraction, note) -> go on?, pose(fields), warning(text), and enough() -> is the best
    so far wanted?, which is asked when progress has said to end.

    Gives (result, arrays). Raises UserError, Cancelled, or what the native module raises.
    """
    return Run(importlib.import_module("transformables_native"), job, arrays, tell).run()


class Run:
    """One job being done."""

    def __init__(self, native, job, arrays, tell):
        self.tn, self.arrays, self.tell = native, arrays, tell
        self.options = DesignOptions(**job["options"])
        self.options.validate()
        self.until = job.get("until", "finishing")
        if self.until not in UNTIL:
            raise UserError(f"a job can end at {', '.join(UNTIL)}, not at {self.until!r}")
        self.stored = dict(job.get("stored") or {})
        self.armature = job["character"]
        self.job = job
        self.seconds, self.warnings, self.cut_short = {}, [], False
        self.joined = self.path = self.parts = self.segmentation = self.certificate = self.rehearsed = None
        self.part_arrays, self.solutions, self.seams, self.surface_arrays = {}, [], [], {}
        self.best, self.found, self.stopped = None, [], False  # of the search, should it be ended before its end

    def run(self):
        began = time.perf_counter()
        self._warn(self.job.get("warnings", ()))  # of those who read the scene
        for stage in STAGES:
            self._stage(stage, getattr(self, f"_{stage}"))
            if stage == self.until:
                break
        if self.until in ("segmentation", "folding"):
            self._stage("preview", self._preview)
        self.seconds["total"] = time.perf_counter() - began
        return outcome.of(self), {**self._echo(), **self.part_arrays, **self.surface_arrays}

    def _stage(self, name, work):
        self._go_on(name, 0.0, "")
        began = time.perf_counter()
        work()
        self.seconds[name] = time.perf_counter() - began
        self._go_on(name, 1.0, "")

    def _go_on(self, stage, fraction, note):
        if not self.tell.progress(stage, fraction, note) and not self.stopped:
            raise Cancelled()

    def _progress(self, stage, start=0.0, end=1.0):
        return lambda fraction, note="": self.tell.progress(stage, start + (end - start) * fraction, note)

    def _warn(self, texts):
        for text in texts:
            self.warnings.append(text)
            self.tell.warning(text)

    def _bytes(self, name):
        return self.arrays[name][1]

    def _character(self):
        self.raw_character = self.tn.make_character(
            names=self.armature["names"], parents=self.armature["parents"], heads=self._bytes("heads"),
            tails=self._bytes("tails"), axes=self._bytes("axes"),
            hinges=[[tuple(hinge) for hinge in hinges] for hinges in self.armature["hinges"]])

    def _target(self):
        self.target = self._made_target(self.options.resolution, self._progress("target"))
        self._warn(self.target.warnings)

    def _made_target(self, resolution, progress):
        return self.tn.make_target(vertices=self._bytes("vertices"), triangles=self._bytes("triangles"), resolution=resolution, progress=progress)

    def _embedding(self):
        scale = self.target.scale if self.options.fit == "off" else 0.0
        self.character = self.tn.fitted(self.raw_character, self.target, least_radius=self._least_radius(), scale=scale)
        self.poses = Poses(self.tn, self.character, self.target, self.options.resolution, *(self._bytes(name) for name in ("heads", "tails", "axes")))
        self._read_wishes(self.job.get("edits") or ())
        if self.stored.get("embedding"):
            self.embedding = self.poses.native(self.stored["embedding"])
            return
        search = {"seed": self.options.seed, "symmetry": self.options.symmetry, "proportions": self.options.proportions,
                  "threads": self.options.threads, "progress": self._progress("embedding"), "best": self._tell_best, "trying": self._tell_pose,
                  "edits": self.edits, **self._steering()}
        try:
            self._search(search)
        except self.tn.Cancelled:
            if self.until != "embedding" or self.best is None or not self.tell.enough():
                raise
            self._keep_best()

    def _search(self, search):
        explore, start = self.job.get("explore"), self.stored.get("start")
        if explore:
            found = self.tn.explore(self.character, self.target, count=int(explore["count"]), found=self.found.append,
                                    least_difference=float(explore["least_difference"]), **search)
            self.solutions = [self.poses.solution(embedding) for embedding in found]
            self.embedding = found[0]
        elif start:
            self.embedding = self.tn.embed(self.character, self.target, start=self.poses.native(start), **search)
        else:
            self._search_and_rehearse(search)

    def _keep_best(self):
        """The search was ended from outside: what it has is the result."""
        self.stopped = True
        found = sorted(self.found, key=lambda embedding: embedding.value) or [self.best]
        self.embedding = found[0]
        if self.job.get("explore"):
            self.solutions = [self.poses.solution(embedding) for embedding in found]

    def _search_and_rehearse(self, search):
        """Some poses that differ, and of them (and a rival, should there be one) the one that loses least when it is rehearsed."""
        apart = steering.pairs_apart(self.job.get("steering") or {}, self._bodies())
        rival = self.poses.native(self.stored["rival"]) if self.stored.get("rival") else None
        tried = TRIED if self.options.resolution < FINE or apart else 1

        def poses(**changed):
            return self.tn.explore(self.character, self.target, count=tried, least_difference=DIFFERENT, evaluations=EVALUATIONS, **{**search, **changed})

        found = poses(progress=self._progress("embedding", 0.0, 0.4))
        self._tell_pose(found[0])
        rehearsals = Rehearsals(self.tn, self.target, self.options, apart, self._grown, self._folded, self._made_target)
        self.rehearsed = rehearsals.best(found, lambda progress: poses(seed=self.options.seed + ELSEWHERE, progress=progress), rival,
                                         self._progress("embedding", 0.4, 1.0))
        self.embedding = self.rehearsed.embedding
        if self.embedding is rival:
            self.stored["embedding"] = self.stored["rival"]
            self._warn(["No better folded pose was found, so the present one was kept. Try again: every search looks elsewhere"])

    def _steering(self):
        wanted = self.job.get("steering") or {}
        pose = self.stored.get("start") or wanted.get("pose")
        return steering.native_arguments(wanted, self.character, self._bodies(), self.poses.native(pose) if pose else None,
                                         lambda given: self.tn.bone_frames(self.character, given))

    def _bodies(self):
        """Of each bone's name, which body it is part of."""
        return {self.armature["names"][bone]: body for body, members in enumerate(self.character.members) for bone in members}

    def _read_wishes(self, wanted):
        bodies = self._bodies()
        names = {bone: self.character.names[body] for bone, body in bodies.items()}
        self.edits = wishes.edits(self.tn, self.target, self.options, names, wanted, self._bytes)
        self.directions, warnings = wishes.directions(wanted, bodies, self.character.parents)
        self._warn(warnings)

    def _least_radius(self):
        """As thick as a printed joint needs, but no more than a bone's share of a slim target can hold."""
        share = (self.target.volume / len(self.raw_character.names)) ** (1 / 3)
        step = LONGEST_SIDE / self.options.resolution
        return max(min(self.options.target_units(PRINTED_RADIUS_MM), 0.2 * share), 0.87 * step)

    def _segmentation(self):
        if self.rehearsed:
            self.segmentation = self.rehearsed.segmentation
        else:
            self.segmentation = self._grown(self.embedding, self.target, self._progress("segmentation", 0.0, 0.9))
        if self.edits:
            self._edit()
        else:
            self._trace_surface()

    def _grown(self, embedding, target, progress, round_off=True):
        rooms = (self.character, target, embedding)
        grown = self.tn.grow(*rooms, threads=self.options.threads, progress=lambda fraction, note="": progress(0.6 * fraction, note))
        return self._transferred(grown, embedding, target, lambda fraction, note="": progress(0.6 + 0.4 * fraction, note), round_off)

    def _transferred(self, segmentation, embedding, target, progress, round_off=True):
        return self.tn.transfer(segmentation, self.character, target, embedding, method=self.options.transfer, direction_of=self.directions,
                                round_off=round_off, threads=self.options.threads, progress=progress)

    def _trace_surface(self):
        """How the target's surface is divided, and the seams there, as edits find them when they are replayed: before folding has its say."""
        for seam in self.tn.seams(self.segmentation, self.target):
            name = f"seam_{len(self.seams)}_points"
            self.seams.append({"bones": [self.character.names[seam[key]] for key in ("bone_a", "bone_b")], "closed": seam["closed"], "points": name})
            self.surface_arrays[name] = ("d", seam["points"])
        division = self.tn.division(self.segmentation, self.target, spacing=max(1.0, self.options.resolution / SHOWN_RESOLUTION))
        for name, kind in DIVISION.items():
            self.surface_arrays[f"division_{name}"] = (kind, division[name])

    def _edit(self):
        """The artist's edits, and what parts then need to turn at their joints: transfer leaves alone what an edit has decided."""
        rooms = (self.character, self.target, self.embedding)
        self.rehearsed = None  # was without the edits
        self.segmentation, report = self.tn.edited(self.segmentation, *rooms, self.edits, threads=self.options.threads)
        self._warn(report)
        self._trace_surface()
        self.segmentation = self._transferred(self.segmentation, self.embedding, self.target, self._progress("segmentation", 0.9, 1.0))

    def _folding(self):
        stored = self.stored.get("path")
        if stored:
            self._check_stored_path(stored["moves"])
            self.path = self.tn.FoldPath(moves=[[tuple(turn) for turn in turns] for turns in stored["moves"]])
            self.segmentation = self.tn.transfer_along(self.segmentation, self.character, self.target, self.embedding, self.path,
                                                       threads=self.options.threads, progress=self._progress("folding"))
            return
        folding = self.rehearsed.folding if self.rehearsed else self._folded(self.embedding, self.target, self.segmentation, self._progress("folding"))
        self.path, self.segmentation = folding.path, folding.segmentation
        if self.cut_short:
            self._warn([f"The search for the fold's order was stopped after {self.options.fold_seconds:g} s: this machine is too slow or too busy for all that "
                        "was to be tried. The design is sound, but another run may give another one. Allow a longer search time"])

    def _folded(self, embedding, target, segmentation, progress, **search):
        seconds = self.options.fold_seconds
        search = {"expansions": max(1, round(EXPANSIONS_A_SECOND * seconds)), **search}
        folding = self.tn.fold(segmentation, self.character, target, embedding, seconds=seconds, threads=self.options.threads, progress=progress, **search)
        self.cut_short = self.cut_short or folding.path.cut_short
        return folding

    def _check_stored_path(self, moves):
        try:
            schedule.check_path(moves, self.embedding.angles)
        except ValueError as error:
            raise UserError(f"the stored fold path is for another folded pose ({error}): "
                            "run the folding stage again") from None

    def _finishing(self):
        self._finish(self.path, self.options.clearance_mm, self.options.style, self._progress("finishing", 0.0, 0.85))
        if len(self.parts.parts) < 2:
            raise UserError(f"of {len(self.character.members)} parts only {len(self.parts.parts)} would be left, and one part can't fold: "
                            "the other bones are very short or have no room. Make the bones' lengths more alike, or try another seed")
        self._warn(self.parts.warnings)
        self.certificate = self.parts.certificate
        self._join_moves()
        rows = self.joined[1] if self.joined else self.certificate.intervals
        flat = array("d", (number for row in rows for number in row))
        self.part_arrays["certificate_intervals"] = ("d", flat.tobytes())

    def _join_moves(self):
        """Lets joints turn at the same time that were planned one after the other, where that is proved for as much as the rest."""
        moves = [[tuple(turn) for turn in turns] for turns in self.path.moves]
        given = bool(self.stored.get("path"))  # a path that was given is followed to the letter
        if given or not (self.options.together and self.certificate.holds and len(moves) > 1):
            return
        self.joined = together.joined_where_proved(self.tn, self.parts, self.character, self.embedding, moves, self.options.threads,
                                                   self._progress("finishing", 0.85, 1.0))

    def _preview(self):
        """Part meshes of a design that is not finished: nothing is carved."""
        self._finish(self.tn.FoldPath(moves=[]), min(PREVIEW_CLEARANCE_MM, self.options.clearance_mm), "solid", self._progress("preview"))
        self._warn(self.parts.warnings)

    def _finish(self, path, clearance_mm, style, progress):
        self.parts = self.tn.finish(
            self.segmentation, self.character, self.target, self.embedding, path,
            clearance=self.options.target_units(clearance_mm), style=style,
            wall=self.options.target_units(self.options.wall_mm), hinges=self.options.hinges, threads=self.options.threads,
            progress=progress)
        self.part_arrays = {}
        for index, part in enumerate(self.parts.parts):
            self.part_arrays[f"part_{index}_vertices"] = ("d", part["vertices"])
            self.part_arrays[f"part_{index}_triangles"] = ("i", part["triangles"])
            if "source" in part:  # a triangle each: the cleaned target's that it is a piece of, or -1 at interfaces
                self.part_arrays[f"part_{index}_source"] = ("i", part["source"])

    def _tell_best(self, embedding):
        self.best = embedding
        self._tell_pose(embedding)

    def _tell_pose(self, embedding):
        self.tell.pose(self.poses.shown(embedding))

    def _echo(self):
        return {name: self.arrays[name] for name in ECHOED if name in self.arrays}
