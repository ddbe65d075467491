# SPDX-License-Identifier: GPL-3.0-or-later
"""The result of a separation in words."""

from . import units
from .library import sentence


def write(scene, run, found, seconds):
    """Keeps the sentences for the panel; returns whether nothing overlaps any more, and what to tell the user."""
    settings, summary = scene.moulage_separate, found.summary
    first, *others = _outcome(scene, run, found)
    took = f"{summary['rounds']} round{'s' if summary['rounds'] != 1 else ''}, {seconds:.0f} s."
    lines = [first, *others, *_moves(scene, run, found), took, *(sentence(w) for w in run.warnings)]
    settings.report, settings.clear = "\n".join(lines), summary["separated"]
    return summary["separated"], " ".join([first, *others])


def _outcome(scene, run, found):
    """What overlaps now, and what did."""
    names = [body.name for body in run.bodies] + [name for name, _, _ in run.bones]
    summary, pairs = found.summary, found.overlaps
    if summary["separated"] and not pairs:
        return ["No triangle crosses: the meshes do not overlap, nothing was moved."]
    if summary["separated"]:
        before = [f"{_pair(names, p)} overlapped, {_depth(scene, p, 0)}." for p in pairs if _is_left(p, 0)]
        return ["No triangle crosses any more, and none lies inside another mesh.", *before]
    left = [p for p in pairs if _is_left(p, 1)]
    count = "1 pair still overlaps" if len(left) == 1 else f"{len(left)} pairs still overlap"
    lines = [f"{_pair(names, p)}: {_depth(scene, p, 1)}; before, {_depth(scene, p, 0)}." for p in left]
    stopped = summary["ending"] == "cancelled"
    advice = (
        "Stopped: the shapes with the least overlap so far are kept." if stopped
        else "Allow more rings, or look whether the shapes contradict each other."
    )
    return [f"{count}.", *lines, advice]


def _is_left(pair, when):
    return pair["crossings"][when] > 0 or pair["vertices_inside"][when] > 0


def _pair(names, pair):
    return f"{names[pair['first']]} and {names[pair['second']]}"


def _depth(scene, pair, when):
    if not _is_left(pair, when):
        return "not at all"
    if pair["depth"][when] > 0:
        return f"{units.text(scene, pair['depth'][when])} deep"
    return "where no vertex lies, edges only"


def _moves(scene, run, found):
    for number, body in enumerate(run.bodies):
        now = found.body(number)
        if now["moved_vertices"] > 0:
            moved = f"{now['moved_vertices']} of {len(body.points)} vertices moved"
            yield f"{body.name}: {moved}, at most {units.text(scene, now['largest_move'])}."
        if now["markers_inside_obstacles"] > 0:
            yield f"{body.name}: {now['markers_inside_obstacles']} markers lie inside what stays, and hold nothing."
