# SPDX-License-Identifier: GPL-3.0-or-later
"""Preferences of the add-on."""

import bpy


class MOULAGE_AP_preferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    tetgen: bpy.props.StringProperty(
        name="TetGen",
        description="The program TetGen. Empty: it is looked for on the search path; where there is "
        "none, the built-in lattice makes the tets",
        subtype="FILE_PATH",
    )
    threads: bpy.props.IntProperty(
        name="Threads", description="Threads to use; 0: all. The result does not depend on it", min=0, max=256
    )

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "tetgen")
        layout.prop(self, "threads")


def get(context):
    """The preferences, or None where the add-on runs without being enabled."""
    addon = context.preferences.addons.get(__package__)
    return addon.preferences if addon else None


classes = (MOULAGE_AP_preferences,)
