"""The core: from YAML to a run. It knows no algorithm, and imports no other room of graphnav."""
