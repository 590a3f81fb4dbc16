@tool
extends EditorScenePostImport

# First and last distance of each level, in units of the scene; a last distance of 0 has no end.
const RANGES = [RANGES_OF_LEVELS]


func _post_import(scene):
	set_ranges(scene)
	return scene


func set_ranges(node):
	var title = String(node.name)
	# Digits after these are Godot's, for nodes that share a name.
	var level = title.substr(title.rfind("_LOD") + 4, N_DIGITS)
	if node is GeometryInstance3D and "_LOD" in title and level.is_valid_int() and int(level) < RANGES.size():
		node.visibility_range_begin = RANGES[int(level)][0]
		node.visibility_range_end = RANGES[int(level)][1]
	for child in node.get_children():
		set_ranges(child)
