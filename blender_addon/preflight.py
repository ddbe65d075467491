# SPDX-License-Identifier: GPL-3.0-or-later
"""Before a run: what is suspicious about a template and its points, in Blender's words, and what mends it. The library
finds it; here it gets a sentence and a button, and is kept on the template for the panel."""

import mathutils
import numpy

from . import markers, problem, units
from .library import Wrong, calls, sentence

# A person's organ, bone or body in millimetres.
_LIKELY_SIZE = (5.0, 3000.0)


def look(context, template):
    """Looks again and keeps what is found as the template's doubts."""
    kept = template.moulage.doubts
    kept.clear()
    template.moulage.checked = True
    try:
        inputs = problem.gather(context, template)
        found = _findings(inputs)
    except Wrong:
        # Data that are not complete yet are refused when a run begins.
        return
    size = _size(inputs.points)
    if units.are_millimetres(context.scene, size):
        _keep(kept, "scene", "note", f"The template is {units.text(context.scene, size)} long: its coordinates look like "
              "millimetres.", "These Are Millimetres")
    for finding in found:
        # Too few points are refused when a run begins.
        if (finding.concern, finding.severity) != ("amount", "refused"):
            text, button = _words(context.scene, inputs, finding)
            row = _keep(kept, finding.concern, finding.severity, text, button)
            _keep_remedy(row, context.scene, inputs, finding)


def serious(template):
    """The doubts after which a run would probably end in nonsense."""
    return [row for row in template.moulage.doubts if row.severity != "note"]


def _findings(inputs):
    with calls() as library:
        pairs = library.Pairs(*inputs.landmarks, labels=inputs.landmark_names)
        held = library.Pairs(*inputs.attachments)
        surface = library.TriMesh(inputs.points, inputs.triangles)
        return library.inspect(surface, inputs.markers, pairs, held, inputs.fixed)


def _size(points):
    return float(numpy.ptp(points, axis=0).max()) if len(points) else 0.0


def _keep(kept, concern, severity, text, button=""):
    row = kept.add()
    row.concern, row.severity, row.text, row.button = concern, severity, text, button
    return row


def _keep_remedy(row, scene, inputs, finding):
    if finding.motion is not None:
        row.moves = "PERSON" if finding.concern == "unit" and _person_is_odd(scene, inputs) else "TEMPLATE"
        motion = numpy.linalg.inv(finding.motion) if row.moves == "PERSON" else finding.motion
        row.motion = motion.ravel().tolist()
    if finding.exchange is not None:
        row.first, row.second = (inputs.landmark_names[number] for number in finding.exchange)


def _person_is_odd(scene, inputs):
    """Whether the template is as large as parts of a body are, and the person is not."""
    low, high = (length / units.millimetres(scene, 1.0) for length in _LIKELY_SIZE)
    own, theirs = _size(inputs.points), _size(inputs.markers)
    return low < own < high and not low < theirs < high


def _words(scene, inputs, finding):
    """The sentence and what the button is called; no button where nothing is known that mends it."""
    def text(length):
        return units.text(scene, length)

    concern, motion = finding.concern, finding.motion
    away = f"The person's points are {text(finding.distance)} from the template on average"
    if finding.mended_distance == finding.mended_distance:
        away += f", but {text(finding.mended_distance)} "
    if concern == "unit":
        own, theirs = text(_size(inputs.points)), text(_size(inputs.markers))
        words = f"The template is {own} long and the person {theirs}: their files are in two units."
        return words, "" if motion is None else "Bring to One Unit"
    if concern == "up_axis":
        from_y = motion[2, 1] > 0
        words = f"{away}once it is turned: {'its file has Y up' if from_y else 'it was turned when it was imported'}."
        return words, "Turn from Y up" if from_y else "Turn Back to Z up"
    if concern == "frame":
        return f"{away}once it is turned round: one of the files is in LPS, the other in RAS.", "Turn LPS to RAS"
    if concern == "place":
        return f"{away}: it lies somewhere else.", "Place"
    if concern == "side":
        return "The landmarks lie as on a mirror image of the template: it is of the other side of the body.", "Mirror"
    if concern == "exchange":
        first, second = (inputs.landmark_names[number] for number in finding.exchange)
        return f"The landmarks '{first}' and '{second}' look exchanged.", "Swap Them"
    return sentence(finding.text.removeprefix("the template: ")), "Fix" if concern == "surface" else ""


def move(template, row):
    """Moves what a doubt says: the template, or all that is the person's."""
    motion = mathutils.Matrix([row.motion[4 * k : 4 * k + 4] for k in range(4)])
    for ob in [template] if row.moves == "TEMPLATE" else _persons(template):
        # Children of what is moved go along.
        ob.matrix_world = motion @ ob.matrix_world


def _persons(template):
    data = template.moulage
    found = [data.markers] + [landmark.target for landmark in data.landmarks]
    found += markers.empties(data.marker_empties) if data.marker_empties is not None else []
    return {ob for ob in found if ob is not None}


def swap(template, row):
    """Gives two landmarks each other's targets."""
    first, second = (template.moulage.landmarks[name].target for name in (row.first, row.second))
    first.matrix_world, second.matrix_world = second.matrix_world.copy(), first.matrix_world.copy()
