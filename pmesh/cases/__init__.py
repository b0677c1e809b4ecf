"""pmesh/cases"""
