"""The long proofs and those that depend on the machine, one module an item."""
