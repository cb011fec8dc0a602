"""Sections, hexahedral meshes, contact elements, files for ParaView."""
