# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows the result of the panel's settings while they change, on copies of the selected objects that are hidden meanwhile.
The work runs in a thread; a timer shows the newest result. Undoing, saving, or ending the preview removes the copies."""

from dataclasses import replace

import bpy
import neural_mesh as nm
from bpy.app.handlers import persistent

from . import convert, poses, scene
from .job import Job, Refusal, first_line
from .simplify import simplify_tasks

# Seconds between two updates of the preview.
INTERVAL = 0.05
# Property of the copies, by which they are found after an undo.
MARK = "neural_mesh_preview"


class Preview:
    """A preview of the selected objects, read once when it begins."""

    def __init__(self, context):
        self.settings = context.scene.neural_mesh
        objects = scene.list_single(scene.find_objects(context))
        self.tasks = scene.read_tasks(context, self.settings, objects)
        # Will Bend may be turned on while the preview runs.
        self.bends = [poses.will_bend(task.owner, task.source) for task in self.tasks]
        self.poses = [task.poses or poses.read_poses(context, task.owner, task.source) for task in self.tasks]
        self.shown_settings = None
        self.running = []
        self.job = None
        self.message = ""
        self.copies = [add_copy(task) for task in self.tasks]

    def read_settings(self):
        """Returns the settings that the result depends on, except those that are read with the objects."""
        settings = self.settings
        size = settings.size_by, settings.ratio, settings.faces, settings.error_percent, settings.error_units, settings.bound_percent
        return (*size, settings.keep_components, settings.merge_equal, settings.bends)

    @property
    def is_outdated(self):
        """Returns whether the settings differ from those of the newest work."""
        return self.shown_settings != self.read_settings()

    def update(self):
        """Shows the result of work that has ended, and starts work for settings that have changed.

        Settings are polled, as Blender crashes on exit if properties of an extension have callbacks.
        """
        if self.job is not None and not self.job.is_running:
            self.finish_job()
        if self.is_outdated:
            if self.job is None:
                self.start_job()
            else:
                self.job.request_stop()

    def start_job(self):
        """Starts the work for the settings as they are."""
        self.shown_settings = self.read_settings()
        tasks = [replace(task, result=None, measures_errors=False) for task in self.tasks]
        try:
            n_faces = scene.plan_sizes(tasks, self.settings)
        except Refusal as error:
            self.message = first_line(error)
            return
        for task in tasks:
            task.keeps_components, task.is_welded = self.settings.keep_components, self.settings.merge_equal
        for task, bends, known in zip(tasks, self.bends, self.poses):
            task.bends = self.settings.bends and bends
            task.poses = known if task.bends else []
        self.running = tasks
        self.job = Job(lambda tell: simplify_tasks(tasks, n_faces, tell))

    def finish_job(self):
        """Shows what the work made; a task without a result keeps all its triangles."""
        if self.job.is_stopped:
            self.job = None
            return
        if self.job.error is None:
            for task, copy in zip(self.running, self.copies):
                convert.write_mesh(copy, task.result or task.source)
        n = sum(len((task.result or task.source).triangles) for task in self.running)
        self.message = self.job.error or f"{n:,} triangles"
        self.job = None

    def end(self):
        """Stops the work, removes the copies and shows the originals."""
        if self.job is not None:
            self.job.stop()
        remove_copies()


# The running preview.
current = None


def add_copy(task):
    """Adds a copy of an object for the preview and hides the original."""
    original = task.owner
    copy = original.copy()
    copy.data = original.data.copy()
    copy.name = f"{original.name}_Preview"
    copy[MARK] = original.name
    if task.applies_modifiers:
        for modifier in scene.find_applicable(copy):
            copy.modifiers.remove(modifier)
    for collection in original.users_collection:
        collection.objects.link(copy)
    copy.hide_select = True
    original.hide_set(True)
    return copy


def remove_copies():
    """Removes all copies, also those that an undo has brought back, and shows their originals."""
    for copy in [item for item in bpy.data.objects if MARK in item]:
        original, mesh = bpy.data.objects.get(copy[MARK]), copy.data
        bpy.data.objects.remove(copy)
        bpy.data.meshes.remove(mesh)
        if original is not None:
            original.hide_set(False)
            original.select_set(True)


def list_handlers():
    """Returns the handler lists of events that change the scene during a preview."""
    handlers = bpy.app.handlers
    return handlers.undo_pre, handlers.redo_pre, handlers.save_pre, handlers.load_pre


def begin(context):
    """Begins a preview of the selected objects."""
    global current
    end()
    current = Preview(context)
    for handlers in list_handlers():
        handlers.append(end_before)
    bpy.app.timers.register(update)


def end():
    """Ends the preview where one runs."""
    global current
    if current is None:
        return
    ended, current = current, None
    # A remaining timer crashes Blender on exit.
    if bpy.app.timers.is_registered(update):
        bpy.app.timers.unregister(update)
    for handlers in list_handlers():
        if end_before in handlers:
            handlers.remove(end_before)
    ended.end()


@persistent
def remove_orphans(*_):
    """Removes copies that an undo, a redo or a file has brought back."""
    if current is None:
        remove_copies()


@persistent
def end_before(*_):
    """Ends the preview before an undo, a redo, or another file changes the scene."""
    end()


def update():
    """Updates the preview; a timer calls it until the preview has ended."""
    if current is None:
        return None
    try:
        current.update()
    except (ReferenceError, nm.NeuralMeshError):
        # Someone has removed the copies.
        end()
    return None if current is None else INTERVAL
