"""levelset"""
