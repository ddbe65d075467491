# SPDX-License-Identifier: GPL-3.0-or-later
"""All that is saved in the .blend: on the scene which object is the template, on the template its
data and settings, on each landmark empty what it belongs to."""

import bpy
from bpy.props import (
    BoolProperty, CollectionProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty,
    PointerProperty, StringProperty,
)

from . import heat_map, identity, landmarks, live_edit, scan
from .library import Wrong


def _is_mesh(_self, ob):
    return ob.type == "MESH"


def _holds_points(_self, ob):
    return ob.type in {"MESH", "POINTCLOUD"}


METHODS = [
    ("auto", "Automatic", "TetGen where it is found and can fill the surface, else the lattice"),
    ("tetgen", "TetGen", "The program TetGen, or an error"),
    ("lattice", "Lattice", "Built in; takes open and self-intersecting surfaces as well"),
]


HEAT_MAPS = [
    ("NONE", "None", "The object's own colours"),
    ("DISTANCE", "Distance", "How far the nearest markers are off the surface"),
    ("STRETCH", "Stretch", "How much the template was stretched: largest principal stretch"),
    ("SURE", "How Sure", "How far the surface may be off: its standard deviation, from shapes that explain the data as well"),
]


HOLDS = [
    ("EXACT", "Hold Exactly", "The template goes to this place, whatever the markers say", "PINNED", 0),
    ("WITHIN", "Within a Distance", "The template ends at most so far from this place, whatever the markers say", "CON_DISTLIMIT", 1),
    ("HINT", "Hint", "Weighed against the markers; lost where they contradict it", "UNPINNED", 2),
]


HOLD_ICONS = {name: icon for name, _label, _description, icon, _number in HOLDS}


def _show_hold(self, _context):
    landmarks.show_hold(self)


class MOULAGE_PG_landmark(bpy.types.PropertyGroup):
    """One place, on the template and on the person."""

    name: StringProperty(name="Name", description="Names with a side, such as hip.L, can be mirrored")
    template: PointerProperty(
        name="On the template", description="The empty on the template at rest", type=bpy.types.Object
    )
    target: PointerProperty(name="On the person", description="The empty on the person", type=bpy.types.Object)
    use: BoolProperty(name="Use", description="Whether the landmark takes part", default=True)
    hold: EnumProperty(
        name="Strength", description="How the template is held at this place", items=HOLDS, default="HINT",
        update=_show_hold,
    )
    within: FloatProperty(
        name="Distance", description="How far from this place the template may end", subtype="DISTANCE", default=2.0,
        min=0.0, update=_show_hold,
    )
    weight: FloatProperty(
        name="Weight", description="Of a hint, beside the others: 2 counts like two of them", default=1.0, min=0.0,
        soft_max=10.0,
    )
    residual: FloatProperty(
        name="Residual", description="How far off the last run left it; below 0: not known", default=-1.0
    )
    moved: FloatVectorProperty(description="Where the last run put the template's point", size=3)


class MOULAGE_PG_doubt(bpy.types.PropertyGroup):
    """Something suspicious about a template and its points (preflight.py)."""

    concern: StringProperty(description="What it is about")
    severity: StringProperty(description="note, doubtful or refused")
    text: StringProperty(description="What is wrong, one sentence")
    button: StringProperty(description="What mends it is called so; empty: nothing is known")
    moves: StringProperty(description="What the motion moves: TEMPLATE or PERSON")
    motion: FloatVectorProperty(description="What mends it, row by row", size=16)
    first: StringProperty(description="A landmark whose target is to be swapped")
    second: StringProperty(description="The other one")


class MOULAGE_PG_attachment(bpy.types.PropertyGroup):
    """A bone on which the template grows."""

    name: StringProperty(name="Name", description="What the attachment is called in messages")
    bone: PointerProperty(
        name="Bone", description="The bone of the template", type=bpy.types.Object, poll=_is_mesh
    )
    target: PointerProperty(
        name="Person's bone",
        description="The same bone of the person, with the same vertices. Empty: the bone is in place already",
        type=bpy.types.Object, poll=_is_mesh,
    )
    by: EnumProperty(
        name="Attached", description="What of the template is held by the bone", items=[
            ("DISTANCE", "Near the bone", "The template is attached to every vertex of the bone that is near it"),
            ("GROUP", "Vertex group", "The template's vertices in a group are attached to the bone"),
        ],
    )
    distance: FloatProperty(
        name="Distance", description="Vertices of the bone as near as this are attached",
        subtype="DISTANCE", min=0.0, default=3.0,
    )
    group: StringProperty(name="Vertex group", description="The template's vertices that grow on the bone")


class MOULAGE_PG_carried(bpy.types.PropertyGroup):
    """A mesh that moves with the template."""

    object: PointerProperty(
        name="Mesh", description="A mesh inside the template or near it", type=bpy.types.Object, poll=_is_mesh
    )


class MOULAGE_PG_result(bpy.types.PropertyGroup):
    """What the last run said; lengths in the scene's units."""

    key: StringProperty(name="Shape key", description="The result's shape key; empty: there is no result")
    ending: StringProperty(name="Ending", description="How the run ended, one sentence")
    warnings: StringProperty(description="What may be a mistake, one sentence per line")
    mean_distance: FloatProperty(description="Of the markers; below 0: not known", default=-1.0)
    max_distance: FloatProperty(description="Of the markers; below 0: not known", default=-1.0)
    mean_before: FloatProperty(
        description="The mean distance of the last whole run, if live editing came after it; else below 0", default=-1.0
    )
    iterations: IntProperty(description="Steps of the run")
    inverted_tets: IntProperty(description="Tets that are turned inside out: the shape is folded there")
    seconds: FloatProperty(description="How long the run took")
    volume: FloatVectorProperty(
        description="Volume and its standard deviation, in cubes of the scene's unit; below 0: not known", size=2, default=(-1.0, -1.0)
    )
    heat_range: FloatVectorProperty(description="The values at the two ends of the heat map's scale", size=2)


def _repaint(self, _context):
    heat_map.paint(self.id_data)


class MOULAGE_PG_template(bpy.types.PropertyGroup):
    """A template: its data and settings."""

    uid: StringProperty(description="Stays the same when the object is renamed")
    tets: StringProperty(description="The tets in the shape of the last run (kept_tets.py)")
    doubts: CollectionProperty(type=MOULAGE_PG_doubt, description="What was suspicious when it was last looked at")
    checked: BoolProperty(description="Whether it was looked at")

    landmarks: CollectionProperty(type=MOULAGE_PG_landmark, description="Pairs of places")
    active_landmark: IntProperty(name="Landmark", description="The landmark that is edited below the list")
    markers: PointerProperty(
        name="Points",
        description="A mesh or point cloud whose points lie on the person's surface",
        type=bpy.types.Object, poll=_holds_points,
    )
    marker_empties: PointerProperty(
        name="Empties", description="A collection whose empties lie on the person's surface",
        type=bpy.types.Collection,
    )
    attachments: CollectionProperty(type=MOULAGE_PG_attachment, description="Where the template grows on bones")
    active_attachment: IntProperty(name="Attachment", description="The attachment that is edited below the list")
    fixed_group: StringProperty(name="Fixed vertices", description="Vertex group of the template that stays where it is")
    carried: CollectionProperty(type=MOULAGE_PG_carried, description="Meshes that move along")
    active_carried: IntProperty(name="Carried mesh", description="The mesh that the button removes from the list")

    method: EnumProperty(name="Tets", description="What fills the template with tets", items=METHODS)
    tet_count: IntProperty(
        name="Number", description="About how many tets", default=15000, min=24, max=10_000_000, soft_max=100_000
    )
    tets_text: StringProperty(description="Quality of the tets, one sentence per line")

    tolerance: FloatProperty(
        name="Tolerance", subtype="DISTANCE", min=0.0, precision=3,
        description="How far a marker may be off because it was not clicked better. 0: the template's "
        "diagonal / 1000",
    )
    landmark_tolerance: FloatProperty(
        name="Landmarks", subtype="DISTANCE", min=0.0, precision=3,
        description="How far a landmark may be off. 0: 5 times the tolerance",
    )
    attachment_tolerance: FloatProperty(
        name="Attachments", subtype="DISTANCE", min=0.0, precision=3,
        description="How far an attachment may be off. 0: the tolerance",
    )
    smoothness: FloatProperty(
        name="Smoothness", description="Times the usual weight of the smoothness of the stretch", default=1.0,
        min=1e-3, soft_min=0.1, soft_max=10.0,
    )
    max_iterations: IntProperty(name="Iterations", description="At most so many; 0: the usual number", min=0)
    hard_attachments: BoolProperty(
        name="Hard attachments", description="Attachments are met whatever the markers say"
    )
    reverse_term: BoolProperty(
        name="Pull back far parts", default=True,
        description="Parts of the template far from every marker are pulled back, except beyond the ends of "
        "a scan that cuts the organ",
    )
    new_key: BoolProperty(
        name="Keep earlier results", description="Each run makes a shape key of its own instead of replacing the last"
    )
    live: BoolProperty(name="Live view", description="Show the shape while it is being found", default=True)

    result: PointerProperty(type=MOULAGE_PG_result, description="What the last run said")
    heat: EnumProperty(name="Heat map", description="What the template's colours tell", items=HEAT_MAPS)
    heat_limit: FloatProperty(
        name="Up to", subtype="DISTANCE", min=0.0, precision=3, update=_repaint,
        description="The distance at the yellow end of the scale. 0: all but the largest hundredth",
    )
    stretch_limit: FloatProperty(
        name="Up to", min=0.0, precision=2, update=_repaint,
        description="The stretch at the red end of the scale; the blue end is its inverse. 0: all but the largest hundredth",
    )
    sure_limit: FloatProperty(
        name="Up to", subtype="DISTANCE", min=0.0, precision=3, update=_repaint,
        description="The standard deviation at the purple end of the scale. 0: all but the largest hundredth",
    )
    show_markers: BoolProperty(
        name="Show markers", description="Draw the markers as dots, coloured by their distance", default=True
    )

    @property
    def findings(self):
        """What is suspicious, one sentence per line."""
        return "\n".join(row.text for row in self.doubts)


def _draw_slice(view):
    def update(_self, context):
        try:
            scan.draw(context, view) if view else scan.draw_all(context)
        except Wrong:
            # The panel says what is wrong with the scan.
            pass

    return update


_label_items = []


def _labels_of_map(_self, context):
    """The labels of the map in the Scan panel. Blender does not keep the texts: they are kept here."""
    try:
        labels = scan.label_map(context.scene)[1]
    except Wrong:
        labels = []
    _label_items[:] = [(str(n), scan.label_name(n), f"The organ or bone of label {n}") for n in labels] or [("0", "No labels", "Choose a label map")]
    return _label_items


def _slider(view):
    return FloatProperty(
        name=view.capitalize(), description="Where the slice lies, in millimetres", step=100, precision=1, update=_draw_slice(view),
    )


def _template_chosen(self, _context):
    if self.template is not None:
        identity.give(self.template)


def _skeleton_chosen(self, _context):
    if self.skeleton is not None:
        identity.give(self.skeleton, "moulage_skeleton")


class MOULAGE_PG_scene(bpy.types.PropertyGroup):
    template: PointerProperty(
        name="Template", description="The mesh to put into the person's shape", type=bpy.types.Object, poll=_is_mesh,
        update=_template_chosen,
    )
    skeleton: PointerProperty(
        name="Skeleton", description="The armature to put on the person's bones", type=bpy.types.Object,
        poll=lambda _self, ob: ob.type == "ARMATURE", update=_skeleton_chosen,
    )
    scan: StringProperty(name="Scan", description="File or folder of the image volume", subtype="FILE_PATH")
    axial: _slider("AXIAL")
    coronal: _slider("CORONAL")
    sagittal: _slider("SAGITTAL")
    window_width: FloatProperty(
        name="Window", description="Values from black to white", default=400, min=1e-3, update=_draw_slice("")
    )
    window_level: FloatProperty(name="Level", description="The value in the middle", default=40, update=_draw_slice(""))
    scan_opacity: FloatProperty(
        name="Opacity", description="Of the slices", subtype="FACTOR", default=1.0, min=0.0, max=1.0, update=_draw_slice("")
    )
    looking_at: StringProperty(description="The slice that is looked at; empty: none")
    label_map: StringProperty(
        name="Label map", description="File of a segmentation of the scan: TotalSegmentator, 3D Slicer and others",
        subtype="FILE_PATH",
    )
    label: EnumProperty(name="Label", description="Which organ of the label map", items=_labels_of_map)
    label_every: FloatProperty(
        name="Slices (mm)", description="Millimetres between the slices that are marked", default=9.0, min=0.1
    )
    label_spacing: FloatProperty(
        name="Markers (mm)", description="Millimetres between markers along an outline", default=8.0, min=0.1
    )
    label_planes: EnumProperty(
        name="Planes", description="Which slices are marked", options={"ENUM_FLAG"}, default={"AXIAL"},
        items=[(view, view.capitalize(), f"Mark {view.lower()} slices") for view in scan.AXES],
    )
    show_contour: BoolProperty(
        name="Outline of the template", description="Draw on the slices where they cut the template as it is shown",
        default=True,
    )


class MOULAGE_PG_runtime(bpy.types.PropertyGroup):
    """Where the present run stands; for the panels, not saved."""

    fraction: FloatProperty(name="Progress", description="Share of the run that is done", subtype="FACTOR", min=0.0, max=1.0)
    stage: StringProperty(description="What the run is doing")
    details: StringProperty(description="Its latest step")
    live_edit: BoolProperty(
        name="Live Editing", update=live_edit.changed,
        description="The shape follows landmarks and markers while they are moved. It begins at the last result",
    )


classes = (
    MOULAGE_PG_landmark, MOULAGE_PG_doubt, MOULAGE_PG_attachment, MOULAGE_PG_carried, MOULAGE_PG_result, MOULAGE_PG_template,
    MOULAGE_PG_scene, MOULAGE_PG_runtime,
)


def register():
    # Which slice of the scan an empty is.
    bpy.types.Object.moulage_slice = StringProperty()
    bpy.types.Object.moulage = PointerProperty(type=MOULAGE_PG_template)
    bpy.types.Scene.moulage = PointerProperty(type=MOULAGE_PG_scene)
    bpy.types.WindowManager.moulage = PointerProperty(type=MOULAGE_PG_runtime)


def unregister():
    del bpy.types.WindowManager.moulage
    del bpy.types.Scene.moulage
    del bpy.types.Object.moulage
    del bpy.types.Object.moulage_slice


def template_of(context):
    """The scene's template, or None; also for one that was deleted but is still in the file."""
    ob = context.scene.moulage.template
    return ob if ob is not None and ob.name in context.scene.objects else None
