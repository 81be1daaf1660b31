"""Adapters: one engine, one file, found by walking this folder; each ends in ADAPTER."""
