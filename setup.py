"""The one Python build: metadata in pyproject.toml, C sources in bindings/sources.txt."""

from setuptools import setup

setup(cffi_modules=["bindings/cffi/build.py:ffi"])
