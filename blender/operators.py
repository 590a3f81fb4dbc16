# SPDX-License-Identifier: GPL-3.0-or-later
"""Defines the operators: simplify the selected objects, make levels of detail of them, and preview the result.
From the panel they run in the background until Esc; from a script, or without a window, they run directly."""

import time

import bpy
import neural_mesh as nm
from bpy.types import Operator

from . import engines, lods, preview, scene
from .job import Job, Refusal, first_line
from .settings import Carrying, Levels, Sizing
from .simplify import simplify_tasks

# Seconds between two updates of the progress.
INTERVAL = 0.1


class RunsInBackground:
    """Runs `prepare`, work without Blender's data, and `finish`, directly or by a modal operator."""

    def execute(self, context):
        """Runs directly."""
        preview.end()
        try:
            work = self.prepare(context)
            work(None)
        except (Refusal, nm.NeuralMeshError) as error:
            self.report({"ERROR"}, first_line(error))
            return {"CANCELLED"}
        return self.put_results(context)

    def invoke(self, context, event):
        """Starts the work in a thread, where there is a window to go on in."""
        if bpy.app.background:
            return self.execute(context)
        preview.end()
        try:
            work = self.prepare(context)
        except Refusal as error:
            self.report({"ERROR"}, first_line(error))
            return {"CANCELLED"}
        manager = context.window_manager
        manager.progress_begin(0, 100)
        self.timer = manager.event_timer_add(INTERVAL, window=context.window)
        self.job = Job(work)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        """Shows the progress, stops at Esc, and puts the result in place at the end."""
        if event.type == "ESC":
            self.cancel(context)
            self.report({"INFO"}, "Stopped: no object has changed")
            return {"CANCELLED"}
        if event.type != "TIMER" or self.job.is_running:
            context.window_manager.progress_update(100 * self.job.progress)
            context.workspace.status_text_set(f"Neural Mesh: {100 * self.job.progress:.0f} %    Esc: stop")
            return {"RUNNING_MODAL"}
        self.end_progress(context)
        if self.job.error:
            self.report({"ERROR"}, self.job.error)
            return {"CANCELLED"}
        return self.put_results(context)

    def put_results(self, context):
        """Puts the results in place, or says in one line why that failed."""
        try:
            return self.finish(context)
        except Refusal as error:
            self.report({"ERROR"}, first_line(error))
            return {"FINISHED"}

    def cancel(self, context):
        """Stops the work; Blender calls this too when it closes."""
        self.job.stop()
        self.end_progress(context)

    def end_progress(self, context):
        """Removes the display of the progress."""
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)

    def report_end(self, tasks):
        """Reports the number of triangles, missed sizes, and modifiers to bind again."""
        before = sum(len(task.source.triangles) for task in tasks)
        after = sum(len(task.result.triangles if task.result else task.source.triangles) for task in tasks)
        self.report({"INFO"}, f"{after:,} of {before:,} triangles in {time.perf_counter() - self.begun:.1f} s")
        for task in tasks:
            if task.outcome != "reached":
                self.report({"WARNING"}, f"{task.name}: {task.outcome}")
        for note in dict.fromkeys(task.note for task in tasks if task.note):
            self.report({"WARNING"}, note)
        bound = [name for task in tasks for name in scene.find_bound_modifiers(task.owner)]
        if bound:
            self.report({"WARNING"}, f"Bind these modifiers again: {', '.join(bound)}")


class OBJECT_OT_neural_mesh_simplify(RunsInBackground, Carrying, Sizing, Operator):
    """Simplify the selected meshes: meshes with more detail get more faces"""

    bl_idname = "object.neural_mesh_simplify"
    bl_label = "Simplify"
    bl_options = {"REGISTER", "UNDO"}

    def prepare(self, context):
        """Reads the selection and returns the work."""
        self.begun = time.perf_counter()
        objects = scene.list_single(scene.find_objects(context))
        self.tasks = tasks = scene.read_tasks(context, self, objects)
        n_faces = scene.plan_sizes(tasks, self)
        return lambda tell: simplify_tasks(tasks, n_faces, tell)

    def finish(self, context):
        """Puts the results in place."""
        for task in self.tasks:
            task.owner.neural_mesh.n_before = len(task.source.triangles)
            if task.result is None and task.applies_modifiers:
                task.result = task.source
            if task.result is not None:
                scene.put_in_place(context, task, self)
        self.report_end(self.tasks)
        return {"FINISHED"}


class OBJECT_OT_neural_mesh_lods(RunsInBackground, Carrying, Levels, Operator):
    """Make levels of detail of the selected meshes, and write them for an engine"""

    bl_idname = "object.neural_mesh_lods"
    bl_label = "Make Levels of Detail"
    bl_options = {"REGISTER", "UNDO"}

    def prepare(self, context):
        """Reads the selection and returns the work."""
        self.begun = time.perf_counter()
        lods.parse_ratios(self.ratios)
        originals = lods.find_originals(scene.find_objects(context, with_empties=True))
        self.files = [engines.plan_files(original, self) for original in originals]
        tasks = scene.read_tasks(context, self, originals, is_copied=True)
        self.levels = levels = lods.plan_levels(tasks, self)
        shares_out = self.share_out and len(tasks) > 1
        return lambda tell: lods.simplify_levels(levels, shares_out, tell)

    def finish(self, context):
        """Makes the objects of the levels and writes their files."""
        groups = [lods.make_levels(context, tasks, self) for tasks in self.levels]
        # Drivers hide what does not show.
        context.view_layer.update()
        self.report_end([task for tasks in self.levels for task in tasks])
        for group, tasks, paths in zip(groups, self.levels, self.files):
            engines.write_files(context, group, tasks, paths, self)
        # Originals are hidden now: levels can be made again from the empties above them.
        engines.select_alone(context, groups)
        written = [path.name for paths in self.files for path in paths]
        if written:
            self.report({"INFO"}, f"Written: {', '.join(written)}")
        return {"FINISHED"}


class OBJECT_OT_neural_mesh_preview(Operator):
    """Show the result of the settings while they change, until pressed again"""

    bl_idname = "object.neural_mesh_preview"
    bl_label = "Preview"

    def execute(self, context):
        """Begins the preview, or ends the one that runs."""
        if preview.current is not None:
            preview.end()
            return {"FINISHED"}
        try:
            preview.begin(context)
        except Refusal as error:
            self.report({"ERROR"}, first_line(error))
            return {"CANCELLED"}
        return {"FINISHED"}


CLASSES = (OBJECT_OT_neural_mesh_simplify, OBJECT_OT_neural_mesh_lods, OBJECT_OT_neural_mesh_preview)
