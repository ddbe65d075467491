"""The way of docs/blender.md from an empty scene to a result, by clicks, which are counted."""

import bpy
import events
from events import choose_file, look_at, picture, running, template, until
from setting import LIVER, clear
from sidebar import click_button, find, open_tab

# More would be too many.
_MOST = 10


def session():
    clear()
    bpy.ops.object.empty_add()
    yield from open_tab()
    # One for the tab. Where a button is costs this session moves of the mouse, a user a look.
    events.CLICKS.clear()
    events.CLICKS.append("the tab")
    yield from click_button("moulage.import_template")
    yield from choose_file(LIVER / "template.obj")
    yield from until(lambda: template() is not None, "the template")
    template().moulage.tet_count = 2000
    yield from find("moulage.import_person")
    yield from click_button("moulage.import_person")
    yield from choose_file(LIVER / "markers.csv")
    yield from until(lambda: template().moulage.markers is not None, "the person's points")
    yield from find("moulage.reshape")
    yield from click_button("moulage.reshape")
    yield from until(running, "the run")
    yield from until(lambda: not running() and template().moulage.result.key != "", "the end of the run")
    assert template().moulage.result.mean_distance < 1.0, template().moulage.result.mean_distance
    print(f"{len(events.CLICKS)} clicks: {', '.join(events.CLICKS)}", flush=True)
    assert len(events.CLICKS) <= _MOST, events.CLICKS
    yield from look_at([template()])
    yield from picture("way")
