"""What a graph's YAML says, every value with its place."""

from graphnav.spec.scalar import Scalar, parse_scalar
from graphnav.spec.value import Entry, Value
from graphnav.spec.yaml import parse_yaml

__all__ = ["Entry", "Scalar", "Value", "parse_scalar", "parse_yaml"]
