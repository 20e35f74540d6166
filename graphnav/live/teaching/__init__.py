"""Teaching a planar model live: the motions that were driven, and those that are missing."""

from graphnav.live.teaching.coverage import Coverage as Coverage
from graphnav.live.teaching.gaps import gaps as gaps
from graphnav.live.teaching.gaps import why_no_model as why_no_model
from graphnav.live.teaching.taught import Taught as Taught
