"""What the add-on promises, in any Blender without a window: bpy, or blender -b."""
