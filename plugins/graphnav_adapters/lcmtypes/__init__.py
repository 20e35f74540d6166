"""LCM types of other packages, generated inside this one: their own packages may be installed beside it."""
