"""pmesh/spectral"""
