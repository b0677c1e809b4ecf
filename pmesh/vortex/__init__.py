"""pmesh/vortex"""
