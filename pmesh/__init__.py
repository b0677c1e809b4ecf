"""pmesh"""
