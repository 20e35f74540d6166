# The public names of graphnav, and the modules that define them; `__init__.py` imports each on first use.

from .core.adapter import Adapter as Adapter
from .core.adapter import Ros2Adapter as Ros2Adapter
from .core.api.draw import (
    Drawing as Drawing,
)
from .core.api.draw import (
    draw as draw,
)
from .core.api.finished_run import (
    Run as Run,
)
from .core.api.finished_run import (
    RunError as RunError,
)
from .core.api.load import (
    check as check,
)
from .core.api.load import (
    load as load,
)
from .core.api.logs.log import (
    Log as Log,
)
from .core.api.logs.log import (
    open_log as open_log,
)
from .core.api.run import run as run
from .core.camera_calibration import (
    BoardPicture as BoardPicture,
)
from .core.camera_calibration import (
    CalibrationBoard as CalibrationBoard,
)
from .core.camera_calibration import (
    CalibrationTask as CalibrationTask,
)
from .core.camera_calibration import (
    CameraCalibration as CameraCalibration,
)
from .core.camera_calibration import (
    CameraMounting as CameraMounting,
)
from .core.camera_calibration import (
    Estimate as Estimate,
)
from .core.camera_calibration import (
    FloorPicture as FloorPicture,
)
from .core.camera_calibration import (
    LensFit as LensFit,
)
from .core.camera_calibration import (
    PreparedCamera as PreparedCamera,
)
from .core.codec import messages_by_name as messages_by_name
from .core.continuity import Continuity as Continuity
from .core.drawing import (
    PictureContext as PictureContext,
)
from .core.drawing import (
    VideoFrames as VideoFrames,
)
from .core.errors import (
    DeclarationError as DeclarationError,
)
from .core.errors import (
    GraphnavError as GraphnavError,
)
from .core.errors import (
    ParamError as ParamError,
)
from .core.errors import (
    Place as Place,
)
from .core.errors import (
    Problem as Problem,
)
from .core.errors import (
    Suggestion as Suggestion,
)
from .core.errors import (
    UserError as UserError,
)
from .core.errors import (
    did_you_mean as did_you_mean,
)
from .core.errors import (
    shown_path as shown_path,
)
from .core.graph import Graph as Graph
from .core.grid import (
    block_mean as block_mean,
)
from .core.grid import (
    block_sum as block_sum,
)
from .core.grid import (
    coarsen as coarsen,
)
from .core.hooks import hookimpl as hookimpl
from .core.machine.camera_devices import (
    CameraDevice as CameraDevice,
)
from .core.machine.camera_devices import (
    CameraMode as CameraMode,
)
from .core.machine.camera_devices import (
    cameras as cameras,
)
from .core.machine.extras import import_extra as import_extra
from .core.machine.files import read_regular as read_regular
from .core.machine.files import written_aside as written_aside
from .core.messages import (
    About as About,
)
from .core.messages import (
    BaseLimits as BaseLimits,
)
from .core.messages import (
    CameraInfo as CameraInfo,
)
from .core.messages import (
    Components as Components,
)
from .core.messages import (
    FieldError as FieldError,
)
from .core.messages import (
    Flow as Flow,
)
from .core.messages import (
    FlowDeviation as FlowDeviation,
)
from .core.messages import (
    Goal as Goal,
)
from .core.messages import (
    GuardState as GuardState,
)
from .core.messages import (
    Image as Image,
)
from .core.messages import (
    LocalMap as LocalMap,
)
from .core.messages import (
    Map as Map,
)
from .core.messages import (
    Message as Message,
)
from .core.messages import (
    Motion as Motion,
)
from .core.messages import (
    Odometry as Odometry,
)
from .core.messages import (
    OdometryCheck as OdometryCheck,
)
from .core.messages import (
    Planar as Planar,
)
from .core.messages import (
    PlanarModel as PlanarModel,
)
from .core.messages import (
    Plane as Plane,
)
from .core.messages import (
    Potential as Potential,
)
from .core.messages import (
    RecoveryState as RecoveryState,
)
from .core.messages import (
    Scan as Scan,
)
from .core.messages import (
    State as State,
)
from .core.messages import (
    Status as Status,
)
from .core.messages import (
    Steering as Steering,
)
from .core.messages import (
    Stop as Stop,
)
from .core.messages import (
    Truth as Truth,
)
from .core.messages import (
    Twist as Twist,
)
from .core.mount import Mount as Mount
from .core.numeric_fields import (
    NumericField as NumericField,
)
from .core.numeric_fields import (
    message_from as message_from,
)
from .core.numeric_fields import (
    numeric_fields as numeric_fields,
)
from .core.numeric_fields import (
    numeric_layout as numeric_layout,
)
from .core.record import Recording as Recording
from .core.scene import (
    Scene as Scene,
)
from .core.scene import (
    SceneArea as SceneArea,
)
from .core.spec import (
    FileFormat as FileFormat,
)
from .core.spec import (
    Names as Names,
)
from .core.spec import (
    Range as Range,
)
from .core.spec import (
    Record as Record,
)
from .core.spec import (
    Value as Value,
)
from .core.spec import (
    key as key,
)
from .core.stage import (
    MEASURED as MEASURED,
)
from .core.stage import (
    UNDEFINED as UNDEFINED,
)
from .core.stage import (
    Age as Age,
)
from .core.stage import (
    Finished as Finished,
)
from .core.stage import (
    Latest as Latest,
)
from .core.stage import (
    LiveSource as LiveSource,
)
from .core.stage import (
    Metric as Metric,
)
from .core.stage import (
    Role as Role,
)
from .core.stage import (
    Since as Since,
)
from .core.stage import (
    Source as Source,
)
from .core.stage import (
    Stage as Stage,
)
from .core.stage import (
    Stamp as Stamp,
)
from .core.stage import (
    Stamped as Stamped,
)
from .core.stage import (
    Unnoticed as Unnoticed,
)
from .core.stage import (
    param as param,
)
from .develop.calibrate_function import calibrate as calibrate
from .develop.profile_function import profile as profile
from .develop.profiling import Profile as Profile
from .learning.make_env import make_env as make_env
from .learning.make_env import make_vec_env as make_vec_env
from .studies.api.ablate import ablate as ablate
from .studies.api.finished_study import Study as Study
from .studies.api.tune import Tuned as Tuned
from .studies.api.tune import tune as tune

__version__: str
