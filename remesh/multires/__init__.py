"""Wavelets on meshes: what a field needs of each node, level by level."""
