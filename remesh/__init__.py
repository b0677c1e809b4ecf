"""remesh"""
