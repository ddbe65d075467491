# SPDX-License-Identifier: GPL-3.0-or-later
"""Doubts before a run: mend one, or run all the same."""

import bpy

from .. import preflight, properties
from ..library import Wrong
from ..panels import draw_doubts
from .base import NeedsTemplate, tells

# Concerns that an operator of their own mends.
_OPERATORS = {
    "surface": bpy.ops.moulage.fix_template, "place": bpy.ops.moulage.place_template,
    "scene": bpy.ops.moulage.use_millimetres,
}


class MOULAGE_OT_mend(NeedsTemplate, bpy.types.Operator):
    """Mend what this sentence says"""

    bl_idname = "moulage.mend"
    bl_label = "Mend"

    index: bpy.props.IntProperty(name="Doubt", description="Its number in the list", min=0)

    @tells
    def execute(self, context):
        template = properties.template_of(context)
        doubts = template.moulage.doubts
        if self.index >= len(doubts) or not doubts[self.index].button:
            raise Wrong("There is nothing to mend any more.")
        row = doubts[self.index]
        if row.concern in _OPERATORS:
            # It looks again by itself.
            return _OPERATORS[row.concern]()
        (preflight.swap if row.concern == "exchange" else preflight.move)(template, row)
        context.view_layer.update()
        preflight.look(context, template)
        return {"FINISHED"}


class MOULAGE_OT_reshape_anyway(NeedsTemplate, bpy.types.Operator):
    """What speaks against the run: mend it, or reshape all the same"""

    bl_idname = "moulage.reshape_anyway"
    bl_label = "Reshape All the Same?"
    bl_options = {"INTERNAL"}

    def invoke(self, context, _event):
        return context.window_manager.invoke_props_dialog(self, width=480)

    def draw(self, context):
        template = properties.template_of(context)
        if not preflight.serious(template):
            self.layout.label(text="All is well now: OK reshapes.", icon="CHECKMARK")
        draw_doubts(self.layout, context, template, width=70)

    def execute(self, _context):
        return bpy.ops.moulage.reshape("INVOKE_DEFAULT", anyway=True)


classes = (MOULAGE_OT_mend, MOULAGE_OT_reshape_anyway)
