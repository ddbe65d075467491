# SPDX-License-Identifier: GPL-3.0-or-later
"""What panels and the 3D view show is found once after each change of the scene, not at each redraw."""

from bpy.app.handlers import persistent

_found = {}


def found(name, key, find):
    """What `find()` said last; asked again after a change of the scene, or for another `key` under this name."""
    if name not in _found or _found[name][0] != key:
        _found[name] = key, find()
    return _found[name][1]


@persistent
def forget(*_arguments):
    """For the handlers of all changes."""
    _found.clear()
