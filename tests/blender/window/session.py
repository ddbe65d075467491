"""A session in a real window, by clicks and keys: chapters/, one after the other. Writes screenshots.

    blender --factory-startup --enable-event-simulate --window-geometry 0 0 1400 1000 \
        --python tests/blender/window/session.py -- DIST SCREENSHOTS [CHAPTER...]

A chapter that is run alone makes what the chapters before would have left.
"""

import importlib
import os
import sys
import time
import traceback
from pathlib import Path

import bpy

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import run  # noqa: E402

CHAPTERS = (
    "way", "template", "markers", "landmarks", "attachments", "reshaping", "scan", "interruptions", "live", "skeleton", "separate",
)


def steps(names):
    import events

    bpy.context.preferences.view.show_splash = False
    # Drawn by software: quickly.
    bpy.context.preferences.system.viewport_aa = "OFF"
    # The file browser is to be in this window.
    bpy.context.preferences.view.filebrowser_display_type = "SCREEN"
    yield from events.pause()
    events.press("ESC")
    yield from events.pause()
    for name in names:
        began = time.monotonic()
        yield from importlib.import_module(f"chapters.{name}").session()
        print(f"{name}: {time.monotonic() - began:.0f} s", flush=True)


def main():
    dist, pictures, *names = sys.argv[sys.argv.index("--") + 1 :]
    pictures = Path(pictures).resolve()
    pictures.mkdir(parents=True, exist_ok=True)
    os.environ["MOULAGE_PICTURES"] = str(pictures)
    os.environ["MOULAGE_MODULE"] = run.install(Path(dist).resolve())
    session, began = steps(names or CHAPTERS), time.monotonic()

    def go_on():
        try:
            next(session)
        except StopIteration:
            print(f"the session went well, {time.monotonic() - began:.0f} s", flush=True)
            os._exit(0)
        except BaseException:
            traceback.print_exc()
            import events

            events.screenshot(pictures / "failed.png")
            sys.stderr.flush()
            os._exit(1)
        return 0.0

    bpy.app.timers.register(go_on, first_interval=1.0, persistent=True)


main()
