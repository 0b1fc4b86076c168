from .attempt import ExperimentRun as ExperimentRun
from .attempt import Settings as Settings
from .models import model_urdf as model_urdf
from .pictures import PictureError as PictureError
from .types import Drawing as Drawing
from .types import Insertions as Insertions
from .types import ModelTrials as ModelTrials
from .types import SimulationDocument as SimulationDocument
