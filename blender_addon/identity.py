# SPDX-License-Identifier: GPL-3.0-or-later
"""Who an object is, for a run that outlives Python's references: undo replaces all objects, and users rename them.
`kind` is the property that holds the uid: "moulage" or "moulage_skeleton"."""

import uuid

import bpy


def give(ob, kind="moulage"):
    """The object's uid. Where it is chosen as template or skeleton it gets one, so that undo does not take it away."""
    data = getattr(ob, kind)
    if not data.uid:
        data.uid = uuid.uuid4().hex
    return data.uid


def find(uid, name, kind="moulage"):
    """The object in the scene, also after it was renamed; None if it was deleted. One of this name without a uid is it
    too: undo went back to before it was given."""
    known = {uid: 0, "": 1}
    there = [ob for ob in bpy.data.objects if ob.users_collection and getattr(ob, kind).uid in known]
    there = [ob for ob in there if getattr(ob, kind).uid or ob.name == name]
    # A duplicate has the uid of its original.
    found = min(there, key=lambda ob: (known[getattr(ob, kind).uid], ob.name != name), default=None)
    if found is not None:
        getattr(found, kind).uid = uid
    return found
