from .differences import with_differences as with_differences
from .joint_offsets import DECIDED as DECIDED
from .joint_offsets import joint_offsets_in_words as joint_offsets_in_words
from .model_averaging import beside_curves as beside_curves
from .model_choice import ModelChoice as ModelChoice
from .model_choice import choose_models as choose_models
from .model_search import SearchedModels as SearchedModels
from .model_search import search as search
