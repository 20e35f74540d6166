"""Teaching a planar model live: the motions that were driven, and those that are missing."""

from graphnav.teaching.coverage import Coverage as Coverage
from graphnav.teaching.gaps import gaps as gaps
from graphnav.teaching.gaps import why_no_model as why_no_model
from graphnav.teaching.taught import Taught as Taught
