"""Pictures of rig, modes, contact faces, responses; figures for notebooks."""
