"""What the add-on decides without Blender: no module here imports bpy."""
