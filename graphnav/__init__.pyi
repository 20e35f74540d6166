# The public names of graphnav, and the modules that define them; `__init__.py` imports each on first use.

from .adapter import Adapter as Adapter
from .api.draw import (
    Drawing as Drawing,
)
from .api.draw import (
    draw as draw,
)
from .api.finished_run import (
    Run as Run,
)
from .api.finished_run import (
    RunError as RunError,
)
from .api.load import (
    check as check,
)
from .api.load import (
    load as load,
)
from .api.logs.log import (
    Log as Log,
)
from .api.logs.log import (
    open_log as open_log,
)
from .api.profile import profile as profile
from .api.run import run as run
from .api.studies.ablate import ablate as ablate
from .api.studies.finished_study import Study as Study
from .api.studies.tune import Tuned as Tuned
from .api.studies.tune import tune as tune
from .continuity import Continuity as Continuity
from .errors import (
    DeclarationError as DeclarationError,
)
from .errors import (
    GraphnavError as GraphnavError,
)
from .errors import (
    ParamError as ParamError,
)
from .errors import (
    Place as Place,
)
from .errors import (
    Problem as Problem,
)
from .errors import (
    Suggestion as Suggestion,
)
from .errors import (
    UserError as UserError,
)
from .errors import (
    did_you_mean as did_you_mean,
)
from .errors import (
    shown_path as shown_path,
)
from .graph import Graph as Graph
from .grid import (
    block_mean as block_mean,
)
from .grid import (
    block_sum as block_sum,
)
from .grid import (
    coarsen as coarsen,
)
from .hooks import hookimpl as hookimpl
from .machine.regular_file import read_regular as read_regular
from .messages import (
    About as About,
)
from .messages import (
    Components as Components,
)
from .messages import (
    FieldError as FieldError,
)
from .messages import (
    Flow as Flow,
)
from .messages import (
    Goal as Goal,
)
from .messages import (
    GuardState as GuardState,
)
from .messages import (
    Image as Image,
)
from .messages import (
    LocalMap as LocalMap,
)
from .messages import (
    Map as Map,
)
from .messages import (
    Message as Message,
)
from .messages import (
    Motion as Motion,
)
from .messages import (
    Odometry as Odometry,
)
from .messages import (
    OdometryCheck as OdometryCheck,
)
from .messages import (
    Planar as Planar,
)
from .messages import (
    PlanarModel as PlanarModel,
)
from .messages import (
    Plane as Plane,
)
from .messages import (
    Potential as Potential,
)
from .messages import (
    State as State,
)
from .messages import (
    Status as Status,
)
from .messages import (
    Steering as Steering,
)
from .messages import (
    Stop as Stop,
)
from .messages import (
    Truth as Truth,
)
from .messages import (
    Twist as Twist,
)
from .mount import Mount as Mount
from .pictures import (
    PictureContext as PictureContext,
)
from .pictures import (
    VideoFrames as VideoFrames,
)
from .profiling import Profile as Profile
from .record import Recording as Recording
from .spec import (
    FileFormat as FileFormat,
)
from .spec import (
    Range as Range,
)
from .spec import (
    Record as Record,
)
from .spec import (
    Value as Value,
)
from .spec import (
    key as key,
)
from .stage import (
    MEASURED as MEASURED,
)
from .stage import (
    UNDEFINED as UNDEFINED,
)
from .stage import (
    Age as Age,
)
from .stage import (
    Finished as Finished,
)
from .stage import (
    Latest as Latest,
)
from .stage import (
    Metric as Metric,
)
from .stage import (
    Role as Role,
)
from .stage import (
    Since as Since,
)
from .stage import (
    Source as Source,
)
from .stage import (
    Stage as Stage,
)
from .stage import (
    Stamp as Stamp,
)
from .stage import (
    Stamped as Stamped,
)
from .stage import (
    Unnoticed as Unnoticed,
)
from .stage import (
    param as param,
)

__version__: str
