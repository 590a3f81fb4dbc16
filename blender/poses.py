# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the poses that a mesh is known to take: its shape keys, and its armature over its animation or as it is posed.
The armature's poses are blended from bones here (linear blend skinning), so that the mesh is not evaluated for each frame."""

from dataclasses import dataclass

import numpy as np

# Poses of shape keys, at most; a further pose has all keys together.
MOST_KEYS = 12
# Frames of an armature's animation. With twelve, the keys of a face whose head turns are a quarter farther from the original than with four.
MOST_FRAMES = 4
# Numbers of all poses of one kind together, which bounds their memory to about half a gigabyte.
MOST_NUMBERS = 100_000_000


def find_armature(item):
    """Returns the armature that deforms an object, or `None`."""
    armatures = [modifier.object for modifier in item.modifiers if modifier.type == "ARMATURE" and modifier.show_viewport]
    if item.parent_type == "ARMATURE":
        armatures.append(item.parent)
    return next((armature for armature in armatures if armature is not None), None)


@dataclass(frozen=True)
class Pose:
    """Offsets of the vertices in one pose."""

    offsets: np.ndarray
    """Offset of each vertex, n x 3."""
    key: int | None = None
    """Shape key that is this pose, whose offsets the simplifier then carries."""


def will_bend(item, source):
    """Returns whether a mesh has shape keys or an armature."""
    return bool(source.keys) or find_armature(item) is not None


def read_poses(context, item, source):
    """Returns the poses of a mesh; none without shape keys and for an armature at rest."""
    most = max(min(MOST_KEYS, MOST_NUMBERS // (18 * max(len(source.triangles), 1))), 1)
    armature = find_armature(item)
    bent = pose_bones(context, item, armature, source, min(most, MOST_FRAMES)) if armature else []
    return pose_keys(item, source, most) + [Pose(offsets) for offsets in bent]


def pose_keys(item, source, most):
    """Returns the poses of the `most` largest shape keys, and of all together."""
    if not source.keys:
        return []
    blocks = item.data.shape_keys.key_blocks
    poses = []
    for number, (block, key) in enumerate(zip(blocks, source.keys)):
        moved = key - source.keys[list(blocks).index(block.relative_key)]
        is_masked = block.vertex_group in item.vertex_groups
        if is_masked:
            moved = moved * source.groups[item.vertex_groups[block.vertex_group].index][:, None]
        is_plain = not is_masked and block.relative_key == item.data.shape_keys.reference_key
        poses.append(Pose(moved, number if is_plain else None))
    poses = sorted((pose for pose in poses if pose.offsets.any()), key=lambda pose: -np.abs(pose.offsets).max())
    together = [Pose(np.sum([pose.offsets for pose in poses], axis=0, dtype=np.float32))] if len(poses) > 1 else []
    return poses[:most] + together


def pose_bones(context, item, armature, source, most):
    """Returns the offsets in poses of an armature: over its animation, else as it is posed now."""
    names = [group.name for group in item.vertex_groups]
    bones = [bone for bone in armature.data.bones if bone.use_deform and bone.name in names]
    weights = [source.groups[names.index(bone.name)] for bone in bones if names.index(bone.name) < len(source.groups)]
    if not bones or len(weights) < len(bones):
        return []
    to_armature = np.array(armature.matrix_world.inverted_safe() @ item.matrix_world)
    animation = armature.animation_data
    if animation is not None and (animation.action is not None or animation.nla_tracks):
        turns = read_frames(context, armature, bones, most)
    else:
        turns = [read_turns(armature, bones)]
    moved = [blend_bones(source.positions, np.array(weights), turn, to_armature) - source.positions for turn in turns]
    return [offsets.astype(np.float32) for offsets in moved if np.abs(offsets).max() > 1e-6 * np.ptp(source.positions)]


def read_frames(context, armature, bones, n):
    """Returns the turns of the bones at `n` frames, evenly over the action or else over the scene."""
    scene, action = context.scene, armature.animation_data.action
    begin, end = action.frame_range if action is not None else (scene.frame_start, scene.frame_end)
    now, fraction = scene.frame_current, scene.frame_subframe
    turns = []
    try:
        for share in (np.arange(n) + 0.5) / n:
            frame = begin + share * (end - begin)
            scene.frame_set(int(frame), subframe=frame % 1)
            turns.append(read_turns(armature, bones))
    finally:
        scene.frame_set(now, subframe=fraction)
    return turns


def read_turns(armature, bones):
    """Returns for each bone the transform from rest to its present pose, 4 x 4."""
    return [np.array(armature.pose.bones[bone.name].matrix @ bone.matrix_local.inverted()) for bone in bones]


def blend_bones(positions, weights, turns, to_armature):
    """Returns positions moved by bones; a vertex that no bone moves stays. `weights` has a row for each bone."""
    back = np.linalg.inv(to_armature)
    total = weights.sum(0)
    moved = positions * np.where(total > 0, 0, 1)[:, None]
    for row, turn in zip(weights / np.where(total > 0, total, 1), turns):
        matrix = back @ turn @ to_armature
        chosen = np.flatnonzero(row)
        moved[chosen] += row[chosen, None] * (positions[chosen] @ matrix[:3, :3].T + matrix[:3, 3])
    return moved
