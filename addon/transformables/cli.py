# SPDX-License-Identifier: GPL-3.0-or-later
"""The headless command.

    blender -b IN.blend --python addon/transformables/cli.py -- design --character NAME --target NAME --output OUT.blend

As an extension in Blender 4.2 and newer: blender -b IN.blend --command transformables design ...
Exit codes: 0 a complete design, 3 a design with collisions left, 2 wrong input (one line says what), 130 stopped, 1 a fault.
"""
import argparse
import importlib
import os
import signal
import sys
import time
import traceback
import types

COMPLETE, FAULT, WRONG_INPUT, COLLISIONS_LEFT, STOPPED = 0, 1, 2, 3, 130
SECONDS_BETWEEN_LINES = 2.0
WAIT_SECONDS = 0.05


def _package():
    """Our package's name. Run as a script the add-on need not be installed: its folder is given a name of its own."""
    if __package__:
        return __package__
    name = "transformables_headless"
    if name not in sys.modules:
        module = types.ModuleType(name)
        module.__path__ = [os.path.dirname(os.path.abspath(__file__))]
        sys.modules[name] = module
    return name


def _import(name):
    return importlib.import_module(f"{_package()}.{name}")


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, without the usage around it."""

    def error(self, message):
        raise _import("core.options").UserError(f"{message} (see {self.prog} --help)")


def _parser():
    parser = _Parser(prog="transformables", allow_abbrev=False,
                     description="Designs transformables: characters that fold up into an object.")
    design = parser.add_subparsers(dest="command", required=True, parser_class=_Parser).add_parser(
        "design", allow_abbrev=False, help="design a transformable from an armature and a mesh of the open file")
    add = design.add_argument
    add("--character", metavar="NAME", help="the armature object (default: the only one in the file)")
    add("--target", metavar="NAME", help="the mesh object (default: the only one in the file)")
    add("--resolution", type=int, default=64, metavar="N", help="voxels along the target's longest side (default: %(default)s)")
    add("--seed", type=int, default=0, metavar="S", help="random seed (default: %(default)s)")
    add("--symmetry", choices=("auto", "on", "off"), default="auto", help="mirror the folded pose (default: %(default)s)")
    add("--simplify", default="auto", metavar="auto|off|N", help="fewer bones (default: %(default)s: 25 at most)")
    add("--fit", choices=("auto", "off"), default="auto", help="scale the character to suit the target (default: %(default)s)")
    add("--proportions", choices=("on", "off"), default="on", help="let the optimiser scale bones (default: %(default)s)")
    add("--size", type=float, default=150.0, metavar="MM", help="printed length of the target's longest side (default: %(default)g)")
    add("--clearance", type=float, default=0.3, metavar="MM", help="gap between neighbouring parts (default: %(default)g)")
    add("--style", choices=("solid", "shell"), default="solid", help="volumetric parts or shells (default: %(default)s)")
    add("--wall", type=float, default=1.2, metavar="MM", help="thickness of shells (default: %(default)g)")
    add("--transfer", choices=("auto", "cylinder", "exact"), default="auto",
        help="how parts make room for a joint's turn: all round it, only what is in the way, or the better of both (default: %(default)s)")
    add("--frames", type=int, default=0, metavar="N", help="length of the fold (default: by the angles turned)")
    add("--hinges", choices=("on", "off"), default="on", help="put a pin, a clevis and a tongue into joints of one axis (default: %(default)s)")
    add("--together", choices=("on", "off"), default="on", help="let joints turn at the same time where that is proved to be safe (default: %(default)s)")
    add("--loop", choices=("on", "off"), default="off", help="fold back again in a second half of the timeline, so that it repeats without a jump (default: %(default)s)")
    add("--fold-seconds", type=float, default=20.0, metavar="S", help="target time of the search for the fold's order (default: %(default)g)")
    add("--threads", type=int, default=0, metavar="N", help="processor cores (default: all; the design is the same)")
    add("--output", metavar="OUT.blend", help="the .blend to write")
    add("--report", metavar="OUT.json", help="the report to write")
    add("--parts", metavar="FOLDER", help="a folder for the parts in millimetres: an STL each, and with pins a 3MF of all in their places, to be printed so")
    add("--certificate", metavar="OUT.json", help="the proof that parts stay apart to write: can be replayed by itself")
    return parser


def run(argv):
    """Does what the words say; gives the exit code. Everything it has to say goes to standard error."""
    errors = _import("core.options")
    python = _import("bridge.system_python")
    if python.numpy_is_missing():
        return _fail(python.advice(), WRONG_INPUT)
    try:
        arguments = _parser().parse_args(argv)
        return _Design(arguments).run()
    except errors.UserError as error:
        return _fail(str(error), WRONG_INPUT)
    except _Stopped:
        return _fail("stopped; nothing was written", STOPPED)
    except SystemExit as done:  # --help
        return int(done.code or 0)
    except Exception:
        traceback.print_exc()
        return _fail("this is a fault in the add-on; nothing was written", FAULT)


def main(argv):
    """As `run`, for the command itself: without NumPy Blender is first started again, where that helps."""
    python = _import("bridge.system_python")
    if python.numpy_is_missing():
        python.start_again()
    return run(argv)


class _Stopped(Exception):
    """Ctrl-C, or the system asked for the end."""


class _Design:
    def __init__(self, arguments):
        self.began = time.perf_counter()
        self.arguments = arguments
        self.errors = _import("core.options")
        self.options = self.errors.DesignOptions(
            resolution=arguments.resolution, seed=arguments.seed, symmetry=arguments.symmetry, simplify=arguments.simplify,
            fit=arguments.fit, proportions=arguments.proportions == "on", size_mm=arguments.size,
            clearance_mm=arguments.clearance, style=arguments.style, wall_mm=arguments.wall, transfer=arguments.transfer, frames=arguments.frames,
            hinges=arguments.hinges == "on", together=arguments.together == "on", loop=arguments.loop == "on", fold_seconds=arguments.fold_seconds,
            threads=arguments.threads)

    def run(self):
        import bpy
        self.options.validate()
        given = self.arguments
        files = _import("bridge.output_files").OutputFiles({"output": given.output, "report": given.report, "certificate": given.certificate}, given.parts)
        character = self._named(bpy.context.scene, self.arguments.character, "character", "ARMATURE", "armature")
        target = self._named(bpy.context.scene, self.arguments.target, "target", "MESH", "mesh object")
        design = _import("bridge.design")
        _leave_edit_mode(bpy.context)
        with _Signals() as stop:
            message, arrays = design.gather(character, target, self.options)
            event = self._do(message, arrays, stop)
            made = design.apply(bpy.context, event["result"], event["arrays"], character, target, self.options)
            if stop.asked:
                raise _Stopped
            files.write(made["report"], event, made["rig"], self.began)
        return self._verdict(made["report"])

    def _do(self, message, arrays, stop):
        """Runs the job in a worker process, with progress on standard error. Gives the result event."""
        job = _import("core.job").Job(message, arrays)
        job.start()
        try:
            lines = _Lines()
            while True:
                if stop.asked:
                    job.cancel()
                for event in job.poll():
                    if event["kind"] == "result":
                        return event
                    if event["kind"] == "error":
                        self._raise(event)
                    lines.take(event)
                job.wait(WAIT_SECONDS)
        finally:
            job.close()

    def _raise(self, event):
        if event["type"] == "Cancelled":
            raise _Stopped
        if event["type"] == "Infeasible":
            raise self.errors.UserError(f"the character doesn't fit into the target: {event['text']}. A slim target holds few bones: try "
                                        "fewer (--simplify 10), a higher --resolution, or another --seed")
        if event["type"] in ("InvalidInput", "OutOfMemory", "WorkerDied", "NoWorker"):
            raise self.errors.UserError(event["text"])
        raise RuntimeError(f"{event['text']}\n{event.get('details', '')}")

    def _named(self, scene, name, role, kind, words):
        objects = [o for o in scene.objects if o.type == kind and o.get("transformable_role") not in ("rig", "part")]
        names = sorted(o.name for o in objects)
        if name is not None:
            found = [o for o in scene.objects if o.name == name]
            if found and found[0].type == kind:
                return found[0]
            what = f"'{name}' is not an {words}" if kind == "ARMATURE" else f"'{name}' is not a {words}"
            problem = what if found else f"there is no {words} '{name}' in the scene"
            raise self.errors.UserError(f"{problem}: give --{role} one of {_quoted(names)}")
        if len(objects) == 1:
            return objects[0]
        if not objects:
            raise self.errors.UserError(f"the scene has no {words}: add one as the {role}")
        raise self.errors.UserError(f"the scene has {len(objects)} of kind {words}: give --{role} one of {_quoted(names)}")

    def _verdict(self, report):
        say = f"design of {report['parts']} parts in {report['seconds']['total']:.1f} s"
        if report["certified"]:
            _say(f"{say}; it folds without collision, proved for {report['minimum_clearance_mm']:.3g} mm between parts at all times")
            return COMPLETE
        _say(f"{say}, but {len(report['collisions'])} collisions are left:")
        for collision in report["collisions"]:
            _say("  " + _import("core.report").collision_line(collision))
        for place in report["uncertified"]:
            _say("  no proof: " + _import("core.report").uncertified_line(place))
        return COLLISIONS_LEFT


class _Signals:
    """Ctrl-C and a polite end: `asked` becomes true, the job is cancelled, nothing is written."""

    def __enter__(self):
        self.asked = False
        self._before = {number: signal.signal(number, self._ask) for number in (signal.SIGINT, signal.SIGTERM)}
        return self

    def _ask(self, *_):
        self.asked = True

    def __exit__(self, *_):
        for number, handler in self._before.items():
            signal.signal(number, handler if handler is not None else signal.SIG_DFL)


class _Lines:
    """Progress in lines: one when a stage begins, and one now and then."""

    def __init__(self):
        self._stage, self._printed = "", 0.0

    def take(self, event):
        if event["kind"] == "warning":
            _say(f"warning: {event['text']}")
        if event["kind"] != "progress":
            return
        now = time.monotonic()
        if event["stage"] == self._stage and now - self._printed < SECONDS_BETWEEN_LINES:
            return
        self._stage, self._printed = event["stage"], now
        note = f" {event['note']}" if event["note"] else ""
        _say(f"{event['stage']}: {100 * event['fraction']:.0f} %{note}")


def _leave_edit_mode(context):
    import bpy
    if context.mode != "OBJECT" and context.view_layer.objects.active is not None:
        bpy.ops.object.mode_set(mode="OBJECT")


def _quoted(names, most=20):
    if not names:
        return "(there are none)"
    return ", ".join(f"'{n}'" for n in names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def _say(text):
    print(f"transformables: {text}", file=sys.stderr, flush=True)


def _fail(text, code):
    _say(f"error: {text}" if code != FAULT else text)
    return code


if __name__ == "__main__":
    exit_code = main(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])
    sys.stdout.flush()
    sys.stderr.flush()
    # Blender exits 0 after a script, whatever the script found.
    sys.exit(exit_code)
