"""The results of a study: records, intervals, comparisons."""
