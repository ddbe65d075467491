"""What the template grows on and what it carries: a bone and a distance, a vertex group, a vessel."""

import bpy
import numpy
from events import (
    click, has_result, keys, look_at, part, pause, picture, press, redo, region, running, select, template,
    undo, until,
)
from setting import with_markers
from sidebar import ICON, choose, click_button, open_tab, pick, show_panels, type_into


def session():
    ob = with_markers()
    yield from open_tab()
    yield from look_at([ob])
    place = ob.data.vertices[0].co
    bone = ball("bone", 6, place)
    person = ball("bone of the person", 6, place)
    ball("vessel", 8, (60, 170, 380))
    yield from vertex_group_by_keys(ob)
    yield from show_panels("Attachments", "Reshape")
    yield from near_a_bone(bone, person)
    yield from by_group()
    yield from picture("attachments")
    yield from grown_on()
    yield from carry()


def ball(name, radius, place):
    bpy.ops.mesh.primitive_uv_sphere_add(radius=radius, location=place)
    bpy.context.object.name = name
    return bpy.context.object


def vertex_group_by_keys(ob):
    """The faces around a place become a vertex group: Edit Mode, a click, Ctrl+Numpad+ twice, Ctrl+G."""
    select(ob)
    press("TAB")
    yield from until(lambda: ob.mode == "EDIT", "Edit Mode")
    press("A", alt=True)
    yield from keys("THREE")
    yield from click(region().x + region().width // 3, region().y + region().height // 2)
    for _ in range(2):
        press("NUMPAD_PLUS", ctrl=True)
        yield from pause()
    press("G", ctrl=True)
    yield from pause()
    yield from keys("RET")
    yield from until(lambda: len(ob.vertex_groups) == 1, "the vertex group")
    yield from keys("TAB")
    yield from until(lambda: ob.mode == "OBJECT", "Object Mode")
    assert 5 < group_of(ob).sum() < 200, group_of(ob).sum()


def near_a_bone(bone, person):
    """The selected bone and a distance; undo, redo."""
    select(bone, template())
    yield from click_button("moulage.add_attachment", ICON)
    yield from until(lambda: len(template().moulage.attachments) == 1, "the attachment")
    assert template().moulage.attachments[0].bone == bone
    yield from undo()
    yield from until(lambda: len(template().moulage.attachments) == 0, "undo of the attachment")
    yield from redo()
    yield from until(lambda: len(template().moulage.attachments) == 1, "redo of the attachment")
    yield from pick(".attachments[0].target", person.name)
    yield from until(lambda: template().moulage.attachments[0].target is not None, "the person's bone")
    yield from type_into(".attachments[0].distance", "5")
    yield from until(lambda: abs(template().moulage.attachments[0].distance - 5) < 1e-4, "the distance")
    points, targets = pairs()
    assert len(points) > 3 and numpy.allclose(points, targets, atol=1e-3)
    # The person's bone lies 2 mm further, and the targets with it.
    person = template().moulage.attachments[0].target
    select(person)
    press("G")
    yield from keys("Z", "2", "RET")
    yield from until(lambda: numpy.allclose(pairs()[1], points + (0, 0, 2), atol=1e-3), "the targets on the bone that moved")


def by_group():
    select(bpy.data.objects["bone"], template())
    yield from click_button("moulage.add_attachment", ICON)
    yield from until(lambda: len(template().moulage.attachments) == 2, "the second attachment")
    before = len(pairs()[0])
    yield from choose(".attachments[1].by", "V")
    yield from until(lambda: template().moulage.attachments[1].by == "GROUP", "attachment by vertex group")
    yield from pick(".attachments[1].group", template().vertex_groups[0].name)
    yield from until(lambda: template().moulage.attachments[1].group != "", "the vertex group of the attachment")
    assert len(pairs()[0]) != before


def grown_on():
    """A run in which attachments are met whatever the markers say; then both are removed."""
    yield from click_button(".hard_attachments")
    yield from until(lambda: template().moulage.hard_attachments, "hard attachments")
    template().moulage.max_iterations = 20
    wanted = pairs()[1][-1] - pairs()[0][-1]
    bpy.ops.ed.undo_push(message="ready")
    yield from click_button("moulage.reshape")
    yield from until(lambda: template().moulage.result.key != "" and not running(), "the end of the run")
    mesh_data, ob = part("mesh_data"), template()
    moved = mesh_data.key_points(ob.data.shape_keys.key_blocks["Reshaped"]) - mesh_data.rest_points(ob.data)
    off = numpy.linalg.norm(moved[group_of(ob)] - wanted, axis=1)
    assert off.max() < 1, f"the vertex group is {off.max()} mm off its bone"
    assert numpy.linalg.norm(moved, axis=1).max() > 10
    yield from picture("attached")
    yield from undo()
    yield from until(lambda: not has_result(), "undo of the run")
    for count in (1, 0):
        yield from click_button("moulage.remove_attachment", ICON)
        yield from until(lambda: len(template().moulage.attachments) == count, "the removal of an attachment")


def group_of(ob):
    return part("mesh_data").group_weights(ob, ob.vertex_groups[0].name) > 0.5


def pairs():
    ob = template()
    points = part("mesh_data").world_points(ob)
    return part("attachments").pairs(ob, points, part("mesh_data").triangles(ob))


def carry():
    vessel = bpy.data.objects["vessel"]
    yield from show_panels("Carried")
    select(vessel, template())
    yield from click_button("moulage.add_carried")
    yield from until(lambda: len(template().moulage.carried) == 1, "the carried mesh")
    assert template().moulage.carried[0].object == vessel
