"""Check a graph part by part: parameters, wires, channels, inputs, outputs, firing order."""
