from .dynamixel import crc16 as crc16
from .joint_maps import MotorCalibration as MotorCalibration
from .joint_maps import read_lerobot as read_lerobot
