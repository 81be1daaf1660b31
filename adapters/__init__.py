"""Adapters: one engine, one file or package, found by walking this folder; each ends in ADAPTER."""
