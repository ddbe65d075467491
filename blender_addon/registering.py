# SPDX-License-Identifier: GPL-3.0-or-later
"""One registration of a skeleton without an operator."""

import time

import bpy
import numpy

from . import identity, mesh_data, person, scan, skeleton, skeleton_files, views
from .library import Wrong, calls, moulage
from .preferences import get
from .runs import Running

_LIVE_LIMIT = 500_000


def missing(armature):
    """What is to be done before a registration can start, or None."""
    data = armature.moulage_skeleton
    wanted = {
        "SURFACE": (data.target, "Pick the surface of the person's bones"),
        "BONES": (data.target_bones, "Pick the collection of the person's bones"),
        "LABELS": (data.label_map, "Choose the label map of the person's bones"),
        "IMAGE": (data.image and data.reference, "Choose the person's image and the template's"),
    }
    there, words = wanted[data.target_kind]
    return None if there else words


class Registering(Running):
    """A registration under way. Volumes are in millimetres, surfaces in the scene's unit; so is the run."""

    def __init__(self, context, armature):
        if armature is not None and missing(armature):
            raise Wrong(missing(armature) + ".")
        if armature is not None:
            # A hidden skeleton is not posed.
            views.show(context, person.parts(armature, "TEMPLATE"), True)
        in_millimetres = armature is not None and armature.moulage_skeleton.target_kind in {"LABELS", "IMAGE"}
        scale = 1.0 / scan.unit(context.scene) if in_millimetres else 1.0
        self.template = skeleton.gather(context, armature, scale)
        self.unit = 1.0 / scale
        data = armature.moulage_skeleton
        self.uid, self.name = identity.give(armature, "moulage_skeleton"), armature.name
        self._live = data.live and sum(map(len, self.template.points)) <= _LIVE_LIMIT
        self._preview = person.Preview(armature, self.template)
        own = get(context)
        super().__init__()
        try:
            with calls() as library:
                native = self.template.native()
                problem = library.Registration(native)
                self._aim(context, library, problem, armature)
                self.tissues = skeleton_files.soft_tissues(armature, scale)
                self._run = problem.start(library.RegistrationOptions(
                    align=not data.near, as_is=data.as_is, limits=data.limits,
                    max_iterations=data.max_iterations, thread_count=own.threads if own else 0,
                ))
        except Wrong:
            self.close()
            raise

    def _aim(self, context, library, problem, armature):
        data = armature.moulage_skeleton
        if data.target_kind == "SURFACE":
            problem.set_target(_surface(library, data.target))
        elif data.target_kind == "BONES":
            self._aim_at_bones(library, problem, data.target_bones)
        elif data.target_kind == "LABELS":
            self._aim_at_labels(library, problem, armature)
        else:
            paths = (bpy.path.abspath(path) for path in (data.image, data.reference))
            problem.set_image(*(library.Volume(path) for path in paths))

    def _aim_at_bones(self, library, problem, collection):
        there = {ob.name.split(".")[0]: ob for ob in collection.all_objects if ob.type == "MESH"}
        there.update({ob.name: ob for ob in collection.all_objects if ob.type == "MESH"})
        known = [number for number, name in enumerate(self.template.names) if name in there]
        if not known:
            raise Wrong(
                f"No mesh in '{collection.name}' is named as a bone, such as '{self.template.names[0]}'."
            )
        for number in known:
            problem.set_bone_target(number, _surface(library, there[self.template.names[number]]))

    def _aim_at_labels(self, library, problem, armature):
        data = armature.moulage_skeleton
        volume = library.Volume(bpy.path.abspath(data.label_map))
        there = volume.labels
        own = {n: armature.pose.bones[name].moulage.label for n, name in enumerate(self.template.names)}
        if data.label > 0:
            problem.set_target(volume.label_surface(data.label))
        elif len(there) == 1:
            problem.set_target(volume.label_surface(there[0]))
        elif any(label in there for label in own.values()):
            for number, label in own.items():
                if label in there:
                    problem.set_bone_target(number, volume.label_surface(label))
        else:
            words = ", ".join(map(str, there[:20])) or "none"
            raise Wrong(
                f"The map has the labels {words}: choose one that holds all bones, or give each bone its label "
                "(Bone Properties > Moulage)."
            )

    def _armature(self):
        return identity.find(self.uid, self.name, "moulage_skeleton")

    def tick(self):
        """Goes on; False when it has ended."""
        if self._error is not None:
            return False
        try:
            self.progress = self._run.poll()
        except moulage().Error as error:
            self._fail(error)
            return False
        if self._armature() is None:
            self._error = f"The skeleton '{self.name}' was deleted; the run was stopped."
            self.stop()
            return False
        return not self.progress.ended

    def wants_view(self):
        return self._live and bpy.context.mode == "OBJECT"

    def show_points(self, points):
        self._preview.show(points * self.unit)

    @property
    def waits_for_object_mode(self):
        """Whether the result cannot be written because something is being edited or posed."""
        return bpy.context.mode != "OBJECT"

    def finish(self, context):
        """Writes the result and returns what to tell the user; Wrong if there is none."""
        armature = self._armature()
        try:
            found = self._wait()
            if armature is None:
                raise Wrong(f"The skeleton '{self.name}' was deleted; the person's is lost.")
            self._preview.remove()
            with calls():
                seconds = time.monotonic() - self.started
                return person.write(context, armature, self, found, seconds)
        finally:
            self.put_back()
            self.close()

    def put_back(self):
        self._preview.remove()


def _surface(library, ob):
    if len(ob.data.polygons) == 0:
        raise Wrong(f"'{ob.name}' has no faces: registration needs a surface.")
    return library.TriMesh(mesh_data.world_points(ob).astype(numpy.float64), mesh_data.triangles(ob))
