"""The template: a naive import is caught and mended, the right one is one step; broken and put right, filled with tets."""

import bpy
from events import (
    choose_file, click, keys, look_at, pause, picture, press, redo, region, running, template, undo, until,
)
from setting import LIVER, clear, load_liver
from sidebar import LEFT, click_button, open_inner_panel, open_tab, show_panels, type_into


def session():
    # By Blender's own importer, whose axes are others.
    load_liver("NEGATIVE_Z", "Y")
    yield from open_tab()
    yield from picture("start")
    yield from naive_import()
    clear()
    yield from pause()
    yield from click_button("moulage.import_template")
    yield from choose_file(LIVER / "template.obj")
    yield from until(lambda: template() is not None, "the template")
    ob = template()
    assert ob.moulage.findings == "" and bpy.context.scene.unit_settings.scale_length < 0.01
    yield from look_at([ob])
    yield from check_and_fix(ob)
    yield from fill_with_tets()


def naive_import():
    """What is wrong is said with the markers, and asked about before a run."""
    yield from click_button("moulage.set_template")
    yield from until(lambda: concerns() == ["scene"], "metres that look like millimetres")
    yield from click_button("moulage.mend(index=0)")
    yield from until(lambda: concerns() == [], "millimetres")
    assert bpy.context.scene.unit_settings.scale_length < 0.01
    yield from show_panels("Template", "Markers", "Reshape")
    yield from click_button("moulage.import_person")
    yield from choose_file(LIVER / "markers.csv")
    yield from until(lambda: concerns() == ["up_axis"], "the axes that differ")
    yield from picture("doubts")
    yield from click_button("moulage.reshape")
    yield from pause()
    assert not running(), "nonsense was not asked about"
    press("ESC")
    yield from pause()
    yield from click_button("moulage.mend(index=0)")
    yield from until(lambda: concerns() == [], "the template turned back")
    yield from undo()
    yield from until(lambda: concerns() == ["up_axis"], "undo of turning")
    assert not running()


def concerns():
    return [row.concern for row in template().moulage.doubts] if template() is not None else None


def check_and_fix(ob):
    """A face is deleted and others are turned over, by keys; Check finds both, Fix puts them right."""
    vertices, faces = len(ob.data.vertices), len(ob.data.polygons)
    press("TAB")
    yield from until(lambda: ob.mode == "EDIT", "Edit Mode")
    press("A", alt=True)
    yield from keys("THREE")
    middle = region().x + region().width // 3, region().y + region().height // 2
    yield from click(*middle)
    yield from keys("X", "F")
    yield from click(middle[0] + 60, middle[1] + 20)
    press("N", alt=True)
    yield from pause()
    yield from keys("F", "TAB")
    yield from until(lambda: ob.mode == "OBJECT", "Object Mode")
    assert len(ob.data.polygons) == faces - 1
    yield from click_button("moulage.check_template", LEFT)
    yield from until(lambda: "hole" in ob.moulage.findings, "the hole that was found")
    assert len(ob.moulage.findings.splitlines()) == 2, ob.moulage.findings
    yield from picture("check")
    yield from click_button("moulage.fix_template")
    yield from until(lambda: template().moulage.findings == "", "the mended template")
    assert (len(ob.data.vertices), len(ob.data.polygons)) == (vertices, faces)
    yield from undo()
    yield from until(lambda: "hole" in template().moulage.findings, "the hole after undo")
    yield from redo()
    yield from until(lambda: template().moulage.findings == "", "redo of the mending")


def fill_with_tets():
    yield from show_panels("Reshape")
    yield from open_inner_panel("moulage.reshape", "moulage.tetrahedralize", gap=22)
    # Fewer than usual: the session is about the window.
    yield from type_into(".moulage.tet_count", "2000")
    yield from until(lambda: template().moulage.tet_count == 2000, "the number of tets")
    yield from click_button("moulage.tetrahedralize")
    yield from until(lambda: "mean quality" in template().moulage.tets_text, "the tets")
    yield from picture("tets")
