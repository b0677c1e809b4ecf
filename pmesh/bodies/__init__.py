"""pmesh/bodies"""
