"""pmesh/run"""
