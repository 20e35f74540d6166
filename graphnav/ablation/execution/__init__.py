"""Make the runs of a plan in parallel and keep them in the folder of the study."""
