"""The hand: file, registration with live view, stop, undo, the person's armature."""

import bpy
from events import (
    choose_file, click, in_view, look_at, picture, press, running, scene, search, undo, until,
)
from setting import HAND, clear
from sidebar import LEFT, click_button, find, open_tab, pick, scroll_to_end, show_panels, type_into


def skeleton():
    return scene().skeleton


def person():
    return skeleton().moulage_skeleton.person


def session():
    yield from open_tab()
    clear()
    yield from search("Coordinates Are Millimetres")
    yield from until(lambda: bpy.context.scene.unit_settings.scale_length < 0.01, "millimetres")
    yield from show_panels("Skeleton")
    yield from click_button("moulage.import_skeleton", LEFT)
    yield from choose_file(HAND / "skeleton.json")
    yield from until(lambda: skeleton() is not None, "the skeleton")
    with in_view():
        bpy.ops.import_mesh.ply(filepath=str(HAND / "target_surface.ply"))
    bpy.context.object.name = "surface"
    yield from pick(".moulage_skeleton.target", "surface")
    yield from until(lambda: skeleton().moulage_skeleton.target is not None, "the surface")
    yield from look_at(list(bpy.data.objects), "RIGHT")
    yield from picture("skeleton_start")
    bpy.ops.ed.undo_push(message="ready")
    yield from stop_by_esc()
    yield from whole_registration()


def is_shown():
    return any("(so far)" in ob.name for ob in bpy.data.objects)


def stop_by_esc():
    yield from click_button("moulage.register")
    yield from until(running, "the registration")
    yield from until(is_shown, "the live view")
    # At once: a registration of this hand takes seconds.
    press("ESC")
    yield from until(lambda: not running(), "the end after Esc")
    result = person().moulage_skeleton.result
    assert result.ending.startswith("Stopped"), result.ending
    yield from undo()
    yield from until(lambda: person() is None, "undo")
    assert not any("person" in ob.name for ob in bpy.data.objects)


def whole_registration():
    yield from click_button("moulage.register")
    yield from until(lambda: is_shown() or person() is not None, "the live view of the whole registration")
    yield from picture("skeleton_running")
    yield from until(lambda: person() is not None and not running(), "the end of the registration")
    own = person()
    assert own.moulage_skeleton.result.mean_residual < 0.05
    assert not skeleton().visible_get()
    yield from click_button("show_part(part='TARGET')", (0.5,))
    yield from until(lambda: not skeleton().moulage_skeleton.target.visible_get(), "the surface to hide")
    yield from look_at(list(own.children), "RIGHT")
    result = own.moulage_skeleton.result
    yield from type_into(".result.share", "0")
    yield from until(lambda: result.share == 0, "the slider at the template")
    keys = own.children[0].data.shape_keys.key_blocks
    assert keys["Template"].value == 1
    yield from scroll_to_end()
    # The second row of the list of bones, below the buttons and its title.
    x, y = yield from find("show_part(part='TEMPLATE')", LEFT)
    yield from click(x, y - 86)
    yield from until(lambda: bpy.context.selected_objects == [result.bones[1].object], "the bone that was clicked")
    yield from type_into(".result.share", "1")
    yield from until(lambda: result.share == 1, "the slider at the person")
    yield from picture("skeleton")
