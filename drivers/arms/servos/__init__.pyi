from .lerobot import MotorCalibration as MotorCalibration
from .lerobot import read_lerobot as read_lerobot
